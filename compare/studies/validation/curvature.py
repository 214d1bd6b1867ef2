"""Statements 8 and 21: what a wheel's curvature along x does to the longitudinal displacement."""

from collections.abc import Mapping

import numpy as np

from compare.pages.panels import Panel
from compare.results.compute import Results
from compare.studies.validation.criteria import POOR, SMALL_PART, Criterion, Statement
from compare.studies.validation.curves import CONCAVE, THROUGH, curve, line_of, panel, rms
from compare.studies.validation.runs import GEOMETRIES, Runs
from geometries.arrays import Array

XN = ("combined", "xn")
PLACES = {"8 mm": 8.0, "16 mm": 16.0}  # x where eq. (16) is compared


def second_over_first(runs: Runs) -> Mapping[str, float]:
    """Rms of C_xn on s = 0: Geometry 2 over Geometry 1."""
    first, second = (_rms_through(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": second / first}


def part_of_curvature(runs: Runs) -> Mapping[str, float]:
    """The part of the difference between the geometries that is gone with a wheel that is not revolved."""
    first, second = (_rms_through(runs.geometry(name)) for name in GEOMETRIES)
    return {"both": abs((second - _rms_through(runs.not_revolved())) / (second - first))}


def _rms_through(results: Results) -> float:
    return rms(curve(results, "C", *XN, [line_of(results, THROUGH)]))


def term_over_change(runs: Runs) -> Mapping[str, float]:
    """How far the term of eq. (16) is from what curvature along x changes, as a share of the change."""
    return {f"x = {name}": abs(term / change - 1) for name, (term, change) in _at_places(runs).items()}


def terms_and_changes(runs: Runs) -> Mapping[str, float]:
    """Both numbers, dimensionless."""
    both = _at_places(runs)
    terms = {f"-½ (A_xx + A_nn) sin α_x: x = {name}": term for name, (term, _) in both.items()}
    return terms | {f"C_xn less C_xn not revolved: x = {name}": change for name, (_, change) in both.items()}


def _at_places(runs: Runs) -> dict[str, tuple[float, float]]:
    x = line_of(runs.geometry(GEOMETRIES[1]), THROUGH).x
    term, change = _term(runs), _change(runs)
    return {
        name: (float(np.interp(at, x, term)), float(np.interp(at, x, change))) for name, at in PLACES.items()
    }


def _term(runs: Runs) -> Array:
    """-½ (A_xx + A_nn) sin α_x of the wheel, α_x = -x / R_roll, on s = 0."""
    wheel = runs.geometry(GEOMETRIES[1])
    line = line_of(wheel, THROUGH)
    a_xx, a_nn = (curve(wheel, "A", CONCAVE, component, [line]) for component in ("xx", "nn"))
    alpha = -line.x / wheel.scene.bodies[CONCAVE].surface.rolling_radius
    return np.asarray(-(a_xx + a_nn) * np.sin(alpha) / 2)


def _change(runs: Runs) -> Array:
    """C_xn of Geometry 2 less that of the same with a wheel that is not revolved, on s = 0."""
    both = runs.geometry(GEOMETRIES[1]), runs.not_revolved()
    revolved, prismatic = (curve(results, "C", *XN, [line_of(results, THROUGH)]) for results in both)
    return revolved - prismatic


def _of_geometries(runs: Runs) -> list[Panel]:
    first, wheel = (runs.geometry(name) for name in GEOMETRIES)
    line = line_of(wheel, THROUGH)
    more = {"C, not revolved": curve(runs.not_revolved(), "C", *XN, [line])}
    return [panel(wheel, (), XN, line, more), panel(first, (), XN, line_of(first, THROUGH))]


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
            Criterion(
                "larger", "rms of C_xn on s = 0: Geometry 2 over Geometry 1", ">", 1.0, second_over_first
            ),
            Criterion(
                "curvature",
                "part of the difference that is gone with a wheel that is not revolved",
                "<",
                SMALL_PART,
                part_of_curvature,
            ),
        ),
        _of_geometries,
    ),
    Statement(
        21,
        "The term -½ (A_xx + A_nn) sin α_x of eq. (16) is what curvature along x changes in C_xn.",
        (
            Criterion(
                "size",
                "Geometry 2, s = 0: |term / (C_xn - C_xn not revolved) - 1|",
                "<",
                POOR,
                term_over_change,
            ),
        ),
        _curvature,
        terms_and_changes,
        columns=1,
    ),
)
