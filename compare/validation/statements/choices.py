"""Statements 11 and 12: the effect of Poisson's ratio on the comparison, and whether the mix is best."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import product

import numpy as np

from compare.report.charts import Panel
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import SATISFACTORY, Numbers, Statement, per_body
from compare.validation.statements.curves import ACROSS, BESIDE, BODIES, INDEPENDENT, Curve
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results, ics_of
from geometries.arrays import Array

COMPARED_VARIANTS = ("A", "B", "Bbar", "Bhat")


# --- 11 -------------------------------------------------------------------------------------------------


def error_change(at_own_nu: Results, at_other_nu: Results, body: str, component: str) -> float:
    """Return the largest change of the error of an approximation from one Poisson's ratio to the other."""
    first, second = (_errors(results, body, component) for results in (at_own_nu, at_other_nu))
    return float(np.max(np.abs(second - first)))


def regret(at_own_nu: Results, at_other_nu: Results, body: str, component: str) -> float:
    """Return error minus best error at the other Poisson's ratio, of the variant that is best at its own."""
    first, second = (_errors(results, body, component) for results in (at_own_nu, at_other_nu))
    return float(second[np.argmin(first)] - np.min(second))


def _errors(results: Results, body: str, component: str) -> Array:
    return np.array([Curve(results, body, component).error(variant) for variant in COMPARED_VARIANTS])


def with_other_nu(number: Callable[[Results, Results, str, str], float]) -> Numbers:
    """Measure a number of each geometry at its own and the other Poisson's ratio, by body and component."""
    return Numbers(
        lambda runs: {
            f"{name}, {body}, {component}": number(runs.geometry(name), runs.other_nu(name), body, component)
            for name, body, component in product(GEOMETRIES, BODIES, INDEPENDENT)
        }
    )


def _both_nu(runs: Runs) -> list[Panel]:
    """Return panels of C and B at both Poisson's ratios."""
    panels = []
    for name in GEOMETRIES:
        at_own_nu, at_other_nu = runs.geometry(name), runs.other_nu(name)
        for place in (("combined", "nn", BESIDE), ("combined", "xn", BESIDE), ("lower", "sn", ACROSS)):
            other = Curve(at_other_nu, *place)
            more = {f"{variant}, other ν": other.variant(variant) for variant in ("C", "B")}
            panels.append(Curve(at_own_nu, *place).panel("B", more=more))
    return panels


# --- 12 -------------------------------------------------------------------------------------------------


def mix_over_best(results: Results, body: str, pooled: Callable[[Array], float]) -> float:
    """Return the pooled error of the components of the mix over the same of the best single variant."""
    errors = _variant_errors(results, body)
    single = [pooled(variant_errors) for variant, variant_errors in errors.items() if variant != "mix"]
    return float(pooled(errors["mix"]) / min(single))


def _variant_errors(results: Results, body: str) -> dict[str, Array]:
    """Return errors (6,) [-] of the components, by variant, of all variants that exist for a body."""
    return {
        variant: np.array([Curve(results, body, component).error(variant) for component in INDEPENDENT])
        for variant in results.scene.variants
        if not np.any(np.isnan(ics_of(results, variant, body)))
    }


def mean_errors(runs: Runs) -> Mapping[str, float]:
    """Return the mean error over the components of every variant, by geometry and body."""
    return {
        f"mean error of {symbol_of(variant)}: {name}, {body}": float(np.mean(variant_errors))
        for name, body in product(GEOMETRIES, BODIES)
        for variant, variant_errors in _variant_errors(runs.fitted(name), body).items()
    }


def _mix(runs: Runs) -> list[Panel]:
    fitted = runs.fitted(GEOMETRIES[0])
    lines = {component: BESIDE if component in ("xx", "xn") else ACROSS for component in INDEPENDENT}
    return [Curve(fitted, "combined", c, line).panel("Bhat", "mix") for c, line in lines.items()]


STATEMENTS = (
    Statement(
        11,
        "ν = 0.28 or 0.30 makes no difference that matters to the comparison.",
        (
            with_other_nu(error_change).below(
                SATISFACTORY, "change", "largest change of the error of A, B, B̄ or B̂ with ν"
            ),
            with_other_nu(regret).below(
                SATISFACTORY,
                "order",
                "error of the variant that is best at this ν, minus the best error, at the other ν",
            ),
        ),
        _both_nu,
        columns=3,
    ),
    Statement(
        12,
        "The mix beats each single variant.",
        (
            per_body(partial(mix_over_best, pooled=np.max), fitted=True).below(
                1.0, "worst", "worst error of a component: mix over the best single variant"
            ),
            per_body(partial(mix_over_best, pooled=np.mean), fitted=True).below(
                1.0, "mean", "mean error over the components: likewise"
            ),
        ),
        _mix,
        mean_errors,
        columns=3,
    ),
)
