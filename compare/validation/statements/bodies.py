"""Statements 5, 17, 18 and 19: deviations of the bodies alone, together and near the load; their rotation."""

from collections.abc import Mapping

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.validation.statements.criteria import (
    FOLLOWS,
    MUCH,
    SATISFACTORY,
    Statement,
    per_body,
    per_geometry,
    side_by_side,
)
from compare.validation.statements.curves import (
    ACROSS,
    ALONE,
    BESIDE,
    BODIES,
    CONVEX,
    INDEPENDENT,
    STEEP,
    THROUGH,
    Curve,
    line_of,
    unit,
)
from compare.validation.statements.runs import GEOMETRIES, Runs
from compare.validation.statements.tangential import worst_xx_error
from femic.reference.discount import FY, MOMENT
from femic.results.ics import Results
from geometries.arrays import Array

CANCEL, ADD = ("nn", "ss", "xx", "xs"), ("xn", "sn")
ON_THROUGH = ("nn", "ss", "xx", "xn")  # the other components vanish on s = 0 by symmetry
AT_LOAD, NEAR_LENGTHS, FAR_LENGTHS = 0.1, 0.25, (1.0, 2.0)  # reference lengths from the load
SHOWN_NEAR = 1.0  # reference lengths from the load, up to which curves are drawn


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
    differences = Curve(results, body, component, on).difference("A")
    return np.asarray(differences / Curve(results, body, "nn", on).variant("A"))


def deviation_at_load(results: Results, body: str, component: str) -> float:
    """Return the largest |C - A| / A_nn on s = 0 within a tenth of the reference length."""
    near = np.abs(line_of(results, THROUGH).x) <= AT_LOAD * results.scene.reference_length
    return float(np.max(np.abs(relative_to_half_space(results, body, component, THROUGH)[near])))


def near_over_far(results: Results, body: str, component: str) -> float:
    """Return the largest |C - A| / A_nn within a quarter of the reference length, over the same at 1 to 2."""
    length = results.scene.reference_length
    r = np.hypot(results.points.x, results.points.s - results.scene.patch.s) / length
    differences = np.abs(relative_to_half_space(results, body, component))
    return float(
        np.max(differences[r <= NEAR_LENGTHS])
        / np.max(differences[(r >= FAR_LENGTHS[0]) & (r <= FAR_LENGTHS[1])])
    )


def rotation(results: Results, body: str) -> float:
    """Return the discounted rotation about x [1/N] under a unit lateral load at s = 0."""
    return float(results.references[body].discount[FY, MOMENT])


def convex_share(results: Results) -> float:
    """Return |discounted rotation| of the convex body over the sum of both bodies."""
    sizes = {body: abs(rotation(results, body)) for body in ALONE}
    return sizes[CONVEX] / sum(sizes.values())


def rotations(runs: Runs) -> Mapping[str, float]:
    """Return the discounted rotations of each body alone, times E L^2."""

    def scaled(results: Results, body: str) -> float:
        return rotation(results, body) * unit(results) * results.scene.reference_length

    return {f"rotation · E L²: {case}": value for case, value in per_body(scaled, ALONE)(runs).items()}


def _sum_panels(runs: Runs) -> list[Panel]:
    results = runs.geometry(GEOMETRIES[0])
    return [
        Curve(results, body, component, line).panel("A")
        for component, line in (("nn", ACROSS), ("sn", ACROSS), ("xn", BESIDE))
        for body in BODIES
    ]


def _body_panels(results: Results) -> list[Panel]:
    return [
        Curve(results, body, component, line).panel("A", "B", beyond=STEEP)
        for component, line in (("xx", THROUGH), ("ss", THROUGH), ("ss", ACROSS))
        for body in ALONE
    ]


def _near_panels(results: Results) -> list[Panel]:
    """Return panels of (C - A) / A_nn near the load: on s = 0, and along s if they vanish there."""
    lines = ((THROUGH, ON_THROUGH), (ACROSS, ("xs", "sn")))
    return [
        _half_space_panel(results, body, line, components) for line, components in lines for body in ALONE
    ]


def _half_space_panel(results: Results, body: str, name: str, components: tuple[str, ...]) -> Panel:
    line, length = line_of(results, name), results.scene.reference_length
    shown = (line.running >= 0) & (line.running <= SHOWN_NEAR * length)
    # every component has the same look in all panels
    curves = dict.fromkeys(INDEPENDENT, np.full(np.count_nonzero(shown), np.nan)) | {
        c: relative_to_half_space(results, body, c, name)[shown] for c in components
    }
    title = f"{results.scene.name}, {body}: {', '.join(components)} on {name}"
    at = line.running[shown] / length
    return Panel(title, f"{line.along} / L  [-]", "(C - A) / A_nn  [-]", curves_of(at, curves))


def _rotation_panels(results: Results) -> list[Panel]:
    """Return panels of C_sn before and after the discount."""
    curves = [Curve(results, body, "sn", ACROSS) for body in ALONE]
    return [
        curve.panel(more={"C before the discount": curve.values(results.references[curve.body].raw)})
        for curve in curves
    ]


STATEMENTS = (
    Statement(
        5,
        "Deviations of the two bodies from A cancel in nn, ss, xx, xs and add in xn, sn.",
        (
            per_geometry(remaining_share, CANCEL).below(
                MUCH, "cancel", "|sum of both deviations| / sum of their norms: nn, ss, xx, xs"
            ),
            per_geometry(remaining_share, ADD).above(0.75, "add", "the same: xn, sn"),
        ),
        _sum_panels,
        columns=3,
    ),
    Statement(
        17,
        "Of the bodies alone C_xx deviates little from A_xx, and C_ss from A_ss to opposite sides; B_ss is "
        "good along s.",
        (
            per_body(worst_xx_error, ALONE).below(
                FOLLOWS, "xx", "largest |A_xx - C_xx| on a line, of max |C_xx| there: body alone"
            ),
            per_geometry(alignment_in_ss, ("along x", "along s")).below(
                -MUCH, "ss", "cosine between both bodies' C_ss - A_ss"
            ),
            per_body(lambda r, body: Curve(r, body, "ss", ACROSS).share("B")).below(
                FOLLOWS, "B_ss", "largest |B_ss - C_ss| at x = 1.6 mm, of max |C_ss| there"
            ),
        ),
        side_by_side(_body_panels),
    ),
    Statement(
        18,
        "All ICs converge to ICs of the half-space near the load.",
        (
            per_geometry(deviation_at_load, BODIES, ON_THROUGH).below(
                SATISFACTORY, "at the load", "largest |C - A| / A_nn on s = 0, |x| ≤ 1 mm"
            ),
            per_geometry(near_over_far, BODIES, INDEPENDENT).below(
                MUCH,
                "converge",
                "largest |C - A| / A_nn up to 2.5 mm from the load over the same at 10 to 20 mm",
            ),
        ),
        side_by_side(_near_panels),
    ),
    Statement(
        19,
        "Most of the discounted rotation is due to the convex body.",
        (
            per_geometry(convex_share).above(
                MUCH, "convex", "rotation of the convex body under a lateral load over the sum of both sizes"
            ),
        ),
        side_by_side(_rotation_panels),
        rotations,
    ),
)
