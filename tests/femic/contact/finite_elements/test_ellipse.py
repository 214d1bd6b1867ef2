"""Crossed bodies of different materials whose patch is an ellipse: Hertz, equilibrium, supports, errors."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.meshed_contact import Bodies, ZoneTooSmall, mesh_bodies, solved
from femic.contact.finite_elements.result import READING, compute_numbers, estimates, fe_contact, hertz_patch
from femic.reference.discount import FZ
from femic.reference.engines import HARMONIC
from femic.reference.job import NotConverged, Settings
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import matrices
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.problems import BRASS, STEEL

ROLLING_RADIUS, OF_LOWER, OF_UPPER = 200.0, 150.0, 250.0  # mm; both are convex
LOAD = 900.0  # N
SURFACES = PointContact(1 / ROLLING_RADIUS, 1 / OF_LOWER + 1 / OF_UPPER, combined_modulus(STEEL, BRASS))
HERTZ = SURFACES.at_load(LOAD)


def bodies(*, symmetric=True, far=25.0, shift=0.0):
    """The bodies, in domains of some half-lengths; flanks make them unsymmetric, far from the patch."""
    flank = 0.6 if symmetric else 0.5
    domain = Domain(far, far)
    lower = Body(LOWER, arc(OF_LOWER, flank, 0.6), STEEL, domain)
    upper = Body(UPPER, arc(-OF_UPPER, flank, 0.6), BRASS, domain, rolling_radius=ROLLING_RADIUS)
    return Bodies(lower, upper, (-10.0, 10.0), shift)


def expected(middle=0.0):
    """Hertz's patch, its middle at an arc length [mm]."""
    return Expected(HERTZ.a, (middle - HERTZ.b, middle + HERTZ.b))


# ---- one contact

CELLS, FAR = 5.0, 15.0


@pytest.fixture(scope="module")
def meshes():
    return mesh_bodies(bodies(far=FAR), expected(), CELLS)


@pytest.fixture(scope="module")
def level(meshes):
    return solved(bodies(far=FAR), meshes, LOAD)


def test_numbers_and_pressures_agree_with_hertz(level):
    """Measured: half-lengths within 2.2 %, the pressure within 0.7 %, of 5 cells per half-width.

    Pressures do not alternate: inside of 80 % of the ellipse to 3 % of the largest (hat functions: 11 %).
    """
    numbers = compute_numbers(level)
    assert [numbers.a, numbers.b] == pytest.approx([HERTZ.a, HERTZ.b], rel=0.035)
    assert numbers.p_max == pytest.approx(HERTZ.p_max, rel=0.015)
    x, s = level.pair.x, level.pair.s
    inside = np.hypot(x / HERTZ.a, s / HERTZ.b) < 0.8
    assert np.count_nonzero(inside) > 20
    assert level.p[inside] == pytest.approx(HERTZ.pressure(x, s)[inside], abs=0.03 * HERTZ.p_max)


def test_bodies_are_in_equilibrium_without_tension_and_penetration(level):
    assert level.load_of_pressures == pytest.approx(LOAD, rel=1e-5)
    assert level.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)
    state, active = level.solution.state, level.solution.active
    gap = level.pair.gap(state.u_lower, state.u_upper, state.approach) / level.pair.area
    assert 20 < np.count_nonzero(active) < len(active) - 20
    assert state.p[active].min() > -1e-5 * state.p.max()
    assert np.all(state.p[~active] == 0)
    assert gap[~active].min() > -1e-5 * state.approach
    assert np.max(np.abs(gap[active])) < 1e-5 * state.approach


def test_far_bodies_add_a_displacement_in_proportion_to_the_load(level, meshes):
    """The approach is Hertz's, less what clamped far arcs take away: the same per load at half of it."""
    half = solved(bodies(far=FAR), meshes, LOAD / 2, level)
    added = [
        (compute_numbers(solution).approach - SURFACES.at_load(solution.load).approach) / solution.load
        for solution in (level, half)
    ]
    assert added[0] < 0
    assert abs(added[0]) * LOAD < 0.1 * HERTZ.approach
    assert added[1] == pytest.approx(added[0], rel=0.06)


def test_shifted_wheel_has_the_shifted_contact(level):
    """Spheres side by side touch at a distance in proportion to their radii; the numbers are the same."""
    aside = 4.0
    whole = bodies(symmetric=False, far=FAR, shift=aside)
    middle = aside * OF_LOWER / (OF_LOWER + OF_UPPER)
    solution = solved(whole, mesh_bodies(whole, expected(middle), 4.0), LOAD)
    numbers = compute_numbers(solution)
    assert whole.share == 0.5
    assert np.mean(solution.s_range) == pytest.approx(middle, abs=0.03)
    of_half = compute_numbers(level)
    assert numbers.p_max == pytest.approx(of_half.p_max, rel=0.02)
    assert [numbers.a, numbers.b] == pytest.approx([of_half.a, of_half.b], rel=0.05)
    assert numbers.approach == pytest.approx(of_half.approach, rel=0.01)  # other cells, far away, too


def test_contact_larger_than_its_zone_is_refused(meshes):
    with pytest.raises(ZoneTooSmall, match="larger `expected`"):
        solved(bodies(far=FAR), meshes, 8 * LOAD)


def test_endless_search_for_the_contact_area_is_refused(meshes, monkeypatch):
    monkeypatch.setattr("femic.contact.finite_elements.saddle.MOST_STEPS", 1)
    with pytest.raises(NotConverged, match=r"still change after 1 steps .* Try more `cells`"):
        solved(bodies(far=FAR), meshes, LOAD / 3)


# ---- what supports add to the approach: M_zz of C on the same supports, times the load

NEAR_END, FAR_END, FINER, LENGTH = 8.0, 32.0, 6.0, 3.0
SIDE = HERTZ.b / 2  # of the load under which M_zz is matched; differences do not depend on it


def held_at(far, length=LENGTH):
    """The pair, clamped at far arcs of a radius [mm]; its length in radii."""
    pair, domain = bodies(), Domain(far, length * far)
    return Bodies(replace(pair.lower, domain=domain), replace(pair.upper, domain=domain), (-6.0, 6.0))


def rigid_compliance(far):
    """M_zz of both bodies by the harmonic engine [mm/N], endless along x and all the way round."""
    pair, settings = held_at(far), Settings(HARMONIC, tolerance=0.01, approach_side=SIDE)
    domain, grid = Domain(far, np.inf), Grid(1, 1, 2 * SIDE, 2 * SIDE)
    jobs = {
        str(body.side): MatrixJob(replace(body, domain=domain), grid, settings, ("nn",))
        for body in (pair.lower, pair.upper)
    }
    return sum(reference.discount[FZ, FZ] for reference in matrices(jobs, combined=True).values())


def raw_approach(far, length=LENGTH):
    pair = held_at(far, length)
    return solved(pair, mesh_bodies(pair, expected(), FINER), LOAD).solution.state.approach


@pytest.mark.slow
def test_other_supports_change_the_approach_by_their_rigid_compliance_times_the_load():
    """No number is fitted between the two: meshes of the contact and C's models of single loads."""
    added = raw_approach(FAR_END) - raw_approach(NEAR_END)
    rigid = LOAD * (rigid_compliance(FAR_END) - rigid_compliance(NEAR_END))
    assert rigid > 0.05 * HERTZ.approach
    # meshes know approaches to 0.2 %; the patch is not small beside the nearer arc: (b / NEAR_END)^2
    assert added == pytest.approx(rigid, abs=0.003 * HERTZ.approach + (HERTZ.b / NEAR_END) ** 2 * rigid)


@pytest.mark.slow
def test_ends_along_x_do_not_matter_where_bodies_are_as_long_as_they_are_meshed():
    """Clamped far arcs screen what lies beyond: half as long again is the same, as two meshes agree."""
    assert raw_approach(NEAR_END, 1.5 * LENGTH) == pytest.approx(raw_approach(NEAR_END), rel=0.002)


# ---- the whole way: patch, meshes for it, contact, estimates


def test_first_guess_is_the_patch_of_hertz():
    guess = hertz_patch(bodies(), LOAD)
    assert [guess.a, guess.b, sum(guess.s)] == pytest.approx([HERTZ.a, HERTZ.b, 0.0], rel=1e-3, abs=1e-9)


WRONG = [*({"load": n} for n in (0.0, -1.0, np.inf, np.nan)), *({"cells": n} for n in (0.0, 7.9, np.nan))]


@pytest.mark.parametrize("wrong", WRONG, ids=str)
def test_loads_that_are_not_positive_and_too_few_cells_are_refused(wrong):
    with pytest.raises(WrongInput, match=f"{next(iter(wrong))} = "):
        fe_contact(bodies(), **{"load": LOAD} | wrong)


def test_the_lower_body_must_be_prismatic():
    pair = bodies()
    with pytest.raises(WrongInput, match="prismatic"):
        Bodies(replace(pair.lower, rolling_radius=500.0), pair.upper, pair.s_range)


@pytest.mark.slow
def test_estimates_bound_errors():
    contact = fe_contact(bodies(), LOAD, cells=9.0)
    truth = {"a": HERTZ.a, "b": HERTZ.b, "p_max": HERTZ.p_max}
    for name, value in truth.items():
        error, estimate = abs(vars(contact.numbers)[name] - value), vars(contact.estimate)[name]
        assert error <= estimate
        assert estimate < 0.06 * value
    assert contact.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)
    assert contact.load_of_pressures == pytest.approx(LOAD, rel=1e-5)
    assert contact.tension <= 1e-5
    assert contact.penetration <= 1e-5
    assert contact.p.max() == contact.numbers.p_max
    assert contact.seconds["fine"] > 0
    assert contact.memory > 0


def made(numbers_are_read):
    """A contact on coarse meshes whose edges can, or cannot, be read from gaps."""

    class Made(SimpleNamespace):
        @property
        def a(self):
            if numbers_are_read:
                return 2.2
            raise Failure("edge of the patch: vertices too few")

    return Made(
        s_range=(-1.1, 1.3),
        patch=Expected(2.6, (-1.2, 1.6)),
        spacing=0.5,
        bodies=bodies(),
        p=np.array([90.0]),
        solution=SimpleNamespace(state=SimpleNamespace(approach=0.1)),
        lateral_force=1.0,
        moment=2.0,
        centre_of_pressure=0.3,
    )


def test_unreadable_edges_on_coarse_meshes_add_half_their_spacing_to_the_estimate():
    fine = made(numbers_are_read=True)
    fine.spacing = 0.2
    read, unread = (estimates(fine, made(numbers_are_read=known)) for known in (True, False))
    assert [read.a, read.b] == pytest.approx([READING * 0.2] * 2)
    assert [unread.a, unread.b] == pytest.approx([0.4 + 0.25, 0.2 + 0.25])
    assert [read.F_y, read.M_x, read.s_centre, read.p_max] == [unread.F_y, unread.M_x, unread.s_centre, 0.0]
