"""Every criterion of `femic validate` is met by one hand-made C and missed by another, in every case."""

import pytest

from compare.studies.validation.changes import CHANGES
from compare.studies.validation.curves import ACROSS, BESIDE, THROUGH
from compare.studies.validation.program import cylinder_errors
from compare.studies.validation.runs import GEOMETRIES
from compare.studies.validation.statements import STATEMENTS
from tests.compare.studies.handmade import (
    SOFT,
    STIFF,
    between,
    by_body,
    by_geometry,
    runs_of,
    times,
    without_c,
)
from tests.compare.studies.makers import (
    NN,
    SN,
    SS,
    XN,
    XS,
    XX,
    beyond_factor,
    bumped,
    bumps,
    engines,
    estimates_away,
    everywhere,
    fitted,
    growing,
    less_with_s,
    lifted,
    misfit_at,
    near_fit,
    nu,
    of,
    off_half_space,
    on_lines,
    plane,
    term,
    turned,
    wheel,
)

ELSEWHERE = {(15, "point loads"), (15, "cylinder")}  # no C in them: tests/compare/studies/test_program.py
SOME = {(11, "order"), (15, "variants")}  # missed in some case only: variants are alike in others


A, B = times("A", None, 1), times("B", None, 1)
SIDES = {  # (met in every case, missed)
    (1, "A departs"): (of(times("A", NN, 0.5)), of(times("A", NN, 0.95))),
    (1, "with distance"): (of(times("A", NN, less_with_s(1, 0.5))), of(times("A", NN, less_with_s(0.5, 1)))),
    (1, "geometry"): (of(times("A", NN, by_geometry(0.9, 0.5))), of(times("A", NN, by_geometry(0.5, 0.9)))),
    (1, "B follows"): (of(times("B", NN, 0.95)), of(times("B", NN, 0.85))),
    (1, "B better"): (of(between("A", "B", 0.6)), of(between("A", "B", 0.4))),
    (1, "A along x"): (of(times("A", NN, 0.95)), of(times("A", NN, 0.85))),
    (1, "B along x"): (of(times("B", NN, 0.95)), of(times("B", NN, 0.85))),
    (2, "A"): (of(times("A", XX, 0.95)), of(times("A", XX, 0.85))),
    (2, "alike"): (of(times("A", XX, 0.7)), of(times("A", XX, by_geometry(1, 0.7)))),
    (3, "faster"): (of(times("B", SS, 0.9)), of(times("B", SS, 1.1))),
    (3, "other way"): (of(times("B", SS, 1.1)), of(times("B", SS, 0.9))),
    (3, "geometry"): (of(times("B", SS, by_geometry(0.9, 0.5))), of(times("B", SS, by_geometry(0.5, 0.9)))),
    (3, "convex geometry"): (
        of(times("B", SS, by_geometry(0.9, 0.5))),
        of(times("B", SS, by_geometry(0.5, 0.9))),
    ),
    (3, "convex"): (of(times("B", SS, by_body(0.5, 1.4))), of(times("B", SS, by_body(0.6, 1.5)))),
    (4, "convex"): (of(times("A", XS, by_body(1.5, 1.4))), of(times("A", XS, by_body(1.4, 1.5)))),
    (4, "along s"): (of(times("A", XS, on_lines(1.5, 1.1))), of(times("A", XS, on_lines(1.1, 1.5)))),
    (4, "better"): (of(between("Bhat", "B", 0.6)), of(between("Bhat", "B", 0.4))),
    (4, "left"): (of(times("A", XS, 3)), of(B)),
    (5, "cancel"): (of(bumps(1, -0.5)), of(bumps(1, -0.2))),
    (5, "add"): (of(bumps(1, -0.1)), of(bumps(1, -0.2))),
    (6, "poor"): (of(lambda of: of.prismatic("B") / 1.3), of(lambda of: of.prismatic("B") / 1.1)),
    (6, "in B"): (of(A, upper_E=SOFT), of(A, upper_E=STIFF)),
    (6, "in B̂"): (of(A, upper_E=SOFT), of(A, upper_E=STIFF)),
    (6, "in C"): (of(times("A", XN, by_body(1.1, 1))), of(times("A", XN, by_body(1, 1.1)))),
    (7, "close"): (fitted(0.95), fitted(0.85)),
    (7, "too large"): (fitted(0.9), fitted(1.1)),
    (7, "geometry"): (fitted(by_geometry(0.8, 0.9)), fitted(by_geometry(0.9, 0.8))),
    (8, "larger"): (of(everywhere(by_geometry(1, 1.1))), of(everywhere(by_geometry(1.1, 1)))),
    (8, "curvature"): (wheel(2.5), wheel(2.0)),
    (9, "convex"): (of(times("A", SN, by_body(-2, 1))), of(times("A", SN, by_body(1, -2)))),
    (9, "concave"): (of(times("A", SN, by_body(0.5, 1.1))), of(times("A", SN, by_body(1.1, 0.9)))),
    (9, "B"): (of(between("Bhat", "B", 0.6)), of(between("Bhat", "B", 0.4))),
    (9, "B̂′"): (near_fit(0.6), near_fit(0.4)),
    (9, "arc"): (of(times("B", SN, 0.95)), of(times("B", SN, 0.5))),
    (9, "translation"): (of(lifted), of(misfit_at(0.5))),
    (9, "flank"): (of(misfit_at(1.2)), of(misfit_at(0.8))),
    (10, "gain"): (of(beyond_factor(-4)), of(beyond_factor(4))),
    (11, "change"): (nu(times("B", None, 0.9), times("B", None, 0.905)), nu(B, times("B", None, 0.9))),
    (11, "order"): (nu(B, times("B", None, 0.98)), nu(B, A)),
    (12, "worst"): (of(times("mix", NN, 0.99)), of(times("Bhat", None, 0.99))),
    (12, "mean"): (of(times("mix", NN, 0.99)), of(times("Bhat", None, 0.99))),
    (13, "B"): (
        of(lambda of: 0.6 * of.a + 0.4 * of.prismatic("B")),
        of(lambda of: 0.4 * of.a + 0.6 * of.prismatic("B")),
    ),
    (13, "B̂"): (
        of(lambda of: 0.6 * of.a + 0.4 * of.prismatic("Bhat")),
        of(lambda of: 0.4 * of.a + 0.6 * of.prismatic("Bhat")),
    ),
    (14, "apart"): (engines(0.9), engines(1.1)),
    (15, "variants"): (plane(A), plane(A, b=1 + 1e-9)),
    (15, "plane"): (plane(estimates_away(0.9), estimate=0.01), plane(estimates_away(1.1), estimate=0.01)),
    (15, "nearly plane"): (plane(times("A", None, 1.009)), plane(times("A", None, 1.011))),
    (16, "along s"): (of(times("A", NN, on_lines(3, 1.1))), of(times("A", NN, on_lines(2, 1.1)))),
    (16, "concave"): (of(times("A", NN, on_lines(2, 1.1))), of(times("A", NN, on_lines(3, 1.1)))),
    (17, "xx"): (of(times("A", XX, 0.95)), of(times("A", XX, 0.85))),
    (17, "ss"): (of(bumped(SS, 1, -0.1)), of(bumped(SS, 1, 0.1))),
    (17, "B_ss"): (of(times("B", SS, 0.95)), of(times("B", SS, 0.85))),
    (18, "at the load"): (of(off_half_space(0.04)), of(off_half_space(0.06))),
    (18, "converge"): (of(off_half_space(growing)), of(off_half_space(0.1))),
    (19, "convex"): (turned(1.1, -1), turned(1, -1.1)),
    (20, "B̂"): (of(between("B", "Bhat", 0.6)), of(between("B", "Bhat", 0.4))),
    (21, "size"): (term(1.1), term(1.3)),
}


def test_every_criterion_has_both_sides():
    asked = {(number, c.name) for number, statement in STATEMENTS.items() for c in statement.criteria}
    assert set(SIDES) | ELSEWHERE == asked


@pytest.mark.parametrize(("number", "name"), SIDES)
def test_a_criterion_is_met_and_missed(number, name):
    criterion = next(c for c in STATEMENTS[number].criteria if c.name == name)
    met, missed = (criterion.measure(runs()) for runs in SIDES[number, name])
    assert met
    assert met.keys() == missed.keys()
    assert all(criterion.met(value) for value in met.values()), met
    wrong = [not criterion.met(value) for value in missed.values()]
    assert any(wrong) if (number, name) in SOME else all(wrong), missed


def test_every_change_is_of_a_statement_that_there_is():
    assert {change.number for change in CHANGES} <= set(STATEMENTS)
    assert [change.number for change in CHANGES] == sorted(change.number for change in CHANGES)


def test_lines_have_the_names_that_measures_ask_for():
    for name in GEOMETRIES:
        assert {line.name for line in without_c(name).scene.lines} == {ACROSS, BESIDE, THROUGH}


def test_cylinders_are_met():
    criterion = next(c for c in STATEMENTS[15].criteria if c.name == "cylinder")
    assert all(criterion.met(value) for value in cylinder_errors(runs_of(A)).values())
