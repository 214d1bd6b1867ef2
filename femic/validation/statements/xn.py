"""Statements 6, 7 and 13: the longitudinal displacement under a normal load, and its approximations."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial

import numpy as np

from compare.ics.compute import Results, ics_of, points_of, reference_of
from compare.report.panels import Panel
from compare.report.styles import SYMBOLS
from femic.validation.statements.criteria import (
    FOLLOWS,
    POOR,
    Numbers,
    Statement,
    per_body,
    per_geometry,
    second_minus_first,
    side_by_side,
)
from femic.validation.statements.curves import (
    ALONE,
    BESIDE,
    BODIES,
    CONCAVE,
    CONVEX,
    THROUGH,
    along,
    curve,
    deviation,
    error,
    line_of,
    not_revolved,
    panel,
    rms,
    unit,
)
from femic.validation.statements.runs import Runs
from geometries.arrays import Array
from geometries.patches import OffsetLine

XN = ("combined", "xn")
NEAR_LOAD = 0.3  # reference lengths: largest |x| that is near the load
X, N = 0, 2


# --- 6 --------------------------------------------------------------------------------------------------


def concave_over_convex(variant: str) -> Callable[[Results], float]:
    """Measure the rms of xn of a variant without curvature along x on s = 1.6 mm, concave over convex."""

    def ratio(results: Results) -> float:
        concave, convex = (
            rms(_xn_beside(results, not_revolved(results, variant, body))) for body in (CONCAVE, CONVEX)
        )
        return concave / convex

    return ratio


def convex_over_concave_c(results: Results) -> float:
    """Return the rms of C_xn on s = 1.6 mm: convex body over concave body."""
    convex, concave = (rms(_xn_beside(results, ics_of(results, "C", body))) for body in ALONE)
    return convex / concave


def _xn_beside(results: Results, ics: Array) -> Array:
    """Return xn of ICs (3, 3, n_points) [mm/N] on s = 1.6 mm, (n,), dimensionless."""
    return np.asarray(unit(results) * ics[X, N, results.lines[BESIDE]])


# --- 7 --------------------------------------------------------------------------------------------------


def b_hat_prime_error(results: Results) -> float:
    """Return the error of B-hat-prime_xn on the lines along x."""
    return error(results, "Bhat_prime", *XN, along(results, "x"))


def excess(results: Results) -> float:
    """Return the mean of (B-hat-prime - C) sgn C / max |C| of xn near the load on the lines along x."""
    c, fit = (curve(results, variant, *XN, along(results, "x")) for variant in ("C", "Bhat_prime"))
    x = np.abs(results.points.x[points_of(results, along(results, "x"))])
    near = (x > results.scene.patch.a) & (x <= NEAR_LOAD * results.scene.reference_length)
    return float(np.mean(((fit - c) * np.sign(c))[near]) / np.max(np.abs(c)))


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
        lines = [line for line in results.scene.lines if line.name != THROUGH]
        return error(results, "A", body, "xn", lines) / _prismatic(variant, results, body, lines)

    return ratio


def xn_errors(runs: Runs) -> Mapping[str, float]:
    """Return the errors of A, and of B and B-hat without curvature along x and with it."""
    numbers = {"A": partial(_revolved, "A")}
    for variant in ("B", "Bhat"):
        numbers |= {
            f"{SYMBOLS[variant]}, not revolved": partial(_prismatic, variant),
            SYMBOLS[variant]: partial(_revolved, variant),
        }
    return {
        f"error of {name}: {case}": value
        for name, number in numbers.items()
        for case, value in per_body(number)(runs).items()
    }


def _revolved(variant: str, results: Results, body: str) -> float:
    """Return the error of xn of a variant."""
    return error(results, variant, body, "xn")


def _prismatic(variant: str, results: Results, body: str, lines: Iterable[OffsetLine] | None = None) -> float:
    """Return the error of xn of a variant without curvature along x, on lines (default: all)."""
    differences = not_revolved(results, variant, body) - reference_of(results, body).ic
    return deviation(results, differences, body, "xn", lines)


# --- panels ---------------------------------------------------------------------------------------------


def _source_panels(results: Results) -> list[Panel]:
    """Return panels of C, A and the approximations without curvature along x on s = 1.6 mm."""
    line = line_of(results, BESIDE)
    part = results.lines[BESIDE]
    return [
        panel(
            results,
            ("A",),
            (body, "xn"),
            line,
            {SYMBOLS[v]: unit(results) * not_revolved(results, v, body)[X, N, part] for v in ("B", "Bhat")},
        )
        for body in BODIES
    ]


def _fitted(results: Results) -> list[Panel]:
    return [panel(results, ("Bhat", "Bhat_prime"), XN, line) for line in along(results, "x")]


STATEMENTS = (
    Statement(
        6,
        "B_xn is poor; off the centre line B and B̂ put the larger displacement in the concave body, C in the "
        "convex one.",
        (
            per_geometry(partial(_prismatic, "B", body="combined")).above(
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
            per_geometry(b_hat_prime_error, fitted=True).below(
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
