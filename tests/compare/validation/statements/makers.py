"""C, and runs of statements with it, made so that one measure of `femic validate` has a given value."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import xarray as xr

from compare.validation.statements.coupling_components import ics_with_factor
from compare.validation.statements.curves import CONCAVE, CONVEX
from compare.validation.statements.random_contacts import GridComparison
from compare.validation.statements.runs import GEOMETRIES
from femic.results.finite_elements import FE, NUMBERS
from geometries.patches import N, S, X
from tests.compare.validation.statements.handmade import (
    Runs,
    by_body,
    by_geometry,
    runs_of,
    with_c,
    without_c,
)

KNOWN_TO_FE = 0.005  # estimate of finite elements
BY_FE, LOAD = 10.0, 50.0  # each of their numbers; load of contacts [N]
NN, SS, XX, XS, XN, SN = (N, N), (S, S), (X, X), (X, S), (X, N), (S, N)


def runs_with(c, **named):
    """Runs with this C, made when they are needed."""
    return lambda: runs_of(c, **named)


def bumps(convex, concave):
    """The same in every component."""
    return lambda of: of.a + of.bump * by_body(convex, concave)(of)


def fitted(factor):
    """C is B-hat-prime times a factor, the same on both bodies."""
    return runs_with(
        lambda of: of.half_by("Bhat_prime") * (factor(of) if callable(factor) else factor), fitted=True
    )


def near_fit(share):
    """C from B-hat-prime to B-hat."""
    return runs_with(
        lambda of: of.half_by("Bhat_prime") * (1 - share) + of.half_by("Bhat") * share, fitted=True
    )


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
        pairs = [(of.by(v), ics_with_factor(results, v, of.body)) for v in ("B", "Bhat")]
        return np.mean([plain + share * (factor - plain) for plain, factor in pairs], axis=0)

    return c


def nu(first, second, **named):
    """C at one Poisson's ratio and at the other."""
    return lambda: replace(runs_of(first, **named), others=runs_of(second, **named).geometries)


def off_half_space(share):
    """A, and a share of A_nn in every component."""
    return lambda of: of.a + (share(of) if callable(share) else share) * of.a[NN]


def turned(convex, concave):
    """Discounted rotations."""
    return runs_with(lambda of: of.a, rotation={CONVEX: convex, CONCAVE: concave})


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


def contacts(**apart):
    """Contacts by C whose numbers are off by so much more than the estimate of finite elements."""
    case = "case", [1.0, 2.0], {"units": "N"}
    numbers = {name: [[BY_FE * (1 + apart.get(name, 0) + KNOWN_TO_FE), BY_FE]] * 2 for name in NUMBERS}
    estimates = {f"estimate_{name}": np.full((2, 2), BY_FE * KNOWN_TO_FE) for name in NUMBERS}
    dataset = xr.Dataset(
        {name: (("case", "ics"), values) for name, values in (numbers | estimates).items()},
        coords={"case": case, "ics": ["C", FE]},
    ).assign(load=("case", [LOAD, LOAD]))
    return lambda: SimpleNamespace(fe_contact=lambda *_, **__: dataset)


def _compared(estimate):
    """A random contact with an error of 1."""
    return GridComparison({"F": 1.0}, {"F": 0.0}, {"F": 0.0}, {"F": estimate}, "mixed")


def wide(times):
    """Random contacts whose estimates are as many times their errors."""
    return lambda: SimpleNamespace(once=lambda *_: [_compared(times)])


def known(held, count=2000):
    """Random contacts of which a share has errors within their estimates."""
    of_size = [_compared(size) for size in (2.0, 0.5)]
    within = round(held * count)
    comparisons = [of_size[0]] * within + [of_size[1]] * (count - within)
    return lambda: SimpleNamespace(once=lambda *_: comparisons)
