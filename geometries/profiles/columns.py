"""Two columns, y and z, and nothing else; the columns of GENSYS are such files, too.

Rows are separated by line ends, columns by blanks, commas or semicolons. `#`, `!`, `%` and quotation
marks start comments.
"""

from geometries.profiles.content import Content, kind_by_name, point, row, rows_of
from geometries.profiles.text import Source, uncommented

COMMENTS = "#!%\"'"


def read_columns(source: Source) -> Content:
    """Points of a file of two columns; unit and axes are not stated."""
    points, lines = [], []
    for line, text in enumerate(source.lines, 1):
        if content := uncommented(text, COMMENTS):
            points.append(point(source, line, *row(source, line, content, range(2, 3))))
            lines.append(line)
    return Content(rows_of(source, points, lines), kind_by_name(source))
