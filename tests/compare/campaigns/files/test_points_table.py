"""Tables of points: what spreadsheets write is read, and nothing is read that may mean something else."""

import csv

import pytest

from compare.campaigns.load import read_points
from femic.scenes.errors import BadScene
from femic.scenes.values import value_of

AXES = ("flank", "ratio")


@pytest.fixture
def read(tmp_path):
    """A function that reads a table of some text or bytes, with two axes."""

    def read(content, axes=AXES, encoding="utf-8"):
        path = tmp_path / "points.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return read_points(path, axes)

    return read


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_tables_of_spreadsheets_are_read(read, encoding, separator, end):
    lines = ["note,ratio,flank,", "ä,1.05,30,", "b,12e-1,-4,", ",,,"]
    text = end.join(lines).replace(",", separator) + end
    assert read(text, encoding=encoding) == [(30, 1.05), (-4, 1.2)]


@pytest.mark.parametrize(
    ("text", "points"),
    [
        ("flank;ratio\n30;1,05\n-,5e1;2,\n", [(30, 1.05), (-5, 2)]),  # decimal commas between semicolons
        ("flank,ratio\n.5e5,05\n1.,2\n", [(5e4, 5), (1, 2)]),
        ("flank,ratio\n60E1,2.1D5\n54E1,-21d-4\n", [("60E1", 2.1e5), ("54E1", -2.1e-3)]),  # a rail; Fortran
        ("flank,ratio\ntrue,\"[1, 2.5, 'a']\"\n", [(True, [1, 2.5, "a"])]),  # values of TOML
        ('flank,ratio\nharmonic,"""30"""\n', [("harmonic", "30")]),
        ('"a,b";flank;ratio\n1;30;1\n', [(30, 1)]),  # a quoted header: the separator that fits
    ],
)
def test_numbers_and_values_are_read_in_the_ways_that_programs_write_them(read, text, points):
    assert read(text) == points


def test_a_table_has_as_many_points_as_rows(read):
    assert read("flank\n" + "\n".join(map(str, range(1000))), ["flank"]) == [(k,) for k in range(1000)]


REFUSED = [
    ("flank,ratio\n20,1\n30,1,05\n", "line 3: cells: 3, columns: 2"),
    ("flank,ratio\n30\n", "line 2: cells: 1, columns: 2"),
    ("flank,ratio\n30,1\n,1\n", "line 3: flank: no value"),
    ("flank,ratio,ratio\n30,1,2\n", "line 1: column ratio is there twice"),
    ("flank,rato\n30,1\n", "line 1: no column ratio; columns are flank, rato"),
    ("flank,ratio\n", "no rows below the header"),
    ("", "columns are none"),
    *(
        (f"flank,ratio\n{number},1\n", f"line 2: {number}: is not a finite decimal number")
        for number in ("0x10", "0o7", "1_2", "nan", "-Infinity", "\u0663")  # the last: 3 of another script
    ),
    ('flank,ratio\n1,"[1, [0x10]]"\n', "0x10: is not a finite"),
    ('flank,ratio\n1,"[{ a = 1_2 }]"\n', "1_2: is not a finite"),
    ("flank,ratio\n1,1e999\n", "1e999: is too large for a number"),
    (f"flank,ratio\n1,{'9' * 5000}\n", "9999: is too large for a number"),
    ('flank,ratio\n30,"1,05"\n', "line 2: 1,05: decimal commas are read where"),
    ("flank\tratio\n30\t1,05\n", "line 2: 1,05: decimal commas are read where"),
    ("flank;ratio\n30;1,05\n30;1.05\n", "line 3: 1.05: other cells have decimal commas"),
    ('flank,ratio\n30,1\n"30,1\n', "line 3: not CSV: unexpected end of data"),
    ('flank,ratio\n"30"0,1\n', "line 2: not CSV: ',' expected after"),
    (f"flank,ratio,n\n30,1,{'x' * (csv.field_size_limit() + 1)}\n", "more characters than allowed"),
    ("flank,ratio,n\n30,1,a\n30,1,ä\n".encode("latin-1"), "line 3: is not text in UTF-8: save the"),
    ("flank,ratio\n30,1\n".encode("utf-16-le"), "is not text in UTF-8: save"),  # without a mark
    ("flank,ratio\n30,1\n".encode("utf-16")[:-1], "line 2: is not text in UTF-16: save the"),  # half of it
    ("flank,ratio\n30,1\n".encode("utf-32"), "is not text in UTF"),
]


@pytest.mark.parametrize(("content", "message"), REFUSED, ids=[case[-1] for case in REFUSED])
def test_ambiguous_table_is_refused_with_line_and_reason(read, content, message):
    with pytest.raises(BadScene) as refused:
        read(content)
    assert message in str(refused.value)
    assert "points.csv" in str(refused.value)
    assert len(str(refused.value)) < 400


def test_unreadable_file_is_reported(tmp_path):
    with pytest.raises(BadScene, match="cannot be read"):
        read_points(tmp_path, AXES)


def test_malformed_lists_and_numbers_are_text():
    assert value_of("[" * 3000) == "[" * 3000
    assert value_of(" 1.2.3 ") == "1.2.3"
