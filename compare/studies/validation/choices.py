"""Statements 11 and 12: what Poisson's ratio changes in the comparison, and whether the mix is best."""

from collections.abc import Callable, Mapping

import numpy as np

from compare.pages.panels import Panel
from compare.pages.styles import SYMBOLS
from compare.results.compute import Results, ics_of
from compare.studies.validation.criteria import SATISFACTORY, Criterion, Numbers, Statement, of_bodies
from compare.studies.validation.curves import BODIES, SHOWN, along, curve, error, panel
from compare.studies.validation.runs import GEOMETRIES, Runs
from geometries.arrays import Array

COMPARED = ("A", "B", "Bbar", "Bhat")


# --- 11 -------------------------------------------------------------------------------------------------


def change_of_errors(one: Results, other: Results, body: str, component: str) -> float:
    """Largest change of an approximation's error with Poisson's ratio."""
    first, second = (_errors(results, body, component) for results in (one, other))
    return float(np.max(np.abs(second - first)))


def regret(one: Results, other: Results, body: str, component: str) -> float:
    """How much worse, at the other Poisson's ratio, what is best at this one is than what is best there."""
    first, second = (_errors(results, body, component) for results in (one, other))
    return float(second[np.argmin(first)] - np.min(second))


def _errors(results: Results, body: str, component: str) -> Array:
    return np.array([error(results, variant, body, component) for variant in COMPARED])


def with_other_nu(number: Callable[[Results, Results, str, str], float]) -> Numbers:
    """A number of each geometry at its own Poisson's ratio and the other's, by body and component."""
    return lambda runs: {
        f"{name}, {body}, {component}": number(runs.geometry(name), runs.other_nu(name), body, component)
        for name in GEOMETRIES
        for body in BODIES
        for component in SHOWN
    }


def _both_nu(runs: Runs) -> list[Panel]:
    """C and B, and the same with the other Poisson's ratio."""
    panels = []
    for name in GEOMETRIES:
        one, other = runs.geometry(name), runs.other_nu(name)
        for body, component in (("combined", "nn"), ("combined", "xn"), ("lower", "sn")):
            line = along(one, "s" if component == "sn" else "x")[0]
            more = {
                f"{variant}, other ν": curve(other, variant, body, component, [line])
                for variant in ("C", "B")
            }
            panels.append(panel(one, ("B",), (body, component), line, more))
    return panels


# --- 12 -------------------------------------------------------------------------------------------------


def worst_of_mix(results: Results, body: str) -> float:
    """Worst error of a component: of the mix over that of the best single variant."""
    return _mix_over_best(results, body, np.max)


def mean_of_mix(results: Results, body: str) -> float:
    """Mean error over the components: likewise."""
    return _mix_over_best(results, body, np.mean)


def _mix_over_best(results: Results, body: str, pooled: Callable[[Array], float]) -> float:
    errors = _errors_of_variants(results, body)
    single = [pooled(of) for variant, of in errors.items() if variant != "mix"]
    return float(pooled(errors["mix"]) / min(single))


def _errors_of_variants(results: Results, body: str) -> dict[str, Array]:
    """Errors of the components (6,) of every variant that there is for a body."""
    return {
        variant: np.array([error(results, variant, body, component) for component in SHOWN])
        for variant in results.scene.variants
        if not np.any(np.isnan(ics_of(results, variant, body)))
    }


def mean_errors(runs: Runs) -> Mapping[str, float]:
    """Of every variant."""
    return {
        f"mean error of {SYMBOLS[variant]}: {name}, {body}": float(np.mean(of))
        for name in GEOMETRIES
        for body in BODIES
        for variant, of in _errors_of_variants(runs.fitted(name), body).items()
    }


def _mix(runs: Runs) -> list[Panel]:
    of = runs.fitted(GEOMETRIES[0])
    return [
        panel(of, ("Bhat", "mix"), ("combined", c), along(of, "x" if c in ("xx", "xn") else "s")[0])
        for c in SHOWN
    ]


STATEMENTS = (
    Statement(
        11,
        "ν = 0.28 or 0.30 makes no difference that matters to the comparison.",
        (
            Criterion(
                "change",
                "largest change of the error of A, B, B̄ or B̂ with ν",
                "<",
                SATISFACTORY,
                with_other_nu(change_of_errors),
            ),
            Criterion(
                "order",
                "error of what is best at this ν, at the other one, less the best error there",
                "<",
                SATISFACTORY,
                with_other_nu(regret),
            ),
        ),
        _both_nu,
        columns=3,
    ),
    Statement(
        12,
        "The mix beats each single variant.",
        (
            Criterion(
                "worst",
                "worst error of a component: mix over the best single variant",
                "<",
                1.0,
                of_bodies(worst_of_mix, fitted=True),
            ),
            Criterion(
                "mean",
                "mean error over the components: likewise",
                "<",
                1.0,
                of_bodies(mean_of_mix, fitted=True),
            ),
        ),
        _mix,
        mean_errors,
        columns=3,
    ),
)
