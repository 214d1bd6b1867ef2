"""Measured profiles and those of a benchmark, which are not part of this project."""

import numpy as np
import pytest

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile, write_profile
from tests.samples import SAMPLES

RAILS = {
    "MBench_UIC60_v3.prr": {},
    "MBench_UIC60_v3.ban": {"axes": "centre"},
    "avg_HR.BAN": {"axes": "centre"},
    "avg_low2.ban": {"axes": "centre"},
    "rail_left_iter795.ban": {"axes": "centre"},
    "r300_wide.prr": {},
    "site_b_hr.prr": {},
    "guard_rail_test.ban": {"axes": "centre up", "surface": 1},
}
WHEELS = [
    "MBench_S1002_v3.prw",
    "worn_high_mileage.prw",
    "Car7216_0001r.whl",
    "Car7358_0001r.whl",
    "avg_wheel.whl",
    "left-wheel-v1-pre-dry.whl",
    "whl_left_iter795.whl",
]


def sample(name, **asked):
    if not (SAMPLES / name).exists():
        pytest.skip(f"{SAMPLES / name} is missing; FEMIC_PROFILES names the folder of the samples")
    return read_profile(SAMPLES / name, **asked)


def raw(name):
    """All pairs of numbers at the beginnings of lines behind the header, read without the reader."""
    pairs = []
    for line in (SAMPLES / name).read_text().splitlines():
        try:
            pairs.append([float(word) for word in line.replace('"', "# ").split()[:2]])
        except ValueError:
            continue
    return np.array([pair for pair in pairs if len(pair) == 2]).T


def at(points, fractions):
    """Points at fractions of the arc length."""
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=1)))])
    return np.stack([np.interp(fractions * s[-1], s, row) for row in points])


def is_simple(points):
    """No two segments that are no neighbours meet, one row of all pairs at a time."""
    p, q = points[:, :-1], points[:, 1:]

    def side(a, b, c):
        return np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))

    for k in range(p.shape[1] - 2):
        a, b, c, d = p[:, k, None], q[:, k, None], p[:, k + 2 :], q[:, k + 2 :]
        if np.any((side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)):
            return False
    return True


@pytest.mark.parametrize("name", [*RAILS, *WHEELS])
def test_points_are_those_of_the_file_up_to_signs_and_order_also_written_and_read(tmp_path, name):
    profile = sample(name, **RAILS.get(name, {}))
    assert profile.kind == ("rail" if name in RAILS else "wheel")
    ours = {tuple(np.round(point, 9)) for point in np.abs(profile.points).T}
    theirs = {tuple(np.round(point, 9)) for point in np.abs(raw(name)).T}
    assert ours <= theirs
    # zigzags, numbers of headers; points up to 5 um apart
    most = {"guard_rail_test.ban": 1065, "MBench_UIC60_v3.prr": 21}
    assert len(theirs - ours) <= most.get(name, 4)
    assert is_simple(profile.points)
    path = tmp_path / ("s.prr" if profile.kind == "rail" else "s.prw")
    write_profile(profile, path)
    assert np.array_equal(read_profile(path).points, profile.points)


@pytest.mark.parametrize("name", RAILS)
def test_rails_are_heads_with_the_top_up(name):
    y, z = points = sample(name, **RAILS[name]).points
    assert (55 if name == "avg_HR.BAN" else 60) < np.ptp(y) < 90
    assert np.ptp(y[z > np.max(z) - 2]) > 20  # the running band is nearly level, and wide
    lowest_end = min(z[0], z[-1])  # faces hang down, at least on one side
    assert np.min(z) > lowest_end - 1
    assert 15 < np.max(z) - lowest_end < 45
    # the way along the surface has the metal on its right: it turns right from face to face
    chords = np.diff(at(points, np.linspace(0, 1, 60)), axis=1)
    directions = np.unwrap(np.arctan2(chords[1], chords[0]))
    assert directions[-1] - directions[0] < -np.radians(50)


@pytest.mark.parametrize("name", WHEELS)
def test_wheels_have_a_flange_at_the_gauge_side_that_hangs_down(name):
    y, z = sample(name).points
    assert 125 < np.ptp(y) < 150
    tip = np.argmin(np.where(y < y[0] + 50, z, np.inf))  # the flange is the first 30 to 40 mm
    back = np.min(y[: tip + 1])
    tread = np.interp(back + 70, y[tip:], z[tip:])  # the taping line: 70 mm from the back of the flange
    height = tread - z[tip]
    assert 26 < height < 38
    # thickness of the flange 10 mm below the taping line
    face = tip + np.flatnonzero(z[tip:] >= tread - 10)[0]
    assert 20 < y[face] - back < 38
    assert np.all(np.diff(y[tip : np.searchsorted(y[tip:], back + 100) + tip]) > 0)


@pytest.mark.parametrize("name", ["whl_left_iter795.whl", "left-wheel-v1-pre-dry.whl"])
def test_height_and_thickness_of_the_flange_are_those_in_the_header(name):
    """Sh and Sd, measured by the device: from its y = 0, 70 mm to the tread, and 10 mm below it."""
    y, z = sample(name).points
    header = dict(
        line.split("=", 1) for line in (SAMPLES / name).read_text().splitlines() if line.count("=") == 1
    )
    tip = np.argmin(z[: len(z) // 2])
    tread = np.interp(70, y[tip:], z[tip:])
    flank = slice(tip, np.searchsorted(y, 60))
    # the tip is between points; 0.03 mm in both files
    assert tread - z[tip] == pytest.approx(float(header["Sh"]), abs=0.05)
    assert np.interp(tread - 10, z[flank], y[flank]) == pytest.approx(float(header["Sd"]), abs=0.05)


def test_one_rail_in_two_formats_is_one_rail():
    block = sample("MBench_UIC60_v3.prr").points
    miniprof = sample("MBench_UIC60_v3.ban", axes="centre").points
    # the .ban has left out some points near the ends, and changed none; which of near ones stays depends
    assert len({tuple(point) for point in miniprof.T} - {tuple(point) for point in block.T}) <= 4
    s = np.linspace(0, 1, 300)
    np.testing.assert_allclose(at(miniprof, s), at(block, s), rtol=0, atol=2e-2)


def test_the_two_surfaces_of_a_guard_rail():
    sample("guard_rail_test.ban", axes="centre up", surface=1)
    path = SAMPLES / "guard_rail_test.ban"
    with pytest.raises(WrongInput, match=r"surface: there are 2 \(1: lines 35 to .* 2: lines"):
        read_profile(path, axes="centre up")
    running, guard = (read_profile(path, axes="centre up", surface=k).points for k in (1, 2))
    # by the drawing in the header: rail from -67.3 to 0, guard rail from 50.6 to 130.6, y to the centre
    np.testing.assert_allclose([running[0].min(), running[0].max()], [0, 67.2822], atol=1e-9)
    np.testing.assert_allclose([guard[0].min(), guard[0].max()], [-130.5875, -50.5875], atol=1e-4)
    assert np.max(guard[0]) < np.min(running[0])
