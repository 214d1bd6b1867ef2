"""Statements 8 and 21: the effect of a wheel's curvature along x on the longitudinal displacement."""

from collections.abc import Mapping

import numpy as np

from compare.ics.compute import Results
from compare.report.panels import Panel
from femic.validation.statements.criteria import POOR, SMALL_PART, Numbers, Statement
from femic.validation.statements.curves import CONCAVE, THROUGH, Curve, line_of, rms
from femic.validation.statements.runs import GEOMETRIES, Runs
from geometries.arrays import Array

XN = ("combined", "xn")
PLACES = {"8 mm": 8.0, "16 mm": 16.0}  # x [mm] at which eq. (16) is compared


def second_over_first(runs: Runs) -> Mapping[str, float]:
    """Return the rms of C_xn on s = 0: Geometry 2 over Geometry 1."""
    first, second = (_rms_through(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": second / first}


def curvature_share(runs: Runs) -> Mapping[str, float]:
    """Return the share of the difference between the geometries that vanishes with a prismatic wheel."""
    first, second = (_rms_through(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": abs((second - _rms_through(runs.not_revolved())) / (second - first))}


def _rms_through(results: Results) -> float:
    return rms(Curve(results, *XN, THROUGH).variant("C"))


def term_over_change(runs: Runs) -> Mapping[str, float]:
    """Return |term / change - 1| at each place: term of eq. (16), change of C_xn by curvature along x."""
    return {f"x = {name}": abs(term / change - 1) for name, (term, change) in _at_places(runs).items()}


def terms_and_changes(runs: Runs) -> Mapping[str, float]:
    """Return the terms and the changes at all places, dimensionless."""
    pairs = _at_places(runs)
    terms = {f"-½ (A_xx + A_nn) sin α_x: x = {name}": term for name, (term, _) in pairs.items()}
    return terms | {f"C_xn less C_xn not revolved: x = {name}": change for name, (_, change) in pairs.items()}


def _at_places(runs: Runs) -> dict[str, tuple[float, float]]:
    x = line_of(runs.geometry(GEOMETRIES[1]), THROUGH).x
    term, change = _term(runs), _change(runs)
    return {
        name: (float(np.interp(place, x, term)), float(np.interp(place, x, change)))
        for name, place in PLACES.items()
    }


def _term(runs: Runs) -> Array:
    """Return -½ (A_xx + A_nn) sin α_x of the wheel on s = 0, (n,), dimensionless; α_x = -x / R_roll."""
    wheel = runs.geometry(GEOMETRIES[1])
    a_xx, a_nn = (Curve(wheel, CONCAVE, component, THROUGH).variant("A") for component in ("xx", "nn"))
    alpha = -line_of(wheel, THROUGH).x / wheel.scene.bodies[CONCAVE].surface.rolling_radius
    return np.asarray(-(a_xx + a_nn) * np.sin(alpha) / 2)


def _change(runs: Runs) -> Array:
    """Return C_xn of Geometry 2 minus C_xn with a prismatic wheel, on s = 0, (n,), dimensionless."""
    revolved, prismatic = (
        Curve(results, *XN, THROUGH).variant("C")
        for results in (runs.geometry(GEOMETRIES[1]), runs.not_revolved())
    )
    return np.asarray(revolved - prismatic)


def _geometry_panels(runs: Runs) -> list[Panel]:
    first, wheel, prismatic = (
        Curve(results, *XN, THROUGH) for results in (*map(runs.geometry, GEOMETRIES), runs.not_revolved())
    )
    return [wheel.panel(more={"C, not revolved": prismatic.variant("C")}), first.panel()]


def _curvature(runs: Runs) -> list[Panel]:
    wheel = runs.geometry(GEOMETRIES[1])
    line = line_of(wheel, THROUGH)
    shown, length = line.x >= 0, wheel.scene.reference_length
    curves = {"C less C not revolved": _change(runs)[shown], "term of eq. (16)": _term(runs)[shown]}
    title = "geometry2, combined: xn by curvature along x"
    return [Panel(title, "x / L  [-]", line.x[shown] / length, "IC · E · L  [-]", curves)]


STATEMENTS = (
    Statement(
        8,
        "C_xn is larger on Geometry 2; longitudinal curvature explains a small part of it.",
        (
            Numbers(second_over_first).above(
                1.0, "larger", "rms of C_xn on s = 0: Geometry 2 over Geometry 1"
            ),
            Numbers(curvature_share).below(
                SMALL_PART,
                "curvature",
                "part of the difference that vanishes with a wheel that is not revolved",
            ),
        ),
        _geometry_panels,
    ),
    Statement(
        21,
        "The term -½ (A_xx + A_nn) sin α_x of eq. (16) is the change of C_xn due to curvature along x.",
        (
            Numbers(term_over_change).below(
                POOR, "size", "Geometry 2, s = 0: |term / (C_xn - C_xn not revolved) - 1|"
            ),
        ),
        _curvature,
        terms_and_changes,
        columns=1,
    ),
)
