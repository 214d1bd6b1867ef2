"""Damaged files: every reader gives a profile or says what is wrong, and never takes long."""

import time

import numpy as np
import pytest
from profile_texts import block_text, columns_text, miniprof_text, old_miniprof_text, rail, wheel

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile, write_profile
from geometries.profiles.sections import read_sections

SECONDS = 2  # of the processor; a file takes 1 ms
N_FAST, N_SLOW = 100, 2000
DOWN = np.array([[1.0], [-1.0]])
KEYS = {
    "shift_y": 1,
    "rotate": 0.01,
    "bound_y_min": -30,
    "bound_y_max": 33,
    "mirror_y": 0,
    "point_dist_min": 0.1,
}
LIST = """% offset, scale
0.0 1000.0
3
2 0 0
1
0.0 'a.prr'
2.5 'b.prr'
7.0 'a.prr'
0.0 0.0 61.0
2.5 0.0 -1
7.0 3.0 61.0
"""
FILES = {
    "columns": (
        "s.txt",
        columns_text(rail(41), "# y z\n", "{:.4f} {:.4f}"),
        {"kind": "rail", "axes": "field"},
    ),
    "metres": (
        "s.csv",
        columns_text(rail(41) / 1000, row="{:.6f},{:.6f}"),
        {"kind": "rail", "axes": "centre"},
    ),
    "gensys": ("s.wheel", columns_text(-wheel(41), "# y to the centre, z down\n", "{:.4f}  {:.4f} # mm"), {}),
    "block": ("s.prr", block_text(np.round(rail(41) * DOWN, 4), **KEYS), {}),
    "wheel block": ("s.prw", block_text(np.round((wheel(41) * DOWN)[:, ::-1], 4), "wheel"), {}),
    "miniprof": (
        "s.ban",
        miniprof_text(np.round(rail(41), 4), ["XOffset=0.5", "Side=L"]),
        {"axes": "field up"},
    ),
    "old miniprof": ("s.whl", old_miniprof_text(np.round(wheel(41), 4)), {}),
    "sections": ("s.slcs", LIST, {}),
}
WORDS = [b"nan", b"inf", b"1e308", b"-1e-308", b"9" * 50, b"1,5", b"-0", b"0", b"''", b"=", b"#", b"!", b" "]
WORDS += [b"\x00", b"\xff", b"\r", b"\n", b"\xe2\x88\x92"]
WORDS += [b"point.end", b"spline.begin", b"ColumnDef=X", b"XYPoints=0"]


def flip(data, rng):
    k = int(rng.integers(len(data)))
    return data[:k] + bytes([data[k] ^ (1 << int(rng.integers(8)))]) + data[k + 1 :]


def delete(data, rng):
    k, n = int(rng.integers(len(data))), int(rng.integers(1, 40))
    return data[:k] + data[k + n :]


def truncate(data, rng):
    return data[: int(rng.integers(len(data)))]


def duplicate(data, rng):
    k, n, m = int(rng.integers(len(data))), int(rng.integers(1, 400)), int(rng.integers(len(data)))
    return data[:m] + data[k : k + n] + data[m:]


def swap_lines(data, rng):
    lines = data.split(b"\n")
    a, b = rng.integers(len(lines), size=2)
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def repeat_line(data, rng):
    lines = data.split(b"\n")
    k = int(rng.integers(len(lines)))
    return b"\n".join(lines[:k] + lines[k : k + 1] * int(rng.integers(2, 5)) + lines[k + 1 :])


def insert_word(data, rng):
    k = int(rng.integers(len(data) + 1))
    return data[:k] + WORDS[int(rng.integers(len(WORDS)))] + data[k:]


def change_number(data, rng):
    words = data.split(b" ")
    k = int(rng.integers(len(words)))
    other = [b"1e7", b"-9999999", b"1e-300", b"0", b"nan", repr(rng.normal(scale=50)).encode()]
    words[k] = other[rng.integers(6)]
    return b" ".join(words)


MUTATIONS = [flip, delete, truncate, duplicate, swap_lines, repeat_line, insert_word, change_number]


def damaged(data, seed):
    rng = np.random.default_rng(seed)
    for _ in range(int(rng.choice([1, 1, 1, 2, 4]))):
        data = MUTATIONS[int(rng.integers(len(MUTATIONS)))](data, rng) if data else data
    return data


def check(profile):
    assert profile.points.shape[0] == 2
    assert profile.points.shape[1] >= 4
    assert np.all(np.isfinite(profile.points))
    assert 1 <= np.ptp(profile.points[0]) <= 1000
    assert profile.points[0, 0] <= profile.points[0, -1]
    assert all(isinstance(note, str) and note for note in profile.notes)


def attempt(path, layout, asked):
    """The profiles of a file, or the message of its refusal."""
    try:
        if layout == "sections":
            return [section.profile for section in read_sections(path).sections]
        return [read_profile(path, **asked)]
    except WrongInput as error:
        return str(error)


def read_damaged(folder, layout, seeds):
    """Number of damaged files that were read all the same."""
    name, text, asked = FILES[layout]
    path, n_read = folder / name, 0
    for k, part in enumerate("ab"):
        (folder / f"{part}.prr").write_text(block_text((rail(31) + np.array([[k], [0]])) * DOWN))
    for seed in seeds:
        path.write_bytes(damaged(text.encode(), seed))
        start = time.process_time()
        try:
            result = attempt(path, layout, asked)
        except Exception as error:
            raise AssertionError(f"{layout}, seed {seed}: {error!r}") from error
        assert time.process_time() - start < SECONDS, f"seed {seed}"
        if isinstance(result, str):
            assert result.startswith(str(path)), f"seed {seed}: {result}"
            assert len(result) < 1000, f"seed {seed}"
        else:
            n_read += 1
            for profile in result:
                check(profile)
    return n_read


@pytest.mark.parametrize("layout", FILES)
@pytest.mark.parametrize(
    ("first", "n", "most"),
    [(0, N_FAST, 0.99), pytest.param(10_000, N_SLOW, 0.9, marks=pytest.mark.slow)],
    ids=["some", "many"],
)
def test_damaged_files_are_read_or_refused(tmp_path, layout, first, n, most):
    assert n / 100 <= read_damaged(tmp_path, layout, range(first, first + n)) <= most * n


@pytest.mark.parametrize("layout", [name for name in FILES if name != "sections"])
def test_what_was_read_of_a_damaged_file_can_be_written_and_read(tmp_path, layout):
    name, text, asked = FILES[layout]
    path, n_read = tmp_path / name, 0
    for seed in range(5000, 5000 + N_FAST // 3):
        path.write_bytes(damaged(text.encode(), seed))
        try:
            profile = read_profile(path, **asked)
        except WrongInput:
            continue
        again = tmp_path / ("again.prr" if profile.kind == "rail" else "again.prw")
        write_profile(profile, again)
        assert np.array_equal(read_profile(again, axes="field down").points, profile.points), f"seed {seed}"
        n_read += 1
    assert n_read > 0


@pytest.mark.parametrize("layout", FILES)
def test_random_bytes_are_refused(tmp_path, layout):
    name, _, asked = FILES[layout]
    for seed in range(30):
        rng = np.random.default_rng(seed)
        data = (
            rng.integers(256, size=200) if seed % 2 else rng.choice(list(b"0123456789.-+e,;= \n#!%'\""), 200)
        )
        path = tmp_path / name
        path.write_bytes(bytes(data.astype(np.uint8)))
        with pytest.raises(WrongInput):
            read_sections(path) if layout == "sections" else read_profile(path, **asked)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["-1e-3 ", "9" * 1000, "'", "\n", "\r", " ", "a.", "=", "0 0\n", "0 1\n1 0\n", "(("]
)
@pytest.mark.parametrize("layout", FILES)
def test_repetitions_of_a_megabyte_end_fast(tmp_path, layout, text):
    name, good, asked = FILES[layout]
    for where in (0, len(good) // 2):
        path = tmp_path / name
        path.write_text(good[:where] + text * (1_000_000 // len(text)) + good[where:])
        start = time.process_time()
        result = attempt(path, layout, asked)
        assert not isinstance(result, str) or len(result) < 1000
        assert time.process_time() - start < 20  # 2 s
