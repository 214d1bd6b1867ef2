"""Planar contact: that of Hertz at several contact angles, beside conformal contact, and rolling."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import Pair, Solid
from compare.validation.statements.wheels import kinked
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.pairs.ics import approximation
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.pairs.planar import planar, solve_planar
from femic.contact.pairs.quantities import numbers
from femic.contact.specification import Profile
from femic.contact.undeformed import Line
from geometries.bodies import Body
from geometries.contours import Contour, arc
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.pairs.problems import DOMAIN, problem, wheel_on_rail
from tests.femic.shifts.test_shift_contact import bumpy

R_RAIL, R_ROLL = 60.0, 400.0  # mm
SOFT, STEEL = Material(100e3, 0.25), Material(210e3, 0.3)


def cone_on_cylinder(angle, **keys):
    """A conical wheel on a rail that is a cylinder: they touch where this inclines as the cone does."""
    cone = Contour(Line((0.0, 0.0), angle), (0.0, 0.0))
    bodies = {
        "lower": Body(LOWER, arc(R_RAIL, 1.2, 1.2), STEEL, DOMAIN),
        "upper": Body(UPPER, cone, SOFT, DOMAIN, R_ROLL),
    }
    solids = (Solid(bodies[name].material, bodies[name].surface) for name in ("upper", "lower"))
    return replace(problem(**keys), bodies=bodies, pair=Pair(*solids), reference_length=R_RAIL)


def hertz(angle, normal_force):
    """The point contact along the normal: a cone of the circle's radius at the touching point."""
    radius = R_ROLL + R_RAIL * np.sin(angle) * np.tan(angle)
    modulus = combined_modulus(SOFT, STEEL)
    return PointContact(np.cos(angle) / radius, 1 / R_RAIL, modulus).at_load(normal_force)


def pair(of):
    """The bodies of a problem on any grid."""
    return pair_on_grid(of, of.grid)


@pytest.mark.parametrize("degrees", [0.0, 20.0, -40.0])
def test_small_loads_give_the_contact_of_hertz_along_the_normal(degrees):
    """b over the radius of the rail is 0.6 %; the rest is the size of elements (20 across)."""
    angle, load = np.radians(degrees), 100.0
    contact = solve_planar(pair(cone_on_cylinder(angle, loads=(load,))), load)
    exact = hertz(angle, load / np.cos(angle))
    (patch,) = contact.patches
    own = numbers(patch.on_grid, patch.contact)
    # the mean inclination of an overlap that is symmetric to the second order in its width over the radius
    assert patch.plane.angle == pytest.approx(angle, abs=1e-4)
    assert patch.normal_force == pytest.approx(exact.load, rel=1e-4)
    assert own["load"] == pytest.approx(patch.normal_force)  # in the plane it is along the normal
    assert own["p_max"] == pytest.approx(exact.p_max, rel=0.01)
    assert (own["a"], own["b"]) == pytest.approx((exact.a, exact.b), rel=0.02)
    assert contact.approach * np.cos(angle) == pytest.approx(exact.approach, rel=0.01)


def test_the_vertical_forces_of_all_planes_are_the_load_along_a_rolled_direction():
    """Whatever the angle of the load to the z axis: it is the sum over the planes."""
    for roll in (0.0, 0.03):
        contact = solve_planar(pair(cone_on_cylinder(np.radians(20.0), loads=(2e3,))), 2e3, roll=roll)
        carried = [patch.normal_force * np.cos(patch.plane.angle - roll) for patch in contact.patches]
        assert sum(carried) == pytest.approx(2e3, rel=2e-6)


def test_the_plane_has_the_mean_inclination_of_the_overlap():
    """Weighted with depth^(5/2) dy, by a quadrature of its own, where the overlap is not symmetric."""
    bodies = kinked()
    contact = solve_planar(bodies, 2e4)
    (patch,), undeformed, zeta = contact.patches, bodies.undeformed, contact.approach
    s = np.linspace(-8, 20, 400001)
    lower, upper = undeformed.lower.contour, undeformed.upper.contour
    y, z = lower.position(s)
    t = np.interp(y - undeformed.shift, upper.position(s)[0], s)
    depth = np.maximum(z - (upper.position(t)[1] + undeformed.touching[1] - zeta), 0)
    weights = depth[:-1] ** 2.5 * np.diff(y)
    delta = np.average(lower.inclination(s)[:-1], weights=weights)
    assert patch.plane.angle == pytest.approx(delta, abs=1e-4)
    assert abs(delta - lower.inclination(np.array(undeformed.touching[0]))) > 20 * 1e-4


def test_each_patch_has_a_plane_of_its_own():
    """Two bumps, the second one lower: together they carry the load."""
    bodies, roll = wheel_on_rail(bumpy(0.02))
    contact = solve_planar(bodies, 9e4, roll=roll)
    assert len(contact.patches) == 2
    one, other = (patch.normal_force for patch in contact.patches)
    assert one > other > 0
    assert one + other == pytest.approx(9e4, rel=1e-3)  # both planes are nearly level


@pytest.mark.parametrize(("degrees", "number", "least"), [(0.0, "p_max", 3e-3), (25.0, "F_y", 8e-3)])
def test_nearly_flat_bodies_have_the_contact_with_a_to_the_second_order(degrees, number, least):
    """A patch half as wide has a quarter of the difference, on grids about the touching point.

    b over the radius is 0.07, then half of it. At an angle edges lie differently on both grids, which
    p_max shows; the lateral force is the same function of the contact angles of all elements.
    """
    angle, differences = np.radians(degrees), []
    for load in (4e5, 5e4):
        of, patch = cone_on_cylinder(angle, loads=(load,)), hertz(angle, load / np.cos(angle))
        grid = Grid(48, 40, 3 * patch.a / 48, 3 * patch.b / 40, R_RAIL * angle)
        conformal = pair_on_grid(of, grid)
        flat = replace(planar(conformal, R_RAIL * angle), grid=replace(grid, s=0.0))
        solved = [each.solve(each.flat, Loading(load)) for each in (flat, conformal)]
        one, other = (numbers(contact.on_grid, contact.normal)[number] for contact in solved)
        differences.append(one / other - 1)
    assert least < abs(differences[0]) < 0.02
    assert differences[0] / differences[1] == pytest.approx(4.0, rel=0.03)


def test_the_grid_is_sized_in_the_plane():
    of = problem(loads=(5e3,), shift=0.6)
    (patch,), (finer,) = (solve_planar(pair(of), 5e3, elements=n).patches for n in (20, 40))
    across = np.flatnonzero(patch.contact.in_contact.any(axis=0))
    assert 16 <= np.ptp(across) + 1 <= 24
    low, high = patch.on_grid.grid.extent
    assert low < 0 < high
    assert planar(patch.on_grid) is patch.on_grid
    assert np.max(finer.contact.p) == pytest.approx(np.max(patch.contact.p), rel=0.01)
    assert finer.plane.angle == pytest.approx(patch.plane.angle, abs=1e-4)
    elsewhere = planar(pair(of), at=1.0).undeformed
    assert elsewhere.angle == pytest.approx(0.1)  # tangent there
    assert planar(pair(of), at=1.0, inclination=0.3).undeformed.angle == 0.3


def test_an_extra_gap_is_refused():
    gap = Profile(np.array([-1.0, 1.0]), np.array([0.01, 0.01]))
    with pytest.raises(WrongInput, match=r"extra_gap: planar contact does not allow it, .*; leave it out"):
        solve_planar(pair(problem(loads=(1e3,), extra_gap=gap)), 1e3)


# ---- rolling


def rolled(creepages, by_angle=()):
    of = cone_on_cylinder(np.radians(25.0), loads=(2e3,))
    (patch,) = solve_planar(pair(of), 2e3).patches
    on_grid = replace(patch.on_grid, undeformed=planar(pair(of)).undeformed)
    frictional = frictional_problem(on_grid, approximation(on_grid, "A"), 0.3, by_angle)
    wheel = rolling_problem(on_grid, frictional)
    return wheel, wheel.contact(creepages, Loading(2e3)).contact


def test_rigid_slip_in_the_plane_is_creepage_and_spin_of_the_contact_angle():
    """The wheel turns about the normal of the plane by sin(delta) / R per rolled distance."""
    angle, xi, upsilon, phi = np.radians(25.0), 1e-3, -4e-4, 2e-5
    on_grid = planar(pair_on_grid(cone_on_cylinder(angle), problem().grid))
    frictional = frictional_problem(on_grid, approximation(on_grid, "A"), 0.3)
    rolling = rolling_problem(on_grid, frictional).rolling
    s, x = on_grid.grid.strips, on_grid.x[:, None]
    y, z = (R_RAIL * np.sin(angle), R_RAIL * (np.cos(angle) - 1))
    radius = R_ROLL - (z - on_grid.undeformed.touching[1])  # of the touching point's circle
    spin = (1 + xi) * np.sin(angle) / R_ROLL + phi * np.cos(angle)
    along_x = 1 - (1 + xi) * radius / R_ROLL - phi * y - spin * s + 0 * x
    along_s = upsilon * np.cos(angle) + spin * x + 0 * s
    found = rolling.rigid_slip(Creepages(xi, upsilon, phi))
    np.testing.assert_allclose(found, np.stack([along_x, along_s], axis=-1), atol=1e-9)


def test_friction_in_the_plane_is_that_of_one_contact_angle():
    """The law of the contact angle has one factor here; all slides at a large creepage."""
    wheel, contact = rolled(Creepages(0.5), [(20.0, 1.0), (30.0, 0.5)])
    np.testing.assert_allclose(wheel.problem.factor, 0.75, rtol=1e-6)
    pressed = float(np.sum(contact.p[..., N])) * wheel.problem.grid.area
    assert contact.force[0] == pytest.approx(0.3 * 0.75 * pressed, rel=1e-3)
    assert contact.force[2] == pytest.approx(2e3, rel=1e-5)
