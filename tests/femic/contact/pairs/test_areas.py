"""Several areas under one approach: one is one grid, two are one grid cut in two, distances are exact."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compare.validation.statements.wheels import kinked
from femic.contact.estimates import floors
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.pairs import area_grids
from femic.contact.pairs import pair_on_grid as pair_on_grid_module
from femic.contact.pairs.area_grids import find_patches, overlaps, refined_grids, unresolved
from femic.contact.pairs.areas import NO_COUPLING, Areas, AreaTooSmall, coupling
from femic.contact.pairs.grids import Sizing
from femic.contact.pairs.quantities import measured
from femic.contact.patch import MARGIN
from femic.shifts.sides import lay_out_wheelset
from femic.shifts.specification import load_shifts
from geometries.errors import Failure
from geometries.materials import Material
from geometries.patches import Grid
from tests.femic.contact.pairs.problems import wheel_on_rail
from tests.femic.shifts.layouts import R_R, R_W, arcs_on_arcs
from tests.femic.shifts.test_shift_contact import RAIL, bumpy

LOAD = 9e4


@cache
def on_arcs(load=LOAD, shift=0.0):
    return wheel_on_rail(arcs_on_arcs("arcs"), load, shift)


@cache
def bumps():
    """A cylinder on two bumps 13 mm apart, of which the second one is 20 um lower: both carry."""
    return wheel_on_rail(bumpy(0.02))[0]


@cache
def one_and_two(variant):
    """A contact on a grid over both patches, and on the same grid cut in the middle of the gap; the parts."""
    grid = Grid(24, 112, 1.54, 0.22, 6.5)
    one = Areas.with_approximation(variant, bumps(), [grid]).solve(LOAD)
    (left, right) = one.contacts[0].patches
    cut = 8 * round((left.s[1] + right.s[0]) / 16)  # so that both have coarser grids
    parts = [grid.strips[:cut], grid.strips[cut:]]
    halves = [Grid(24, len(strips), 1.54, 0.22, float(np.mean(strips))) for strips in parts]
    areas = Areas.with_approximation(variant, bumps(), halves)
    return one, areas.solve(LOAD), areas


@pytest.mark.parametrize("variant", ["A", "Bhat"])
def test_two_areas_are_one_grid_cut_in_two(variant):
    """Their coupling is that within the grid; without it the approach is 8 % too small."""
    one, two, areas = one_and_two(variant)
    whole = one.contacts[0]
    for patch, part in zip(whole.patches, two.contacts, strict=True):
        # both are on the same elements; nodes of the coupling and its point forces leave 1e-3 of it
        assert np.max(part.p) == pytest.approx(float(np.max(whole.p[patch.elements])), rel=2e-3)
        assert np.sum(part.p) == pytest.approx(float(np.sum(whole.p[patch.elements])), rel=1e-3)
    assert two.approach == pytest.approx(one.approach, rel=1e-3)
    alone = replace(areas, coupling=NO_COUPLING).solve(LOAD)
    assert alone.approach < 0.95 * one.approach


def test_all_areas_carry_the_load_together():
    _, contact, _ = one_and_two("Bhat")
    assert contact.force[2] == pytest.approx(LOAD, rel=1e-9)
    level, carried = contact, []
    while level is not None:
        carried.append(level.force[2])
        level = level.coarser
    assert len(carried) >= 3
    # so do coarser elements, each with its approach; their cosines are means, not those of their centres
    np.testing.assert_allclose(carried, LOAD, rtol=1e-4)
    assert contact.approach != pytest.approx(contact.coarser.approach, rel=1e-4)


def test_the_coupling_is_symmetric():
    """By B, which is not reciprocal, it is averaged."""
    boxes = ((5.0, (-10.0, 0.0)), (4.0, (20.0, 35.0)))
    for variant in ("A", "B", "Bhat"):
        between = coupling(variant, bumps().pair, boxes).between
        np.testing.assert_allclose(between[0, 1], between[1, 0].T, rtol=1e-12)


def test_far_apart_the_coupling_is_that_of_point_forces():
    """A: (1 - nu^2) / (pi E r) of each body."""
    grids = [Grid(8, 8, 0.2, 0.2, s) for s in (0.0, 60.0)]
    boxes = tuple((grid.n_x * grid.dx / 2, grid.extent) for grid in grids)
    p = [np.zeros((8, 8)), np.random.default_rng(3).uniform(0, 1, (8, 8))]
    u = coupling("A", bumps().pair, boxes).displacements(grids, p)
    steel = Material(RAIL.E, RAIL.nu)
    far = np.sum(p[1]) * grids[1].area / (np.pi * combined_modulus(steel, steel) * 60.0)
    np.testing.assert_allclose(u[0], far, rtol=0.03)  # elements are 58.6 to 61.4 mm apart
    np.testing.assert_allclose(u[1], 0.0, atol=1e-15)


def test_one_area_is_the_contact_with_the_exact_distance():
    """The fixed point of the distance of the displaced body, on one grid."""
    bodies, _ = on_arcs(shift=3.0)
    on_grid = replace(bodies, grid=Grid(32, 32, 0.9, 0.9))
    other = on_grid.solve(on_grid.operator("Bhat"), Loading(LOAD), exact=True).normal
    contact = Areas.with_approximation("Bhat", bodies, [on_grid.grid]).solve(LOAD)
    np.testing.assert_allclose(contact.contacts[0].p, other.p, atol=1e-5 * np.max(other.p))
    assert contact.approach == pytest.approx(other.approach, rel=1e-5)


def test_a_guess_of_the_approach_does_not_decide_the_contact():
    bodies, roll = on_arcs(shift=3.0)
    areas = Areas.with_approximation("A", bodies, [Grid(32, 32, 0.9, 0.9)], roll)
    one, other = areas.solve(LOAD), areas.solve(LOAD, 0.2)
    assert one.approach == pytest.approx(other.approach, rel=2e-6)


def test_an_approach_along_another_direction_closes_the_distance_by_its_cosine():
    """zeta cos(delta - turn), to the first order, where both bodies have nearly one normal."""
    bodies, _ = on_arcs()
    undeformed, turn, zeta = bodies.undeformed, 0.02, 1e-3
    s = np.linspace(-0.5, 0.5, 11)
    straight = undeformed.distance(0.0, s, zeta)
    moved = undeformed.distance(0.0, s, zeta * np.cos(turn), -zeta * np.sin(turn))
    delta = undeformed.lower.contour.inclination(s)
    closed = zeta * (np.cos(delta - turn) - np.cos(delta))
    assert np.max(np.abs(closed)) > 1e-6
    # the normals of both bodies differ by 1.7 mrad at the ends
    np.testing.assert_allclose(straight - moved, closed, atol=5e-8)


def test_a_patch_near_the_end_of_its_grid_is_said():
    other = Grid(24, 24, 1.54, 0.22, 13.0)
    areas = Areas.with_approximation("A", bumps(), [Grid(24, 16, 1.54, 0.16), other])
    with pytest.raises(AreaTooSmall, match="comes closer") as raised:
        areas.solve(LOAD)
    assert raised.value.number == 0
    grids = area_grids.longer(areas, raised.value)
    assert grids[0].n_s > 16
    assert grids[1] == areas.grids[1]
    near = Areas.with_approximation("A", bumps(), [Grid(24, 16, 1.54, 0.16), replace(other, s=4.0)])
    with pytest.raises(Failure, match="grows into the grid of another"):
        area_grids.longer(near, raised.value)


# ---- grids


def test_overlaps_of_arcs_are_those_of_circles():
    """Two circles of radii R_r < R_w that touch, lowered by zeta: they cross at s = R_r theta."""
    bodies, _ = on_arcs()
    zeta, apart = 0.05, R_W - R_R
    ((low, high),) = overlaps(bodies.undeformed, zeta, 0.0)
    touching = bodies.undeformed.lower.contour.inclination(0.0)
    # the centre of the wheel's circle, seen from that of the rail, moves from `apart` along the normal
    y, z = np.array([np.sin(touching), np.cos(touching)]) * -apart
    far = np.hypot(y, z - zeta)
    middle = np.arctan2(-y, zeta - z)
    half = np.arccos((R_W**2 - R_R**2 - far**2) / (2 * R_R * far))
    exact = (middle + np.array([-half, half]) - touching) * R_R
    np.testing.assert_allclose([low, high], exact, atol=0.03)  # the spacing of samples


@pytest.mark.parametrize("load", [1e3, LOAD])
def test_patches_are_found_and_their_grids_fit_them(load):
    bodies, roll = on_arcs(load, 2.0)
    boxes, sought = find_patches(bodies, "Bhat", load, roll)
    (box,) = boxes
    assert box.share == pytest.approx(1)
    (grid,) = refined_grids(bodies, boxes, sought, 20)
    contact = Areas.with_approximation("Bhat", bodies, [grid], roll).solve(load, sought.approach)
    assert sought.approach == pytest.approx(contact.approach, rel=0.02)
    (patch,) = contact.contacts[0].patches
    assert 18 <= patch.s[1] - patch.s[0] <= 48  # 20 elements across, or twice as many
    assert 18 <= patch.x[1] - patch.x[0] <= 48
    low, high = patch.s
    assert low > MARGIN
    assert high < grid.n_s - 1 - MARGIN


def test_strips_resolve_a_narrow_change_of_the_distance():
    """What grids of fewer strips lack is within what is said of them; coarse grids say that they lack it."""
    bodies, load = kinked(), 2e4
    boxes, sought = find_patches(bodies, "A", load, 0.0)
    (fine,) = refined_grids(bodies, boxes, sought, 12)
    assert fine.n_s > 64  # 12 elements across the patch would not do
    rows = []
    for times in (1, 2, 4, 8):
        grid = Grid(fine.n_x, fine.n_s * times // 4, fine.dx, fine.ds * 4 / times, fine.s)
        contact = Areas.with_approximation("A", bodies, [grid]).solve(load, sought.approach)
        rows.append((float(np.max(contact.contacts[0].p)), unresolved(contact, 0)))
    *coarser, (best, _) = rows
    assert rows[2][1] <= area_grids.RESOLVED * best
    assert rows[0][1] > rows[1][1] > rows[2][1]
    for p_max, error in coarser:
        assert abs(p_max - best) <= error + 0.01 * best  # and what any grid of 12 elements has


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.8])
def test_what_is_not_resolved_is_at_the_jump_of_the_curvature(offset):
    """Third differences of a jump by dk are half to three quarters of dk, at the strips beside it alone."""
    bodies = kinked()
    on_grid = replace(bodies, grid=Grid(8, 80, 1.0, 0.1, 1.0 + offset * 0.1))
    strips, lacking = on_grid.grid.strips, on_grid.unresolved(0.0)
    modulus = combined_modulus(bodies.pair.upper.material, bodies.pair.lower.material)
    jump = pair_on_grid_module.OF_CHANGE * modulus * 0.1 * (1 / 12 - 1 / 200)
    assert 0.45 * jump < np.max(lacking) < 0.8 * jump
    assert abs(strips[np.argmax(lacking)]) <= 0.1
    inner = (np.abs(strips) > 0.25) & (np.abs(strips) < 2.5)
    assert np.max(lacking[inner]) < 0.02 * jump


def test_automatic_grids_of_one_contact_resolve_a_narrow_change_as_far_as_they_may():
    """Eight elements lack 9 % of p_max where the curvature jumps; strips that may not be halved say so."""
    bodies, loading = kinked(), Loading(2e4)
    sizing = Sizing(bodies, 8)
    ((grid, _),) = sizing.grids([loading])

    def solved(fitting):
        on_grid = replace(bodies, grid=fitting)
        contact = on_grid.solve_in_place(on_grid.flat, loading)
        known = measured(on_grid, contact)
        return known.numbers["p_max"], known.floors["peak"] - floors(contact.slip_state)["peak"]

    fine = solved(replace(grid, n_s=512, ds=grid.ds * grid.n_s / 512))
    as_it_is, resolved = (solved(sizing.resolved(grid, [loading], most)) for most in (grid.n_s, 1024))
    assert as_it_is[0] < 0.95 * fine[0]
    assert 0.04 < as_it_is[1] < 0.2
    assert resolved[0] == pytest.approx(fine[0], rel=0.01)
    assert resolved[1] == 0


def test_the_contact_of_hertz_is_resolved():
    """Distances that are parabolas have no change of curvature but that of circles."""
    bodies, roll = on_arcs(300.0, 1.0)
    boxes, sought = find_patches(bodies, "A", 300.0, roll)
    grids = refined_grids(bodies, boxes, sought, 24)
    contact = Areas.with_approximation("A", bodies, grids, roll).solve(300.0, sought.approach)
    steel = Material(RAIL.E, RAIL.nu)
    exact = PointContact(1 / 460.0, 1 / R_R - 1 / R_W, combined_modulus(steel, steel)).at_load(300.0)
    assert np.max(contact.contacts[0].p) == pytest.approx(exact.p_max, rel=0.01)
    assert unresolved(contact, 0) < 1e-3 * exact.p_max


def test_overlaps_end_where_contours_do_and_patches_there_are_refused():
    """What bodies do not reach is no contact; a patch that would go on beyond has no solution."""
    bodies, _ = on_arcs()
    low, high = bodies.undeformed.s_range
    ((start, end),) = overlaps(bodies.undeformed, 30.0, 0.0)
    assert (start, end) == pytest.approx((low, high), abs=0.1)
    with pytest.raises(Failure, match="a patch comes near the end of a contour, which reaches from"):
        find_patches(bodies, "A", 1e9, 0.0)


def test_areas_come_together_along_the_direction_of_their_load():
    """The exact distance closes, to the first order, by the cosine with which pressures carry the load."""
    bodies, _ = on_arcs(shift=3.0)
    areas, zeta = Areas.with_approximation("A", bodies, [Grid(8, 8, 0.01, 0.01)], roll=0.03), 1e-3
    (before,), (after,) = areas.distances_at(0.0), areas.distances_at(zeta)
    (problem,) = areas.levels.problems
    # within 0.04 mm of the touching point normals of both bodies differ by 0.13 mrad, of which 0.2 counts
    np.testing.assert_allclose(
        (before - after) / zeta, np.broadcast_to(problem.cosine, before.shape), atol=5e-5
    )


@settings(max_examples=200)
@given(st.floats(0.01, 1.0), st.floats(0.05, 20.0), st.floats(0.03, 5.0), st.booleans())
def test_coarse_grids_over_neighbouring_overlaps_have_room_beside_both(ratio, gap, room, is_first):
    """A short overlap beside a long one, which lies near the end of the contour."""
    long, short = (0.0, 10.0), (10.0 + 10 * gap, 10.0 + 10 * gap + 10 * ratio)
    ranges = [long, short] if is_first else [(-short[1], -short[0]), (-long[1], -long[0])]
    ends = (-10 * room, short[1] + 30.0) if is_first else (-short[1] - 30.0, 10 * room)
    bodies = SimpleNamespace(undeformed=SimpleNamespace(s_range=ends))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(area_grids, "_half_length", lambda *_: 5.0)
        one, other = area_grids._coarse_grids(bodies, ranges, 0.1, 0.0)
    assert one.extent[1] <= other.extent[0] + 1e-9
    assert one.extent[0] >= ends[0] - 1e-9
    assert other.extent[1] <= ends[1] + 1e-9
    for grid, (low, high) in zip((one, other), ranges, strict=True):
        assert (low - grid.extent[0]) / grid.ds > MARGIN
        assert (grid.extent[1] - high) / grid.ds > MARGIN
        assert grid.n_s <= area_grids.MOST_COARSE


def test_a_worn_wheel_has_one_patch_where_its_coarse_grids_would_meet():
    """At an approach that is sought, a second overlap lies close beside the first one."""
    file = load_shifts("s1002-on-60e1-worn")[2]
    layout = lay_out_wheelset(file)
    bodies, roll = wheel_on_rail(layout, LOAD, 6.43, file.rail, file.wheel)
    boxes, _ = find_patches(bodies, "A", LOAD, roll)
    assert sum(box.share for box in boxes) == pytest.approx(1)
