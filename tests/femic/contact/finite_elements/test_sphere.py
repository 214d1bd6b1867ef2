"""A ball on a block against Hertz. The ball is a whole wheel: its far side is above the patch, too."""

import numpy as np
import pytest

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.finite_elements import coupling
from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.coupling import couple
from femic.contact.finite_elements.meshed_contact import Bodies, mesh_bodies, solved
from femic.contact.finite_elements.result import compute_numbers
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.errors import Failure
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.finite_elements.ellipse import BRASS, STEEL

RADIUS, LOAD, FAR = 40.0, 900.0, 15.0  # mm, N, mm
HERTZ = PointContact(1 / RADIUS, 1 / RADIUS, combined_modulus(STEEL, BRASS)).at_load(LOAD)
ALL_ROUND = np.pi * RADIUS


def bodies(half_length=ALL_ROUND):
    """A block, and a ball that is modelled up to a length [mm] along its equator."""
    block = Body(LOWER, plane(), STEEL, Domain(FAR, FAR))
    ball = Body(UPPER, arc(-RADIUS, 0.6, 0.6), BRASS, Domain(FAR, half_length), rolling_radius=RADIUS)
    return Bodies(block, ball, (-6.0, 6.0))


def at(cells, half_length=ALL_ROUND):
    """Meshes for Hertz's patch."""
    return mesh_bodies(bodies(half_length), Expected(HERTZ.a, (-HERTZ.b, HERTZ.b)), cells)


@pytest.fixture(scope="module")
def coarse():
    return at(4.0)


def test_a_ball_on_a_block_converges_to_hertz(coarse):
    """The pressure with second order, or nearly so; half-lengths stay within a fifth of a cell."""
    assert bodies().upper.closed
    errors = []
    for meshes in (coarse, at(6.5)):
        level = solved(bodies(), meshes, LOAD)
        numbers = compute_numbers(level)
        errors.append(abs(numbers.p_max / HERTZ.p_max - 1))
        assert [numbers.a, numbers.b] == pytest.approx([HERTZ.a, HERTZ.a], abs=0.2 * HERTZ.a / meshes.cells)
        assert level.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)
    assert np.log(errors[0] / errors[1]) / np.log(6.5 / 4) > 1.5
    assert errors[1] < 0.006


def coupled(meshes, half_width):
    """The coupling within a half-width [mm] of the middle."""
    x, s = meshes.lower.solid.trace.basis.mesh.p
    near = np.flatnonzero(np.hypot(x, s) < half_width)
    return couple(meshes.lower, meshes.upper, bodies().undeformed, near)


def test_an_upper_surface_that_ends_too_early_is_refused():
    with pytest.raises(Failure, match="lie opposite the upper surface; give a larger `far_radius`"):
        coupled(at(3.0, HERTZ.a), 2 * HERTZ.a)


def test_points_opposite_several_of_the_upper_surface_are_refused(coarse, monkeypatch):
    """As would be the far side of the ball, were it not left out."""
    monkeypatch.setattr(coupling, "ROOM", np.inf)
    with pytest.raises(Failure, match="opposite several points of the upper surface; give a smaller load"):
        coupled(coarse, HERTZ.a)
