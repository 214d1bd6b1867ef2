"""How many wavenumbers a request is expected to take, against those that it takes."""

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.harmonic.engine import expected_samples, solve
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.meshing import Cells
from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse, plane
from geometries.materials import Material
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER

STEEP = np.radians(60)
OBSERVED = Points(np.zeros(7), np.array([-8.0, -1.6, -0.3, 0.0, 0.7, 1.6, 8.0]))
CASES = {  # (side, contour, R_roll, half-sides, accuracy as a share of 1 / (2 pi G 8 mm))
    "plane": (LOWER, plane(), np.inf, (0.2, 0.3), 1e-3),
    "plane, roughly": (LOWER, plane(), np.inf, (0.2, 0.3), 3e-2),
    "plane, small patch": (LOWER, plane(), np.inf, (0.004, 0.006), 1e-3),
    "plane, long patch": (LOWER, plane(), np.inf, (1.0, 0.01), 1e-3),
    "rail, wide patch": (LOWER, ellipse(13.0, 6.5, STEEP, STEEP), np.inf, (0.1, 1.0), 1e-3),
    "small wheel": (UPPER, arc(10.0, STEEP, STEEP), 50.0, (0.3, 0.2), 1e-3),
    "large wheel": (UPPER, arc(10.0, STEEP, STEEP), 1e5, (0.3, 0.2), 1e-3),
}


MORE = ("plane, long patch", "plane, small patch", "large wheel")


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow) if case in MORE else case for case in CASES]
)
def test_as_many_wavenumbers_are_expected_as_are_taken(case):
    side, contour, rolling_radius, (a, b), share = CASES[case]
    material = Material(210e3, 0.28)
    body = Body(side, contour, material, Domain(320.0, np.inf), rolling_radius)
    accuracy = share / (2 * np.pi * material.G * 8.0)
    loads = tuple(Load(Patch(a, b), direction) for direction in (1, 2))
    asked = HarmonicRequest(body, loads, OBSERVED, Cells(b / 2, 0.8, 0.8), accuracy)
    taken = len(solve(asked).samples.k)
    expected = len(expected_samples(asked).k)
    if "plane" in case:
        assert abs(expected - taken) <= 3, (expected, taken)  # an interval next to the far arc's effect
    assert 0.7 < expected / taken < 1.3, (expected, taken)


def test_tighter_accuracy_takes_more_wavenumbers_and_may_differ_by_observer():
    body = Body(LOWER, plane(), Material(210e3, 0.28), Domain(320.0, np.inf))
    loads = (Load(Patch(0.2, 0.3), 2),)

    def expected(accuracy):
        asked = HarmonicRequest(body, loads, OBSERVED, Cells(0.1, 0.5, 0.5), accuracy)
        return len(expected_samples(asked).k)

    assert expected(1e-9) < expected(1e-11)
    each = np.full((1, 1, len(OBSERVED.s)), 1e-9)
    assert expected(each) == expected(1e-9)
    each[..., 3] = 1e-11
    assert expected(1e-9) < expected(each) <= expected(1e-11)
