"""Contacts of `femic extremes`: builders of cases, what they are compared with, refusals."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad

from compare.validation.extremes import contacts, friction, friction_solutions, frictionless
from compare.validation.extremes.cases import CONTACT, FRICTION, Limit, WithinLimit, run_limits
from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.loading import Loading
from femic.contact.motions.rolling import OF_ROLLING
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.reference.run_options import RunOptions
from geometries.patches import Grid

ALONE = RunOptions(1)
FEWEST = {"elements": 8}


def solved(numbers, estimates, scales=None):
    """A contact that is not solved."""
    scales = dict.fromkeys(numbers, 1.0) if scales is None else scales
    return contacts.ContactSolution(None, None, numbers, estimates, scales, None)


def truth_of(case, **changes):
    """What a case is compared with, of a contact that is not solved."""
    problem = replace(case, changes={**case.changes, **changes}).problem
    return case.truth.numbers(contacts.ContactSolution(problem, None, {}, {}, {}, None))


def problem_of(base, changes):
    return contacts.ContactCase("", base, changes, None, None).problem


LIMITS = {CONTACT: frictionless.limits(), FRICTION: friction.limits()}
CASES = {part: {limit.name: limit.reached for limit in limits} for part, limits in LIMITS.items()}
REFUSED = {part: [(row.name, case) for row in rows for case in row.beyond] for part, rows in LIMITS.items()}


# --- errors, estimates and notes -------------------------------------------------------------------------


def test_the_number_with_the_largest_share_of_its_estimate_is_named():
    """p_max is off by more, b by more than its estimate."""
    known = solved({"p_max": 1100.0, "b": 2.02}, {"p_max": 200.0, "b": 0.01})
    result = contacts.compare("here", known, {"p_max": 1000.0, "b": 2.0}, "Hertz", 1.0)
    assert (result.error, result.estimate, result.used) == pytest.approx((0.1, 0.2, 2.0))
    assert result.note == "p_max 1100, b 2.02; worst: b"
    assert not result.honest


def test_forces_are_shares_of_the_force_and_vanishing_ones_of_the_largest_possible():
    """F_y = 0 by symmetry beside F_x = 4 N; M_z = 0 is a share of its scale; sliding is one of 1."""
    truth = {"F_x": 4.0, "F_y": 0.0, "M_z": 0.0, "sliding_share": 0.01}
    numbers = {name: value + 0.002 for name, value in truth.items()}
    scales = {"F_x": 30.0, "F_y": 30.0, "M_z": 2.0, "sliding_share": 1.0}
    for name, share in (("F_x", 0.0005), ("F_y", 0.0005), ("M_z", 0.001), ("sliding_share", 0.002)):
        others = {other: numbers[name] if other == name else value for other, value in truth.items()}
        result = contacts.compare("", solved(others, dict.fromkeys(truth, 0.004), scales), truth, "", 0.0)
        assert result.error == pytest.approx(share), name
        assert result.used == pytest.approx(0.5)


def test_numbers_without_estimates_have_errors_alone():
    known = solved({"p_max": 101.0, "a": 2.0}, {"p_max": np.nan, "a": 0.1})
    result = contacts.compare("", known, {"p_max": 100.0, "a": 2.0}, "", 0.0)
    assert (result.estimate, result.used) == (None, None)
    assert result.error == pytest.approx(0.01)
    assert "worst: p_max, without an estimate" in result.note


def test_finer_grids_cover_the_same_area_with_smaller_elements():
    grids = []

    def on(grid):
        grids.append(grid)
        return {"p_max": 1.0, "a": 2.0}

    on_grid = SimpleNamespace(grid=Grid(6, 10, 0.3, 0.2, 1.1))
    known = replace(solved({}, {}), on_grid=on_grid, on=on)
    assert contacts.finer("a").numbers(known) == contacts.finer("a", factor=2).numbers(known) == {"a": 2.0}
    assert [(grid.n_x, grid.n_s) for grid in grids] == [(24, 40), (12, 20)]
    for grid in grids:
        assert (*grid.extent, grid.n_x * grid.dx) == pytest.approx((*on_grid.grid.extent, 1.8))


def test_numbers_of_another_case_are_taken_times_factors():
    solve = lambda *_: solved({"F_y": 2.0, "a": 3.0}, {})  # noqa: E731
    other = contacts.ContactCase("", "flat", contacts.crossed(1.0), solve, contacts.Truth("", None))
    assert contacts.same_as("", other, {"F_y": -1.0, "a": 10.0}).numbers(solved({}, {})) == {
        "F_y": -2.0,
        "a": 30.0,
    }


# --- builders --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [CONTACT, FRICTION])
def test_all_cases_are_contacts_that_scenes_take(part):
    for name, row in CASES[part].items():
        for case in row:
            specification = case.problem.specification
            assert len(specification.ics) == 1, name
            assert (specification.friction is None) == (part == CONTACT)
            assert len({other.label for other in row}) == len(row), name


VALUES = {  # of a contact, by the name of a parameter
    "load": lambda problem: problem.specification.loads[-1],
    "modulus ratio": lambda problem: problem.bodies["upper"].material.E / problem.bodies["lower"].material.E,
    "ν": lambda problem: problem.bodies["lower"].material.nu,
    "R_roll": lambda problem: problem.bodies["upper"].rolling_radius,
    "elements across": lambda problem: problem.specification.elements,
    "element aspect dx/ds": lambda problem: problem.grid.dx / problem.grid.ds,
    "patch aspect a/b": lambda problem: contacts.hertz_contact(problem).a / contacts.hertz_contact(problem).b,
    "friction": lambda problem: problem.specification.friction.coefficients[0],
    "creepage": lambda problem: problem.specification.friction.longitudinal[-1],
    "lateral creepage": lambda problem: problem.specification.friction.lateral,
    "spin": lambda problem: problem.specification.friction.spin,
}
OF_BOTH = {"modulus ratio": (0.01, 100), "ν": (0, 0.4999), "R_roll": (20, 1e6), "elements across": (8, 64)}
ENDS = {
    CONTACT: {"load": (1e-3, 310e3), "element aspect dx/ds": (0.05, 20)} | OF_BOTH,
    FRICTION: {"friction": (1e-9, 1000), "creepage": (-0.99, 0.99), "spin": (1e-4, 1)}
    | {"lateral creepage": (1e-4, 0.99)}
    | OF_BOTH,
}


@pytest.mark.parametrize("part", ENDS)
def test_cases_reach_both_ends_of_their_range(part):
    for name, ends in ENDS[part].items():
        values = [VALUES[name](case.problem) for case in CASES[part][name]]
        assert (min(values), max(values)) == pytest.approx(ends), name


@pytest.mark.parametrize("part", [CONTACT, FRICTION])
def test_patches_are_as_slender_as_their_labels_say(part):
    for case in CASES[part]["patch aspect a/b"]:
        label = case.label.split(",")[0]
        stated = 1 / float(label[2:]) if label.startswith("1/") else float(label)
        assert VALUES["patch aspect a/b"](case.problem) == pytest.approx(stated, rel=0.03)


def test_radii_of_conformal_cases_differ_by_their_label():
    for case in CASES[CONTACT]["R_w / R_r − 1"]:
        lower, upper = (case.problem.bodies[name].contour.inclination(1e-3) for name in ("lower", "upper"))
        assert lower / upper - 1 == pytest.approx(float(case.label.split(",")[0]), rel=1e-6)


# --- closed forms ----------------------------------------------------------------------------------------


def test_hertz_has_the_curvatures_at_the_crown():
    """Of ellipses d / b^2, of the wheel 1 / R_roll."""
    surfaces = contacts.hertz_contact(problem_of("tall", {"contact": {"loads": [1.0]}})).surfaces
    assert surfaces.curvature_x == pytest.approx(1 / 653.7)
    assert surfaces.curvature_s == pytest.approx(12.97 / 6.485**2 - 14.7 / 6.985**2, rel=1e-6)


def test_two_bumps_are_parabolas_of_their_radius_as_far_as_contours_go():
    gap, s = contacts.two_bumps(), np.array([-9.9, -3.2, -3.0, 3.3, 9.9])
    expected = np.array([6.9, 0.2, 0, 0.3, 6.9]) ** 2 / 2 / contacts.BUMP_RADIUS
    np.testing.assert_allclose(gap.at(np.zeros(1), s), expected, atol=1e-6)


def test_the_stiffness_of_two_patches_is_the_derivative_of_their_load():
    case = CASES[CONTACT]["patches"][0]
    low, middle, high = (
        truth_of(case, contact={**case.changes["contact"], "loads": [200.0 + step]})
        for step in (-0.1, 0, 0.1)
    )
    assert middle["stiffness"] == pytest.approx(0.2 / (high["approach"] - low["approach"]), rel=1e-6)
    one = contacts.hertz_bump(case.problem)
    assert one.load == 100.0
    assert middle["approach"] > 1.01 * one.approach
    assert middle["stiffness"] < 2 * one.stiffness


def rollers(xi=0.0, coefficient=0.3, **keys):
    return friction.case("", friction.rollers(xi, coefficient, **keys), contacts.Truth("", None))


def test_kalkers_forces_are_those_of_the_ellipse_of_hertz():
    case = replace(rollers(2e-4, lateral=1e-4, spin=3e-5), truth=friction_solutions.KALKER)
    hertz, constants = contacts.hertz_contact(case.problem), case.problem.pair.constants
    coefficients = creepage_coefficients(hertz.a, hertz.b, constants.nu, degree=12)  # faster
    expected = coefficients.forces(constants.G, 2e-4, 1e-4, 3e-5)
    found = truth_of(case)
    assert (found["F_x"], found["F_y"], found["M_z"]) == pytest.approx(expected, rel=0.01)


def test_carters_strips_are_kalkers_force_of_slender_patches_and_friction_times_load():
    """Where nothing slips C11 tends to pi^2 / (4 (1 - nu)): within 1 % at a/b = 1/66."""
    case = replace(rollers(1e-6, 1000.0, crown=1e5, roller=100.0), truth=friction_solutions.CARTER)
    kalker = truth_of(replace(case, truth=friction_solutions.KALKER))["F_x"]
    assert truth_of(case)["F_x"] == pytest.approx(kalker, rel=0.01)
    slides = replace(rollers(0.5, 0.3, crown=1e5, roller=100.0), truth=friction_solutions.CARTER)
    assert truth_of(slides)["F_x"] == pytest.approx(0.3 * 100.0, rel=0.01)


def test_all_friction_opposes_the_slip_where_all_slides():
    case = replace(rollers(0.3, 0.2, lateral=-0.4), truth=friction_solutions.SLIDING)
    found = truth_of(case)
    assert (found["F_x"], found["F_y"]) == pytest.approx((0.2 * 100 * 0.6, 0.2 * 100 * 0.8))
    assert found["dissipation"] == pytest.approx(0.2 * 100 * 0.5)


def test_the_moment_of_a_circle_that_turns_is_the_integral_of_friction():
    turns = next(case for case in CASES[FRICTION]["spin"] if case.truth.name == "turning circle")
    hertz = contacts.hertz_contact(turns.problem)
    assert hertz.a == pytest.approx(hertz.b)
    moment, _ = quad(lambda r: 2 * np.pi * r**2 * 0.3 * float(hertz.pressure(r, 0.0)), 0, hertz.a)
    found = truth_of(turns)
    assert (found["M_z"], found["dissipation"]) == pytest.approx((-moment, moment), rel=1e-6)


# --- the cheapest contacts -------------------------------------------------------------------------------


def test_a_contact_of_few_elements_is_hertzs_within_its_estimates():
    case = frictionless.against_hertz("8", contacts.crossed(100.0, **FEWEST))
    result = case(ALONE)
    assert result.honest
    assert (result.at, result.exact) == ("8", "Hertz")
    rows = list(run_limits([Limit(CONTACT, "", "", [lambda _: result])], ALONE))
    assert json.dumps(rows)  # no number or truth value of numpy's
    assert 1e-3 < result.error < 0.05
    heavier = replace(case, changes=contacts.crossed(150.0, **FEWEST))  # and its truth the contact of 100 N
    wrong = replace(heavier, truth=contacts.Truth("", lambda _: truth_of(case)))
    assert wrong(ALONE).used > 1


def test_finer_contacts_are_nearer_to_hertz():
    known = frictionless.press(problem_of("flat", contacts.crossed(100.0, **FEWEST)), ALONE)
    exact = contacts.hertz_contact(known.problem).approach
    coarse, fine = (abs(numbers["approach"] / exact - 1) for numbers in (known.numbers, known.finer(2)))
    assert fine < coarse / 2
    assert set(known.scales) == set(OF_FRICTIONLESS)


def test_rolling_of_few_elements_has_kalkers_force():
    case = replace(rollers(1e-4, 1000.0, **FEWEST), truth=friction_solutions.KALKER)
    known = friction_solutions.roll(case.problem, ALONE)
    found, exact = known.numbers, case.truth.numbers(known)
    assert found["F_x"] == pytest.approx(exact["F_x"], rel=0.03)
    assert found["F_x"] == pytest.approx(known.on(known.on_grid.grid)["F_x"], rel=1e-5)
    assert set(known.scales) == set(OF_ROLLING)
    assert contacts.compare("", known, exact, "", 0.0).honest


def test_a_compression_ends_at_its_load_and_needs_no_friction_between_like_bodies():
    changes = friction._pressed_on_circle(0.3, {})
    changes = {**changes, "contact": {**changes["contact"], **FEWEST, "loads": [50.0, 100.0]}}
    known = friction_solutions.compress(problem_of("flat", changes), ALONE)
    without = friction_solutions.without_friction(known)
    assert known.numbers["p_max"] == pytest.approx(without["p_max"], rel=1e-5)
    assert known.numbers["p_max"] == pytest.approx(contacts.hertz_contact(known.problem).p_max, rel=0.05)


def test_loads_of_a_compression_let_its_radius_grow_in_equal_steps():
    loads = friction._growing(64.0)
    assert loads[-1] == 64.0
    assert np.ptp(np.diff(np.cbrt([0.0, *loads]))) < 1e-12


def test_full_stick_of_like_bodies_is_hertz():
    changes = friction._pressed_on_circle(1000.0, {})
    like = contacts.ContactSolution(problem_of("flat", changes), None, {}, {}, {}, None)
    hertz = contacts.hertz_contact(like.problem)
    found = friction_solutions.full_stick(like)
    assert (found["a"], found["approach"]) == pytest.approx((hertz.a, hertz.approach), rel=1e-6)
    unlike = problem_of("flat", friction._pressed_on_circle(1000.0, {"E": 2.1e3, "nu": 0.0}))
    stuck = friction_solutions.full_stick(replace(like, problem=unlike))
    assert stuck["approach"] < 0.99 * contacts.hertz_contact(unlike).approach


@pytest.mark.slow
def test_rolling_from_rest_becomes_steady():
    (case,) = CASES[FRICTION]["rolling from rest"]
    result = case(ALONE)
    assert isinstance(result, WithinLimit)
    assert result.error < 0.05


# --- beyond ----------------------------------------------------------------------------------------------


FIELDS = (
    *("loads", "E =", "nu =", "rolling_radius", "contour", "elements", "rotation_reach", "friction"),
    *("end of a", "longitudinal", "lateral", "spin", "distance"),
)


@pytest.mark.parametrize("part", [CONTACT, FRICTION])
def test_each_case_beyond_that_is_refused_before_any_work_has_a_message_with_its_number(part):
    assert len(REFUSED[part]) > 5
    for name, case in REFUSED[part]:
        if not case.also:
            result = case(ALONE)
            assert any(field in result.says for field in FIELDS), (name, result)
            assert not result.failed, (name, result)


@pytest.mark.slow
def test_contacts_that_leave_their_contours_are_refused_when_they_are_solved_and_no_others():
    """All others are refused before (the test above)."""
    solved_first = [case for part in REFUSED.values() for _, case in part if case.also]
    assert [case.label for case in solved_first] == ["tall, 1e7 N", "-0.01"]
    for case in solved_first:
        result = case(ALONE)
        assert any(field in result.says for field in FIELDS), result
        assert (result.failed, replace(case, also=())(ALONE).failed) == (False, True), case.label


def test_a_failure_beyond_is_a_refusal_only_where_the_case_names_it():
    def failing(*_):
        raise PotentialAreaTooSmall(("s > 0",), Loading(1.0))

    unnamed = contacts.BeyondContact("here", "flat", contacts.crossed(1.0), failing)
    for case, failed in ((unnamed, True), (replace(unnamed, also=(PotentialAreaTooSmall,)), False)):
        result = case(ALONE)
        assert result.failed == failed
        assert result.says.startswith("potential contact area")
    taken = replace(unnamed, solve=lambda *_: None)(ALONE)
    assert (taken.says, taken.failed) == ("", False)


def test_conformal_contacts_keep_their_flanks_and_materials():
    bodies = problem_of(
        "geometry1", contacts.conformal(1.0, 0.02, flanks=[60.0, 45.0], bodies={"upper": {"E": 7.0}})
    ).bodies
    ends = np.degrees(bodies["upper"].contour.inclination(np.array([-50.0, 50.0])))
    assert np.abs(ends) == pytest.approx([60.0, 45.0])
    assert (bodies["upper"].material.E, bodies["lower"].material.E) == (7.0, 210e3)
