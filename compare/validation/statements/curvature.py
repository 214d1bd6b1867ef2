"""Statements 8 and 21: the effect of a wheel's curvature along x on the longitudinal displacement."""

from collections.abc import Mapping

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.validation.statements.criteria import POOR, SMALL_PART, Numbers, Statement
from compare.validation.statements.curves import CONCAVE, THROUGH, Curve, line_of, rms
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results
from geometries.arrays import Array

XN = ("combined", "xn")
PLACES = (8.0, 16.0)  # x [mm] at which eq. (16) is compared


def second_over_first(runs: Runs) -> Mapping[str, float]:
    """Return the rms of C_xn on s = 0: Geometry 2 over Geometry 1."""
    first, second = (_rms_through(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": second / first}


def curvature_share(runs: Runs) -> Mapping[str, float]:
    """Return the share of the difference between the geometries that vanishes with a prismatic wheel."""
    first, second = (_rms_through(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": abs((second - _rms_through(runs.not_revolved())) / (second - first))}


def _rms_through(results: Results) -> float:
    return rms(_c_through(results))


def _c_through(results: Results) -> Array:
    """Return C_xn on s = 0, (n,), dimensionless."""
    return Curve(results, *XN, THROUGH).variant("C")


def term_over_change(runs: Runs) -> Mapping[str, float]:
    """Return |term / change - 1| at each place: term of eq. (16), change of C_xn by curvature along x."""
    terms, changes = _at_places(runs, _term(runs)), _at_places(runs, _change(runs))
    return {place: abs(term / changes[place] - 1) for place, term in terms.items()}


def terms_and_changes(runs: Runs) -> Mapping[str, float]:
    """Return the terms and the changes at all places, dimensionless."""
    curves = {"-½ (A_xx + A_nn) sin α_x": _term(runs), "C_xn less C_xn not revolved": _change(runs)}
    return {
        f"{name}: {place}": value
        for name, values in curves.items()
        for place, value in _at_places(runs, values).items()
    }


def _at_places(runs: Runs, values: Array) -> dict[str, float]:
    x = line_of(runs.geometry(GEOMETRIES[1]), THROUGH).x
    return {f"x = {place:g} mm": float(np.interp(place, x, values)) for place in PLACES}


def _term(runs: Runs) -> Array:
    """Return -½ (A_xx + A_nn) sin α_x of the wheel on s = 0, (n,), dimensionless; α_x = -x / R_roll."""
    wheel = runs.geometry(GEOMETRIES[1])
    a_xx, a_nn = (Curve(wheel, CONCAVE, component, THROUGH).variant("A") for component in ("xx", "nn"))
    alpha = -line_of(wheel, THROUGH).x / wheel.scene.bodies[CONCAVE].surface.rolling_radius
    return np.asarray(-(a_xx + a_nn) * np.sin(alpha) / 2)


def _change(runs: Runs) -> Array:
    """Return C_xn of Geometry 2 minus C_xn with a prismatic wheel, on s = 0, (n,), dimensionless."""
    return _c_through(runs.geometry(GEOMETRIES[1])) - _c_through(runs.not_revolved())


def _geometry_panels(runs: Runs) -> list[Panel]:
    first, wheel = (Curve(runs.geometry(name), *XN, THROUGH) for name in GEOMETRIES)
    return [wheel.panel(more={"C, not revolved": _c_through(runs.not_revolved())}), first.panel()]


def _curvature(runs: Runs) -> list[Panel]:
    wheel = runs.geometry(GEOMETRIES[1])
    line = line_of(wheel, THROUGH)
    shown, length = line.x >= 0, wheel.scene.reference_length
    curves = {"C less C not revolved": _change(runs)[shown], "term of eq. (16)": _term(runs)[shown]}
    title = "geometry2, combined: xn by curvature along x"
    return [Panel(title, "x / L  [-]", "IC · E · L  [-]", curves_of(line.x[shown] / length, curves))]


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
