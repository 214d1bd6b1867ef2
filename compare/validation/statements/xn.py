"""Statements 6, 7 and 13: the longitudinal displacement under a normal load, and its approximations."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import product

import numpy as np

from compare.report.charts import Panel
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import (
    FOLLOWS,
    POOR,
    Numbers,
    Statement,
    per_body,
    per_geometry,
    second_minus_first,
    side_by_side,
)
from compare.validation.statements.curves import (
    ACROSS,
    ALONE,
    BESIDE,
    BODIES,
    THROUGH,
    Curve,
    not_revolved,
    rms,
)
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results

XN = ("combined", "xn")
NEAR_LOAD = 0.3  # reference lengths: largest |x| that is near the load


# --- 6 --------------------------------------------------------------------------------------------------


def concave_over_convex(variant: str) -> Callable[[Results], float]:
    """Measure the rms of xn of a variant without curvature along x on s = 1.6 mm, concave over convex."""

    def ratio(results: Results) -> float:
        convex, concave = (
            rms(_beside(results, body).values(not_revolved(results, variant, body))) for body in ALONE
        )
        return concave / convex

    return ratio


def convex_over_concave_c(results: Results) -> float:
    """Return the rms of C_xn on s = 1.6 mm: convex body over concave body."""
    convex, concave = (rms(_beside(results, body).variant("C")) for body in ALONE)
    return convex / concave


def _beside(results: Results, body: str) -> Curve:
    return Curve(results, body, "xn", BESIDE)


# --- 7 --------------------------------------------------------------------------------------------------


def excess(results: Results) -> float:
    """Return the mean of (B-hat-prime - C) sgn C / max |C| of xn near the load on the lines along x."""
    curve = Curve(results, *XN, "x")
    c, fit = curve.variant("C"), curve.variant("Bhat_prime")
    x = np.abs(np.concatenate([line.x for line in curve.lines]))
    near = (x > results.scene.patch.a) & (x <= NEAR_LOAD * results.scene.reference_length)
    return float(np.mean(((fit - c) * np.sign(c))[near]) / curve.size("C"))


def first_minus_second(runs: Runs) -> Mapping[str, float]:
    """Return the excess on Geometry 1 minus the excess on Geometry 2."""
    more = second_minus_first(excess, fitted=True)(runs)
    return {case: -value for case, value in more.items()}


# --- 13 -------------------------------------------------------------------------------------------------


def a_over(variant: str) -> Callable[[Results, str], float]:
    """Measure the error of A_xn over the error of a variant without curvature along x, on lines off s = 0.

    On s = 0 both are equal.
    """

    def ratio(results: Results, body: str) -> float:
        curves = [Curve(results, body, "xn", line) for line in (BESIDE, ACROSS)]
        return max(curve.error("A") for curve in curves) / max(
            prismatic_error(curve, variant) for curve in curves
        )

    return ratio


def xn_errors(runs: Runs) -> Mapping[str, float]:
    """Return the errors of A, and of B and B-hat without curvature along x and with it."""
    numbers = {"A": partial(Curve.error, variant="A")}
    for variant in ("B", "Bhat"):
        numbers |= {
            f"{symbol_of(variant)}, not revolved": partial(prismatic_error, variant=variant),
            symbol_of(variant): partial(Curve.error, variant=variant),
        }
    return {
        f"error of {name}: {geometry}, {body}": number(Curve(runs.geometry(geometry), body, "xn"))
        for name, number in numbers.items()
        for geometry, body in product(GEOMETRIES, BODIES)
    }


def prismatic_error(curve: Curve, variant: str) -> float:
    """Return the error of a variant without curvature along x."""
    return curve.error_of(not_revolved(curve.results, variant, curve.body))


# --- panels ---------------------------------------------------------------------------------------------


def _source_panels(results: Results) -> list[Panel]:
    """Return panels of C, A and the approximations without curvature along x on s = 1.6 mm."""
    panels = []
    for body in BODIES:
        curve = _beside(results, body)
        more = {
            f"{symbol_of(variant)}, not revolved": curve.values(not_revolved(results, variant, body))
            for variant in ("B", "Bhat")
        }
        panels.append(curve.panel("A", more=more))
    return panels


def _fitted(results: Results) -> list[Panel]:
    return [Curve(results, *XN, line).panel("Bhat", "Bhat_prime") for line in (BESIDE, THROUGH)]


STATEMENTS = (
    Statement(
        6,
        "B_xn is poor; off the centre line B and B̂ put the larger displacement in the concave body, C in the "
        "convex one.",
        (
            per_geometry(lambda r: prismatic_error(Curve(r, *XN), "B")).above(
                POOR, "poor", "error of B_xn, both bodies together"
            ),
            per_geometry(concave_over_convex("B")).above(
                1.0, "in B", "rms of B_xn on s = 1.6 mm: concave body over convex body"
            ),
            per_geometry(concave_over_convex("Bhat")).above(
                1.0, "in B̂", "rms of B̂_xn on s = 1.6 mm: concave body over convex body"
            ),
            per_geometry(convex_over_concave_c).above(
                1.0, "in C", "rms of C_xn on s = 1.6 mm: convex body over concave body"
            ),
        ),
        side_by_side(_source_panels),
    ),
    Statement(
        7,
        "B̂′_xn is close to C_xn along x, somewhat too large near the load, more so on Geometry 1.",
        (
            per_geometry(lambda r: Curve(r, *XN, "x").error("Bhat_prime"), fitted=True).below(
                FOLLOWS, "close", "error of B̂′_xn on the lines along x"
            ),
            per_geometry(excess, fitted=True).above(
                0.0, "too large", "mean of (B̂′ - C) sgn C / max |C| within 0.3 reference lengths"
            ),
            Numbers(first_minus_second).above(0.0, "geometry", "the same: Geometry 1 minus Geometry 2"),
        ),
        side_by_side(_fitted, fitted=True),
    ),
    Statement(
        13,
        "Without a fit, A_xn is better than B_xn and B̂_xn (both without curvature along x).",
        (
            per_body(a_over("B")).below(1.0, "B", "error of A_xn over error of B_xn, off s = 0"),
            per_body(a_over("Bhat")).below(1.0, "B̂", "error of A_xn over error of B̂_xn, off s = 0"),
        ),
        side_by_side(_source_panels),
        xn_errors,
    ),
)
