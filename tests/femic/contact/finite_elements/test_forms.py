"""Contacts of other forms: a ball on a block, arcs that touch on their flanks, a patch that wraps a rail."""

from dataclasses import replace

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
from tests.femic.contact.problems import BRASS, STEEL

# ---- a ball on a block. The ball is a whole wheel: its far side is above the patch, too

RADIUS, LOAD, FAR = 40.0, 900.0, 15.0  # mm, N, mm
BALL = PointContact(1 / RADIUS, 1 / RADIUS, combined_modulus(STEEL, BRASS)).at_load(LOAD)
ALL_ROUND = np.pi * RADIUS


def ball_on_block(half_length=ALL_ROUND):
    """A block, and a ball that is modelled up to a length [mm] along its equator."""
    block = Body(LOWER, plane(), STEEL, Domain(FAR, FAR))
    ball = Body(UPPER, arc(-RADIUS, 0.6, 0.6), BRASS, Domain(FAR, half_length), rolling_radius=RADIUS)
    return Bodies(block, ball, (-6.0, 6.0))


def at(cells, half_length=ALL_ROUND):
    """Meshes for Hertz's patch."""
    return mesh_bodies(ball_on_block(half_length), Expected(BALL.a, (-BALL.b, BALL.b)), cells)


@pytest.fixture(scope="module")
def coarse():
    return at(3.5)


def test_a_ball_on_a_block_converges_to_hertz(coarse):
    """The pressure with second order, or nearly so; half-lengths stay within a fifth of a cell."""
    assert ball_on_block().upper.closed
    errors = []
    for meshes in (coarse, at(5.5)):
        level = solved(ball_on_block(), meshes, LOAD)
        numbers = compute_numbers(level)
        errors.append(abs(numbers.p_max / BALL.p_max - 1))
        assert [numbers.a, numbers.b] == pytest.approx([BALL.a, BALL.a], abs=0.2 * BALL.a / meshes.cells)
        assert level.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)
    assert np.log(errors[0] / errors[1]) / np.log(5.5 / 3.5) > 1.5
    assert errors[1] < 0.006


def coupled(meshes, half_width):
    """The coupling within a half-width [mm] of the middle."""
    x, s = meshes.lower.solid.trace.basis.mesh.p
    near = np.flatnonzero(np.hypot(x, s) < half_width)
    return couple(meshes.lower, meshes.upper, ball_on_block().undeformed, near)


def test_an_upper_surface_that_ends_too_early_is_refused():
    with pytest.raises(Failure, match="lie opposite the upper surface; give a larger `far_radius`"):
        coupled(at(3.0, BALL.a), 2 * BALL.a)


def test_points_opposite_several_of_the_upper_surface_are_refused(coarse, monkeypatch):
    """As would be the far side of the ball, were it not left out."""
    monkeypatch.setattr(coupling, "ROOM", np.inf)
    with pytest.raises(Failure, match="opposite several points of the upper surface; give a smaller load"):
        coupled(coarse, BALL.a)


# ---- arcs side by side touch where the line between their centres inclines by delta
# A small contact there is Hertz's: pressures act along that line: F_y / N = tan(delta) under any load.

R_LOWER, R_UPPER, R_ROLLING = 60.0, 90.0, 400.0  # mm; both arcs are convex
DELTA = np.radians(35.0)
ASIDE = (R_LOWER + R_UPPER) * np.sin(DELTA)  # of the upper body [mm]
MIDDLE = R_LOWER * DELTA  # arc length where they touch [mm]
CIRCLE = R_ROLLING - R_UPPER * (1 - np.cos(DELTA))  # radius of the wheel there [mm]
ON_FLANK, CELLS, FAR_END, SOUGHT = 600.0, 3.5, 60.0, 10.0
# the contact lies in a plane that inclines: the load on it is N / cos(delta)
INCLINED = PointContact(
    np.cos(DELTA) / CIRCLE, 1 / R_LOWER + 1 / R_UPPER, combined_modulus(STEEL, BRASS)
).at_load(ON_FLANK / np.cos(DELTA))


def arcs(side=1):
    """The pair with the upper body moved towards +y, or towards -y."""
    domain = Domain(FAR_END, FAR_END)
    lower = Body(LOWER, arc(R_LOWER, 0.9, 1.0), STEEL, domain)
    upper = Body(UPPER, arc(-R_UPPER, 0.9, 1.0), BRASS, domain, rolling_radius=R_ROLLING)
    if side < 0:
        lower = replace(lower, contour=arc(R_LOWER, 1.0, 0.9))
        upper = replace(upper, contour=arc(-R_UPPER, 1.0, 0.9))
    low, high = sorted((side * (MIDDLE - SOUGHT), side * (MIDDLE + SOUGHT)))
    return Bodies(lower, upper, (low, high), side * ASIDE)


def on_flanks(side=1):
    """The contact on meshes for Hertz's patch."""
    whole, half = arcs(side), INCLINED.b
    patch = Expected(INCLINED.a, (side * MIDDLE - half, side * MIDDLE + half))
    return solved(whole, mesh_bodies(whole, patch, CELLS), ON_FLANK)


@pytest.fixture(scope="module")
def aside():
    return on_flanks()


def test_small_contact_on_the_flank_agrees_with_hertz(aside):
    """Largest pressure and half-lengths, at 3.5 cells along the shorter one."""
    numbers = compute_numbers(aside)
    assert numbers.p_max == pytest.approx(INCLINED.p_max, rel=0.03)
    assert [numbers.a, numbers.b] == pytest.approx([INCLINED.a, INCLINED.b], rel=0.06)


def test_lateral_force_is_the_load_times_the_tangent(aside):
    """The centre of pressure is known to a twentieth of a cell, which turns the force by 1/6000.

    All normals of an arc meet at its centre, which is R below the crown: M_x = R F_y.
    """
    numbers = compute_numbers(aside)
    assert numbers.s_centre == pytest.approx(MIDDLE, abs=0.05 * INCLINED.b / CELLS)
    assert numbers.F_y == pytest.approx(ON_FLANK * np.tan(DELTA), rel=1e-3)
    assert numbers.M_x == pytest.approx(R_LOWER * numbers.F_y, rel=1e-9)


def test_supports_of_both_bodies_balance_the_lateral_force(aside):
    """To the tolerance of the linear problems."""
    lower, upper = aside.support_forces
    assert [lower[1], upper[1]] == pytest.approx([aside.lateral_force, -aside.lateral_force], rel=1e-3)
    assert [lower[2], upper[2]] == pytest.approx([ON_FLANK, -ON_FLANK], rel=1e-5)


def test_mirrored_contact_has_the_opposite_lateral_force(aside):
    """Meshes are no mirror images: numbers agree as well as each of them is known."""
    numbers, mirrored = compute_numbers(aside), compute_numbers(on_flanks(-1))
    assert mirrored.F_y == pytest.approx(-numbers.F_y, rel=2e-3)
    assert mirrored.M_x == pytest.approx(-numbers.M_x, rel=2e-3)
    assert mirrored.s_centre == pytest.approx(-numbers.s_centre, abs=0.1 * INCLINED.b / CELLS)
    assert mirrored.p_max == pytest.approx(numbers.p_max, rel=0.03)


# ---- normals that turn by nearly 60 degrees
CONFORMING = 40e3  # N


@pytest.fixture(scope="module")
def conforming():
    domain = Domain(60.0, 60.0)
    lower = Body(LOWER, arc(10.0, 1.1, 1.1), STEEL, domain)
    upper = Body(UPPER, arc(10.2, 1.0, 1.0), STEEL, domain, rolling_radius=300.0)
    bodies = Bodies(lower, upper, lower.contour.limits)
    return solved(bodies, mesh_bodies(bodies, Expected(4.0, (-5.2, 5.2)), 5.0), CONFORMING)


def test_pressures_of_a_conformal_patch_carry_the_load(conforming):
    """On inclined surfaces they count by their cosine: plain ones, by the trapezoidal rule, too."""
    assert compute_numbers(conforming).angle > np.radians(55)
    assert np.all(conforming.p >= 0)
    assert conforming.reactions == pytest.approx((CONFORMING, -CONFORMING), rel=2e-5)
    assert conforming.load_of_pressures == pytest.approx(CONFORMING, rel=1e-5)
    cosine = np.cos(conforming.bodies.lower.contour.inclination(conforming.pair.s))
    assert 4 * conforming.pair.area @ (conforming.p * cosine) == pytest.approx(CONFORMING, rel=0.01)


def test_surfaces_in_contact_meet_in_space(conforming):
    """Deformed vertices in contact lie on the deformed upper surface: weighted gaps by interpolation."""
    pair, state = conforming.pair, conforming.solution.state
    lower = pair.lower.solid.trace
    u_lower = state.u_lower.reshape(-1, 3)[lower.nodes[pair.vertices]]
    sin, cos = conforming.bodies.lower.contour.normal(pair.s)
    upper = pair.upper.solid.trace
    distance = conforming.bodies.undeformed.distance(pair.x, pair.s)
    y, z = conforming.bodies.lower.contour.position(pair.s) + distance * np.stack([sin, cos])
    xi, y, z = conforming.bodies.upper.surface.to_chart(np.stack([pair.x, y, z]))
    t = conforming.bodies.upper.contour.nearest(np.stack([y, z]), (-12.0, 12.0))
    inner = (pair.x > 0.1) & (pair.s > 0.1) & (conforming.p > 0.3 * conforming.p.max())
    u_upper = upper.interpolation(np.abs(xi), np.abs(t)) @ state.u_upper.reshape(-1, 3)[upper.nodes]
    apart = u_upper - u_lower
    gap = distance - state.approach * cos + apart[:, 1] * sin + apart[:, 2] * cos
    assert np.count_nonzero(inner) > 12
    assert gap[inner] == pytest.approx(np.zeros(np.count_nonzero(inner)), abs=0.01 * state.approach)
