"""Statements and the criteria that decide them: numbers with thresholds, measured in several cases.

Modules of this package define statements, grouped by component; `registry` lists all of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

from compare.report.charts import Panel
from compare.validation.statements.contact_series import estimate_of
from compare.validation.statements.curves import BODIES
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results

FOLLOWS = 0.10  # largest error of a curve that follows another one
POOR = 0.20  # smallest error of a poor curve
SATISFACTORY = 0.05  # largest error that is fully satisfactory
SMALL_PART = 1 / 3
MUCH = 1 / 2

CLOSE = 0.002  # of the threshold, or of 1 if that is 0: C, accurate to 0.001, cannot decide closer numbers

Measure = Callable[[Runs], Mapping[str, float]]  # of a number in all of its cases; some are `Estimated`


@dataclass(frozen=True)
class Criterion:
    """A number and its threshold; the criterion is met or not in each case."""

    name: str
    description: str
    relation: Literal["<", ">"]
    threshold: float
    measure: Measure

    def met(self, value: float) -> bool:
        """Whether a value is on the right side of the threshold; a value that is NaN is not."""
        return bool(value < self.threshold if self.relation == "<" else value > self.threshold)

    def close(self, value: float) -> bool:
        """Whether a value is so close to the threshold that its accuracy does not suffice to decide.

        It is known to its estimated error, if it has one, and not better than C.
        """
        accuracy = max(CLOSE * (abs(self.threshold) or 1.0), estimate_of(value))
        return bool(abs(value - self.threshold) <= accuracy)


@dataclass(frozen=True)
class Numbers:
    """A number in all of its cases; with a threshold, a name and a description it is a criterion."""

    measure: Measure

    def __call__(self, runs: Runs) -> Mapping[str, float]:
        """Measure the number in all of its cases."""
        return self.measure(runs)

    def below(self, threshold: float, name: str, description: str) -> Criterion:
        """Return the criterion that the number is smaller than a threshold."""
        return Criterion(name, description, "<", threshold, self.measure)

    def above(self, threshold: float, name: str, description: str) -> Criterion:
        """Return the criterion that the number is larger than a threshold."""
        return Criterion(name, description, ">", threshold, self.measure)


@dataclass(frozen=True)
class Statement:
    """A claim with the criteria that decide it, and panels that illustrate it in a number of columns.

    `details` measures numbers that explain the statement and decide nothing.
    """

    number: int
    claim: str
    criteria: tuple[Criterion, ...]
    panels: Callable[[Runs], Sequence[Panel]]
    details: Measure = lambda _: {}
    columns: int = 2  # one for each geometry


def per_geometry(number: Callable[..., float], *choices: Sequence[str], fitted: bool = False) -> Numbers:
    """Measure a number of each geometry for each combination of `choices`: bodies, lines or components.

    With `fitted` the results include B-hat-prime.
    """
    return Numbers(
        lambda runs: {
            ", ".join((name, *choice)): number(_results(runs, name, fitted), *choice)
            for name, *choice in product(GEOMETRIES, *choices)
        }
    )


def per_body(
    number: Callable[[Results, str], float], bodies: Sequence[str] = BODIES, *, fitted: bool = False
) -> Numbers:
    """Measure a number of each geometry and body."""
    return per_geometry(number, bodies, fitted=fitted)


def second_minus_first(number: Callable[[Results], float], *, fitted: bool = False) -> Numbers:
    """Measure a number of Geometry 2 minus the same of Geometry 1."""
    first, second = GEOMETRIES

    def difference(runs: Runs) -> Mapping[str, float]:
        values = per_geometry(number, fitted=fitted)(runs)
        return {"both": values[second] - values[first]}

    return Numbers(difference)


def side_by_side(
    panels_of: Callable[[Results], Sequence[Panel]], *, fitted: bool = False
) -> Callable[[Runs], list[Panel]]:
    """Make panels of both geometries, side by side."""

    def panels(runs: Runs) -> list[Panel]:
        columns = [panels_of(_results(runs, name, fitted)) for name in GEOMETRIES]
        return [panel for row in zip(*columns, strict=True) for panel in row]

    return panels


def _results(runs: Runs, name: str, fitted: bool) -> Results:
    return runs.fitted(name) if fitted else runs.geometry(name)
