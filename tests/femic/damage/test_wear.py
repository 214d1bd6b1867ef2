"""Worn gaps: mass balance, stability, convergence with steps, symmetry; the wear of a scene."""

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from femic.cli.main import WRONG_INPUT, exit_code
from femic.contact.exact.hertz import combined_modulus
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.rolling import RollingContact
from femic.contact.specification import Profile
from femic.contact.undeformed import Undeformed
from femic.damage import wear as module
from femic.damage.estimates import RollingSolution
from femic.damage.laws import STEEL_DENSITY, EnergyLaw
from femic.damage.specification import DamageSpecification
from femic.damage.wear import WearSteps, ripple_factor, wear_contact, worn_problem
from femic.results.damage import compute_wear
from femic.results.stressed_contact import require_stresses
from femic.scenes.load import load_scene
from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.friction_problems import POINT, STEELS, groove, level, paraboloids, wheel_on
from tests.femic.contact.wheel_on_rail import scene

LAW = EnergyLaw(mild=0.7, transition=1e9)
PASSAGES = 60.0


def steps(count, lower=PASSAGES, upper=PASSAGES / 3, **other):
    return WearSteps(count, (lower, upper), LAW, 10.0, **other)


def driven(wheel, creepage=0.01):
    """A wheel at a prescribed creepage: wear solves its contact."""
    return RollingSolution(wheel, RollingContact(None, Creepages(creepage)), POINT.load)


def worn(wheel, of):
    return list(wear_contact(driven(wheel), of))


def flat(n_x=14, n_s=18, *, room=(1.8, 2.1), **other):
    return wheel_on(paraboloids(n_x, n_s, room=room, **other))


def gap_after(wheel, of):
    return np.sum(worn(wheel, of)[-1].depths, axis=0)


FOUR_STEPS = cache(lambda: worn(flat(), steps(4)))


# ---- what is worn


def test_worn_volume_is_energy_times_coefficient():
    contacts = FOUR_STEPS()
    ds = contacts[0].sliding.grid.ds
    joules_per_metre = np.array([contact.sliding.total_work for contact in contacts[:-1]])
    section = 0.7 / 7850 * np.sum(joules_per_metre) * 1e-3  # mm^2 per passage
    lower, upper = contacts[-1].depths
    assert np.sum(lower) * ds == pytest.approx(PASSAGES * section, rel=1e-12)
    assert np.sum(upper) * ds == pytest.approx(PASSAGES / 3 * section, rel=1e-12)
    np.testing.assert_array_equal(contacts[-1].worn, 0)
    assert len(contacts) == 5


def test_without_creepage_nothing_is_worn():
    contacts = list(wear_contact(driven(flat(), 0.0), steps(3, 1e9, 1e9)))
    assert np.all(contacts[-1].depths == 0)
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
    gap = np.sum(FOUR_STEPS()[-1].depths, axis=0)
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
    wheel, forces = flat(), {"longitudinal": 0.24 * POINT.load}
    rolling = wheel.contact(Creepages(1e-3), Loading(POINT.load), forces=forces)
    contacts = list(
        wear_contact(RollingSolution(wheel, rolling, POINT.load, slope=np.nan), steps(2, 2000.0, 1000.0))
    )
    for contact in contacts:
        assert contact.rolling.contact.force[0] == pytest.approx(0.24 * POINT.load, rel=1e-4)
    assert contacts[-1].rolling.creepages.longitudinal != contacts[0].rolling.creepages.longitudinal


# ---- the gap and the wheel's circles


def test_the_worn_gap_is_an_extra_gap_of_bodies_on_a_grid():
    wheel = wheel_on(groove())
    s = wheel.rolling.s
    depths = np.stack([1e-3 * np.exp(-((s - 3) ** 2)), 2e-3 * np.exp(-((s - 2.5) ** 2))])
    rail, tyre = Surface(LOWER, arc(10.0, 1.3, 1.1)), Surface(UPPER, arc(10.2, 1.3, 1.1), 500.0)
    undeformed = Undeformed(tyre, rail, (-8.0, 10.0), -0.07)
    on_grid = PairOnGrid(level(STEELS), undeformed, wheel.problem.grid, Profile(s, depths.sum(axis=0)))
    distance = worn_problem(wheel, depths).problem.distance
    np.testing.assert_allclose(distance, on_grid.distance, atol=1e-9)
    assert np.max(distance - wheel.problem.distance) > 2e-3


def test_wear_of_the_wheel_makes_its_circles_smaller():
    wheel = wheel_on(groove())
    smaller = worn_problem(wheel, np.outer([0.0, 1e-2], np.ones_like(wheel.rolling.s))).rolling
    slower = smaller.rigid_slip(Creepages()) - wheel.rolling.rigid_slip(Creepages())
    exact = 1e-2 * np.cos(wheel.problem.inclination) / 500.0
    np.testing.assert_allclose(slower[..., 0], np.broadcast_to(exact, slower.shape[:2]), atol=1e-15)


def test_the_turn_is_the_largest_slope_of_either_depth():
    last = FOUR_STEPS()[-1]
    slopes = np.gradient(last.depths[0], last.rolling.contact.problem.grid.strips)  # it wears more
    assert last.turned == pytest.approx(np.max(np.abs(slopes)))


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
    first = next(wear_contact(driven(wheel), one))
    passages = factor / ripple_factor(first.rolling.contact, first.sliding, one)
    monkeypatch.setattr(module, "LARGEST_FACTOR", 10.0)
    of = steps(1, passages, passages / 2)
    plain, other = (
        next(wear_contact(driven(each), of)).worn.sum(axis=0) for each in (wheel, rippled(wheel, size))
    )
    strips = (-1.0) ** np.arange(30)
    multiplied = 1 + (other - plain) * strips / size
    assert np.mean(multiplied[12:18]) == pytest.approx(1 - factor, abs=0.08 * factor)


# ---- scattered places


@pytest.mark.parametrize("spread", [0.15, 0.4])
def test_scattered_places_keep_the_volume_and_widen_the_gap(spread):
    wheel = flat(14, 40, room=(1.8, 4.4))
    plain, wide = (worn(wheel, steps(1, spread=one))[-1] for one in (0.0, spread))
    s, ds = wheel.rolling.s, wheel.problem.grid.ds
    volumes = [np.sum(each.depths[0]) * ds for each in (plain, wide)]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-12)
    variances = [np.sum(each.depths[0] * s**2) * ds / volumes[0] for each in (plain, wide)]
    assert variances[1] - variances[0] == pytest.approx(spread**2, rel=0.01)  # cut off at 4 deviations


def ripple_factors(wheel, *spreads):
    """The factors of ripples in the first contact of a wheel, by the spread of places."""
    first = next(wear_contact(driven(wheel), steps(1, 1.0, 0.0)))
    return [
        ripple_factor(first.rolling.contact, first.sliding, steps(1, 1.0, 0.0, spread=one)) for one in spreads
    ]


def test_a_ripple_is_as_stiff_as_half_spaces_of_their_combined_modulus():
    """On elements of any shape: pi^2 E* / (8 G ds), G Catalan's constant, for the longest row that slides."""
    for n_x, n_s in ((30, 12), (12, 30)):
        wheel, friction, creepage = flat(n_x, n_s), 0.3, 0.05
        first = next(wear_contact(driven(wheel, creepage), steps(1, 2.0, 1.0)))
        factor = ripple_factor(first.rolling.contact, first.sliding, steps(1, 2.0, 1.0))
        grid = first.sliding.grid
        length = grid.dx * np.max(np.sum(first.sliding.pressure > 0, axis=0))
        per_pressure = 0.7 / STEEL_DENSITY * 1e-3 * friction * creepage * length
        stiffness = np.pi**2 * combined_modulus(*STEELS) / (8 * 0.915965594177219 * grid.ds)
        assert factor == pytest.approx(3.0 * stiffness * per_pressure, rel=1e-3)


def test_scattered_places_leave_the_stiffest_wave():
    """The largest E* kappa / 2 exp(-(kappa spread)^2 / 2) of all wavenumbers kappa over that of ripples."""
    wheel = flat(14, 40, room=(1.8, 4.4))
    alone, large, larger = ripple_factors(wheel, 0.0, 0.5, 0.8)
    kappa = np.linspace(0.0, 10.0, 20001)
    for spread, found in ((0.5, large), (0.8, larger)):
        wave = np.max(kappa / 2 * np.exp(-((kappa * spread) ** 2) / 2))
        ripple = np.pi**2 / (8 * 0.915965594177219 * wheel.problem.grid.ds)
        assert found / alone == pytest.approx(wave / ripple, rel=1e-6)


def test_scattered_places_allow_larger_steps_which_do_not_oscillate():
    """A small spread is limited by ripples."""
    wheel = flat(14, 40, room=(1.8, 4.4))
    alone, small, large = ripple_factors(wheel, 0.0, 1e-3, 0.5)
    assert alone == small
    assert large < alone / 4
    gap = gap_after(wheel, steps(4, 0.9 / large, 0.0, spread=0.5))
    s = wheel.rolling.s
    assert np.all(np.diff(gap[s < 0]) >= 0)
    assert np.all(np.diff(gap[s > 0]) <= 0)


@pytest.mark.parametrize("side", [-10, 10])
def test_a_spread_beyond_either_end_of_the_grid_is_refused(side):
    wheel = flat(14, 40, room=(1.8, 4.4), offset=(0.0, side))
    with pytest.raises(
        WrongInput, match=r"spread = 0.4 mm: wear reaches the ends of the grid; \d+ strips are"
    ):
        worn(wheel, steps(1, spread=0.4))


def test_too_many_passages_per_step_are_refused():
    with pytest.raises(
        WrongInput,
        match=r"1e.06 .lower., 0 .upper. per step: .* use .* and 0 at most and more steps, or a larger",
    ):
        worn(flat(), steps(2, 1e6, 0.0))


# ---- datasets of scenes


@pytest.fixture(scope="module")
def solution():
    """A wheel that rolls on a rail, driven, on elements a seventh of the patch."""
    wheel = flat()
    return RollingSolution(wheel, wheel.contact(Creepages(0.01), Loading(POINT.load)), POINT.load)


def damage(**keys):
    return DamageSpecification(speed=10.0, energy=LAW, **keys)


def test_each_body_loses_its_share_of_the_work_of_the_contact(solution):
    """Between that of the new and that of the worn contact, which hardly differ."""
    worn = compute_wear(solution, damage(passages=240.0, revolutions=80.0, steps=4))
    section = worn.worn.sum("s").values / 1e3 * solution.contact.problem.grid.ds
    assert section[0] == pytest.approx(3 * section[1], rel=1e-12)
    joules = section[0] * STEEL_DENSITY / (0.7e-3 * 240.0)
    work = worn.worn_work.values
    assert min(work) <= joules <= max(work) < 1.01 * min(work)
    new, last = worn.worn_p_max.values
    assert new == pytest.approx(np.max(solution.contact.p[..., 2]), rel=1e-4)
    of_contact = np.sum(solution.contact.dissipation) * solution.contact.problem.grid.area
    assert work[0] == pytest.approx(of_contact, rel=1e-4)
    assert last < new  # wear spreads the contact of convex bodies


def test_estimates_bound_the_error_by_steps(solution):
    exact = float(compute_wear(solution, damage(passages=240.0, steps=32)).worn[0].max())
    worn = compute_wear(solution, damage(passages=240.0, steps=4))
    assert worn.wear_steps == 4
    error = abs(float(worn.worn[0].max()) - exact)
    assert 0 < error < worn.estimate_worn[0] < 4 * error
    assert worn.estimate_worn[1] == 0
    assert np.all(worn.worn[1] == 0)


def test_there_are_more_steps_where_so_few_are_not_stable(solution, monkeypatch):
    steps = int(compute_wear(solution, damage(passages=20_000.0, steps=2)).wear_steps)
    assert steps in {4, 8, 16, 32, 64, 128}
    monkeypatch.setattr("femic.results.damage.MOST_STEPS", steps - 1)
    with pytest.raises(WrongInput, match=r"steps of wear are needed; passages = .* per step"):
        compute_wear(solution, damage(passages=20_000.0, steps=2))


@pytest.mark.parametrize("spread", [1.0, 30.0])
def test_wear_that_spreads_beyond_the_grid_is_refused_before_any_work(spread, tmp_path, capsys):
    """Its room is known before C: refused are spreads for which no strip of contact is left."""
    path = tmp_path / "mine.toml"
    of = scene(10.5, motion="rolling", friction=[0.3], ics=["A"], loads=[2e3])
    path.write_text(f"{of.text}\n[damage]\npassages = 2e3\nspread = {spread}\n", encoding="utf-8")
    assert exit_code(["stresses", str(path), "--out", str(tmp_path / "out")]) == WRONG_INPUT
    said = capsys.readouterr().err
    assert f"damage.spread = {spread:g} mm: " in said
    least = float(re.search(r"give less than ([\d.e-]+) mm", said)[1])
    assert 0 < least < spread
    require_stresses(load_scene(str(path), {"damage": {"spread": 0.9 * least}}))
    assert not (tmp_path / "out").exists()


def test_wear_that_reaches_the_ends_of_the_grid_is_refused_by_its_key(solution):
    with pytest.raises(WrongInput, match=r"damage\.spread = 0\.6 mm: wear reaches the ends of the grid"):
        compute_wear(solution, damage(passages=240.0, steps=4, spread=0.6))
