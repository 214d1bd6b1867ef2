"""The numbers of `femic validate` are those that C was made for, and decide at their thresholds.

C is made so that a criterion has a value v in every case; 1 % below and above the threshold (of 1, if that
is 0) the value is values, and it is met on one side only.
"""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from compare.validation.statements.changes import CHANGES
from compare.validation.statements.curves import ACROSS, BESIDE, CONVEX, THROUGH
from compare.validation.statements.finite_elements import ELEMENTS
from compare.validation.statements.finite_elements import NUMBERS as ELEMENT_NUMBERS
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.random_contacts import STUDIES
from compare.validation.statements.runs import GEOMETRIES
from femic.results.finite_elements import OF_PATCH
from tests.compare.validation.statements import friction_makers, normal_makers
from tests.compare.validation.statements import makers as make
from tests.compare.validation.statements.handmade import (
    SOFT,
    STIFF,
    between,
    by_body,
    by_geometry,
    times,
    without_c,
)
from tests.compare.validation.statements.makers import BY_FE, LOAD, NN, SN, SS, XN, XS, XX, runs_with
from tests.compare.validation.statements.mutations import CRITERIA


def missed_by(variant, component):
    """|variant / C - 1| is v."""
    return lambda v: runs_with(times(variant, component, 1 / (1 + v)))


def growing(v):
    """A misses 0.1 of C_nn up to half way to s = 10 mm and v more beyond."""
    return runs_with(times("A", NN, lambda of: 1 / (1.1 + v * (np.abs(of.points.s) > 7.5))))


def nearer_to(first, second):
    """C between two variants: the first is v times as far away as the second."""
    return lambda v: runs_with(between(first, second, v / (1 + v)))


def from_a_prismatic(variant):
    """The same for A and a variant without curvature along x."""
    return lambda v: runs_with(lambda of: of.a + v / (1 + v) * (of.prismatic(variant) - of.a))


def apart_on_lines(component, across):
    """|C - A| is `across` on the line along s, 1 on those along x, in some unit."""

    def c(of):
        out = of.a.copy()
        out[component] += np.where(of.on(ACROSS), across, 1) * 1e-7
        return out

    return runs_with(c)


def mean_over_a(v):
    """(C - A) sgn A / max |A| of sn is v on average on the line along s, s > 0."""

    def c(of):
        out, part = of.a.copy(), of.results.lines[ACROSS]
        a, s = of.a[SN][part], of.points.s[part]
        out[SN] *= 1 + v * np.max(np.abs(a[s > 0])) / np.mean(np.abs(a[s > 0]))
        return out

    return runs_with(c)


def off_at_one_point(v):
    """C_sn is B_sn but for a point within the arc, v of the largest C_sn away."""

    def c(of):
        out = of.half_by("B").copy()
        at = of.results.lines[ACROSS].start + 220  # s = 2.5 mm
        out[SN][at] -= v * np.max(np.abs(out[SN])) * np.sign(out[SN][at])
        return out

    return runs_with(c)


def explained(v):
    """C_sn is B-hat, a vertical translation and something even; the translation is v of the sum's square."""

    def c(of):
        out, part = of.by("Bhat").copy(), of.results.lines[ACROSS]
        lean = np.sin(of.results.scene.bodies[CONVEX].contour.inclination(of.points.s))
        even = np.cos(of.points.s)
        ratio = np.linalg.norm(lean[part]) / np.linalg.norm(even[part])
        out[SN] += 1e-6 * (lean + np.sqrt(1 / v - 1) * ratio * even)
        return out

    return runs_with(c)


def cosine(v):
    """C_ss - A_ss of both bodies: an even one, and a mix of it and an odd one, on every line."""

    def c(of):
        out, t = of.a.copy(), np.where(of.on(ACROSS), of.points.s, of.points.x)
        out[SS] += 1e-8 * (np.abs(t) if of.body == CONVEX else v * np.abs(t) + np.sqrt(1 - v**2) * t)
        return out

    return runs_with(c)


def near_and_far(v):
    """|C - A| / A_nn is v up to 2.5 mm from the load, 1 beyond."""
    return runs_with(
        make.off_half_space(lambda of: np.where(np.hypot(of.points.x, of.points.s) <= 2.5, v, 1))
    )


def fit_missed_along_x(v):
    """B-hat-prime / C - 1 is v; on the line along s C is half of that, so that it is no scale."""
    return make.fitted(lambda of: np.where(of.on(ACROSS), 0.5, 1) / (1 + v))


def too_large(first, second):
    """B-hat-prime is too large by shares of the largest C_xn, on average within 3 mm on the lines along x."""

    def size(of):
        fit, x = np.abs(of.half_by("Bhat_prime")[XN]), np.abs(of.points.x)
        along_x = ~of.on(ACROSS)
        near = along_x & (x > of.results.scene.patch.a) & (x <= 3.0)
        return 1 / (1 + by_geometry(first, second)(of) * np.max(fit[along_x]) / np.mean(fit[near]))

    return make.fitted(size)


def with_variants(runs, size):
    """Runs whose approximations are A times sizes by variant, where they are numbers."""

    def changed(results):
        sized = {
            key: size(key[0]) * results.approximations["A", key[1]] + 0 * ic
            for key, ic in results.approximations.items()
        }
        return replace(results, approximations=sized)

    geometries, others = (
        {name: changed(one) for name, one in some.items()} for some in (runs.geometries, runs.others)
    )
    return replace(runs, geometries=geometries, others=others)


def both_missed(v):
    """B is A and misses v of C_xs, B-hat is twice A and misses more."""
    runs = runs_with(times("A", XS, 1 / (1 + v)))
    return lambda: with_variants(runs(), lambda variant: 2 if variant == "Bhat" else 1)


def errors_change(v):
    """All variants alike, their error 0.3 and 0.3 + v; of unlike bodies, whose A_xn does not vanish."""
    runs = make.nu(times("A", None, 1 / 1.3), times("A", None, 1 / (1.3 + v)), upper_E=SOFT)
    return lambda: with_variants(runs(), lambda _: 1)


def regretted(v):
    """A is best at its own ratio; at the other its error is (1 - u) / 2, that of the others, 2 A, is u."""
    u = (1 - 2 * v) / 3
    runs = make.nu(times("A", None, 1), times("A", None, 2 / (1 + u)), upper_E=SOFT)
    return lambda: with_variants(runs(), lambda variant: 1 if variant == "A" else 2)


def mixed(v):
    """C is A; all variants are a tenth larger, the mix v tenths."""
    runs = runs_with(times("A", None, 1), fitted=True)
    return lambda: with_variants(runs(), lambda variant: 1 + 0.1 * (v if variant == "mix" else 1))


class OnElements:
    """Contacts on three grids: a number by C that changes by the same share from grid to grid."""

    def __init__(self, name, share):
        self.name, self.share = name, share

    def contact(self, _, changes):
        steps = np.log2(ELEMENTS[-1] / changes["elements"])
        zeros = dict.fromkeys((f"estimate_{name}" for name in ELEMENT_NUMBERS), 0.0)
        numbers = dict.fromkeys(ELEMENT_NUMBERS, 1.0) | zeros
        numbers[self.name] = (1 + self.share) ** steps
        return xr.Dataset(
            {n: (("case", "ics"), [[v, v]], {"units": "1"}) for n, v in numbers.items()}
        ).assign_coords(ics=["Bhat", "C"])


def on_grids(name):
    return lambda v: lambda: OnElements(name, v)


EXACT = {  # the threshold, and C for a value
    (1, "A departs"): (0.10, missed_by("A", NN)),
    (1, "with distance"): (0.0, growing),
    (1, "geometry"): (0.0, lambda v: runs_with(times("A", NN, by_geometry(1 / 1.1, 1 / (1.1 + v))))),
    (1, "B follows"): (0.10, missed_by("B", NN)),
    (1, "B better"): (1.0, nearer_to("B", "A")),
    (1, "A along x"): (0.10, missed_by("A", NN)),
    (1, "B along x"): (0.10, missed_by("B", NN)),
    (2, "A"): (0.10, missed_by("A", XX)),
    (2, "alike"): (0.10, lambda v: runs_with(times("A", XX, by_geometry(1, 1 / (1 - v))))),
    (3, "faster"): (0.0, lambda v: runs_with(times("B", SS, 1 - v))),
    (3, "other way"): (0.0, lambda v: runs_with(times("B", SS, 1 - v))),
    (3, "geometry"): (0.0, lambda v: runs_with(times("B", SS, by_geometry(0.8, 0.8 - v)))),
    (3, "convex geometry"): (0.0, lambda v: runs_with(times("B", SS, by_geometry(0.8, 0.8 - v)))),
    (3, "convex"): (0.0, lambda v: runs_with(times("B", SS, by_body(0.7 - v, 1.3)))),
    (4, "convex"): (1.0, lambda v: runs_with(times("A", XS, by_body(1 + v / 10, 0.9)))),
    (4, "along s"): (1.0, lambda v: apart_on_lines(XS, v)),
    (4, "better"): (1.0, nearer_to("B", "Bhat")),
    (4, "left"): (0.05, both_missed),
    (5, "cancel"): (0.50, lambda v: runs_with(make.bumps(1, -(1 - v) / (1 + v)))),
    (5, "add"): (0.75, lambda v: runs_with(make.bumps(1, -(1 - v) / (1 + v)))),
    (6, "poor"): (0.20, lambda v: runs_with(lambda of: of.prismatic("B") / (1 + v))),
    (6, "in C"): (1.0, lambda v: runs_with(times("A", XN, by_body(v, 1)))),
    (7, "close"): (0.10, fit_missed_along_x),
    (7, "too large"): (0.0, lambda v: too_large(v, v)),
    (7, "geometry"): (0.0, lambda v: too_large(0.1 + v, 0.1)),
    (8, "larger"): (1.0, lambda v: runs_with(make.everywhere(by_geometry(1, v)))),
    (8, "curvature"): (1 / 3, lambda v: make.wheel(3 - 2 * v)),
    (9, "convex"): (-0.20, mean_over_a),
    (9, "concave"): (0.0, mean_over_a),
    (9, "B"): (1.0, nearer_to("B", "Bhat")),
    (9, "B̂′"): (1.0, lambda v: make.near_fit(v / (1 + v))),
    (9, "arc"): (0.10, off_at_one_point),
    (9, "translation"): (0.50, explained),
    (11, "change"): (0.05, errors_change),
    (11, "order"): (0.05, regretted),
    (12, "worst"): (1.0, mixed),
    (12, "mean"): (1.0, mixed),
    (13, "B"): (1.0, from_a_prismatic("B")),
    (13, "B̂"): (1.0, from_a_prismatic("Bhat")),
    (14, "apart"): (1.0, make.engines),
    (15, "plane"): (1.0, lambda v: make.plane(make.estimates_away(v), estimate=0.01)),
    (15, "nearly plane"): (0.01, lambda v: make.plane(times("A", None, 1 + v))),
    (16, "along s"): (1.0, lambda v: apart_on_lines(NN, v)),
    (16, "concave"): (1.0, lambda v: apart_on_lines(NN, v)),
    (17, "xx"): (0.10, missed_by("A", XX)),
    (17, "ss"): (-0.50, cosine),
    (17, "B_ss"): (0.10, missed_by("B", SS)),
    (18, "at the load"): (0.05, lambda v: runs_with(make.off_half_space(v))),
    (18, "converge"): (0.50, near_and_far),
    (19, "convex"): (0.50, lambda v: make.turned(v, v - 1)),
    (20, "B̂"): (1.0, nearer_to("Bhat", "B")),
    (21, "size"): (0.20, lambda v: make.term(1 + v)),
    (22, "patch"): (0.02, lambda v: make.contacts(**dict.fromkeys(OF_PATCH, v))),
    (22, "approach"): (0.02, lambda v: make.contacts(approach=v)),
    (23, "pressure"): (0.02, lambda v: make.contacts(p_max=v)),
    (23, "force"): (0.02, lambda v: make.contacts(F_y=v * LOAD / BY_FE)),
    (23, "centre"): (0.2, lambda v: make.contacts(s_centre=v / BY_FE)),
    (23, "approach"): (0.02, lambda v: make.contacts(approach=v)),
    **{(24, name): (0.002, on_grids(name)) for name in ELEMENT_NUMBERS},
    **{(25, f"held {study}"): (0.95, make.known) for study in STUDIES},
    **{(25, f"width {study}"): (10.0, make.wide) for study in STUDIES},
    **normal_makers.EXACT,
    **friction_makers.MADE,
}


@pytest.mark.parametrize(("number", "name"), EXACT)
def test_a_number_has_the_value_that_c_was_made_for_and_decides_at_its_threshold(number, name):
    criterion = CRITERIA[number, name]
    threshold, made = EXACT[number, name]
    for side in (-1, 1):
        value = threshold + side * 0.01 * (abs(threshold) or 1)
        with friction_makers.without_estimates():  # test_estimated has them
            values = criterion.measure(made(value)())
        assert values
        assert list(values.values()) == pytest.approx([value] * len(values), rel=1e-6)
        is_met = side == (-1 if criterion.relation == "<" else 1)
        assert {criterion.met(value) for value in values.values()} == {is_met}


# --- criteria without such a value, and what statements ask for -----------------------------------------

ELSEWHERE = {  # no C in them
    *((15, name) for name in ("point loads", "cylinder")),  # test_program
    *(key for key in CRITERIA if key[0] in (44, 46, 47, 48)),  # test_closed_forms, test_wheels
}
SOME = {(15, "variants")}  # missed in some case only: variants are alike in others
A, B = times("A", None, 1), times("B", None, 1)
SIDES = {  # (met in every case, missed)
    (6, "in B"): (runs_with(A, upper_E=SOFT), runs_with(A, upper_E=STIFF)),
    (6, "in B̂"): (runs_with(A, upper_E=SOFT), runs_with(A, upper_E=STIFF)),
    (9, "flank"): (runs_with(make.misfit_at(1.2)), runs_with(make.misfit_at(0.8))),
    (10, "gain"): (runs_with(make.beyond_factor(-4)), runs_with(make.beyond_factor(4))),
    (15, "variants"): (make.plane(A), make.plane(A, b=1 + 1e-9)),
}


def test_every_criterion_is_tested_on_both_sides():
    assert {*EXACT, *SIDES} | ELSEWHERE == {*CRITERIA}


@pytest.mark.parametrize(("number", "name"), SIDES)
def test_a_criterion_is_met_and_missed(number, name):
    criterion = CRITERIA[number, name]
    met, missed = (criterion.measure(runs()) for runs in SIDES[number, name])
    assert met
    assert met.keys() == missed.keys()
    assert all(criterion.met(value) for value in met.values()), met
    wrong = [not criterion.met(value) for value in missed.values()]
    assert any(wrong) if (number, name) in SOME else all(wrong), missed


def test_every_change_belongs_to_a_statement():
    assert {change["number"] for change in CHANGES} <= set(STATEMENTS)


def test_lines_of_the_geometries_have_the_names_that_measures_use():
    for name in GEOMETRIES:
        assert {line.name for line in without_c(name).scene.lines} == {ACROSS, BESIDE, THROUGH}
