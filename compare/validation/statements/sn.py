"""Statements 9 and 10: the lateral displacement under a normal load."""

from collections.abc import Mapping
from itertools import product

import numpy as np

from approx.forms import FORMS, rotation_between
from approx.halfspace import HalfSpace
from compare.report.charts import Panel
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import (
    FOLLOWS,
    MUCH,
    POOR,
    Numbers,
    Statement,
    per_geometry,
    side_by_side,
)
from compare.validation.statements.curves import ACROSS, ALONE, CONCAVE, CONVEX, Curve, error_ratio, line_of
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results, parts_of
from geometries.arrays import Array
from geometries.patches import N, S

SN = ("combined", "sn")
GAIN = 0.9  # error with the factor over error without it: at most this is a gain
WITH_FACTOR = ("B", "Bhat")  # variants to which the factor is applied


# --- 9: all on the line along s -------------------------------------------------------------------------


def mean_deviation_from_a(results: Results, body: str) -> float:
    """Return the mean of (C - A) sgn A / max |A| of sn on the line along s, s > 0.

    The source draws each body in its own frame, in which A_sn of both bodies has the same sign; here A_sn of
    the lower and of the upper body have opposite signs.
    """
    positive = line_of(results, ACROSS).s > 0
    c, a = (Curve(results, body, "sn", ACROSS).variant(name)[positive] for name in ("C", "A"))
    return float(np.mean((c - a) * np.sign(a) / np.max(np.abs(a))))


def translation(results: Results) -> float:
    """Return the share of |C_sn - B-hat_sn|^2 that the best vertical translation of both bodies explains."""
    misfit = _c_minus_b_hat(results)
    lean = np.sin(results.scene.bodies[CONVEX].contour.inclination(line_of(results, ACROSS).s))
    remainder = misfit - lean * (lean @ misfit) / (lean @ lean)
    return float(1 - (remainder @ remainder) / (misfit @ misfit))


def furthest_misfit(results: Results) -> float:
    """Return |s| of the largest |C_sn - B-hat_sn| on the line along s, over |s| of the joint."""
    s = line_of(results, ACROSS).s
    return float(abs(s[np.argmax(np.abs(_c_minus_b_hat(results)))]) / _joint(results))


def within_arc(results: Results, variant: str) -> float:
    """Return the largest |v - C| of sn between the joints, as a share of max |C_sn| on all lines."""
    on_arc = np.abs(line_of(results, ACROSS).s) <= _joint(results)
    differences = Curve(results, *SN, ACROSS).difference(variant)
    return float(np.max(np.abs(differences[on_arc])) / Curve(results, *SN).size("C"))


def _c_minus_b_hat(results: Results) -> Array:
    return Curve(results, *SN, ACROSS).difference("Bhat")


def _joint(results: Results) -> float:
    """Return the smallest |s| [mm] of a joint of arc and flank of either body."""
    return min(abs(s) for body in results.scene.bodies.values() for s in body.contour.joints)


# --- 10 -------------------------------------------------------------------------------------------------


def gain_share(runs: Runs) -> Mapping[str, float]:
    """Return the share of cases in which the factor reduces the error by a tenth or more."""
    return {"all": float(np.mean([ratio <= GAIN for ratio in errors_with_factor(runs).values()]))}


def errors_with_factor(runs: Runs) -> Mapping[str, float]:
    """Return the error of sn with the factor over the error without it, of each body alone.

    Where both bodies are equal, the combined A_sn cancels, and the factor with it.
    """
    return {
        f"error with over without: {name}, {body}, {variant}": _with_over_without(
            Curve(runs.geometry(name), body, "sn"), variant
        )
        for variant, name, body in product(WITH_FACTOR, GEOMETRIES, ALONE)
    }


def _with_over_without(curve: Curve, variant: str) -> float:
    return curve.error_of(with_factor(curve.results, variant, curve.body)) / curve.error(variant)


def with_factor(results: Results, variant: str, body: str) -> Array:
    """Return B or B-hat [mm/N], (3, 3, n), from A with sn and ns times (pi - |alpha|) / pi.

    alpha is the angle between the normals of the observer and the load.
    """
    scene, points = results.scene, (results.points.x, results.points.s)
    total = np.zeros((3, 3, len(points[0])))
    for name in parts_of(body):
        solid = getattr(scene.pair, name)
        a = HalfSpace(solid.constants).ics(scene.patch, points[0], points[1] - scene.patch.s)
        inclination = solid.surface.contour.inclination
        alpha = np.abs(inclination(points[1]) - inclination(scene.patch.s))
        a[[S, N], [N, S]] *= (np.pi - alpha) / np.pi
        total += FORMS[variant].rotate(a, rotation_between(solid.surface, points, scene.patch.s))
    return total / scene.patch.area


# --- panels ---------------------------------------------------------------------------------------------


def _body_panels(results: Results) -> list[Panel]:
    return [
        Curve(results, *SN, ACROSS).panel("A", "B", "Bhat", "Bhat_prime"),
        *(Curve(results, body, "sn", ACROSS).panel("A", "B", "Bhat") for body in ALONE),
    ]


def _factor(results: Results) -> list[Panel]:
    panels = []
    for body in ALONE:
        curve = Curve(results, body, "sn", ACROSS)
        more = {
            f"{symbol_of(variant)} with the factor": curve.values(with_factor(results, variant, body))
            for variant in WITH_FACTOR
        }
        panels.append(curve.panel("B", "Bhat", more=more))
    return panels


STATEMENTS = (
    Statement(
        9,
        "C_sn along s: convex body well below A, concave above; B_sn better than B̂_sn, B̂′_sn worst, and "
        "within the arc C_sn is captured; much of C_sn - B̂_sn is a vertical translation; the largest misfit "
        "lies beyond the arc/flank joint of Geometry 1.",
        (
            per_geometry(lambda r: mean_deviation_from_a(r, CONVEX)).below(
                -POOR, "convex", "mean of (C - A) sgn A / max |A| at x = 1.6 mm, s > 0, convex body"
            ),
            per_geometry(lambda r: mean_deviation_from_a(r, CONCAVE)).above(
                0.0, "concave", "the same, concave body"
            ),
            per_geometry(error_ratio("B", "Bhat", "sn", ACROSS)).below(
                1.0, "B", "error of B_sn over error of B̂_sn at x = 1.6 mm"
            ),
            per_geometry(error_ratio("Bhat_prime", "Bhat", "sn", ACROSS), fitted=True).above(
                1.0, "B̂′", "error of B̂′_sn over error of B̂_sn at x = 1.6 mm"
            ),
            per_geometry(lambda r: within_arc(r, "B")).below(
                FOLLOWS, "arc", "largest |B_sn - C_sn| at x = 1.6 mm up to the joint, of max |C_sn|"
            ),
            per_geometry(translation).above(
                MUCH,
                "translation",
                "part of |C_sn - B̂_sn|² at x = 1.6 mm that a vertical translation explains",
            ),
            Numbers(lambda runs: {GEOMETRIES[0]: furthest_misfit(runs.geometry(GEOMETRIES[0]))}).above(
                1.0, "flank", "|s| of the largest |C_sn - B̂_sn| at x = 1.6 mm over |s| of the joint"
            ),
        ),
        side_by_side(_body_panels, fitted=True),
    ),
    Statement(
        10,
        "The factor (π - |α|) / π on A_sn brings no consistent gain.",
        (
            Numbers(gain_share).below(
                0.75, "gain", "share of cases (bodies alone) in which the error of sn falls by a tenth"
            ),
        ),
        side_by_side(_factor),
        errors_with_factor,
    ),
)
