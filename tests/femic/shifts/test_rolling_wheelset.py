"""A rolling wheelset: Kalker's linear theory, free rolling, mirrored motions, signs, equilibrium, errors."""

import json
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from compare.pages.shift_figures import OF_ROLLING, difference, difference_estimate
from femic.contact.estimates import from_grids
from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.pairs.ics import approximation
from femic.shifts.axle import (
    OF_PATCH,
    OF_WHEEL,
    TORQUE,
    VERTICAL,
    RollingWheelset,
    WheelNumbers,
    axle_numbers,
    wheel_numbers,
)
from femic.shifts.contact import contact_at, read_grids
from femic.shifts.position import RollingSide, label_wheelset, roll
from femic.shifts.sides import SIDES, Place, bodies_at, contact_problem
from femic.shifts.specification import ContactTable, RollingTable
from femic.shifts.wheel import RollingWheel
from geometries.errors import Failure
from geometries.patches import Grid
from geometries.track.wheelset import settle
from tests.femic.shifts.layouts import R_0, RAIL, STEEL, WHEEL, arcs_on_arcs, cones_on_arcs

FRICTION, LOAD = 0.3, 9e4


@cache
def sides(layout, shift, load=LOAD, elements=12, given_roll="about rails"):
    """Both sides at a shift, on the grids of their frictionless contacts."""
    position = settle(layout, shift, roll=given_roll)
    both = []
    for side in SIDES:
        where = Place(layout, position, side)
        asked = ContactTable(load=load, ics=("A",), elements=elements, planar=False)
        contact = contact_at(where, RAIL, WHEEL, asked)
        grids, bodies = read_grids(contact), bodies_at(where, RAIL, WHEEL)
        problem = contact_problem(bodies, asked, grids[0])
        both.append(RollingSide(where, problem, grids, contact.approach.item(), with_c=False))
    return tuple(both)


def rolled(both, load=LOAD, ics="A", **motion):
    """The wheelset with one kind of ICs."""
    wheels = tuple(wheel_on(side, load, ics, **motion) for side in both)
    return RollingWheelset(wheels, load, wheels[0].motion).solve()


def wheel_on(side, load=LOAD, ics="A", **motion):
    """The wheel of a side; friction may be larger than that of files."""
    pressed = side.pressed(ics, load)
    operators = [approximation(on_grid, ics) for on_grid in pressed.areas.on_grids]
    return RollingWheel.on_areas(side.place, pressed, operators, RollingTable.model_construct(**motion))


def numbers(both, load=LOAD, ics="A", **rolling):
    return roll(both, load, RollingTable(**rolling), (ics,)).isel(ics=0)


def labelled(state, ics="A"):
    """The numbers of a wheelset that is solved, as `numbers` has them."""
    left, right = (wheel_numbers(state, k, ics) for k in range(2))
    axle = axle_numbers(state, left, right)
    return label_wheelset(ics, dict(zip(SIDES, (left, right), strict=True)), axle).isel(ics=0)


@cache
def at_2():
    """The wheelset on arcs, shifted by 2 mm, rolling freely."""
    return numbers(sides(arcs_on_arcs("arcs"), 2.0))


def test_floors_of_several_contacts_of_a_wheel_add_up_and_the_largest_missed_share_counts(monkeypatch):
    """As if the wheel had two contacts."""
    state = rolled(sides(arcs_on_arcs("arcs"), 2.0))
    rows = {"floor_": (1.0, 2.0), "missed_": (0.1, 0.3)}

    def of_two(_, quantities):
        return {prefix: [dict.fromkeys(quantities, one) for one in both] for prefix, both in rows.items()}

    monkeypatch.setattr("femic.shifts.axle.difference_errors_of_all", of_two)
    variations = wheel_numbers(state, 0, "A").variations
    assert set(variations["floor_"].values()) == {3.0}
    assert set(variations["missed_"].values()) == {0.3}


def test_small_creepages_of_cones_are_those_of_kalkers_linear_theory():
    """Nothing slips: F_x = G c^2 C11 xi, F_s = -G c^2 (C22 upsilon + c C23 phi).

    phi is sin(inclination) / R, the part of the wheel's rotation, and the spin of the yaw.
    """
    load, motion = 300.0, {"friction": 50.0, "lateral": 2e-5, "spin": 1e-8}
    both = sides(cones_on_arcs(), 0.1, load, 16)
    free = rolled(both, load, **motion)
    for wheelset in (free, rolled(both, load, longitudinal=free.xi_0 + 2e-5, **motion)):
        for wheel, contact in zip(wheelset.wheels, wheelset.contacts, strict=True):
            touch = wheel.place.touch
            inclination = wheel.place.roll - touch.angle
            point = PointContact(
                np.cos(inclination) / touch.radius, 1 / 300.0, combined_modulus(STEEL, STEEL)
            )
            ellipse = point.at_load(load / np.cos(touch.angle))
            coefficients = creepage_coefficients(ellipse.a, ellipse.b, STEEL.nu)
            given = contact.creepages
            spin = np.sin(inclination) / touch.radius + given.spin * np.cos(inclination)
            aside = given.lateral * np.cos(inclination)
            F_x, F_s, _ = coefficients.forces(STEEL.G, given.longitudinal, aside, spin)
            p, area = contact.states[0].p, wheel.on_grids[0].grid.area
            largest = STEEL.G * ellipse.a * ellipse.b * coefficients.C11 * 1e-5
            assert np.sum(p[..., 0]) * area == pytest.approx(F_x, rel=0.03, abs=0.02 * largest)
            assert np.sum(p[..., 1]) * area == pytest.approx(F_s, rel=0.03)


def test_free_cones_roll_at_the_mean_of_their_radii():
    """Linear theory with equal ellipses: the creepages of both wheels are opposite."""
    both = sides(cones_on_arcs(), 0.1, 300.0, 16)
    wheelset = rolled(both, 300.0, friction=50.0)
    radii = [side.place.touch.radius for side in both]
    assert radii[0] - radii[1] == pytest.approx(2 * 0.1 / 20, rel=0.1)
    assert wheelset.xi_0 == pytest.approx(2 * R_0 / sum(radii) - 1, abs=2e-2 * (radii[0] - radii[1]) / R_0)


def test_without_shift_both_wheels_only_push_aside():
    found = rolled(sides(arcs_on_arcs("arcs"), 0.0))
    solved = labelled(found)
    left, right = (solved.sel(side=side) for side in SIDES)
    for name in OF_WHEEL:
        near = {"rel": 1e-6, "abs": 1e-4 * abs(left["F_y"].item())}
        assert left[name].item() == pytest.approx(right[name].item(), **near), name
    assert abs(left["F_x"]) < 1e-4 * FRICTION * LOAD
    assert left["F_y"] > 0
    assert abs(solved.sum_F_y) < 1e-4 * left["F_y"]
    # no force along x: the mean of its circles rolls
    (wheel, _), contact = found.wheels, found.contacts[0].states[0]
    radii, weights = wheel.radius - wheel.problems[0].rolling.height, contact.pressures.sum(axis=0)
    mean, spread = np.average(radii, weights=weights), np.ptp(radii[weights > 0])
    assert found.xi_0 == pytest.approx(R_0 / mean - 1, abs=0.02 * spread / R_0)
    assert abs(mean - wheel.radius) > 0.04 * spread  # not the radius of the touching point


@pytest.mark.slow  # without shift the test above compares both sides
def test_the_mirrored_wheelset_has_the_mirrored_forces():
    """Shift, lateral velocity and yaw rate to the other side."""
    layout = arcs_on_arcs("arcs")
    one = numbers(sides(layout, 2.0), lateral=0.001, spin=1e-6)
    other = numbers(sides(layout, -2.0), lateral=-0.001, spin=-1e-6)
    for side, mirrored in (("left", "right"), ("right", "left")):
        for name in ("xi", "F_x", "F_y", "M_z", "work", "p_max_rolling"):
            here, there = one[name].sel(side=side), other[name].sel(side=mirrored)
            assert here.item() == pytest.approx(there.item(), rel=1e-3, abs=1e-6), name
    assert one.xi_0 == pytest.approx(other.xi_0.item(), abs=1e-8)
    for name in ("sum_F_y", "steering"):
        assert one[name] == pytest.approx(-other[name].item(), rel=1e-3)


def test_the_creepage_of_free_rolling_given_is_free_rolling():
    both = sides(arcs_on_arcs("arcs"), 2.0)
    free = at_2()
    given = numbers(both, longitudinal=free.xi_0.item())
    driven = numbers(both, longitudinal=free.xi_0.item() + 0.001)
    unit = FRICTION * LOAD * R_0
    for solved in (free, given):
        assert abs(solved.axle_torque) < 2 * TORQUE * unit
    assert driven.axle_torque > 0.3 * unit
    for side in SIDES:
        for name in ("F_x", "F_y", "work"):
            one, other = (solved[name].sel(side=side).item() for solved in (free, given))
            assert one == pytest.approx(other, rel=1e-4, abs=1e-5 * FRICTION * LOAD)


def test_the_wheel_of_larger_radius_drives_and_the_wheelset_steers_back():
    """Shifted to the left: omega R > V there, the rail pushes this wheel ahead, which turns to the right."""
    solved = at_2()
    left, right = (solved.sel(side=side) for side in SIDES)
    assert left["xi"] > 0 > right["xi"]
    assert left["F_x"] > 0.01 * FRICTION * LOAD
    assert right["F_x"] < -0.01 * FRICTION * LOAD
    assert solved.steering > 0


def test_friction_opposes_lateral_motion_and_yaw():
    """To the left: pushed to the right. Yaw to the left: the left wheel advances less, and is pushed on."""
    both = sides(arcs_on_arcs("arcs"), 0.0)
    still, aside, turning = numbers(both), numbers(both, lateral=0.001), numbers(both, spin=2e-6)
    assert aside.sum_F_y < -0.2 * FRICTION * LOAD
    assert aside.F_y.sel(side="left") > still.F_y.sel(side="left")
    assert aside.F_y.sel(side="right") < still.F_y.sel(side="right")
    radius, y = both[0].place.touch.radius, both[0].place.touch.point[0]
    expected = (1 + turning.xi_0.item()) * radius / R_0 - 1 + 2e-6 * y
    assert turning.xi.sel(side="left") == pytest.approx(expected, abs=1e-12)
    assert turning.F_x.sel(side="left") > 0 > turning.F_x.sel(side="right")
    assert turning.steering > 0


@pytest.mark.parametrize("ics", [pytest.param("A", marks=pytest.mark.slow), "Bhat+sn:B"])
def test_tractions_add_up_to_the_forces_in_the_track(ics):
    """Element by element, with a roll of 1 degree: forces turned by it, moments about the axle."""
    both = sides(arcs_on_arcs("arcs"), 1.0 - R_0 * 0.0175, given_roll=0.0175)
    wheelset = rolled(both, ics=ics, lateral=0.0005)
    solved = labelled(wheelset, ics)
    for side, wheel, contact in zip(SIDES, wheelset.wheels, wheelset.contacts, strict=True):
        (on_grid,), (state,) = wheel.on_grids, contact.states
        grid, contour = on_grid.grid, on_grid.undeformed.lower.contour
        force, about_axle = np.zeros(3), 0.0
        for k, m in zip(*np.nonzero(state.in_contact), strict=True):
            s, x = np.array(grid.strips[m]), on_grid.x[k]
            (dy, dz), (y, z) = contour.tangent(s), contour.position(s)
            p_x, p_s, p_n = state.p[k, m] * grid.area
            f = np.array([p_x, p_s * dy - p_n * dz, p_s * dz + p_n * dy])
            force += f
            place = np.array([x, y, z - wheel.radius])  # from the axle
            about_axle += np.cross(place, f)[1]
        turn = wheel.place.roll
        assert abs(turn) > 0.017
        field = np.cos(turn) * force[1] - np.sin(turn) * force[2]
        up = np.sin(turn) * force[1] + np.cos(turn) * force[2]
        of_side = solved.sel(side=side)
        assert up == pytest.approx(LOAD, rel=VERTICAL)
        assert of_side["vertical_rolling"] == pytest.approx(LOAD, rel=VERTICAL)
        assert of_side["F_x"] == pytest.approx(force[0], abs=2e-5 * FRICTION * LOAD)
        assert of_side["F_y"] == pytest.approx(-field, rel=1e-4)
        assert contact.torque == pytest.approx(-about_axle, rel=1e-3, abs=0.5 * R_0)  # circle of the wheel


def test_any_tractions_have_the_torque_of_their_moments_about_the_axle():
    """Moments about the line x = 0, z = R, which is parallel to y; random tractions on inclined elements."""
    side = sides(arcs_on_arcs("arcs"), 2.0)[0]
    wheel = wheel_on(side)
    rolling, grid = wheel.problems[0].rolling, wheel.problems[0].problem.grid
    p = np.random.default_rng(7).normal(size=(grid.n_x, grid.n_s, 3))
    moment = 0.0
    for k, x in enumerate(rolling.x):
        for m, s in enumerate(rolling.s):
            tangent, normal = rolling.contour.tangent(s), rolling.contour.normal(s)
            force = grid.area * np.array([p[k, m, 0], *(p[k, m, 1] * tangent + p[k, m, 2] * normal)])
            moment += np.cross([x, 0.0, rolling.height[m] - wheel.radius], force)[1]
    assert np.sum(wheel.torque_weights[0] * p) == pytest.approx(-moment, rel=1e-12)


def test_a_lubricated_flange_lowers_the_forces_as_its_bound_says():
    """All elements slide one way: forces are as the bounds, by the contact angle in the track."""
    both = sides(arcs_on_arcs("arcs"), 1.0 - R_0 * 0.0175, given_roll=0.0175)
    pairs, moved = ((2.0, 1.0), (4.0, 0.2)), {"longitudinal": 0.1, "lateral": 0.04}
    wheelset = rolled(both, **moved)
    dry, lubricated = labelled(wheelset), numbers(both, by_angle=pairs, **moved)
    for side, wheel, contact in zip(SIDES, wheelset.wheels, wheelset.contacts, strict=True):
        strips = np.sum(contact.states[0].pressures, axis=0)
        on_grid = wheel.on_grids[0]
        tangent = on_grid.undeformed.lower.contour.tangent(on_grid.grid.strips)
        angles = np.degrees(np.abs(np.arctan2(tangent[1], tangent[0]) + wheel.place.roll))
        factor = np.average(np.interp(angles, *np.transpose(pairs)), weights=strips)
        one, other = (solved.sel(side=side) for solved in (dry, lubricated))
        assert one["sliding"] == other["sliding"] == 1
        assert factor < 0.9
        assert other["F_x"] / one["F_x"] == pytest.approx(factor, rel=0.02)
        assert other["utilised"] == pytest.approx(one["utilised"].item(), rel=0.01)


def test_work_of_friction_is_power_less_what_raises_the_wheel():
    """That of the slip converges to that of the tractions on the rigid motion, which changes less."""
    level, differences, works = rolled(sides(arcs_on_arcs("arcs"), 2.0), lateral=0.002), [], []
    while level is not None:
        pairs = [
            (wheel.problems[0], contact.patches[0])
            for wheel, contact in zip(level.wheels, level.contacts, strict=True)
        ]
        power = [problem.power(rolling) - problem.climbing(rolling) for problem, rolling in pairs]
        own = [np.sum(r.contact.dissipation) * problem.problem.grid.area for problem, r in pairs]
        differences.append(np.abs(np.subtract(power, own)) / power)
        works.append(power)
        level = level.coarser
    assert np.all(differences[0] < 0.1)
    assert np.all(differences[0] < 0.6 * differences[1])
    np.testing.assert_allclose(works[1], works[0], rtol=0.02)


def test_finer_elements_change_creep_forces_within_their_estimates():
    coarse, fine = at_2(), numbers(sides(arcs_on_arcs("arcs"), 2.0, elements=15))
    for side in SIDES:
        for name in OF_WHEEL:
            one, other = (solved.sel(side=side) for solved in (coarse, fine))
            known = one[f"estimate_{name}"] + other[f"estimate_{name}"]
            assert np.isnan(known) or abs(one[name] - other[name]) <= known, name
    assert abs(coarse.xi_0 - fine.xi_0) <= coarse.estimate_xi_0 + fine.estimate_xi_0


def test_differences_of_creep_forces_on_finer_elements_are_within_their_estimates():
    """Of A and B-hat, at a given creepage; forces themselves are known ten times worse."""
    motion = RollingTable(longitudinal=0.002, lateral=0.002)
    coarse, fine = (
        roll(sides(arcs_on_arcs("arcs"), 2.0, elements=elements), LOAD, motion, ("A", "Bhat"))
        .expand_dims(shift=[2.0])
        .assign_attrs(friction=motion.friction, load=LOAD)
        for elements in (12, 18)
    )
    for quantity in OF_ROLLING:
        own, finer = (difference(one, "A", quantity) for one in (coarse, fine))
        assert np.all(abs(own - finer) <= difference_estimate(coarse, "A", quantity)), quantity.symbol


def test_creepages_of_a_patch_are_those_of_its_circle_and_normal():
    """Of cones: the spin is omega sin(inclination) / V and that of the yaw; pressures are those of Hertz.

    The rail is inclined a little otherwise in the centre of pressure than at the touching point: the spin has
    the mean of both.
    """
    both, yaw = sides(cones_on_arcs(), 0.1), 2e-5
    solved = numbers(both, friction=FRICTION, longitudinal=1e-4, spin=yaw)
    for side, sign in zip(both, (1, -1), strict=True):
        wheel, touch = solved.sel(side=side.place.side), side.place.touch
        patch = {name: wheel[f"area_{name}"].item() for name in OF_PATCH}
        inclination = side.place.roll - touch.angle
        mean = np.mean(np.sin([inclination, side.place.roll - np.radians(patch["angle"])]))
        turning = (1 + wheel.xi.item()) * mean / touch.radius + sign * yaw * np.cos(inclination)
        assert patch["spin"] == pytest.approx(turning, rel=1e-3)
        assert patch["slip_x"] == pytest.approx(-wheel.xi.item(), abs=1e-5)
        assert patch["angle"] == pytest.approx(np.degrees(touch.angle), abs=0.1)
        point = PointContact(np.cos(inclination) / touch.radius, 1 / 300.0, combined_modulus(STEEL, STEEL))
        ellipse = point.at_load(patch["F_n"])
        assert patch["p_max"] == pytest.approx(ellipse.p_max, rel=0.01)
        assert patch["area"] == pytest.approx(np.pi * ellipse.a * ellipse.b, rel=0.08)


def test_a_wheel_without_a_contact_is_said(monkeypatch):
    """Free: neither wheel has numbers. At a given creepage the other wheel has its own."""
    both = sides(arcs_on_arcs("arcs"), 2.0)
    own = RollingWheel.contact

    def failing(wheel, xi_0, approach, start):
        if wheel.place.side == "right":
            raise Failure("not today")
        return own(wheel, xi_0, approach, start)

    monkeypatch.setattr(RollingWheel, "contact", failing)
    free, given = numbers(both), numbers(both, longitudinal=0.001)
    assert np.isnan(free.F_x).all()
    reasons = json.loads(free.attrs["reasons"])
    assert set(reasons) == set(SIDES)
    assert "right wheel" in reasons["left"]
    assert "not today" in reasons["left"]
    assert np.isfinite(given.F_x).values.tolist() == [True, False]
    assert set(json.loads(given.attrs["reasons"])) == {"right"}
    assert np.isnan(given.xi_0)
    assert "other wheel has no contact" in json.loads(numbers(both[:1]).attrs["reasons"])["left"]


def test_short_grids_become_longer():
    """From a grid that ends at the patch."""
    left, right = sides(arcs_on_arcs("arcs"), 2.0)
    (grid,) = left.grids
    short = Grid(grid.n_x - 16, grid.n_s, grid.dx, grid.ds, grid.s)
    longer = numbers((replace(left, grids=(short,)), right))
    here, full = (solved.F_x.sel(side="left").item() for solved in (longer, at_2()))
    assert here == pytest.approx(full, rel=1e-2)


# ---- estimated errors, of stand-ins with known numbers


RADIUS, SLOPE = 460.0, -2.3e9  # mm; N mm


def axle_errors(creepages, error_left=30.0, error_right=40.0, *, given=False):
    """Numbers and errors of a wheelset on elements of growing size, by its creepage on each.

    The left wheel at y = 750, the right one at -740 mm; lateral forces point towards the middle.
    """
    places = [SimpleNamespace(touch=SimpleNamespace(point=(y, 0.0))) for y in (750.0, -740.0)]
    state = SimpleNamespace(
        wheels=[SimpleNamespace(place=place, nominal_radius=RADIUS) for place in places],
        contacts=[SimpleNamespace(torque=5.0), SimpleNamespace(torque=-2.0)],
        levels=[SimpleNamespace(xi_0=xi_0) for xi_0 in creepages],
        xi_0=creepages[0],
        given=given,
        slope=SLOPE / 1e9,
        unit=1e9,
    )
    left = WheelNumbers({"F_x": 100.0, "F_y": 20.0}, {"F_x": error_left, "F_y": 2.0}, ())
    right = WheelNumbers({"F_x": -80.0, "F_y": 50.0}, {"F_x": error_right, "F_y": 5.0}, ())
    return axle_numbers(state, left, right)


def test_the_creepage_is_known_to_the_worse_of_larger_elements_and_forces():
    """Forces of error 30 and 40 N turn the axle by 50 N times its radius; over the slope that is 1e-5."""
    by_forces = 50.0 * RADIUS / abs(SLOPE)
    assert by_forces == pytest.approx(1e-5)
    same, apart = [1e-4] * 3, [1e-4, 1.3e-4, 1.7e-4]
    assert axle_errors(same)[1]["xi_0"] == pytest.approx(by_forces)
    assert axle_errors(apart)[1]["xi_0"] == pytest.approx(from_grids(*apart))
    assert from_grids(*apart) > by_forces


def test_forces_and_moments_of_a_wheelset_are_known_to_the_sums_of_those_of_its_wheels():
    own, errors = axle_errors([1e-4], 3.0, 4.0, given=True)
    assert own == {
        "xi_0": 1e-4,
        "axle_torque": 3.0,
        "sum_F_y": 30.0,
        "steering": 100.0 * 750.0 + 80.0 * 740.0,
    }
    assert errors == {"xi_0": 0.0, "sum_F_y": 7.0, "steering": 3.0 * 750.0 + 4.0 * 740.0}


def test_a_given_creepage_is_exact_and_one_on_a_single_grid_is_not_known():
    assert axle_errors([1e-4, 2e-4], given=True)[1]["xi_0"] == 0
    assert np.isnan(axle_errors([1e-4])[1]["xi_0"])
