"""Contacts of a wheelset on circular arcs: Hertz, the balance of the load, mirrored sides, two patches."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.planar import solve_planar
from femic.shifts import contact as module
from femic.shifts.contact import contact_at, planar_patches
from femic.shifts.sides import Place, bodies_at, contact_problem
from femic.shifts.specification import ContactTable
from geometries.errors import Failure
from geometries.track.wheelset import curves_in_place, settle
from tests.femic.shifts.layouts import R_R, R_W, RAIL, STEEL, WHEEL, arcs_on_arcs, bumpy


@cache
def place(shift, side, kind="points"):
    return Place(arcs_on_arcs(kind), settle(arcs_on_arcs(kind), shift, roll="about rails"), side)


@cache
def solved(shift, side, load, kind="points", **asked):
    return contact_at(place(shift, side, kind), RAIL, WHEEL, asking(load, "A", "Bhat", **asked))


def hertz(where, load):
    """The ellipse of arcs that touch: 1/R_r - 1/R_w across, cos(delta)/r along."""
    along = float(np.cos(where.touch.angle - where.roll) / where.touch.radius)
    surfaces = PointContact(along, 1 / R_R - 1 / R_W, combined_modulus(STEEL, STEEL))
    return surfaces.at_load(load / np.cos(where.touch.angle))


def asking(load, *ics, **keys):
    return ContactTable(**{"load": load, "ics": ics, "planar": False} | keys)


@pytest.mark.parametrize("side", ["left", "right"])
def test_forces_turn_into_the_track_as_the_wheel_does(side):
    """A force along the wheel's surface, in axes parallel to the axle, is along the wheel in its place."""
    where = place(5.0, side)
    _, wheel = curves_in_place(where.layout, where.position, side)
    assert abs(where.roll) > 1e-5
    delta = float(wheel.curve.inclination(np.array(10.0)))
    force = np.array([0.0, np.cos(delta), -np.sin(delta)])
    np.testing.assert_allclose(where.in_track(force), wheel.tangent(10.0), atol=1e-12)


@pytest.mark.parametrize(
    ("shift", "side"),
    [
        (1.0, "left"),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in ((0.0, "left"), (1.0, "right"))),
    ],
)
def test_small_contacts_of_sampled_arcs_are_those_of_hertz(shift, side):
    """A of half-spaces has no other error than that of its elements."""
    load, where = 300.0, place(shift, side)
    exact = hertz(where, load)
    half_spaces = contact_at(where, RAIL, WHEEL, asking(load, "A", "Bhat", elements=32)).sel(ics="A")
    assert half_spaces.p_max == pytest.approx(exact.p_max, abs=2 * half_spaces.estimate_p_max.item())
    assert half_spaces.p_max == pytest.approx(exact.p_max, rel=0.01)
    assert half_spaces.b == pytest.approx(exact.b, rel=0.02)
    assert half_spaces.a == pytest.approx(exact.a, rel=0.02)
    assert half_spaces.angle == pytest.approx(np.degrees(2 * exact.b / R_R), rel=0.02)


def test_planar_contact_of_a_small_patch_is_that_of_hertz_and_carries_the_load():
    """Its normal force is the vertical one over the cosine of the contact angle; the lateral one follows."""
    load, where = 300.0, place(1.0, "left")
    contact = contact_at(where, RAIL, WHEEL, asking(load, "A", elements=32, planar=True))
    planar, angle = contact.sel(ics="planar"), where.touch.angle
    assert contact.ics.values.tolist() == ["A", "planar"]
    exact = hertz(where, load)
    assert planar.p_max == pytest.approx(exact.p_max, rel=0.01)
    assert planar.b == pytest.approx(exact.b, rel=0.02)
    assert planar.vertical == pytest.approx(load, rel=1e-6)
    # the plane has the mean inclination of the overlap, which is not quite symmetric about the touching point
    assert planar.lateral / planar.vertical == pytest.approx(np.tan(angle), rel=1e-4)
    assert planar.patches == 1
    assert np.mean([planar.patch_start[0], planar.patch_end[0]]) == pytest.approx(
        where.touch.s_rail, abs=0.02 * exact.b
    )


def test_patches_of_planar_contact_are_arc_lengths_of_the_rail():
    """On an arc, of which the plane is tangent, its coordinate is R sin((s - s_0) / R)."""
    where = place(1.0, "left")
    problem = contact_problem(bodies_at(where, RAIL, WHEEL), asking(300.0, "A"))
    planar = solve_planar(pair_on_grid(problem, problem.grid), 300.0, roll=where.roll)
    (patch,) = planar.patches
    (numbers,) = planar_patches(where, patch, 300.0)
    t, at = np.array([-1.0, 0.5, 2.0]), patch.plane.place
    on_rail = patch.plane.lower_arc_length(t)
    turn = at / R_R + where.touch.angle - where.roll + patch.plane.angle  # of the plane beside the tangent
    assert abs(turn) < 1e-3
    np.testing.assert_allclose(on_rail, at + R_R * np.arcsin(t / R_R), atol=3e-3)
    assert numbers["centre"] == pytest.approx(where.touch.s_rail + at, abs=0.02)
    assert numbers["start"] < numbers["centre"] < numbers["end"]


@pytest.mark.parametrize("side", [pytest.param("left", marks=pytest.mark.slow), "right"])
def test_the_vertical_load_is_the_given_one_and_the_lateral_force_follows_the_contact_angle(side):
    """Small patch: lateral / vertical = tan(contact angle); the balance holds for all ICs."""
    contact = solved(3.0, side, 2000.0)
    touch = place(3.0, side).touch
    np.testing.assert_allclose(contact.vertical, 2000.0, rtol=2e-6)
    np.testing.assert_allclose(contact.lateral / contact.vertical, np.tan(touch.angle), rtol=0.03)


def test_contacts_of_a_symmetric_wheelset_are_mirrored():
    """Two independent solutions; positions agree to rounding, iterations end at their tolerance."""
    one, other = (solved(shift, side, 9e4, elements=12) for shift, side in ((1.0, "left"), (-1.0, "right")))
    for name in ("p_max", "approach", "vertical", "lateral", "angle", "a", "b"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-4, err_msg=name)


def test_contacts_of_sampled_arcs_are_those_of_exact_ones_and_on_finer_elements_within_their_estimates():
    sampled, exact = (solved(1.0, "left", 9e4, kind, elements=12) for kind in ("points", "arcs"))
    np.testing.assert_allclose(sampled.p_max, exact.p_max, rtol=1e-3)
    np.testing.assert_allclose(sampled.angle, exact.angle, rtol=1e-2)
    coarse, fine = sampled.sel(ics="Bhat"), solved(1.0, "left", 9e4, elements=20).sel(ics="Bhat")
    assert abs(coarse.p_max - fine.p_max) <= coarse.estimate_p_max + fine.estimate_p_max


def test_both_bodies_touch_at_the_origin_with_one_inclination():
    """The rail is turned with the roll, the wheel is not; both contours start at the touching point."""
    where = place(3.0, "left")
    bodies = bodies_at(where, RAIL, WHEEL)
    lower, upper = bodies["lower"], bodies["upper"]
    assert where.roll != 0
    assert float(lower.contour.inclination(0.0)) == pytest.approx(where.roll - where.touch.angle, abs=1e-12)
    assert float(upper.contour.inclination(0.0)) == pytest.approx(where.roll - where.touch.angle, abs=1e-9)
    np.testing.assert_allclose(lower.contour.position(0.0), 0, atol=1e-12)
    assert upper.rolling_radius == where.touch.radius
    assert np.isinf(lower.rolling_radius)


def test_two_patches_share_the_load():
    """Nearly equal bumps: both carry; the lower, the less. Far lower: the main patch is alone."""
    shares = []
    for lower in (0.0, 0.02, 0.5):
        own = bumpy(lower)
        where = Place(own, settle(own, 0.0, roll="about rails"), "left")
        contact = contact_at(where, RAIL, WHEEL, asking(9e4, "A"))
        assert contact.attrs["notes"] == ""
        shares.append(sorted(contact.patch_share.values[0]))
        assert sum(shares[-1]) == pytest.approx(1, rel=1e-9)
    both, less, alone = shares
    np.testing.assert_allclose(both, 0.5, atol=0.02)
    assert len(less) == 2
    assert less[0] < 0.45
    assert alone == [pytest.approx(1)]


def test_c_is_solved_only_above_its_angle(monkeypatch):
    """C itself would take minutes. Where it fails, the others stay."""
    asked = []

    def with_c(*arguments):
        asked.append(arguments[3].ics)
        raise Failure("not today")

    monkeypatch.setattr(module, "_with_c", with_c)
    below = solved(1.0, "left", 9e4, elements=12, c_above_deg=30.0)
    assert asked == []
    assert below.attrs["notes"] == ""
    above = solved(1.0, "left", 9e4, elements=12, c_above_deg=2.0)
    assert asked == [("A", "Bhat", "C")]
    assert above.attrs["notes"] == "C was not computed: not today"
    np.testing.assert_array_equal(above.p_max, below.p_max)


def test_c_has_flat_flanks_or_is_left_out():
    """Steep flanks beside a small head would bend away under the lateral force."""
    bodies = bodies_at(place(0.0, "left", "arcs"), RAIL, WHEEL, np.radians(20.0))
    for body in bodies.values():
        ends = np.degrees(body.contour.inclination(np.array(body.contour.limits)))
        np.testing.assert_allclose(np.abs(ends), 20, atol=1e-6)
    where = place(0.0, "left")
    steep = replace(where.position, left=(replace(where.touch, angle=np.radians(61.0)),))
    with pytest.raises(Failure, match=r"contact angle is 61\.0 degrees"):
        module._with_c(replace(where, position=steep), RAIL, WHEEL, asking(9e4, "C"), module.DEFAULT)
