"""Formulas and example of docs/theory/wheel-on-rail.md."""

import re
from pathlib import Path

import numpy as np
import pytest
from track_sections import flanged

from geometries.track.wheelset import settle

PAGE = Path(__file__).parents[3] / "docs/theory/wheel-on-rail.md"


def test_the_example_runs_and_its_claims_hold():
    (example,) = re.findall(
        r"^```python\n(.*?)^```$", PAGE.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    names = {}
    exec(compile(example, PAGE, "exec"), names)
    assert example.count("assert") == 3
    assert names["conicity"].amplitude == 3


@pytest.mark.parametrize("shift", [0.5, 8.7])
def test_the_slope_of_the_height_by_the_roll(shift):
    """The formula of the page against differences of heights, on tread and flange."""
    layout, h = flanged(), 1e-5
    roll = settle(layout, shift).roll
    at, more, less = (settle(layout, shift, roll=roll + step) for step in (0, h, -h))
    y, z = at.left[0].point
    slope = -((y - shift) + (z - at.heights[0]) * np.tan(at.left[0].angle))
    # second order in h times the radius 460 mm over curvatures of 10 mm
    assert (more.heights[0] - less.heights[0]) / (2 * h) == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("shift", [0.5, 8.7])
def test_the_position_of_a_wheel_in_the_track(shift):
    layout = flanged()
    position = settle(layout, shift)
    for side, own, sign in (("left", layout.left, 1), ("right", layout.right, -1)):
        touch = getattr(position, side)[0]
        eta, zeta = own.wheel.position(touch.s_wheel)
        c, s = np.cos(sign * position.roll), np.sin(sign * position.roll)
        point = [sign * shift, position.height] + np.array([[c, -s], [s, c]]) @ [eta, zeta]
        np.testing.assert_allclose(point, touch.point, rtol=0, atol=1e-9)
        assert touch.radius == -zeta
