"""Statements 6 to 10, 13 and 21: xn and sn, the displacements along x and s under a normal load."""

from collections.abc import Callable, Iterator, Mapping
from itertools import product

import numpy as np

from approx.forms import FORMS, rotation_between
from approx.halfspace import HalfSpace
from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.curves import (
    ACROSS,
    ALONE,
    BESIDE,
    BODIES,
    CONCAVE,
    CONVEX,
    THROUGH,
    Curve,
    curve_panels,
    error_ratio,
    find_line,
    per_body,
    per_geometry,
    prismatic_ics,
    rms,
    side_by_side,
)
from compare.validation.statements.frame import FOLLOWS, MUCH, POOR, SMALL_PART, Statement, above, below
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results, solved_parts
from geometries.arrays import Array
from geometries.patches import N, S

XN, SN = ("combined", "xn"), ("combined", "sn")
NEAR_LOAD = 0.3  # reference lengths: largest |x| that is near the load
PLACES = (8.0, 16.0)  # x [mm] at which eq. (16) is compared
GAIN = 0.9  # error with the factor over error without it: at most this is a gain
WITH_FACTOR = ("B", "Bhat")  # variants to which the factor is applied

# --- 6, 7, 13: xn and its approximations ----------------------------------------------------------------


def prismatic_error(curve: Curve, variant: str) -> float:
    """Return the error of a variant without curvature along x."""
    return curve.error(prismatic_ics(curve.results, variant, curve.body))


def concave_over_convex(variant: str) -> Callable[[Results], float]:
    """Measure the rms of xn of a variant without curvature along x on s = 1.6 mm, concave over convex."""

    def ratio(results: Results) -> float:
        convex, concave = (
            rms(Curve(results, body, "xn", BESIDE).values(prismatic_ics(results, variant, body)))
            for body in ALONE
        )
        return concave / convex

    return ratio


def c_xn_rms(results: Results, body: str = "combined", line: str = BESIDE) -> float:
    """Return the rms of C_xn on a line."""
    return rms(Curve(results, body, "xn", line).variant("C"))


def fit_excess(results: Results) -> float:
    """Return the mean of (B-hat-prime - C) sgn C / max |C| of xn near the load on the lines along x."""
    curve = Curve(results, *XN, "x")
    c, fit = curve.variant("C"), curve.variant("Bhat_prime")
    x = np.abs(np.concatenate([line.x for line in curve.lines]))
    near = (x > results.scene.patch.a) & (x <= NEAR_LOAD * results.scene.reference_length)
    return float(np.mean(((fit - c) * np.sign(c))[near]) / curve.size("C"))


@above(0.0, "geometry", "the same: Geometry 1 minus Geometry 2")
def _more_on_the_first(runs: Runs) -> Mapping[str, float]:
    first, second = map(runs.fitted, GEOMETRIES)
    return {"both": fit_excess(first) - fit_excess(second)}


def a_over_prismatic(variant: str) -> Callable[[Results, str], float]:
    """Measure the error of A_xn over the error of a variant without curvature along x, on lines off s = 0.

    On s = 0 both are equal.
    """

    def ratio(results: Results, body: str) -> float:
        curves = [Curve(results, body, "xn", line) for line in (BESIDE, ACROSS)]
        prismatic = max(prismatic_error(curve, variant) for curve in curves)
        return max(curve.error("A") for curve in curves) / prismatic

    return ratio


def xn_errors(runs: Runs) -> Mapping[str, float]:
    """Return the errors of A, and of B and B-hat without curvature along x and with it."""
    details = {}
    for variant, revolved in (("A", True), ("B", False), ("B", True), ("Bhat", False), ("Bhat", True)):
        label = ics_symbol(variant) + ("" if revolved else ", not revolved")
        for geometry, body in product(GEOMETRIES, BODIES):
            curve = Curve(runs.geometry(geometry), body, "xn")
            error = curve.error(variant) if revolved else prismatic_error(curve, variant)
            details[f"error of {label}: {geometry}, {body}"] = error
    return details


def _prismatic_panels(results: Results) -> Iterator[Panel]:
    """Return panels of C, A and the approximations without curvature along x on s = 1.6 mm."""
    for body in BODIES:
        curve = Curve(results, body, "xn", BESIDE)
        more = {
            f"{ics_symbol(variant)}, not revolved": curve.values(prismatic_ics(results, variant, body))
            for variant in ("B", "Bhat")
        }
        yield curve.panel("A", more=more)


XN_STATEMENTS = (
    Statement(
        6,
        "B_xn is inaccurate. Away from the centre line, B and B̂ give the larger displacement in the "
        "concave body, C in the convex body.",
        (
            above(POOR, "poor", "error of B_xn, both bodies together")(
                per_geometry(lambda r: prismatic_error(Curve(r, *XN), "B"))
            ),
            above(1.0, "in B", "rms of B_xn on s = 1.6 mm: concave body over convex body")(
                per_geometry(concave_over_convex("B"))
            ),
            above(1.0, "in B̂", "rms of B̂_xn on s = 1.6 mm: concave body over convex body")(
                per_geometry(concave_over_convex("Bhat"))
            ),
            above(1.0, "in C", "rms of C_xn on s = 1.6 mm: convex body over concave body")(
                per_geometry(lambda r: c_xn_rms(r, CONVEX) / c_xn_rms(r, CONCAVE))
            ),
        ),
        side_by_side(_prismatic_panels),
    ),
    Statement(
        7,
        "B̂′_xn is close to C_xn along x. It is somewhat too large near the load, more so on Geometry 1.",
        (
            below(FOLLOWS, "close", "error of B̂′_xn on the lines along x")(
                per_geometry(lambda r: Curve(r, *XN, "x").error("Bhat_prime"), fitted=True)
            ),
            above(0.0, "too large", "mean of (B̂′ - C) sgn C / max |C| within 0.3 reference lengths")(
                per_geometry(fit_excess, fitted=True)
            ),
            _more_on_the_first,
        ),
        curve_panels([(*XN, line) for line in (BESIDE, THROUGH)], "Bhat", "Bhat_prime", fitted=True),
    ),
    Statement(
        13,
        "Without a fit, A_xn is better than B_xn and B̂_xn (both without curvature along x).",
        (
            below(1.0, "B", "error of A_xn over error of B_xn, off s = 0")(per_body(a_over_prismatic("B"))),
            below(1.0, "B̂", "error of A_xn over error of B̂_xn, off s = 0")(
                per_body(a_over_prismatic("Bhat"))
            ),
        ),
        side_by_side(_prismatic_panels),
        xn_errors,
    ),
)

# --- 8, 21: xn by a wheel's curvature along x -----------------------------------------------------------


def c_xn_through(results: Results) -> Array:
    """Return C_xn on s = 0, (n,), dimensionless."""
    return Curve(results, *XN, THROUGH).variant("C")


@above(1.0, "larger", "rms of C_xn on s = 0: Geometry 2 over Geometry 1")
def _larger(runs: Runs) -> Mapping[str, float]:
    first, second = (c_xn_rms(runs.geometry(name), line=THROUGH) for name in GEOMETRIES)
    return {"both": second / first}


@below(SMALL_PART, "curvature", "part of the difference that vanishes with a wheel that is not revolved")
def _by_curvature(runs: Runs) -> Mapping[str, float]:
    results = (*map(runs.geometry, GEOMETRIES), runs.not_revolved())
    first, second, prismatic = (c_xn_rms(each, line=THROUGH) for each in results)
    return {"both": abs((second - prismatic) / (second - first))}


def curvature_term(runs: Runs) -> Array:
    """Return -½ (A_xx + A_nn) sin α_x of the wheel on s = 0, (n,), dimensionless; α_x = -x / R_roll."""
    wheel = runs.geometry(GEOMETRIES[1])
    a_xx, a_nn = (Curve(wheel, CONCAVE, component, THROUGH).variant("A") for component in ("xx", "nn"))
    alpha = -find_line(wheel, THROUGH).x / wheel.scene.bodies[CONCAVE].surface.rolling_radius
    return np.asarray(-(a_xx + a_nn) * np.sin(alpha) / 2)


def curvature_change(runs: Runs) -> Array:
    """Return C_xn of Geometry 2 minus C_xn with a prismatic wheel, on s = 0, (n,), dimensionless."""
    return c_xn_through(runs.geometry(GEOMETRIES[1])) - c_xn_through(runs.not_revolved())


def terms_and_changes(runs: Runs) -> list[tuple[str, float, float]]:
    """Return the places, the terms of eq. (16) there, and the changes of C_xn by curvature along x."""
    x = find_line(runs.geometry(GEOMETRIES[1]), THROUGH).x
    term, change = (np.interp(PLACES, x, curve(runs)) for curve in (curvature_term, curvature_change))
    names = [f"x = {place:g} mm" for place in PLACES]
    return list(zip(names, term.tolist(), change.tolist(), strict=True))


@below(POOR, "size", "Geometry 2, s = 0: |term / (C_xn - C_xn not revolved) - 1|")
def _term_over_change(runs: Runs) -> Mapping[str, float]:
    return {place: abs(term / change - 1) for place, term, change in terms_and_changes(runs)}


def curvature_details(runs: Runs) -> Mapping[str, float]:
    """Return the terms and the changes at all places, dimensionless."""
    found = terms_and_changes(runs)
    return {f"-½ (A_xx + A_nn) sin α_x: {place}": term for place, term, _ in found} | {
        f"C_xn less C_xn not revolved: {place}": change for place, _, change in found
    }


def _geometry_panels(runs: Runs) -> list[Panel]:
    first, wheel = (Curve(runs.geometry(name), *XN, THROUGH) for name in GEOMETRIES)
    return [wheel.panel(more={"C, not revolved": c_xn_through(runs.not_revolved())}), first.panel()]


def _curvature_panels(runs: Runs) -> list[Panel]:
    wheel = runs.geometry(GEOMETRIES[1])
    x = find_line(wheel, THROUGH).x
    shown = x >= 0
    curves = {
        "C less C not revolved": curvature_change(runs)[shown],
        "term of eq. (16)": curvature_term(runs)[shown],
    }
    title = "geometry2, combined: xn by curvature along x"
    at = x[shown] / wheel.scene.reference_length
    return [Panel(title, "x / L  [-]", "IC · E · L  [-]", make_curves(at, curves))]


CURVATURE_STATEMENTS = (
    Statement(
        8,
        "C_xn is larger on Geometry 2; longitudinal curvature explains a small part of the difference.",
        (_larger, _by_curvature),
        _geometry_panels,
    ),
    Statement(
        21,
        "The term -½ (A_xx + A_nn) sin α_x of eq. (16) is the change of C_xn due to curvature along x.",
        (_term_over_change,),
        _curvature_panels,
        curvature_details,
        columns=1,
    ),
)

# --- 9, 10: sn, all on the line along s -----------------------------------------------------------------


def mean_deviation_from_a(results: Results, body: str) -> float:
    """Return the mean of (C - A) sgn A / max |A| of sn on the line along s, s > 0.

    The source draws each body in its own frame, in which A_sn of both bodies has the same sign; here A_sn of
    the lower and of the upper body have opposite signs.
    """
    positive = find_line(results, ACROSS).s > 0
    c, a = (Curve(results, body, "sn", ACROSS).variant(name)[positive] for name in ("C", "A"))
    return float(np.mean((c - a) * np.sign(a) / np.max(np.abs(a))))


def translation_share(results: Results) -> float:
    """Return the share of |C_sn - B-hat_sn|^2 that the best vertical translation of both bodies explains."""
    misfit = Curve(results, *SN, ACROSS).difference("Bhat")
    lean = np.sin(results.scene.bodies[CONVEX].contour.inclination(find_line(results, ACROSS).s))
    remainder = misfit - lean * (lean @ misfit) / (lean @ lean)
    return float(1 - (remainder @ remainder) / (misfit @ misfit))


def furthest_misfit(results: Results) -> float:
    """Return |s| of the largest |C_sn - B-hat_sn| on the line along s, over |s| of the joint."""
    misfit = np.abs(Curve(results, *SN, ACROSS).difference("Bhat"))
    return float(abs(find_line(results, ACROSS).s[np.argmax(misfit)]) / first_joint(results))


@above(1.0, "flank", "|s| of the largest |C_sn - B̂_sn| at x = 1.6 mm over |s| of the joint")
def _furthest(runs: Runs) -> Mapping[str, float]:
    return {GEOMETRIES[0]: furthest_misfit(runs.geometry(GEOMETRIES[0]))}


def error_within_arc(results: Results, variant: str) -> float:
    """Return the largest |v - C| of sn between the joints, as a share of max |C_sn| on all lines."""
    on_arc = np.abs(find_line(results, ACROSS).s) <= first_joint(results)
    deviation = Curve(results, *SN, ACROSS).difference(variant)
    return float(np.max(np.abs(deviation[on_arc])) / Curve(results, *SN).size("C"))


def first_joint(results: Results) -> float:
    """Return the smallest |s| [mm] of a joint of arc and flank of either body."""
    return min(abs(s) for body in results.scene.bodies.values() for s in body.contour.joints)


def ics_with_factor(results: Results, variant: str, body: str) -> Array:
    """Return B or B-hat [mm/N], (3, 3, n), from A with sn and ns times (pi - |alpha|) / pi.

    alpha is the angle between the normals of the observer and the load.
    """
    scene, points = results.scene, (results.points.x, results.points.s)
    total = np.zeros((3, 3, len(points[0])))
    for name in solved_parts(body):
        solid = getattr(scene.pair, name)
        a = HalfSpace(solid.constants).ics(scene.patch, points[0], points[1] - scene.patch.s)
        inclination = solid.surface.contour.inclination
        alpha = np.abs(inclination(points[1]) - inclination(scene.patch.s))
        a[[S, N], [N, S]] *= (np.pi - alpha) / np.pi
        total += FORMS[variant].rotate(a, rotation_between(solid.surface, points, scene.patch.s))
    return total / scene.patch.area


def errors_with_factor(runs: Runs) -> Mapping[str, float]:
    """Return the error of sn with the factor over the error without it, of each body alone.

    Where both bodies are equal, the combined A_sn cancels, and the factor with it.
    """
    ratios = {}
    for variant, name, body in product(WITH_FACTOR, GEOMETRIES, ALONE):
        curve = Curve(runs.geometry(name), body, "sn")
        with_factor = curve.error(ics_with_factor(curve.results, variant, body))
        ratios[f"error with over without: {name}, {body}, {variant}"] = with_factor / curve.error(variant)
    return ratios


@below(0.75, "gain", "share of cases (bodies alone) in which the error of sn falls by a tenth")
def _gain(runs: Runs) -> Mapping[str, float]:
    return {"all": float(np.mean([ratio <= GAIN for ratio in errors_with_factor(runs).values()]))}


def _sn_panels(runs: Runs) -> list[Panel]:
    combined = curve_panels([(*SN, ACROSS)], "A", "B", "Bhat", "Bhat_prime", fitted=True)
    alone = curve_panels([(body, "sn", ACROSS) for body in ALONE], "A", "B", "Bhat", fitted=True)
    return [*combined(runs), *alone(runs)]


def _factor_panels(results: Results) -> Iterator[Panel]:
    for body in ALONE:
        curve = Curve(results, body, "sn", ACROSS)
        more = {
            f"{ics_symbol(variant)} with the factor": curve.values(ics_with_factor(results, variant, body))
            for variant in WITH_FACTOR
        }
        yield curve.panel("B", "Bhat", more=more)


SN_STATEMENTS = (
    Statement(
        9,
        "Along s, C_sn lies well below A for the convex body and above A for the concave body. B_sn is "
        "better than B̂_sn, B̂′_sn is the least accurate, and C_sn is captured within the arc. Much of "
        "C_sn - B̂_sn is a vertical translation. On Geometry 1 the largest difference lies beyond the "
        "joint of arc and flank.",
        (
            below(-POOR, "convex", "mean of (C - A) sgn A / max |A| at x = 1.6 mm, s > 0, convex body")(
                per_geometry(lambda r: mean_deviation_from_a(r, CONVEX))
            ),
            above(0.0, "concave", "the same, concave body")(
                per_geometry(lambda r: mean_deviation_from_a(r, CONCAVE))
            ),
            below(1.0, "B", "error of B_sn over error of B̂_sn at x = 1.6 mm")(
                per_geometry(error_ratio("B", "Bhat", "sn", ACROSS))
            ),
            above(1.0, "B̂′", "error of B̂′_sn over error of B̂_sn at x = 1.6 mm")(
                per_geometry(error_ratio("Bhat_prime", "Bhat", "sn", ACROSS), fitted=True)
            ),
            below(FOLLOWS, "arc", "largest |B_sn - C_sn| at x = 1.6 mm up to the joint, of max |C_sn|")(
                per_geometry(lambda r: error_within_arc(r, "B"))
            ),
            above(
                MUCH,
                "translation",
                "part of |C_sn - B̂_sn|² at x = 1.6 mm that a vertical translation explains",
            )(per_geometry(translation_share)),
            _furthest,
        ),
        _sn_panels,
    ),
    Statement(
        10,
        "The factor (π - |α|) / π on A_sn gives no consistent improvement.",
        (_gain,),
        side_by_side(_factor_panels),
        errors_with_factor,
    ),
)

STATEMENTS = (*XN_STATEMENTS, *CURVATURE_STATEMENTS, *SN_STATEMENTS)
