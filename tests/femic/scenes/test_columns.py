"""Columns of numbers in text files: what is read, and what is said of files that are something else."""

import numpy as np
import pytest

from femic.scenes.columns import columns
from geometries.errors import WrongInput

HEADINGS = ("s, gap", "x, s, gap")


def written(folder, text):
    path = folder / "gap.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    ["1 2\n-3 4e-1\n", "# s gap\n\n1\t2 # here\r\n  -3.0   .4  ", b"\xef\xbb\xbf1 2\n-3 0.4\n"],
)
def test_numbers_are_separated_by_blanks_beside_comments(text, tmp_path):
    np.testing.assert_array_equal(columns(written(tmp_path, text), HEADINGS), [(1, 2), (-3, 0.4)])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no numbers; give columns s, gap or x, s, gap, separated by blanks"),
        ("# only a comment\n", "no numbers"),
        ("1\n", r"line 1: 1 columns; give s, gap or x, s, gap"),
        ("1 2\n\n1 2 3\n", "line 3: 3 columns, 2 before"),
        ("1 2 3 4\n", "line 1: 4 columns; give"),
        ("1,0 2\n", r"line 1: '1,0': give a number, .* such as 1\.5 or -2e-3"),
        ("1 nan\n", "line 1: 'nan'"),
        ("1 2\n1 -inf", "line 2: '-inf'"),
        ("0x10 2\n", "'0x10'"),
        ("1_2 2\n", "'1_2'"),
        ("1 1e13\n", r"'1e13': give a number, at most 1e\+12"),
        (b"\xff\xfe1\x00 \x002\x00", r"not a text in UTF-8 .*: save it as such"),
        ("1 2\n".encode("utf-16"), "not a text in UTF-8"),
    ],
)
def test_invalid_files_are_refused_with_the_line(text, reason, tmp_path):
    with pytest.raises(WrongInput, match=reason):
        columns(written(tmp_path, text), HEADINGS)
