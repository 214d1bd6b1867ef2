"""Text files that users name: scenes, campaigns, columns of numbers; their names, encodings and numbers."""

import numpy as np
import pytest

from compare.campaigns.load import load_campaign
from femic.scenes.errors import BadScene
from femic.scenes.input_files import columns
from femic.scenes.load import load_scene, load_solid_scene
from femic.shifts.specification import example, load_shifts
from geometries.errors import WrongInput

CAMPAIGN = """
scene = "flat"
points = "random"
samples = 3
[sweep.E]
keys = ["lower.E"]
from = 1e5
to = 2e5
"""


@pytest.mark.parametrize("name", ["...toml", "..toml", " .toml", "a\nb.toml"])
def test_names_that_no_folder_can_have_are_refused(name, tmp_path):
    path = tmp_path / name
    for text, load in (
        (load_scene("flat").text, lambda: load_scene(str(path))),
        (load_scene("flat").text, lambda: load_solid_scene(str(path))),
        (CAMPAIGN, lambda: load_campaign(path)),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(BadScene, match=r"is used for the folder of results, .*: rename it"):
            load()


@pytest.mark.parametrize("name", [".hidden.toml", "a b.toml", "Räder.toml", "mine"])
def test_other_file_names_become_scene_names(name, tmp_path):
    path = tmp_path / name
    path.write_text(load_scene("flat").text, encoding="utf-8")
    assert load_scene(str(path)).name == name.removesuffix(".toml")


def test_negative_or_non_integer_seeds_are_refused(tmp_path):
    path = tmp_path / "mine.toml"
    for seed, allowed in ((0, True), (7, True), (-3, False), ('"3"', False), ("true", False)):
        path.write_text(f"seed = {seed}\n{CAMPAIGN}", encoding="utf-8")
        if allowed:
            assert load_campaign(path).size == 3
        else:
            with pytest.raises(BadScene, match=r"seed = .*: Input should be "):
                load_campaign(path)


def test_scenes_and_wheelsets_may_have_a_byte_order_mark(tmp_path):
    path, text = tmp_path / "mine.toml", load_scene("flat").text
    for encoding in ("utf-8", "utf-8-sig"):
        path.write_text(text, encoding=encoding)
        assert load_scene(str(path)).text == text
    path.write_text(example(), encoding="utf-8-sig")
    assert load_shifts(str(path))[1] == example()


# --- columns of numbers ---------------------------------------------------------------------------------

HEADINGS = ("s, gap", "x, s, gap")


def written(folder, text):
    path = folder / "gap.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    [
        "1 2\n-3 4e-1\n",
        "# s gap\n\n1\t2 # here\r\n  -3.0   .4  ",
        b"\xef\xbb\xbf1 2\n-3 0.4\n",
        "1.0D+00 2d0\n-.3E1 4.0d-01\n",
        '"1","2"\n"-3.0" , "4e-1"\n',
        "1;2\n-3;0.4",
        b"# \xb0\n1 2\n-3 0.4",
    ],
)
def test_numbers_are_separated_by_blanks_beside_comments(text, tmp_path):
    np.testing.assert_array_equal(columns(written(tmp_path, text), HEADINGS), [(1, 2), (-3, 0.4)])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "gap.txt, line 1: the file is empty"),
        ("# only a comment\n", "no numbers; give columns s, gap or x, s, gap"),
        ("1\n", r"line 1: 1 columns; give s, gap or x, s, gap"),
        ("1 2\n\n1 2 3\n", "line 3: 3 columns, 2 before"),
        ("1 2 3 4\n", "line 1: 4 columns; give"),
        ("1,0 2\n", r"line 1: '1,0 2': looks like decimal commas; write a point"),
        ('"1,0";"2,0"\n', r"line 1: '1,0;2,0': looks like decimal commas; write a point"),
        ("1 nan\n", "line 1: gap = nan: not a finite number"),
        ("1 2\n1 -inf", "line 2: gap = -inf"),
        ("0x10 2\n", "s = '0x10': not a number"),
        ("1_2 2\n", "s = '1_2'"),
        ("1 1e13\n", r"gap = '1e13': larger than 1e\+07"),
        (b"\xff\xfe1\x00 \x002\x00", "byte 0 is no text; save the file as plain text"),
        ("1 2\n".encode("utf-16"), "byte 0 is no text"),
    ],
)
def test_invalid_files_are_refused_with_the_line(text, reason, tmp_path):
    with pytest.raises(WrongInput, match=reason):
        columns(written(tmp_path, text), HEADINGS)
