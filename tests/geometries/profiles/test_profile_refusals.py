import time

import numpy as np
import pytest
from profile_texts import block_text, columns_text, miniprof_text, old_miniprof_text, rail, wheel

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.text import MAX_BYTES, MAX_POINTS

DOWN = rail() * [[1.0], [-1.0]]
TEXTS = {
    "r.txt": (columns_text(rail()), {"kind": "rail", "axes": "field"}),
    "r.prr": (block_text(DOWN), {}),
    "r.ban": (miniprof_text(rail()), {"axes": "field"}),
    "w.whl": (old_miniprof_text(wheel()), {}),
}
FIRST_ROW = {"r.txt": 1, "r.prr": 8, "r.ban": 5, "w.whl": 5}
each = pytest.mark.parametrize("name", TEXTS)


def error_of(folder, name, data, **asked):
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(WrongInput) as error:
        read_profile(path, **(asked or TEXTS[name][1]))
    return str(error.value), path


def replaced(text, line, new):
    lines = text.split("\n")
    lines[line - 1] = new
    return "\n".join(lines)


@each
@pytest.mark.parametrize(
    ("row", "word"),
    [
        ("nan 1.0 0", "not a finite number"),
        ("1.0 -INF 0", "not a finite number"),
        ("1e999 2 0", "larger than"),
        ("1.0 1e8 0", "larger than"),
        ("1_0 2 0", "not a number"),
        ("\u0661 2 0", "not a number"),
        ("0x10 2 0", "not a number"),
        ("1." + "3" * 100 + " 2 0", "not a number"),
        ("12", "1 columns"),
        ("1 2 3 4 5 6 7", "7 columns"),
        ("-37,5 -26,2 0,0", "decimal commas"),
    ],
)
def test_a_wrong_row_is_named_by_file_and_line(tmp_path, name, row, word):
    text, line = TEXTS[name][0], FIRST_ROW[name] + 10
    if name != "w.whl":
        row = row.removesuffix(" 0").removesuffix(" 0,0")
    message, path = error_of(tmp_path, name, replaced(text, line, row))
    assert message.startswith(f"{path}, line {line}: ")
    assert word in message


@each
def test_files_that_are_cut_off_are_refused(tmp_path, name):
    text = TEXTS[name][0]
    lines = text.split("\n")
    for n_lines in (1, FIRST_ROW[name] - 1, FIRST_ROW[name] + 2):
        message, path = error_of(tmp_path, name, "\n".join(lines[:n_lines]) + "\n")
        assert message.startswith(f"{path}, line ")
    if name in ("r.prr", "r.ban"):  # both say how many points there should be, or where they end
        message, _ = error_of(tmp_path, name, "\n".join(lines[:40]))
        assert "cut off" in message


@each
@pytest.mark.parametrize(
    ("data", "line", "word"),
    [
        (b"", 1, "empty"),
        (b" \n\n", 1, "empty"),
        (b"! nothing\n" * 3, 4, ""),
        (b"1 2\n3 4\n\x00\x01\x02", 3, "no text"),
        ("1 2\n".encode("utf-16"), 1, "no text"),
        (b"\x89PNG\r\n\x1a\n1 2\n", 2, "no text"),
        (b"\xff\xd8\xff\xe0 \xe4\xf6 1\n", 1, ""),
    ],
)
def test_empty_and_binary_files_are_refused(tmp_path, name, data, line, word):
    message, path = error_of(tmp_path, name, data)
    assert message.startswith(f"{path}, line {line}: ")
    assert word in message


@each
def test_huge_files_are_refused_at_once(tmp_path, name):
    start = time.process_time()
    message, _ = error_of(tmp_path, name, b"1 2\n" * (MAX_BYTES // 4 + 1))
    assert "thin the points out" in message
    assert time.process_time() - start < 2
    if name == "r.txt":
        message, _ = error_of(tmp_path, name, b"1 2\n" * (MAX_POINTS + 5))
        assert f"line {MAX_POINTS + 1}: more than {MAX_POINTS} points" in message


@each
def test_crossings_are_named_by_their_lines(tmp_path, name):
    lines, first = TEXTS[name][0].split("\n"), FIRST_ROW[name]
    points = np.array([line.split()[:2] for line in lines[first - 1 :] if line[:1] in tuple("-0123456789")])
    points = points.astype(float).T
    k, m = 20, 40  # the way goes from one side of the contour at point m to the other, instead of over k
    across = 3 * np.array([[0.0, -1.0], [1.0, 0.0]]) @ (points[:, m + 1] - points[:, m - 1])
    for row, sign in ((k, 1), (k + 1, -1)):
        y, z = (points[:, m] + sign * across).tolist()
        lines[first - 1 + row] = f"{y!r} {z!r}" + " 0.0" * (name == "w.whl")
    message, path = error_of(tmp_path, name, "\n".join(lines))
    assert message.startswith(f"{path}, line ")
    assert any(words in message for words in ("crosses itself", "turn back"))
    named = [int(word.strip(":;,")) for word in message.split() if word.strip(":;,").isdigit()]
    assert all(any(abs(line - first - near) <= 2 for near in (k, m)) for line in named)


@each
@pytest.mark.parametrize("sign", [1, -1])
def test_a_spike_is_refused_on_both_sides(tmp_path, name, sign):
    """A point 15 mm off the contour: on one side of it the way there and back crosses nothing."""
    lines, row = TEXTS[name][0].split("\n"), FIRST_ROW[name] + 30
    y, z, *more = lines[row - 1].split()
    lines[row - 1] = " ".join([y, repr(float(z) + 15 * sign), *more])
    message, path = error_of(tmp_path, name, "\n".join(lines))
    assert message.startswith(f"{path}, line {row}: the points turn back")


def test_a_loop_and_a_closed_outline_are_refused(tmp_path):
    t = np.linspace(0, 1, 200)
    loop = np.stack([60 * t, -10 * (2 * t - 1) ** 2]) + 4 * np.exp(-(((t - 0.5) / 0.05) ** 2)) * np.stack(
        [np.sin(60 * t), np.cos(60 * t)]
    )
    message, _ = error_of(tmp_path, "r.txt", columns_text(loop))
    assert "crosses itself" in message
    closed = np.concatenate([rail(), [[20.0, -20.0], [-60.0, -60.0]], rail()[:, :1]], axis=1)
    message, _ = error_of(tmp_path, "r.txt", columns_text(closed))
    assert "line 64: the outline is closed" in message


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("type = 0", "type = 2", "0 (rail) or 1 (wheel)"),
        ("type = 0", "type = nan", "finite"),
        ("type = 0", "type 0", "KEY = VALUE"),
        ("units.len.f = 1000", "units.len.f = 0", "positive"),
        ("units.len.f = 1000", "units.len.f = -1000", "positive"),
        ("units.len.f = 1000", "units.len.f = 1", "units.len.f"),
        ("units.len.f = 1000", "units.len.f = 'mm'", "not a number"),
        ("units.len.f = 1000", "mirror.y = 2", "0 (no) or 1 (yes)"),
        ("units.len.f = 1000", "shift.y = inf", "finite"),
        ("units.len.f = 1000", "point.dist.min = -1", "0 or more"),
        ("units.len.f = 1000", "bound.y.min = 500\nbound.y.max = 600", "no point lies"),
        ("units.len.f = 1000", "shift.y = 1\nshift.y = 2", "also given in line 6"),
        ("point.begin", "point.begin\npoint.begin", "not expected here"),
        ("spline.end", "spline.end\nspline.begin\nspline.end", "not expected here"),
        ("point.end", "", "KEY"),
        ("point.begin", "", "KEY = VALUE"),
        ("header.begin", "", "header.begin or spline.begin"),
    ],
)
def test_wrong_keys_of_a_spline_block(tmp_path, old, new, word):
    text = TEXTS["r.prr"][0]
    assert f"{old}\n" in text
    message, _ = error_of(tmp_path, "r.prr", text.replace(f"{old}\n", f"{new}\n"))
    assert word in message or (new == "" and "spline.end" in message), message


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("ColumnDef=X,Y", "ColumnDef=X", "must name X and Y"),
        ("ColumnDef=X,Y", "ColumnDef=X,Y,Q", "must name X and Y"),
        ("ColumnDef=X,Y", "ColumnDef=X,Y,A", "2 columns, 3 expected"),
        ("ColumnDef=X,Y", "ColumnDef=X,Y\nColumnDef=Y,X", "also given in line 2"),
        ("ColumnDef=X,Y", "XOffset=nan", "finite"),
        ("XYPoints=61", "XYPoints=62", "61 rows, but XYPoints = 62"),
        ("XYPoints=61", "a line of text", "KEY=VALUE"),
    ],
)
def test_wrong_headers_of_miniprof(tmp_path, old, new, word):
    text = TEXTS["r.ban"][0]
    message, path = error_of(tmp_path, "r.ban", text.replace(old, new))
    assert message.startswith(f"{path}, line ")
    assert word in message


@pytest.mark.parametrize(
    ("name", "old", "new", "lines"),
    [
        ("w.whl", " (Sd/Sh)", "", "3"),
        ("w.whl", "32.5 37.1 (Sd/Sh)\n", "32.5 37.1\n1 2 3\n", "3, 4"),
        ("w.whl", "32.5 37.1 (Sd/Sh)\n\n", "32.5 37.1 14.7\nStock: 7\n", "3"),  # without the blank line
        *(
            ("r.ban", behind, f"{behind}\n{numbers}", None)
            for behind in ("ColumnDef=X,Y", "XYPoints=61")
            for numbers in ("12.5 13.5", "12.5", "12.5 13.5\n1 2 3\n4 5")
        ),
    ],
)
def test_numbers_in_a_header_are_not_taken_for_points(tmp_path, name, old, new, lines):
    path = tmp_path / name
    path.write_text(TEXTS[name][0].replace(old, new))
    profile = read_profile(path, **TEXTS[name][1])
    np.testing.assert_array_equal(profile.points, wheel() if name == "w.whl" else rail())
    note = f"Numbers in the header were not read as points (lines {lines})."
    assert lines is None or note in profile.notes


def test_points_on_both_sides_of_a_blank_line_are_refused(tmp_path):
    lines = TEXTS["w.whl"][0].split("\n")
    text = "\n".join([*lines[:3], *lines[4:24], "", *lines[24:]])
    message, path = error_of(tmp_path, "w.whl", text)
    assert message.startswith(f"{path}, line 4: numbers before the first blank line, 24, and behind it")


def test_miniprof_is_known_by_its_text_under_any_ending(tmp_path):
    for name, kind in (("r.ban", "rail"), ("w.whl", "wheel")):
        path = tmp_path / "s.mpt"
        path.write_text(TEXTS[name][0])
        points = {"rail": rail(), "wheel": wheel()}[kind]
        np.testing.assert_array_equal(read_profile(path, kind, axes="field").points, points)
        with pytest.raises(WrongInput, match="kind: the file does not state it"):
            read_profile(path, axes="field")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ProgramName=test\nColumnDef=X,Y\n", "without points; is it cut off, or one of settings?"),
        ("[Template]\nflange 3\n", "ending '.mpt', which is none of a format of profiles"),
        ("<?xml version='1.0'?>\n<a/>\n", "as two columns .txt"),
    ],
)
def test_what_is_no_profile_says_what_to_export(tmp_path, text, words):
    message, _ = error_of(tmp_path, "s.mpt", text, kind="rail", axes="field")
    assert words in message


def test_what_miniprof_may_have_is_read(tmp_path):
    points = rail()
    plain = miniprof_text(points).split("\n")
    body = plain[4:-1]
    variants = {
        "offsets": "XOffset=1.5 ! mm\nYoffset=-2\nColumnDef=X,Y\n\n"
        + columns_text(points - [[1.5], [-2.0]]).replace(" ", ", "),
        "columns": "ColumnDef=A,Y,K,X\n\n" + columns_text(points[::-1], row="0 {!r} 663810000 {!r}"),
        "no blank line": "\n".join([*plain[:3], *body]),
        "comments": "\n".join(
            [*plain[:4], '"1 2', "% 3 4", body[0] + " ! x", "", body[1] + " remark 1", *body[2:]]
        ),
        "returns": "\r\n".join(plain),
        "old ends of lines": "\r".join(plain),
        "Latin-1": "\n".join([plain[0] + " H\u00f6he", *plain[1:]]),
        "byte order mark": "\ufeff" + "\n".join(plain),
        "end of file": "\n".join(plain) + "\x1a",
        "no ColumnDef": "\n".join([plain[0], *plain[2:]]),
    }
    for name, text in variants.items():
        path = tmp_path / "r.ban"
        path.write_bytes(text.encode("latin-1" if name == "Latin-1" else "utf-8"))
        profile = read_profile(path, axes="field")
        np.testing.assert_allclose(profile.points, points, rtol=0, atol=1e-12, err_msg=name)


def test_paths_that_are_no_files_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "missing.prr", "a\0b.prr", "x" * 5000, "/dev/null", ""):
        with pytest.raises(WrongInput):
            read_profile(path)
