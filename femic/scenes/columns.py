"""Columns of numbers in text files: points of contours, and of extra gaps. They are read as profiles are."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from geometries.arrays import Array
from geometries.profiles.text import number, read_source, split_columns, uncommented


def columns(path: Path, headings: Sequence[str]) -> Array:
    """Return lengths [mm] in columns of one of the headings, such as "y, z", shape (rows, columns).

    They are separated by blanks, commas or semicolons; # begins a comment. Raise WrongInput that names the
    line with anything else.
    """
    names = {len(heading.split(", ")): heading.split(", ") for heading in headings}
    source = replace(read_source(path), path=Path(path.name))  # the key is named with its folder
    rows = list[list[float]]()
    for line, text in enumerate(source.lines, 1):
        cells = split_columns(source, line, uncommented(text, "#"))
        if not cells:
            continue
        if len(cells) not in names or (rows and len(cells) != len(rows[0])):
            before = f", {len(rows[0])} before" if rows else ""
            raise source.wrong(line, f"{len(cells)} columns{before}; give {' or '.join(headings)}")
        pairs = zip(cells, names[len(cells)], strict=True)
        rows.append([number(source, line, cell, name) for cell, name in pairs])
    if not rows:
        raise source.refused(f"no numbers; give columns {' or '.join(headings)}")
    return np.array(rows)
