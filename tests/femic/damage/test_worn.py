"""Worn gaps: mass balance, stability, convergence with steps, renewal of ICs, symmetry."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.undeformed import Undeformed
from femic.damage import worn as module
from femic.damage.laws import ArchardMap, EnergyLaw
from femic.damage.worn import (
    BodyWear,
    Operation,
    WearSteps,
    WornSurfaces,
    ripple_factor,
    worn_contacts,
    worn_problem,
)
from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.friction_problems import POINT, STEELS, groove, level, paraboloids, wheel_on

LAW = EnergyLaw(mild=0.7, transition=1e9)
DRIVEN = Operation(Loading(POINT.load), Creepages(0.01), 10.0)
PASSAGES = 60.0
SOFT = Material(150e3, 0.28)


def steps(count, lower=PASSAGES, upper=PASSAGES / 3, **other):
    return WearSteps(count, BodyWear(LAW, lower), BodyWear(LAW, upper), **other)


def flat(n_x=14, n_s=18, *, room=(1.8, 2.1), **other):
    return wheel_on(paraboloids(n_x, n_s, room=room, **other))


def gap_after(wheel, of, operation=DRIVEN):
    return list(worn_contacts(wheel, operation, of))[-1].surfaces.extra_gap.gap


FOUR_STEPS = cache(lambda: list(worn_contacts(flat(), DRIVEN, steps(4))))


# ---- what is worn


def test_worn_volume_is_energy_times_coefficient():
    contacts = FOUR_STEPS()
    ds = contacts[0].sliding.grid.ds
    joules_per_metre = np.array([contact.sliding.total_work for contact in contacts[:-1]])
    section = 0.7 / 7850 * np.sum(joules_per_metre) * 1e-3  # mm^2 per passage
    last = contacts[-1].surfaces
    assert np.sum(last.lower) * ds == pytest.approx(PASSAGES * section, rel=1e-12)
    assert np.sum(last.upper) * ds == pytest.approx(PASSAGES / 3 * section, rel=1e-12)
    np.testing.assert_allclose(last.extra_gap.gap, last.lower + last.upper)
    np.testing.assert_array_equal(contacts[-1].worn, 0)
    assert len(contacts) == 5


def test_without_creepage_nothing_is_worn():
    contacts = list(worn_contacts(flat(), replace(DRIVEN, creepages=Creepages()), steps(3, 1e9, 1e9)))
    assert np.all(contacts[-1].surfaces.extra_gap.gap == 0)
    np.testing.assert_allclose(contacts[-1].rolling.contact.p, contacts[0].rolling.contact.p, atol=1e-3)


def test_wear_spreads_the_contact_and_lowers_its_pressure():
    contacts = [contact.rolling.contact for contact in FOUR_STEPS()]
    largest = [contact.p.max() for contact in contacts]
    assert np.all(np.diff(largest) < 0)
    s = contacts[0].problem.grid.strips
    widths = [np.sum(contact.pressures * s**2) for contact in contacts]
    assert np.all(np.diff(widths) > 0)
    for contact in contacts:
        assert contact.force[2] == pytest.approx(POINT.load, rel=1e-6)


def test_a_symmetric_contact_stays_symmetric_and_a_mirrored_one_mirrored():
    gap = FOUR_STEPS()[-1].surfaces.extra_gap.gap
    np.testing.assert_allclose(gap[::-1], gap, atol=1e-4 * gap.max())
    aside, mirrored = (gap_after(flat(offset=(0.0, side)), steps(2)) for side in (0.4, -0.4))
    np.testing.assert_allclose(mirrored[::-1], aside, atol=1e-4 * gap.max())
    assert np.max(np.abs(aside[::-1] - aside)) > 0.05 * gap.max()


def test_more_and_smaller_steps_converge_to_the_first_order():
    gaps = [gap_after(flat(), steps(n, 240 / n, 80 / n)) for n in (2, 4, 8)]
    far, near = (np.max(np.abs(one - other)) for one, other in pairwise(gaps))
    assert far / near == pytest.approx(2.0, abs=0.4)
    assert near < 0.01 * gaps[-1].max()


def test_prescribed_forces_stay():
    operation = Operation(
        Loading(POINT.load), Creepages(1e-3), 10.0, {"longitudinal": 0.8 * 0.3 * POINT.load}
    )
    contacts = list(worn_contacts(flat(), operation, steps(2, 2000.0, 1000.0)))
    for contact in contacts:
        assert contact.rolling.contact.force[0] == pytest.approx(0.24 * POINT.load, rel=1e-4)
    assert contacts[-1].rolling.creepages.longitudinal != contacts[0].rolling.creepages.longitudinal


# ---- the gap and the wheel's circles


def test_the_worn_gap_is_an_extra_gap_of_bodies_on_a_grid():
    wheel = wheel_on(groove())
    s = wheel.rolling.s
    surfaces = WornSurfaces(s, 1e-3 * np.exp(-((s - 3) ** 2)), 2e-3 * np.exp(-((s - 2.5) ** 2)))
    rail, tyre = Surface(LOWER, arc(10.0, 1.3, 1.1)), Surface(UPPER, arc(10.2, 1.3, 1.1), 500.0)
    undeformed = Undeformed(tyre, rail, (-8.0, 10.0), -0.07)
    on_grid = PairOnGrid(level(STEELS), undeformed, wheel.problem.grid, surfaces.extra_gap)
    worn = worn_problem(wheel, surfaces, wheel.problem.operator)
    np.testing.assert_allclose(worn.problem.distance, on_grid.distance, atol=1e-9)
    assert np.max(worn.problem.distance - wheel.problem.distance) > 2e-3


def test_wear_of_the_wheel_makes_its_circles_smaller():
    wheel = wheel_on(groove())
    s = wheel.rolling.s
    worn = worn_problem(wheel, WornSurfaces(s, 0 * s, 1e-2 + 0 * s), wheel.problem.operator)
    slower = worn.rolling.rigid_slip(Creepages()) - wheel.rolling.rigid_slip(Creepages())
    exact = 1e-2 * np.cos(wheel.problem.inclination) / 500.0
    np.testing.assert_allclose(slower[..., 0], np.broadcast_to(exact, slower.shape[:2]), atol=1e-15)


# ---- ICs


@pytest.mark.parametrize(("angle", "renewals"), [(1.0, [0, 0, 0]), (1e-12, [0, 1, 2])])
def test_ics_are_renewed_where_the_surface_has_turned(angle, renewals):
    wheel, seen = flat(), []

    def renew(surfaces):
        seen.append(surfaces)
        return wheel.problem.operator

    contacts = list(worn_contacts(wheel, DRIVEN, steps(2, largest_turn=angle), renew))
    assert [contact.renewals for contact in contacts] == renewals
    assert len(seen) == renewals[-1]
    if seen:
        assert contacts[-1].turned == 0
        np.testing.assert_array_equal(seen[-1].lower, contacts[-1].surfaces.lower)


def test_the_angle_is_the_largest_slope_of_either_depth():
    contacts = FOUR_STEPS()
    last = contacts[-1]
    slopes = np.gradient(last.surfaces.lower, last.surfaces.s)  # of the body that wears more
    assert last.turned == pytest.approx(np.max(np.abs(slopes)))
    assert [contact.renewals for contact in contacts] == [0, 0, 0, 0, 0]


def test_renewed_ics_are_used():
    """Those of softer bodies, as an example."""
    soft = paraboloids(14, 18, room=(1.8, 2.1), materials=(SOFT, SOFT)).operator
    of = steps(1, 1.0, 0.0, largest_turn=1e-12)
    renewed = list(worn_contacts(flat(), DRIVEN, of, lambda _: soft))
    assert renewed[1].rolling.contact.p.max() < 0.85 * renewed[0].rolling.contact.p.max()


# ---- stability


def rippled(wheel, size):
    """The wheel with a gap of +size and -size from strip to strip."""
    strips = size * (-1.0) ** np.arange(wheel.problem.grid.n_s)
    return replace(wheel, problem=replace(wheel.problem, distance=wheel.problem.distance + strips))


@pytest.mark.parametrize("factor", [0.3, 0.9, 1.8])
def test_a_step_multiplies_ripples_by_1_less_their_factor(factor, monkeypatch):
    """In the middle of a contact that slides as a whole; its edges and its length cost some per cent."""
    wheel, size = flat(20, 30), 1e-6
    one = steps(1, 1.0, 0.5)
    first = next(worn_contacts(wheel, DRIVEN, one))
    passages = factor / ripple_factor(first.rolling.contact, first.sliding, one)
    monkeypatch.setattr(module, "LARGEST_FACTOR", 10.0)
    of = steps(1, passages, passages / 2)
    plain, other = (
        next(worn_contacts(each, DRIVEN, of)).worn.sum(axis=0) for each in (wheel, rippled(wheel, size))
    )
    strips = (-1.0) ** np.arange(30)
    multiplied = 1 + (other - plain) * strips / size
    assert np.mean(multiplied[12:18]) == pytest.approx(1 - factor, abs=0.08 * factor)


# ---- scattered places


@pytest.mark.parametrize("spread", [0.15, 0.4])
def test_scattered_places_keep_the_volume_and_widen_the_gap(spread):
    wheel = flat(14, 40, room=(1.8, 4.4))
    plain, wide = (list(worn_contacts(wheel, DRIVEN, steps(1, spread=one)))[-1] for one in (0.0, spread))
    s, ds = wheel.rolling.s, wheel.problem.grid.ds
    volumes = [np.sum(each.surfaces.lower) * ds for each in (plain, wide)]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-12)
    variances = [np.sum(each.surfaces.lower * s**2) * ds / volumes[0] for each in (plain, wide)]
    assert variances[1] - variances[0] == pytest.approx(spread**2, rel=0.01)  # cut off at 4 deviations


def test_scattered_places_allow_larger_steps_which_do_not_oscillate():
    wheel = flat(14, 40, room=(1.8, 4.4))
    first = next(worn_contacts(wheel, DRIVEN, steps(1, 1.0, 0.0)))
    alone, spread = (ripple_factor(first.rolling.contact, first.sliding, steps(1, 1.0, 0.0, spread=one))
                     for one in (0.0, 0.5))  # fmt: skip
    assert spread < alone / 4
    worn = list(worn_contacts(wheel, DRIVEN, steps(4, 0.9 / spread, 0.0, spread=0.5)))
    gap = worn[-1].surfaces.extra_gap.gap
    s = wheel.rolling.s
    assert np.all(np.diff(gap[s < 0]) >= 0)
    assert np.all(np.diff(gap[s > 0]) <= 0)


def test_a_small_spread_is_limited_by_ripples():
    first = next(worn_contacts(flat(), DRIVEN, steps(1)))
    factors = [
        ripple_factor(first.rolling.contact, first.sliding, steps(1, spread=one)) for one in (0.0, 1e-3)
    ]
    assert factors[0] == factors[1]


@pytest.mark.parametrize("side", [-10, 10])
def test_a_spread_beyond_either_end_of_the_grid_is_refused(side):
    wheel = flat(14, 40, room=(1.8, 4.4), offset=(0.0, side))
    with pytest.raises(
        WrongInput, match=r"spread = 0.4 mm: wear reaches the ends of the grid; \d+ strips are"
    ):
        list(worn_contacts(wheel, DRIVEN, steps(1, spread=0.4)))


def test_too_many_passages_per_step_are_refused():
    with pytest.raises(
        WrongInput,
        match=r"1e.06 .lower., 0 .upper. per step: .* take .* and 0 at most and more steps, or a larger",
    ):
        list(worn_contacts(flat(), DRIVEN, steps(2, 1e6, 0.0)))


# ---- bad input


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: steps(0), "steps = 0: one or more"),
        (lambda: steps(2, -1.0), "passages = -1.0 per step: must be zero or positive"),
        (lambda: steps(2, largest_turn=0.0), "largest_turn = 0.0: must be positive"),
        (lambda: steps(2, spread=-0.1), "spread = -0.1: must be zero or positive"),
        (lambda: replace(DRIVEN, speed=-1.0), "speed = -1.0: must be positive"),
        (lambda: BodyWear(ArchardMap(), np.inf), "passages = inf per step"),
    ],
)
def test_wrong_numbers_are_refused(call, message):
    with pytest.raises(WrongInput, match=message):
        call()
