"""Statement 25: whether the estimates of contacts bound their errors."""

from collections.abc import Mapping, Sequence

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.validation.estimates import STUDIES, GridComparison, by_regime, coverage
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.runs import Runs
from geometries.arrays import Array

HELD = 0.95  # least share of errors that are within their estimates
USEFUL = 10.0  # largest median of estimate over error
COUNTS = {"frictionless": 200, "rolling": 200, "differences": 100, "frictionless differences": 100}
SEED = 7  # of the random contacts of each study; no share of an estimate was found with them
SHOWN = ("p_max", "approach", "area", "F_x", "F_y", "sliding_share")  # numbers that are drawn
FACTORS = (0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35, 1.5)


def coverage_by_number(study: str) -> Numbers:
    """Measure the share of random contacts whose error is within its estimate, by number."""

    def measure(runs: Runs) -> Mapping[str, float]:
        comparisons = runs.random_contacts(study, SEED, COUNTS[study])
        return {f"{study}, {name}": coverage(comparisons, name).held for name in comparisons[0].numbers}

    return Numbers(measure)


def width_by_number(study: str) -> Numbers:
    """Measure the median of estimate over error of random contacts, by number."""

    def measure(runs: Runs) -> Mapping[str, float]:
        comparisons = runs.random_contacts(study, SEED, COUNTS[study])
        return {f"{study}, {name}": coverage(comparisons, name).median for name in _with_errors(comparisons)}

    return Numbers(measure)


def _details(runs: Runs) -> Mapping[str, float]:
    """Return the worst ratio of error to estimate, and the median ratio of estimate to error, by number."""
    details: dict[str, float] = {}
    for study in STUDIES:
        comparisons = runs.random_contacts(study, SEED, COUNTS[study])
        for name in _with_errors(comparisons):
            cover = coverage(comparisons, name)
            details[f"{study}, {name}: worst error over estimate"] = cover.worst
            details[f"{study}, {name}: median of estimate over error"] = cover.median
            for regime, those in by_regime(comparisons).items():
                details[f"{study}, {name}: held, {regime} ({len(those)})"] = coverage(those, name).held
    return details


def _with_errors(comparisons: Sequence[GridComparison]) -> list[str]:
    """Return the names of computed numbers; given ones have no errors."""
    return [name for name in comparisons[0].numbers if np.isfinite(coverage(comparisons, name).median)]


def _panels(runs: Runs) -> list[Panel]:
    """Return the share of contacts whose error is at most a multiple of its estimate, over the multiple."""
    return [_panel(study, runs.random_contacts(study, SEED, COUNTS[study])) for study in STUDIES]


def _panel(study: str, comparisons: Sequence[GridComparison]) -> Panel:
    held = {name: _held_by_factor(comparisons, name) for name in SHOWN}
    return Panel(
        f"{study}, {len(comparisons)} random contacts",
        "multiple of the estimate [-]",
        "share of contacts with an error below [-]",
        curves_of(FACTORS, held),
        marks=(1.0,),
    )


def _held_by_factor(comparisons: Sequence[GridComparison], name: str) -> Array:
    """Return the share of contacts whose error is at most a multiple of its estimate; NaN without errors."""
    if name not in comparisons[0].numbers:
        return np.full(len(FACTORS), np.nan)
    return np.array([coverage(comparisons, name, factor=factor).held for factor in FACTORS])


STATEMENTS = (
    Statement(
        25,
        "In contacts with A and the B family, the error of a number, and of its difference between two ICs, "
        "is within its estimate nineteen times out of twenty or more, and half of the estimates are at most "
        "ten times the error.",
        (
            *(
                coverage_by_number(study).above(
                    HELD,
                    f"held {study}",
                    f"share of {COUNTS[study]} random contacts, {study}, whose error is within its estimate",
                )
                for study in STUDIES
            ),
            *(
                width_by_number(study).below(
                    USEFUL,
                    f"width {study}",
                    f"median of estimate over error of {COUNTS[study]} random contacts, {study}",
                )
                for study in STUDIES
            ),
        ),
        _panels,
        _details,
    ),
)
