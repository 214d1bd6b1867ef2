"""Loads on both sides of the crown, before and after the discount: reciprocity, mirror images."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.engines import SOLID
from femic.reference.job import Job, Settings
from geometries.contours import through_points
from geometries.patches import Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import COARSE, UNSYMMETRIC, request_for
from tests.femic.reference.known_bodies import reference

HERE, THERE = -1.5, 2.5
CELLS = replace(COARSE, smallest=0.1)
FINER = replace(COARSE, smallest=0.08, growth=0.25, line_growth=0.15)
BODIES = {"rail": (LOWER, np.inf, CELLS), "wheel": (UPPER, 80.0, FINER)}

pytestmark = pytest.mark.slow


def lateral_ics(name, contour, s_load, s_observer, x=0.0):
    """C of s and n before and after the discount, and its estimate, (2, 2) each, at one observer."""
    side, radius, cells = BODIES[name]
    body = request_for(contour, side=side, rolling_radius=radius).body
    points = Points(np.array([x]), np.array([s_observer]))
    settings = Settings(SOLID, cells=cells, rotation_reach=5.0, moment_arm=2.0)
    loads = Patch(0.2, 0.2, s_load), ("ss", "sn", "ns", "nn")
    result = reference(Job(body, *loads, points, {"point": slice(0, 1)}, settings))
    return [values[1:, 1:, 0] for values in (result.raw, result.c.ic, result.c.estimate)]


@pytest.mark.parametrize("name", BODIES)
def test_loads_on_both_sides_of_the_crown_are_reciprocal(name):
    *there, known_there = lateral_ics(name, UNSYMMETRIC, HERE, THERE)
    *here, known_here = lateral_ics(name, UNSYMMETRIC, THERE, HERE)
    allowed = known_there + known_here.T
    for one, other in zip(there, here, strict=True):
        assert np.all(np.abs(one - other.T) <= allowed), np.abs(one - other.T) / allowed
    assert np.all(allowed < 0.03 * np.abs(there[1]).max())  # not trivially large
    # not trivially true either: it fails by far more with observer and load not exchanged
    assert np.abs(there[1] - here[1]).max() > 10 * allowed.max()


def test_a_load_at_s_is_the_mirrored_load_at_minus_s_on_the_mirrored_section():
    y = np.linspace(-12, 12, 41)
    z = -(y**2) / 30 - 0.03 * y - 0.0005 * y**3
    *here, known = lateral_ics("wheel", through_points(y, z), THERE, HERE, 1.5)
    *mirrored, known_mirrored = lateral_ics("wheel", through_points(y, z[::-1]), -THERE, -HERE, 1.5)
    allowed, signs = known + known_mirrored, np.array([[1, -1], [-1, 1]])
    for one, other in zip(here, mirrored, strict=True):
        assert np.all(np.abs(one - signs * other) <= allowed), np.abs(one - signs * other) / allowed
    assert np.all(allowed < 0.05 * np.abs(here[1]).max())
