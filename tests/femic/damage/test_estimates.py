"""Estimates of wear and fatigue numbers bound the differences to exact numbers, and to finer elements."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.estimates import ROUNDING, floors, from_grids, readings
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.pairs.quantities import main_patch
from femic.damage.estimates import FOLLOW, RollingSolution, estimate_errors
from femic.damage.fatigue import (
    nearest_aspect,
    patch_aspect,
    shakedown_limit,
    surface_index,
    t_gamma,
    utilised_friction,
)
from femic.damage.laws import EnergyLaw, depth
from femic.damage.wear import find_sliding
from geometries.patches import Grid, N
from tests.femic.contact.friction_problems import (
    MIXED,
    POINT,
    STEELS,
    groove,
    on_half_spaces,
    paraboloids,
    wheel_on,
)
from tests.femic.contact.problems import x_of

LOAD, LIMIT, YIELD = Loading(POINT.load), 0.3 * POINT.load, 300.0
SIZE, FINER = (32, 36), (64, 72)
LAW = EnergyLaw(transition=1e9)
SIDEWAYS = Creepages(-1e-3, 5e-4, 1e-4)


def work(solution):
    return {"work": find_sliding(solution.contact, 1.0).total_work}


def at_creepages(wheel, creepages):
    return RollingSolution(wheel, wheel.contact(creepages, LOAD), POINT.load)


def rolled(creepages):
    """What solves a wheel at creepages."""
    return lambda wheel: at_creepages(wheel, creepages)


def at_force(wheel, share, guess):
    """A wheel with a share of friction times load, and the slope of its curve from a contact beside it."""
    rolling = wheel.contact(guess, LOAD, forces={"longitudinal": share * LIMIT})
    below = wheel.contact(guess, LOAD, forces={"longitudinal": 0.98 * share * LIMIT}, start=rolling.contact)
    rise = rolling.creepages.longitudinal - below.creepages.longitudinal
    return RollingSolution(wheel, rolling, POINT.load, 0.02 * share * LIMIT / rise)


def solved(solve, problem):
    """A contact, with those on elements twice and four times as large."""
    coarse = problem.coarsened
    own, *larger = (solve(wheel_on(one)) for one in (problem, coarse, coarse.coarsened))
    return replace(own, larger=tuple(larger))


def known(solve, numbers=work, bodies=paraboloids, **keys):
    """A contact, its numbers and their errors."""
    own = solved(solve, bodies(*SIZE, **keys))
    return own, *estimate_errors(own, numbers)


@pytest.mark.parametrize("creepages", [SIDEWAYS, Creepages(4e-3, 2e-3, -3e-4)], ids=str)
def test_work_on_slip_is_that_of_forces_and_creepages_on_half_spaces(creepages):
    own, numbers, errors = known(rolled(creepages), offset=(0.2, 0.3))
    x, s = own.problem.rolling.x[:, None], own.problem.rolling.s
    p_x, p_s = (own.contact.p[..., k] * own.problem.problem.grid.area for k in (0, 1))
    xi, upsilon, phi = creepages.longitudinal, creepages.lateral, creepages.spin
    exact = xi * p_x.sum() - upsilon * p_s.sum() - phi * np.sum(x * p_s - s * p_x)
    assert abs(numbers["work"] - exact) < errors["work"] < 0.3 * exact


@pytest.mark.parametrize("materials", [MIXED, MIXED[::-1]], ids=["brass on steel", "steel on brass"])
def test_work_on_slip_is_that_of_the_rigid_motion_in_a_groove(materials):
    own, numbers, errors = known(rolled(SIDEWAYS), bodies=groove, materials=materials)
    exact, error = own.problem.power(own.rolling) - own.problem.climbing(own.rolling), errors["work"]
    assert abs(exact - numbers["work"]) < error < 0.1 * exact
    assert abs(t_gamma(own.problem, own.rolling)[2]) > error


def test_where_little_slides_what_grids_miss_of_the_work_counts():
    """At 1 % of the work of full sliding; the force is that of Kalker's linear theory, nearly."""
    own, numbers, errors = known(rolled(Creepages(2e-4)), work_and_worn)
    finer = wheel_on(paraboloids(*FINER)).contact(Creepages(2e-4), LOAD)
    missed = 2e-4 * finer.contact.force[0] - numbers["work"]
    by_state = floors(own.contact.slip_state)["work"] * own.contact.largest_work
    assert by_state < 0.6 * missed  # does not know it
    assert 0.95 * missed < errors["work"] < 1.5 * missed
    assert errors["area"] / numbers["area"] == pytest.approx(errors["work"] / numbers["work"], rel=0.05)


def work_and_worn(solution):
    sliding = find_sliding(solution.contact, 1.0)
    return work(solution) | {"area": float(np.sum(depth(sliding, LAW))) * sliding.grid.ds}


def test_worn_areas_are_known_as_well_as_the_work_which_they_follow():
    """They are in proportion to it under this law."""
    creepages = Creepages(2e-3, 1e-3)
    _, numbers, errors = known(rolled(creepages), work_and_worn)
    assert errors["area"] / numbers["area"] == pytest.approx(errors["work"] / numbers["work"], rel=1e-3)
    finer = work_and_worn(at_creepages(wheel_on(paraboloids(*FINER)), creepages))
    assert abs(finer["area"] - numbers["area"]) < errors["area"] < 0.2 * numbers["area"]


def test_uncertain_elements_count_by_the_work_of_full_sliding():
    """Beside changes from grid to grid, and not by the own work; here they are more than what slip misses."""
    own = solved(rolled(Creepages(4e-3)), paraboloids(*SIZE))
    by_changes = from_grids(*(work(one)["work"] for one in (own, *own.larger)))
    uncertain = floors(own.contact.slip_state)["work"] * own.contact.largest_work
    assert own.problem.missed_work(own.rolling) < uncertain
    error = estimate_errors(own, work)[1]["work"]
    assert error - by_changes == pytest.approx(uncertain, rel=1e-3)
    assert uncertain > 0.05 * by_changes


# ---- at prescribed forces


def all_numbers(solution):
    longitudinal, lateral, spin = t_gamma(solution.problem, solution.rolling)
    p_max = float(np.max(solution.contact.p[..., N]))
    utilised = utilised_friction(solution.contact)
    return {
        "xi": solution.rolling.creepages.longitudinal,
        "p_max": p_max,
        "utilised_friction": utilised,
        "t_gamma": longitudinal + lateral,
        "t_gamma_with_spin": longitudinal + lateral + spin,
        "surface_index": float(surface_index(p_max, utilised, YIELD)),
        **work_and_worn(solution),
    }


def in_map(p_max, utilised, aspect):
    """The place of a contact in the shakedown map."""
    ratio, limit = p_max / YIELD, float(shakedown_limit(utilised, aspect))
    return {"pressure_ratio": ratio, "shakedown_limit": limit, "load_factor": limit / ratio}


def test_numbers_that_follow_are_known_to_what_they_follow_from():
    """Their largest changes over all signs of the errors of pressures, limit and friction."""

    def with_shakedown(solution):
        numbers = all_numbers(solution)
        return numbers | in_map(numbers["p_max"], numbers["utilised_friction"], 1.0)

    solve, bodies = random_rolling(1)
    _, numbers, errors = known(solve, with_shakedown, bodies)
    p, limit, utilised = (
        numbers[name] + errors[name] * np.array([-1.0, 1.0])
        for name in ("p_max", "shakedown_limit", "utilised_friction")
    )
    found = {
        "pressure_ratio": p / YIELD,
        "load_factor": limit[:, None] / (p / YIELD),
        "surface_index": surface_index(p, 0.0, YIELD) + utilised[:, None],
    }
    for name, values in found.items():
        assert errors[name] == pytest.approx(np.max(np.abs(values - numbers[name])), rel=0.05)


def random_rolling(seed):
    random = np.random.default_rng(seed)
    share, lateral = random.uniform(0.1, 0.9), random.normal(0, 8e-4)
    offset = tuple(random.uniform(-0.5, 0.5, 2))
    guess = Creepages(1e-3 * share, lateral, random.normal(0, 1e-4))

    def made(n_x, n_s):
        """The same place of the contact in elements of all sizes."""
        return paraboloids(n_x, n_s, offset=tuple(n_x / 32 * one for one in offset))

    def solve(wheel):
        return at_force(wheel, share, guess)

    return solve, made


@pytest.mark.parametrize("seeds", [[0, 1], pytest.param(range(2, 30), marks=pytest.mark.slow)])
def test_estimates_bound_differences_to_finer_elements_at_random_forces(seeds):
    within, sizes = [], []
    for seed in seeds:
        solve, bodies = random_rolling(seed)
        _, numbers, errors = known(solve, all_numbers, bodies)
        finer = all_numbers(solve(wheel_on(bodies(*FINER)))) | {"p_max": POINT.p_max}
        within += [abs(finer[name] - numbers[name]) <= errors[name] for name in numbers]
        sizes.append(errors["t_gamma"] / numbers["t_gamma"])
    assert np.mean(within) >= 0.95
    assert np.median(sizes) < 0.2


def random_ellipse(seed):
    """A contact of a random ellipse at random creepages, and Hertz's of the same bodies."""
    random = np.random.default_rng(1000 + seed)
    radii = np.exp(random.uniform(np.log(10.0), np.log(200.0), 2))
    hertz = PointContact(*1 / radii, combined_modulus(*STEELS)).at_load(POINT.load)
    offset, friction = random.uniform(-0.5, 0.5, 2) / [16, 20], random.uniform(0.1, 0.6)
    size, angle = friction * np.exp(random.uniform(np.log(3e-4), np.log(2e-2))), random.uniform(0, 2 * np.pi)
    spin = 0.3 * size / np.sqrt(hertz.a * hertz.b) * random.normal()
    creepages = Creepages(size * np.cos(angle), size * np.sin(angle), spin)

    def bodies(n_x, n_s):
        sides = 3.4 * hertz.a, 3.6 * hertz.b
        grid = Grid(n_x, n_s, sides[0] / n_x, sides[1] / n_s)
        x, s = x_of(grid)[:, None] - offset[0] * sides[0], grid.strips - offset[1] * sides[1]
        return on_half_spaces(grid, x**2 / 2 / radii[0] + s**2 / 2 / radii[1], friction=friction)

    return bodies, creepages, hertz


def shakedown(solution):
    p_max, utilised = float(np.max(solution.contact.p[..., N])), utilised_friction(solution.contact)
    of_map = in_map(p_max, utilised, patch_aspect(solution.contact))
    return {"p_max": p_max, "utilised_friction": utilised} | of_map


@pytest.mark.parametrize("seeds", [[1, 15], pytest.param(range(20, 44), marks=pytest.mark.slow)])
def test_the_shakedown_limit_is_within_its_estimate_of_that_of_hertz_and_finer_elements(seeds):
    """Seed 1: a/b 3.2 and little friction, where the aspect decides; 15: where its own change is small."""
    shares = []
    for seed in seeds:
        bodies, creepages, hertz = random_ellipse(seed)
        own = solved(rolled(creepages), bodies(16, 20))
        numbers, errors = estimate_errors(own, shakedown)
        finer = at_creepages(wheel_on(bodies(48, 60)), creepages)
        aspect = nearest_aspect(hertz.a / hertz.b)
        exact = {"shakedown_limit": float(shakedown_limit(utilised_friction(finer.contact), aspect))}
        exact["load_factor"] = exact["shakedown_limit"] * YIELD / hertz.p_max
        shares.append([abs(numbers[name] - exact[name]) / errors[name] for name in exact])
        by_friction = shakedown_limit(
            numbers["utilised_friction"] + errors["utilised_friction"], patch_aspect(own.contact)
        )
        assert errors["shakedown_limit"] > 0.999 * abs(by_friction - numbers["shakedown_limit"])
    assert np.mean(np.array(shares) <= 1, axis=0) == pytest.approx(1.0, abs=0.05)


def test_the_shakedown_limit_is_known_to_the_aspect_alone_where_friction_is_known():
    """Changed edges: the limit changes by no more than the estimate, and that is not ten times too wide."""
    bodies, creepages, _ = random_ellipse(1)
    own = at_creepages(wheel_on(bodies(16, 20)), creepages)
    numbers, errors = estimate_errors(replace(own, larger=(own, own)), shakedown)
    aspect, utilised = patch_aspect(own.contact), numbers["utilised_friction"]
    readings_of = readings(main_patch(own.contact))
    changed = float(shakedown_limit(utilised, aspect * (1 + max(readings_of.values()))))
    change = abs(changed - numbers["shakedown_limit"])
    assert change < errors["shakedown_limit"] < 3 * change


@pytest.mark.parametrize(
    ("radii", "factors"), [((20.0, 20.0), (-1, 1)), ((10.0, 400.0), (1,)), ((400.0, 10.0), (-1,))]
)
def test_the_aspect_of_a_patch_may_be_larger_or_smaller(radii, factors):
    """Here utilised friction is known better. At an end of the map the aspect changes to one side only."""
    hertz = PointContact(*1 / np.array(radii), combined_modulus(*STEELS)).at_load(POINT.load)
    grid = Grid(16, 16, 3.4 * hertz.a / 16, 3.4 * hertz.b / 16)
    distance = x_of(grid)[:, None] ** 2 / 2 / radii[0] + grid.strips**2 / 2 / radii[1]
    own = at_creepages(wheel_on(on_half_spaces(grid, distance, friction=0.1)), Creepages(0.1))
    numbers, errors = estimate_errors(replace(own, larger=(own, own)), shakedown)
    aspect, utilised = patch_aspect(own.contact), numbers["utilised_friction"]
    share = np.hypot(*readings(main_patch(own.contact)).values())  # of independent lengths and widths
    frictions = utilised + errors["utilised_friction"] * np.array([-1, 1])
    limits = [shakedown_limit(utilised, one) for one in aspect * (1 + share) ** np.array(factors)]
    by_aspect, by_friction = (
        np.max(np.abs(changed - numbers["shakedown_limit"]))
        for changed in (np.array(limits), shakedown_limit(frictions, aspect))
    )
    rounding = 2 * ROUNDING * numbers["shakedown_limit"]
    assert errors["shakedown_limit"] == pytest.approx(np.hypot(by_aspect, by_friction), abs=rounding)
    assert by_aspect > by_friction


def test_utilised_friction_is_known_to_the_largest_change_by_errors_of_both_forces():
    """Over all their signs; to the error of the lateral force alone where the longitudinal one is given."""

    def forces(solution):
        F_x, F_s = (np.sum(solution.contact.p[..., k]) * solution.problem.problem.grid.area for k in (0, 1))
        return {"F_x": F_x, "F_s": F_s, "utilised_friction": utilised_friction(solution.contact)}

    free = at_creepages(wheel_on(paraboloids(16, 18)), SIDEWAYS)
    found = []
    for own in (free, replace(free, slope=1.0)):
        numbers, errors = estimate_errors(replace(own, larger=(own, own)), forces)
        changed = [
            np.hypot(numbers["F_x"] + one * errors["F_x"], numbers["F_s"] + other * errors["F_s"])
            / POINT.load
            for one in (-1, 1)
            for other in (-1, 1)
        ]
        largest = np.max(np.abs(np.array(changed) - numbers["utilised_friction"]))
        assert errors["utilised_friction"] == pytest.approx(largest, rel=1e-6)
        found.append(errors)
    assert found[1]["F_x"] < 1.01 * ROUNDING * POINT.load < found[0]["F_x"]
    assert found[0]["utilised_friction"] > found[1]["utilised_friction"] > 0


def test_changed_ics_add_at_least_their_change():
    solve, bodies = random_rolling(3)
    own = solved(solve, bodies(*SIZE))
    numbers, errors = estimate_errors(own, all_numbers)
    changed = replace(own)  # another one, by its identity

    def compute(one):
        factor = 1.03 if one is changed else 1.0
        return {name: factor * number for name, number in all_numbers(one).items()}

    _, with_change = estimate_errors(replace(own, changed=(changed,)), compute)
    for name, number in numbers.items():
        if name in FOLLOW:  # these follow from the others, and from forces
            continue
        assert with_change[name] - errors[name] >= 0.03 * abs(number) * (1 - ROUNDING)


@pytest.mark.parametrize(("larger", "changed"), [([], []), ([None], []), ("same", [None])], ids=str)
def test_what_is_not_known_is_nan(larger, changed):
    solve, bodies = random_rolling(0)
    solution = solve(wheel_on(bodies(16, 18)))
    larger = [solution, solution] if larger == "same" else larger
    own = replace(solution, larger=tuple(larger), changed=tuple(changed))
    _, errors = estimate_errors(own, all_numbers)
    assert np.all(np.isnan(list(errors.values())))


def test_t_gamma_is_known_to_uncertain_forces_times_the_creepages_that_are_given():
    """By elements whose state is uncertain alone: nothing else changes from grid to grid; these are exact."""
    own = at_creepages(wheel_on(paraboloids(16, 18)), SIDEWAYS)
    force = floors(own.contact.slip_state)["force"] * LIMIT
    expected = np.hypot(SIDEWAYS.longitudinal, SIDEWAYS.lateral) * force
    _, errors = estimate_errors(replace(own, larger=(own, own)), all_numbers)
    assert errors["t_gamma"] == pytest.approx(expected, rel=1e-3)
    assert errors["xi"] == 0
    still = at_creepages(wheel_on(paraboloids(16, 18)), Creepages())
    numbers, errors = estimate_errors(replace(still, larger=(still, still)), work_and_worn)
    assert numbers == errors == {"work": 0, "area": 0}


def test_without_a_slope_creepage_and_t_gamma_are_not_known():
    solve, bodies = random_rolling(0)
    solution = solve(wheel_on(bodies(16, 18)))
    _, errors = estimate_errors(replace(solution, slope=np.nan, larger=(solution,) * 2), all_numbers)
    assert {name for name, error in errors.items() if np.isnan(error)} == {
        "xi",
        "t_gamma",
        "t_gamma_with_spin",
    }
