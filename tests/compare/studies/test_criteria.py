"""Every criterion of `femic validate` is met by one hand-made C and missed by another, in every case."""

from dataclasses import replace

import numpy as np
import pytest

from compare.studies.validation.changes import CHANGES
from compare.studies.validation.curves import ACROSS, BESIDE, CONCAVE, CONVEX, THROUGH
from compare.studies.validation.program import cylinder_errors
from compare.studies.validation.runs import GEOMETRIES
from compare.studies.validation.sn import with_factor
from compare.studies.validation.statements import STATEMENTS
from geometries.patches import N, S, X
from tests.compare.studies.handmade import (
    SOFT,
    STIFF,
    Runs,
    between,
    by_body,
    by_geometry,
    runs_of,
    times,
    with_c,
    without_c,
)

NN, SS, XX, XS, XN, SN = (N, N), (S, S), (X, X), (X, S), (X, N), (S, N)
ELSEWHERE = {(15, "point loads"), (15, "cylinder")}  # no C in them: tests/compare/studies/test_measures.py
SOME = {(11, "order"), (15, "variants")}  # missed in some case only: variants are alike in others


def of(c, **named):
    """Runs with this C, made when they are needed."""
    return lambda: runs_of(c, **named)


def less_with_s(near, far):
    """A factor that goes from `near` at s = 0 to `far` at 10 mm."""
    return lambda of: near + (far - near) * np.minimum(np.abs(of.points.s) / 10, 1)


def on_lines(across, along):
    """A factor on the line along s, another on those along x."""
    return lambda of: np.where(of.on(ACROSS), across, along)


def bumped(component, convex, concave):
    """A and a bump of a size for each body."""

    def c(of):
        out = of.a.copy()
        out[component] += of.bump * by_body(convex, concave)(of)
        return out

    return c


def bumps(convex, concave):
    """The same in every component."""
    return lambda of: of.a + of.bump * by_body(convex, concave)(of)


def fitted(factor):
    """C is B-hat-prime times a factor, the same on both bodies."""
    return of(lambda of: of.half_by("Bhat_prime") * (factor(of) if callable(factor) else factor), fitted=True)


def near_fit(share):
    """C from B-hat-prime to B-hat."""
    return of(lambda of: of.half_by("Bhat_prime") * (1 - share) + of.half_by("Bhat") * share, fitted=True)


def everywhere(size):
    """The same in every component and at every point."""
    return lambda of: np.full_like(of.a, 1e-6) * size(of)


def wheel(size):
    """C_xn 1 on Geometry 1, 3 on Geometry 2, `size` where its wheel is not revolved."""

    def runs():
        not_revolved = with_c(without_c("geometry2"), everywhere(lambda _: size))
        return replace(runs_of(everywhere(by_geometry(1, 3))), prismatic=not_revolved)

    return runs


def term(share):
    """Curvature along x changes C_xn by the term of eq. (16) over a share."""

    def revolved(of):
        out = of.a.copy()
        if of.body == CONCAVE:
            out[XN] += np.sin(of.points.x / 500) * (of.a[XX] + of.a[NN]) / 2 / share
        return out

    def runs():
        return replace(runs_of(revolved), prismatic=with_c(without_c("geometry2"), lambda of: of.a))

    return runs


def lifted(of):
    """B-hat, and both bodies moved along z."""
    out = of.by("Bhat").copy()
    out[SN] -= 1e-6 * np.sin(of.results.scene.bodies[CONVEX].contour.inclination(of.points.s))
    return out


def misfit_at(joints):
    """B-hat, and a bump of sn so many joints away, on both sides."""

    def c(of):
        out, joint = of.by("Bhat").copy(), of.results.scene.bodies["lower"].contour.joints[-1]
        out[SN] += 1e-6 * np.exp(-20 * (np.abs(of.points.s) - joints * joint) ** 2)
        return out

    return c


def beyond_factor(share):
    """From B and B-hat to what they are with the factor, and beyond."""

    def c(of):
        results = with_c(of.results, lambda of: of.a)
        pairs = [(of.by(v), with_factor(results, v, of.body)) for v in ("B", "Bhat")]
        return np.mean([plain + share * (factor - plain) for plain, factor in pairs], axis=0)

    return c


def nu(first, second):
    """C at one Poisson's ratio and at the other."""
    return lambda: replace(runs_of(first), others=runs_of(second).geometries)


def off_half_space(share):
    """A, and a share of A_nn in every component."""
    return lambda of: of.a + (share(of) if callable(share) else share) * of.a[NN]


def growing(of):
    """A tenth at 10 mm from the load, less before."""
    return 0.1 * np.minimum(np.hypot(of.points.x, of.points.s) / 10, 1)


def turned(convex, concave):
    """Discounted rotations."""
    return of(lambda of: of.a, rotation={CONVEX: convex, CONCAVE: concave})


def engines(apart):
    """The solid engine so many sums of both estimates away."""

    def runs():
        c = {name: with_c(without_c(name), lambda of: of.a, estimate=0.01) for name in GEOMETRIES}

        def check(results):
            off = {
                body: replace(one, c=replace(one.c, ic=one.c.ic + 2 * apart * one.c.estimate))
                for body, one in results.references.items()
            }
            return replace(results, checks=off)

        return Runs({name: check(results) for name, results in c.items()})

    return runs


def plane(c, *, estimate=0.0, b=1.0):
    """The plane with a C, and its B times a number."""

    def runs():
        made = with_c(without_c("flat"), c, estimate=estimate)
        changed = {key: ic * (b if key[0] == "B" else 1) for key, ic in made.approximations.items()}
        return Runs({}, flat=replace(made, approximations=changed))

    return runs


def estimates_away(number):
    """A, and so many estimates (of 0.01 of the largest A_nn)."""
    return lambda of: of.a + number * 0.01 * np.max(of.a[NN])


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
