"""Statements 1 to 5 and 16 to 20: nn, xx, ss and xs of both bodies, near the load and away from it.

How far A, B and B-hat follow C in them, how deviations of the bodies add up, and which body rotates.
"""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from compare.report.charts import Panel, make_curves
from compare.validation.statements.curves import (
    ACROSS,
    ALONE,
    BESIDE,
    BODIES,
    CONCAVE,
    CONVEX,
    INDEPENDENT,
    STEEP,
    THROUGH,
    Curve,
    across_over_along,
    curve_panels,
    error_ratio,
    find_line,
    per_body,
    per_geometry,
    second_minus_first,
    side_by_side,
    unit,
)
from compare.validation.statements.frame import FOLLOWS, MUCH, SATISFACTORY, Statement, above, below, labelled
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.reference.discount import FY, MOMENT
from femic.results.ics import Results
from geometries.arrays import Array

AWAY, HALF_WAY = 10.0, 5.0  # coordinates [mm], with the load at 0
CANCEL, ADD = ("nn", "ss", "xx", "xs"), ("xn", "sn")
ON_THROUGH = ("nn", "ss", "xx", "xn")  # the other components vanish on s = 0 by symmetry
AT_LOAD, NEAR_LENGTHS, FAR_LENGTHS = 0.1, 0.25, (1.0, 2.0)  # reference lengths from the load
SHOWN_NEAR = 1.0  # reference lengths from the load, up to which curves are drawn

# --- 1, 16, 20: nn --------------------------------------------------------------------------------------


def nn_error(variant: str, line: str = ACROSS, at: float = AWAY) -> Callable[[Results], float]:
    """Measure |v / C - 1| of the combined nn of a variant v at a coordinate [mm] of a line."""
    return lambda results: Curve(results, "combined", "nn", line).relative(variant, at)


def _nn_body_panels(runs: Runs) -> list[Panel]:
    across = curve_panels([(body, "nn", ACROSS) for body in BODIES], "A")
    return [*across(runs), *curve_panels([(CONCAVE, "nn", THROUGH)], "A", beyond=STEEP)(runs)]


NN = (
    Statement(
        1,
        "Along s, A_nn deviates from C_nn with increasing distance, more on Geometry 2, while B_nn "
        "follows C_nn. Along x all three agree (combined bodies).",
        (
            above(FOLLOWS, "A departs", "|A_nn / C_nn - 1| at s = 10 mm")(per_geometry(nn_error("A"))),
            above(0.0, "with distance", "the same: at s = 10 mm minus at 5 mm")(
                per_geometry(lambda r: nn_error("A")(r) - nn_error("A", at=HALF_WAY)(r))
            ),
            above(0.0, "geometry", "the same at s = 10 mm: Geometry 2 minus Geometry 1")(
                second_minus_first(nn_error("A"))
            ),
            below(FOLLOWS, "B follows", "|B_nn / C_nn - 1| at s = 10 mm")(per_geometry(nn_error("B"))),
            below(1.0, "B better", "|B_nn - C_nn| over |A_nn - C_nn| at s = 10 mm")(
                per_geometry(lambda r: nn_error("B")(r) / nn_error("A")(r))
            ),
            *(
                below(FOLLOWS, f"{variant} along x", f"|{variant}_nn / C_nn - 1| at x = 10 mm")(
                    per_geometry(lambda r, line, v=variant: nn_error(v, line)(r), (BESIDE, THROUGH))
                )
                for variant in ("A", "B")
            ),
        ),
        curve_panels([("combined", "nn", line) for line in (ACROSS, BESIDE)], "A", "B"),
    ),
    Statement(
        16,
        "C_nn deviates most from A_nn along s; in the concave body, along x.",
        (
            above(1.0, "along s", "largest |C_nn - A_nn|: line along s over lines along x")(
                per_geometry(across_over_along("nn"), ("combined", CONVEX))
            ),
            below(1.0, "concave", "the same, concave body")(
                per_geometry(across_over_along("nn"), (CONCAVE,))
            ),
        ),
        _nn_body_panels,
    ),
    Statement(
        20,
        "B̂_nn is no worse than B_nn.",
        (
            below(1.0, "B̂", "error of B̂_nn over error of B_nn on the line along s")(
                per_body(error_ratio("Bhat", "B", "nn", ACROSS))
            ),
        ),
        curve_panels([(body, "nn", ACROSS) for body in BODIES], "B", "Bhat"),
    ),
)

# --- 2, 3, 4: xx, ss, xs --------------------------------------------------------------------------------


def worst_xx_error(results: Results, body: str = "combined") -> float:
    """Return the largest |A_xx - C_xx| on a line, as a share of max |C_xx| there, over all lines."""
    return max(Curve(results, body, "xx", line.name).share("A") for line in results.scene.lines)


@below(FOLLOWS, "alike", "largest difference of (C_xx - A_xx) / max |C_xx| of a line between geometries")
def _alike(runs: Runs) -> Mapping[str, float]:
    deviations = []
    for results in map(runs.geometry, GEOMETRIES):
        curves = [Curve(results, "combined", "xx", line.name) for line in results.scene.lines]
        deviations.append(np.concatenate([curve.difference("A") / curve.size("C") for curve in curves]))
    return {"both": float(np.max(np.abs(deviations[0] - deviations[1])))}


def deficit(results: Results, body: str) -> float:
    """Return 1 - C_ss / B_ss at x = reference length, s = 0."""
    curve, x = Curve(results, body, "ss", THROUGH), results.scene.reference_length
    return 1 - curve.at("C", x) / curve.at("B", x)


@above(0.0, "convex", "|1 - C_ss / B_ss| on Geometry 2: convex body minus concave body")
def _more_on_the_convex(runs: Runs) -> Mapping[str, float]:
    wheel = runs.geometry(GEOMETRIES[1])
    return {GEOMETRIES[1]: abs(deficit(wheel, CONVEX)) - abs(deficit(wheel, CONCAVE))}


def xs_deviation(results: Results, body: str) -> float:
    """Return the largest |C_xs - A_xs|, dimensionless."""
    return Curve(results, body, "xs").largest("A")


TANGENTIAL = (
    Statement(
        2,
        "The combined C_xx is close to A_xx in both geometries.",
        (
            below(FOLLOWS, "A", "largest |A_xx - C_xx| on a line, of max |C_xx| there")(
                per_geometry(worst_xx_error)
            ),
            _alike,
        ),
        curve_panels([("combined", "xx", line) for line in (BESIDE, ACROSS)], "A"),
    ),
    Statement(
        3,
        "Along x, C_ss decreases faster than B_ss for the combined bodies and for the convex body, most "
        "on Geometry 2 and its convex body. The concave body deviates in the opposite direction.",
        (
            above(0.0, "faster", "1 - C_ss / B_ss at x = reference length, s = 0")(
                per_geometry(deficit, ("combined", CONVEX))
            ),
            below(0.0, "other way", "the same, concave body")(per_geometry(lambda r: deficit(r, CONCAVE))),
            above(0.0, "geometry", "the same of both bodies: Geometry 2 minus Geometry 1")(
                second_minus_first(lambda r: deficit(r, "combined"))
            ),
            above(0.0, "convex geometry", "the same of the convex body: Geometry 2 minus Geometry 1")(
                second_minus_first(lambda r: deficit(r, CONVEX))
            ),
            _more_on_the_convex,
        ),
        curve_panels([(body, "ss", THROUGH) for body in BODIES], "A", "B", beyond=STEEP),
    ),
    Statement(
        4,
        "In absolute numbers the convex body deviates more from A_xs than the concave body, and both "
        "deviate most along s. For each single body B_xs is better than B̂_xs; neither is fully "
        "satisfactory.",
        (
            above(1.0, "convex", "largest |C_xs - A_xs|: convex body over concave body")(
                per_geometry(lambda r: xs_deviation(r, CONVEX) / xs_deviation(r, CONCAVE))
            ),
            above(1.0, "along s", "largest |C_xs - A_xs|: line along s over lines along x")(
                per_body(across_over_along("xs"))
            ),
            below(1.0, "better", "error of B_xs over error of B̂_xs")(
                per_geometry(error_ratio("B", "Bhat", "xs"), ALONE)
            ),
            above(SATISFACTORY, "left", "the smaller of both errors")(
                per_body(lambda r, body: min(Curve(r, body, "xs").error(v) for v in ("B", "Bhat")))
            ),
        ),
        curve_panels([(body, "xs", ACROSS) for body in BODIES], "A", "B", "Bhat"),
        labelled("largest |C_xs - A_xs| E L", per_geometry(xs_deviation, ALONE)),
    ),
)

# --- 5, 17, 18, 19: bodies alone and together -----------------------------------------------------------


def remaining_share(results: Results, component: str) -> float:
    """Return the norm of the sum of both bodies' C - A over the sum of their norms, on all lines.

    It is 0 if the deviations cancel and 1 if they add.
    """
    convex, concave = (Curve(results, body, component).difference("A") for body in ALONE)
    return float(np.linalg.norm(convex + concave) / (np.linalg.norm(convex) + np.linalg.norm(concave)))


def alignment_in_ss(results: Results, way: str) -> float:
    """Return the cosine between both bodies' C_ss - A_ss on all lines "along x" or "along s"."""
    convex, concave = (Curve(results, body, "ss", way[-1]).difference("A") for body in ALONE)
    return float(convex @ concave / (np.linalg.norm(convex) * np.linalg.norm(concave)))


def relative_to_half_space(results: Results, body: str, component: str, on: str | None = None) -> Array:
    """Return (C - A) / A_nn [-] of a body's component on a line (default: all), (n,)."""
    deviation = Curve(results, body, component, on).difference("A")
    return np.asarray(deviation / Curve(results, body, "nn", on).variant("A"))


def deviation_at_load(results: Results, body: str, component: str) -> float:
    """Return the largest |C - A| / A_nn on s = 0 within a tenth of the reference length."""
    near = np.abs(find_line(results, THROUGH).x) <= AT_LOAD * results.scene.reference_length
    return float(np.max(np.abs(relative_to_half_space(results, body, component, THROUGH)[near])))


def near_over_far(results: Results, body: str, component: str) -> float:
    """Return the largest |C - A| / A_nn within a quarter of the reference length, over the same at 1 to 2."""
    length = results.scene.reference_length
    r = np.hypot(results.points.x, results.points.s - results.scene.patch.s) / length
    deviation = np.abs(relative_to_half_space(results, body, component))
    far = (r >= FAR_LENGTHS[0]) & (r <= FAR_LENGTHS[1])
    return float(np.max(deviation[r <= NEAR_LENGTHS]) / np.max(deviation[far]))


def rotation(results: Results, body: str) -> float:
    """Return the discounted rotation about x [1/N] under a unit lateral load at s = 0."""
    return float(results.references[body].discount[FY, MOMENT])


@above(MUCH, "convex", "rotation of the convex body under a lateral load over the sum of both sizes")
def _mostly_convex(runs: Runs) -> Mapping[str, float]:
    rotations = {name: [abs(rotation(runs.geometry(name), body)) for body in ALONE] for name in GEOMETRIES}
    return {name: convex / (convex + concave) for name, (convex, concave) in rotations.items()}


def _sum_panels(runs: Runs) -> list[Panel]:
    results = runs.geometry(GEOMETRIES[0])
    return [
        Curve(results, body, component, line).panel("A")
        for component, line in (("nn", ACROSS), ("sn", ACROSS), ("xn", BESIDE))
        for body in BODIES
    ]


def _near_panels(results: Results) -> Iterator[Panel]:
    """Return panels of (C - A) / A_nn near the load: on s = 0, and along s if they vanish there."""
    length = results.scene.reference_length
    for name, components in ((THROUGH, ON_THROUGH), (ACROSS, ("xs", "sn"))):
        line = find_line(results, name)
        shown = (line.running >= 0) & (line.running <= SHOWN_NEAR * length)
        for body in ALONE:
            # every component has the same look in all panels
            curves = dict.fromkeys(INDEPENDENT, np.full(np.count_nonzero(shown), np.nan)) | {
                c: relative_to_half_space(results, body, c, name)[shown] for c in components
            }
            yield Panel(
                f"{results.scene.name}, {body}: {', '.join(components)} on {name}",
                f"{line.along} / L  [-]",
                "(C - A) / A_nn  [-]",
                make_curves(line.running[shown] / length, curves),
            )


def _rotation_panels(results: Results) -> list[Panel]:
    curves = [Curve(results, body, "sn", ACROSS) for body in ALONE]
    raw = [curve.values(results.references[curve.body].raw) for curve in curves]
    return [curve.panel(more={"C before the discount": c}) for curve, c in zip(curves, raw, strict=True)]


SINGLE_BODIES = (
    Statement(
        5,
        "Deviations of the two bodies from A cancel in nn, ss, xx, xs and add in xn, sn.",
        (
            below(MUCH, "cancel", "|sum of both deviations| / sum of their norms: nn, ss, xx, xs")(
                per_geometry(remaining_share, CANCEL)
            ),
            above(0.75, "add", "the same: xn, sn")(per_geometry(remaining_share, ADD)),
        ),
        _sum_panels,
        columns=3,
    ),
    Statement(
        17,
        "For single bodies, C_xx deviates little from A_xx, and C_ss deviates from A_ss in opposite "
        "directions. B_ss is accurate along s.",
        (
            below(FOLLOWS, "xx", "largest |A_xx - C_xx| on a line, of max |C_xx| there: body alone")(
                per_geometry(worst_xx_error, ALONE)
            ),
            below(-MUCH, "ss", "cosine between both bodies' C_ss - A_ss")(
                per_geometry(alignment_in_ss, ("along x", "along s"))
            ),
            below(FOLLOWS, "B_ss", "largest |B_ss - C_ss| at x = 1.6 mm, of max |C_ss| there")(
                per_body(lambda r, body: Curve(r, body, "ss", ACROSS).share("B"))
            ),
        ),
        curve_panels(
            [
                (body, component, line)
                for component, line in (("xx", THROUGH), ("ss", THROUGH), ("ss", ACROSS))
                for body in ALONE
            ],
            *("A", "B"),
            beyond=STEEP,
        ),
    ),
    Statement(
        18,
        "All ICs converge to ICs of the half-space near the load.",
        (
            below(SATISFACTORY, "at the load", "largest |C - A| / A_nn on s = 0, |x| ≤ 1 mm")(
                per_geometry(deviation_at_load, BODIES, ON_THROUGH)
            ),
            below(
                MUCH,
                "converge",
                "largest |C - A| / A_nn up to 2.5 mm from the load over the same at 10 to 20 mm",
            )(per_geometry(near_over_far, BODIES, INDEPENDENT)),
        ),
        side_by_side(_near_panels),
    ),
    Statement(
        19,
        "Most of the rotation that the discount removes comes from the convex body.",
        (_mostly_convex,),
        side_by_side(_rotation_panels),
        labelled(
            "rotation · E L²",
            per_geometry(lambda r, body: rotation(r, body) * unit(r) * r.scene.reference_length, ALONE),
        ),
    ),
)

STATEMENTS = (*NN, *TANGENTIAL, *SINGLE_BODIES)
