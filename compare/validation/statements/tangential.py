"""Statements 2, 3 and 4: tangential displacements under tangential loads."""

from collections.abc import Mapping

import numpy as np

from compare.report.charts import Panel
from compare.validation.statements.criteria import (
    FOLLOWS,
    SATISFACTORY,
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
    CONCAVE,
    CONVEX,
    STEEP,
    THROUGH,
    Curve,
    across_over_along,
    error_ratio,
)
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results
from geometries.arrays import Array


def worst_xx_error(results: Results, body: str) -> float:
    """Return the largest |A_xx - C_xx| on a line, as a share of max |C_xx| there, over all lines."""
    return max(Curve(results, body, "xx", line.name).share("A") for line in results.scene.lines)


def difference_in_xx(runs: Runs) -> Mapping[str, float]:
    """Return the largest difference between the geometries of (C_xx - A_xx) / max |C_xx| of a line."""
    first, second = (_relative_xx_deviation(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": float(np.max(np.abs(first - second)))}


def _relative_xx_deviation(results: Results) -> Array:
    curves = [Curve(results, "combined", "xx", line.name) for line in results.scene.lines]
    return np.concatenate([curve.difference("A") / curve.size("C") for curve in curves])


def deficit(results: Results, body: str) -> float:
    """Return 1 - C_ss / B_ss at x = reference length, s = 0."""
    curve, x = Curve(results, body, "ss", THROUGH), results.scene.reference_length
    return 1 - curve.at("C", x) / curve.at("B", x)


def convex_less_concave(runs: Runs) -> Mapping[str, float]:
    """Return |1 - C_ss / B_ss| of Geometry 2: convex body minus concave body."""
    name = GEOMETRIES[1]
    convex, concave = (abs(deficit(runs.geometry(name), body)) for body in ALONE)
    return {name: convex - concave}


def xs_deviation(results: Results, body: str) -> float:
    """Return the largest |C_xs - A_xs|, dimensionless."""
    return Curve(results, body, "xs").largest("A")


def convex_over_concave(results: Results) -> float:
    """Return the largest |C_xs - A_xs| of the convex body over the same of the concave one."""
    return xs_deviation(results, CONVEX) / xs_deviation(results, CONCAVE)


def smaller_error(results: Results, body: str) -> float:
    """Return the smaller of the errors of B_xs and B-hat_xs."""
    return min(Curve(results, body, "xs").error(variant) for variant in ("B", "Bhat"))


def sizes_in_xs(runs: Runs) -> Mapping[str, float]:
    """Return the largest |C_xs - A_xs| of each body, dimensionless."""
    sizes = per_body(xs_deviation, ALONE)(runs)
    return {f"largest |C_xs - A_xs| E L: {case}": size for case, size in sizes.items()}


def _xx(results: Results) -> list[Panel]:
    return [Curve(results, "combined", "xx", line).panel("A") for line in (BESIDE, ACROSS)]


def _ss(results: Results) -> list[Panel]:
    return [Curve(results, body, "ss", THROUGH).panel("A", "B", beyond=STEEP) for body in BODIES]


def _xs(results: Results) -> list[Panel]:
    return [Curve(results, body, "xs", ACROSS).panel("A", "B", "Bhat") for body in BODIES]


STATEMENTS = (
    Statement(
        2,
        "The combined C_xx is about A_xx, alike in both geometries.",
        (
            per_geometry(lambda r: worst_xx_error(r, "combined")).below(
                FOLLOWS, "A", "largest |A_xx - C_xx| on a line, of max |C_xx| there"
            ),
            Numbers(difference_in_xx).below(
                FOLLOWS,
                "alike",
                "largest difference of (C_xx - A_xx) / max |C_xx| of a line between geometries",
            ),
        ),
        side_by_side(_xx),
    ),
    Statement(
        3,
        "C_ss falls faster than B_ss along x for both bodies together and for the convex one, most on "
        "Geometry 2 and on its convex body; the concave body deviates the other way.",
        (
            per_body(deficit, ("combined", CONVEX)).above(
                0.0, "faster", "1 - C_ss / B_ss at x = reference length, s = 0"
            ),
            per_geometry(lambda r: deficit(r, CONCAVE)).below(0.0, "other way", "the same, concave body"),
            second_minus_first(lambda r: deficit(r, "combined")).above(
                0.0, "geometry", "the same of both bodies: Geometry 2 minus Geometry 1"
            ),
            second_minus_first(lambda r: deficit(r, CONVEX)).above(
                0.0, "convex geometry", "the same of the convex body: Geometry 2 minus Geometry 1"
            ),
            Numbers(convex_less_concave).above(
                0.0, "convex", "|1 - C_ss / B_ss| on Geometry 2: convex body minus concave body"
            ),
        ),
        side_by_side(_ss),
    ),
    Statement(
        4,
        "In absolute numbers the convex body deviates more from A_xs than the concave one, and both most "
        "along s; of each body alone B_xs is better than B̂_xs; neither is fully satisfactory.",
        (
            per_geometry(convex_over_concave).above(
                1.0, "convex", "largest |C_xs - A_xs|: convex body over concave body"
            ),
            per_body(across_over_along("xs")).above(
                1.0, "along s", "largest |C_xs - A_xs|: line along s over lines along x"
            ),
            per_body(error_ratio("B", "Bhat", "xs"), ALONE).below(
                1.0, "better", "error of B_xs over error of B̂_xs"
            ),
            per_body(smaller_error).above(SATISFACTORY, "left", "the smaller of both errors"),
        ),
        side_by_side(_xs),
        sizes_in_xs,
    ),
)
