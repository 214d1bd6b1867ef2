"""Statements 1, 16 and 20: the normal displacement under a normal load."""

from collections.abc import Callable

from compare.report.charts import Panel
from compare.validation.statements.criteria import (
    FOLLOWS,
    Statement,
    per_body,
    per_geometry,
    second_minus_first,
    side_by_side,
)
from compare.validation.statements.curves import (
    ACROSS,
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
from femic.results.ics import Results

AWAY, HALF_WAY = 10.0, 5.0  # coordinates [mm], with the load at 0
NN = ("combined", "nn")


def relative_error_across(variant: str, s: float = AWAY) -> Callable[[Results], float]:
    """Measure |v / C - 1| of the combined nn of a variant v at s [mm] on the line along s."""
    return lambda results: Curve(results, *NN, ACROSS).relative(variant, s)


def relative_error_along(variant: str) -> Callable[[Results, str], float]:
    """Measure |v / C - 1| of the combined nn of a variant v at x = 10 mm on a line along x."""
    return lambda results, line: Curve(results, *NN, line).relative(variant, AWAY)


def growth_with_distance(results: Results) -> float:
    """Return |A / C - 1| of the combined nn at s = 10 mm, minus the same at s = 5 mm."""
    return relative_error_across("A")(results) - relative_error_across("A", HALF_WAY)(results)


def b_over_a(results: Results) -> float:
    """Return |B_nn - C_nn| over |A_nn - C_nn| at s = 10 mm."""
    a, b, c = (Curve(results, *NN, ACROSS).at(variant, AWAY) for variant in ("A", "B", "C"))
    return abs(b - c) / abs(a - c)


def _both_ways(results: Results) -> list[Panel]:
    return [Curve(results, *NN, line).panel("A", "B") for line in (ACROSS, BESIDE)]


def _body_panels(results: Results) -> list[Panel]:
    across = [Curve(results, body, "nn", ACROSS).panel("A") for body in BODIES]
    return [*across, Curve(results, CONCAVE, "nn", THROUGH).panel("A", beyond=STEEP)]


def _with_b_hat(results: Results) -> list[Panel]:
    return [Curve(results, body, "nn", ACROSS).panel("B", "Bhat") for body in BODIES]


STATEMENTS = (
    Statement(
        1,
        "Laterally A_nn departs from C_nn with distance, more on Geometry 2, and B_nn follows; "
        "longitudinally all three agree (both bodies together).",
        (
            per_geometry(relative_error_across("A")).above(
                FOLLOWS, "A departs", "|A_nn / C_nn - 1| at s = 10 mm"
            ),
            per_geometry(growth_with_distance).above(
                0.0, "with distance", "the same: at s = 10 mm minus at 5 mm"
            ),
            second_minus_first(relative_error_across("A")).above(
                0.0, "geometry", "the same at s = 10 mm: Geometry 2 minus Geometry 1"
            ),
            per_geometry(relative_error_across("B")).below(
                FOLLOWS, "B follows", "|B_nn / C_nn - 1| at s = 10 mm"
            ),
            per_geometry(b_over_a).below(1.0, "B better", "|B_nn - C_nn| over |A_nn - C_nn| at s = 10 mm"),
            per_geometry(relative_error_along("A"), (BESIDE, THROUGH)).below(
                FOLLOWS, "A along x", "|A_nn / C_nn - 1| at x = 10 mm"
            ),
            per_geometry(relative_error_along("B"), (BESIDE, THROUGH)).below(
                FOLLOWS, "B along x", "|B_nn / C_nn - 1| at x = 10 mm"
            ),
        ),
        side_by_side(_both_ways),
    ),
    Statement(
        16,
        "C_nn departs most from A_nn along s; in the concave body, along x.",
        (
            per_body(across_over_along("nn"), ("combined", CONVEX)).above(
                1.0, "along s", "largest |C_nn - A_nn|: line along s over lines along x"
            ),
            per_body(across_over_along("nn"), (CONCAVE,)).below(1.0, "concave", "the same, concave body"),
        ),
        side_by_side(_body_panels),
    ),
    Statement(
        20,
        "B̂_nn is no worse than B_nn.",
        (
            per_body(error_ratio("Bhat", "B", "nn", ACROSS)).below(
                1.0, "B̂", "error of B̂_nn over error of B_nn on the line along s"
            ),
        ),
        side_by_side(_with_b_hat),
    ),
)
