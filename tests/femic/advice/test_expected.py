"""Bounds from handmade knowledge: a law of errors, what lies outside, more scenes, decisions."""

import json
from dataclasses import replace

import numpy as np
import pytest
from advice_reliability import (
    LEAST_HELD,
    Trial,
    check_bounds,
    choose_rule,
    coverage_rows,
    worst_trials,
    write,
)
from advice_scenes import random_scene

from femic.advice.expected import Bounds, bounds_at, expect
from femic.advice.knowledge import (
    FEATURES,
    BoundCoverage,
    Knowledge,
    KnownScene,
    Rule,
    contact_features,
    read,
)

NUMBER, ICS = "p_max", "A"
ROLLING = "p_max in rolling"
PLAIN = Rule(nearest=6, widened=0.0, growth=0.0)


def law(features):
    """Errors as those of flat half-spaces: they grow with the squared angle, more where a patch is long."""
    return 1e-5 * features["angle"] ** 2 * features["aspect"] ** 0.3


def known_scenes(count, seed=1, factor=1.0, estimate=0.0):
    random = np.random.default_rng(seed)
    scenes = []
    for number in range(count):
        features = dict.fromkeys(FEATURES, 1.0) | {
            "angle": 10 ** random.uniform(0.7, 2.0),
            "aspect": 2 ** random.uniform(-1, 1),
            "friction": random.uniform(0.1, 0.6),
        }
        errors = {NUMBER: factor * law(features), "F_x/limit": features["friction"]}
        estimates = {NUMBER: estimate, "F_x/limit": 0.0}
        scenes.append(KnownScene(seed, number, features, {ICS: errors}, estimates))
    return scenes


@pytest.fixture(scope="module")
def knowledge():
    return Knowledge(known_scenes(400), PLAIN)


def bounds_among(scenes, rule=PLAIN, features=None):
    """Bounds of the error of p_max by A, by default at the first of known scenes."""
    return bounds_at(Knowledge(scenes, rule), features or scenes[0].features, NUMBER)[ICS]


def test_bounds_enclose_a_law_and_are_close_to_it(knowledge):
    for scene in known_scenes(40, seed=2):
        if knowledge.outside(scene.features, friction=True):
            continue
        bounds = bounds_at(knowledge, scene.features, NUMBER)[ICS]
        error = law(scene.features)
        # six of 400 scenes in two features are within 15 % in angle and aspect, and errors within 40 %
        assert 0.5 * error < bounds.low <= 1.15 * error
        assert 0.85 * error <= bounds.high < 2 * error


def test_errors_taken_to_the_angle_of_the_contact_have_narrower_bounds(knowledge):
    widths = []
    for rule in (PLAIN, replace(PLAIN, growth=2.0)):  # the power of the law
        bounds = [bounds_among(knowledge.scenes, rule, scene.features) for scene in knowledge.scenes[:20]]
        widths.append(np.mean([each.high / each.low - 1 for each in bounds]))
    assert widths[1] < 0.8 * widths[0]


def test_more_neighbours_give_wider_bounds(knowledge):
    features = knowledge.scenes[3].features
    several = [bounds_among(knowledge.scenes, replace(PLAIN, nearest=k), features) for k in (2, 6, 20, 100)]
    lows, highs = [each.low for each in several], [each.high for each in several]
    assert lows == sorted(lows, reverse=True)
    assert highs == sorted(highs)
    assert highs[0] < highs[-1]


def test_bounds_are_those_of_the_size_of_errors_with_a_sign():
    scenes = known_scenes(6)
    for signs, low in (([-1, 1, 1, 1, 1, 1], 0.0), ([-1] * 6, pytest.approx(0.1))):
        signed = [
            replace(scene, errors={ICS: {NUMBER: sign * 0.1 * (number + 1)}})
            for number, (scene, sign) in enumerate(zip(scenes, signs, strict=True))
        ]
        bounds = bounds_among(signed)
        assert (bounds.low, bounds.high) == (low, pytest.approx(0.6))


def test_estimates_of_c_and_the_margin_make_bounds_wider():
    exact, uncertain = (bounds_among(known_scenes(6, estimate=estimate)) for estimate in (0.0, 1e-4))
    assert uncertain.low == pytest.approx(exact.low - 1e-4)
    assert uncertain.high == pytest.approx(exact.high + 1e-4)
    widened = bounds_among(known_scenes(6), replace(PLAIN, widened=0.1))
    assert widened.high - exact.high == pytest.approx(0.1 * (exact.high - exact.low))


def test_friction_counts_only_for_numbers_of_rolling(knowledge):
    features = knowledge.scenes[0].features
    other = features | {"friction": 0.6 if features["friction"] < 0.35 else 0.1}
    assert bounds_at(knowledge, features, NUMBER) == bounds_at(knowledge, other, NUMBER)
    assert bounds_at(knowledge, features, "F_x/limit") != bounds_at(knowledge, other, "F_x/limit")


def test_a_scene_outside_is_named(knowledge):
    inside = knowledge.scenes[0].features
    most = max(scene.features["angle"] for scene in knowledge.scenes)
    for changes, friction, count in (
        ({}, True, 0),
        ({"angle": 1.01 * most}, True, 0),  # nearly inside
        ({"friction": 0.9}, False, 0),
        ({"friction": 0.9}, True, 1),
    ):
        assert len(knowledge.outside(inside | changes, friction=friction)) == count
    (reason,) = knowledge.outside(inside | {"angle": 150.0}, friction=True)
    assert FEATURES["angle"].meaning in reason
    assert "150 deg" in reason


@pytest.fixture(scope="module")
def scene():
    return random_scene(7, 0)


def around(scene, errors=(0.01, 0.02, 0.03, 0.04, 0.05, 0.06)):
    """Scenes about one, with these errors of p_max in rolling, and twice them without friction."""
    features = contact_features(scene.problem, scene.size)
    friction = scene.problem.specification.friction.coefficients[0]
    of_all = []
    for number, error in enumerate(errors):
        spread = 0.9 + 0.2 * number / (len(errors) - 1)
        near = {name: spread * value for name, value in features.items()} | {"friction": friction}
        near["middle"] = features["middle"] + spread - 1
        errors, exact = {NUMBER: 2 * error, ROLLING: error}, {NUMBER: 0.0, ROLLING: 0.0}
        of_all.append(KnownScene(0, number, near, {ICS: errors}, exact))
    return Knowledge(of_all, PLAIN, BoundCoverage(10, {ICS: {ROLLING: [9, 10]}}))


def test_expected_of_a_contact(scene):
    expected = expect(scene.problem, [NUMBER, "area"], around(scene))
    assert expected.bounds == {(ICS, NUMBER): Bounds(0.01, 0.06)}
    assert [expected.high(*of) for of in ((ICS, "area"), ("B", NUMBER))] == [np.inf, np.inf]
    assert "1.0 to 6.0 %" in expected.describe(ICS, NUMBER)
    assert "9 of 10 random scenes" in expected.describe(ICS, NUMBER)


def test_pressures_without_friction_are_those_studied_without(scene):
    specification = replace(scene.problem.specification, motion="none", friction=None)
    still = replace(scene.problem, specification=specification)
    expected = expect(still, [NUMBER], around(scene))
    assert expected.bounds == {(ICS, NUMBER): Bounds(0.02, 0.12)}
    assert "not tested" in expected.describe(ICS, NUMBER)
    assert expect(still, ["F_x"], around(scene)) is None


def test_shares_of_a_force_that_may_vanish_have_no_largest(scene):
    known = around(scene)
    own = [
        replace(each, errors={ICS: {"F_x": each.errors[ICS][ROLLING]}}, estimates={"F_x": 0.0})
        for each in known.scenes
    ]
    expected = expect(scene.problem, ["F_x"], replace(known, scenes=own))
    assert expected.bounds == {(ICS, "F_x"): Bounds(0.01, np.inf)}
    assert "1.0 % or more" in expected.describe(ICS, "F_x")


def test_trials_have_the_bounds_that_are_stated():
    """Of shares without a largest one no decision accepts ICs, however small known errors are."""
    scenes = [replace(each, errors={ICS: {"F_x": 1e-3}}, estimates={"F_x": 0.0}) for each in known_scenes(40)]
    _, tried = check_bounds(Knowledge(scenes[:30], PLAIN), scenes[30:])
    assert tried
    assert all(trial.bounds.high == np.inf for trial in tried)
    assert {trial.outcome(0.05) for trial in tried} == {"undecided"}
    json.dumps([coverage_rows(tried), worst_trials(tried)], allow_nan=False)


def test_of_fewer_creepages_than_studied_the_error_may_be_smaller(scene):
    known, specification = around(scene), scene.problem.specification
    friction = replace(specification.friction, longitudinal=(0.5, 0.6))  # all of it slides
    sliding = replace(scene.problem, specification=replace(specification, friction=friction))
    expected = expect(sliding, [NUMBER], known)
    assert expected.bounds == {(ICS, NUMBER): Bounds(0.0, 0.06)}


@pytest.fixture
def why_not(caplog):
    """Why nothing is expected of a contact, as it is logged; nothing where something is."""
    caplog.set_level("INFO", "femic.advice")

    def logged(problem, knowledge):
        caplog.clear()
        expected = expect(problem, [NUMBER], knowledge)
        said = [record.message.partition("the solved scenes: ")[2] for record in caplog.records]
        assert (expected is None) == bool(said)
        return said

    return logged


def test_nothing_is_expected_outside(scene, why_not, monkeypatch):
    """Angle and aspect of several patches together are not those of a patch."""
    knowledge, problem, given = around(scene), scene.problem, scene.problem.specification
    (reason,) = why_not(
        replace(problem, specification=replace(given, loads=(given.loads[0] / 20,))), knowledge
    )
    assert FEATURES["angle"].meaning in reason
    friction = replace(given.friction, spin=1e-4)
    for other, reasons in (
        (replace(problem, specification=replace(given, friction=friction)), ["lateral creepage or spin"]),
        (replace(problem, discount="source"), ["discount = source"]),
        (replace(problem, specification=replace(given, gap="exact")), ["gap = exact"]),
        (problem, []),
    ):
        assert why_not(other, knowledge) == reasons
    both = replace(scene.size, smallest=(1.0, 1.0))
    monkeypatch.setattr("femic.advice.expected.contact_size", lambda *_: both)
    assert why_not(problem, knowledge) == ["several patches"]


@pytest.mark.parametrize(
    ("bounds", "error", "outcome"),
    [
        (Bounds(0.01, 0.03), 0.02, "right"),
        (Bounds(0.01, 0.03), 0.08, "wrong"),
        (Bounds(0.06, 0.09), 0.08, "right"),
        (Bounds(0.06, 0.09), 0.02, "wrong"),
        (Bounds(0.01, 0.09), 0.02, "undecided"),
        (Bounds(0.01, 0.03), 0.052, "open"),
        (Bounds(0.01, 0.05), 0.04, "right"),
    ],
)
def test_decisions(bounds, error, outcome):
    scene = replace(known_scenes(1)[0], errors={ICS: {NUMBER: -error}}, estimates={NUMBER: 0.003})
    assert Trial(scene, ICS, NUMBER, bounds).outcome(0.05) == outcome


def test_errors_beyond_their_bounds_are_counted(knowledge):
    rule = replace(PLAIN, growth=2.0, widened=0.25)
    inside, _ = check_bounds(replace(knowledge, rule=rule), known_scenes(40, seed=3))
    held, of = inside.held.count(ICS, NUMBER)
    assert 0.9 * of <= held <= of
    assert of > 30
    twice, tried = check_bounds(replace(knowledge, rule=rule), known_scenes(40, seed=3, factor=2.0))
    assert twice.held.count(ICS, NUMBER)[0] < 0.1 * of
    (row,) = (row for row in coverage_rows(tried) if row["number"] == NUMBER)
    assert row["scenes"] == of
    assert all(
        sum(one[end] for end in ("right", "wrong", "undecided", "open")) == of for one in row["decisions"]
    )


def test_the_chosen_rule_holds_in_known_scenes_left_out():
    scenes = known_scenes(40, seed=4)
    rule = choose_rule(scenes)
    knowledge = Knowledge(scenes, rule)
    held = [
        bounds.low <= abs(scene.errors[ICS][number]) <= bounds.high
        for index, scene in enumerate(scenes)
        for number in (NUMBER, "F_x/limit")
        for bounds in [bounds_at(knowledge, scene.features, number, index)[ICS]]
    ]
    assert np.mean(held) >= LEAST_HELD


def test_knowledge_is_read_as_it_was_written(tmp_path, knowledge):
    small = replace(
        knowledge, scenes=knowledge.scenes[:3], held=BoundCoverage(4, {ICS: {NUMBER: [3, 4]}}), code="c"
    )
    write(small, {"versions": {}}, tmp_path / "knowledge.json")
    again = read(tmp_path / "knowledge.json")
    assert (again.rule, again.code, again.held.count(ICS, NUMBER)) == (small.rule, "c", (3, 4))
    for one, other in zip(again.scenes, small.scenes, strict=True):
        assert one.errors[ICS][NUMBER] == pytest.approx(other.errors[ICS][NUMBER], rel=1e-3)
        assert one.features == pytest.approx(other.features, rel=1e-3)
