"""A patch that wraps around a rail: normals turn by nearly 60 degrees."""

import numpy as np
import pytest

from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.meshed_contact import Bodies, mesh_bodies, solved
from femic.contact.finite_elements.result import compute_numbers
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

STEEL = Material(210e3, 0.3)
LOAD = 40e3  # N


@pytest.fixture(scope="module")
def level():
    domain = Domain(60.0, 60.0)
    lower = Body(LOWER, arc(10.0, 1.1, 1.1), STEEL, domain)
    upper = Body(UPPER, arc(10.2, 1.0, 1.0), STEEL, domain, rolling_radius=300.0)
    bodies = Bodies(lower, upper, lower.contour.limits)
    return solved(bodies, mesh_bodies(bodies, Expected(4.0, (-5.2, 5.2)), 5.0), LOAD)


def test_the_patch_is_conformal(level):
    assert compute_numbers(level).angle > np.radians(55)
    assert np.all(level.p >= 0)


def test_reactions_and_pressures_carry_the_load(level):
    """Pressures on inclined surfaces count by their cosine."""
    assert level.reactions == pytest.approx((LOAD, -LOAD), rel=2e-5)
    assert level.load_of_pressures == pytest.approx(LOAD, rel=1e-5)


def test_pressures_integrate_to_the_load_on_the_arc(level):
    """By the trapezoidal rule on the plain pressures, with the cosine at each vertex."""
    cosine = np.cos(level.bodies.lower.contour.inclination(level.pair.s))
    assert 4 * level.pair.area @ (level.p * cosine) == pytest.approx(LOAD, rel=0.01)


def test_surfaces_in_contact_meet_in_space(level):
    """Deformed vertices in contact lie on the deformed upper surface: weighted gaps by interpolation."""
    pair, state = level.pair, level.solution.state
    lower = pair.lower.solid.trace
    u_lower = state.u_lower.reshape(-1, 3)[lower.nodes[pair.vertices]]
    sin, cos = level.bodies.lower.contour.normal(pair.s)
    upper = pair.upper.solid.trace
    distance = level.bodies.undeformed.distance(pair.x, pair.s)
    y, z = level.bodies.lower.contour.position(pair.s) + distance * np.stack([sin, cos])
    xi, y, z = level.bodies.upper.surface.to_chart(np.stack([pair.x, y, z]))
    t = level.bodies.upper.contour.nearest(np.stack([y, z]), (-12.0, 12.0))
    inner = (pair.x > 0.1) & (pair.s > 0.1) & (level.p > 0.3 * level.p.max())
    u_upper = upper.interpolation(np.abs(xi), np.abs(t)) @ state.u_upper.reshape(-1, 3)[upper.nodes]
    apart = u_upper - u_lower
    gap = distance - state.approach * cos + apart[:, 1] * sin + apart[:, 2] * cos
    assert np.count_nonzero(inner) > 12
    assert gap[inner] == pytest.approx(np.zeros(np.count_nonzero(inner)), abs=0.01 * state.approach)
