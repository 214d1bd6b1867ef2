"""What decides a statement: numbers with thresholds, and the cases in which each number is measured.

A statement keeps its claim, its criteria and their measures in one place; the modules of this package have
them, grouped by component, and `statements` has all of them in one table.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from compare.pages.panels import Panel
from compare.results.compute import Results
from compare.studies.validation.curves import BODIES, Measured
from compare.studies.validation.runs import GEOMETRIES, Runs

FOLLOWS = 0.10  # largest error with which a curve still follows another
POOR = 0.20  # error from which on it is poor
SATISFACTORY = 0.05  # largest error that is fully satisfactory
SMALL_PART = 1 / 3
MUCH = 1 / 2

CLOSE = 0.002  # of the threshold (of 1, where it is 0): a number that C, known to 0.001, cannot decide

Numbers = Callable[[Runs], Mapping[str, float]]  # of a number, by case


@dataclass(frozen=True)
class Criterion:
    """A number, how it is measured, and its threshold; it is met in a case (a geometry, a body) or not."""

    name: str
    says: str
    relation: Literal["<", ">"]
    threshold: float
    measure: Numbers

    def met(self, value: float) -> bool:
        """Whether a measured value is on the right side; never where it is not a number."""
        return bool(value < self.threshold if self.relation == "<" else value > self.threshold)

    def close(self, value: float) -> bool:
        """Whether a value is so close to the threshold that the accuracy of C cannot decide."""
        return abs(value - self.threshold) <= CLOSE * (abs(self.threshold) or 1.0)


@dataclass(frozen=True)
class Statement:
    """Something that is said, what decides it, and what to look at in so many columns.

    `details` has numbers that decide nothing and explain something.
    """

    number: int
    claim: str
    criteria: tuple[Criterion, ...]
    panels: Callable[[Runs], Sequence[Panel]]
    details: Numbers = lambda _: {}
    columns: int = 2  # one for each geometry

    def measured(self, runs: Runs) -> Measured:
        """All numbers and curves."""
        values = {criterion.name: criterion.measure(runs) for criterion in self.criteria}
        return Measured(values, tuple(self.panels(runs)), self.details(runs), self.columns)


def of_geometries(number: Callable[[Results], float], *, fitted: bool = False) -> Numbers:
    """A number of each geometry; `fitted`: with B-hat-prime."""
    return lambda runs: {name: number(_results(runs, name, fitted)) for name in GEOMETRIES}


def of_bodies(
    number: Callable[[Results, str], float], bodies: Sequence[str] = BODIES, *, fitted: bool = False
) -> Numbers:
    """A number of each geometry and body."""
    return lambda runs: {
        f"{name}, {body}": number(_results(runs, name, fitted), body)
        for name in GEOMETRIES
        for body in bodies
    }


def of_lines(number: Callable[[Results, str], float], lines: Sequence[str]) -> Numbers:
    """A number of each geometry and line."""
    return of_bodies(number, lines)


def of_components(number: Callable[[Results, str, str], float], components: Sequence[str]) -> Numbers:
    """A number of each geometry, body and component."""
    return lambda runs: {
        f"{name}, {body}, {component}": number(runs.geometry(name), body, component)
        for name in GEOMETRIES
        for body in BODIES
        for component in components
    }


def more_on_second(number: Callable[[Results], float], *, fitted: bool = False) -> Numbers:
    """A number of Geometry 2 less that of Geometry 1."""
    first, second = GEOMETRIES

    def difference(runs: Runs) -> Mapping[str, float]:
        of = of_geometries(number, fitted=fitted)(runs)
        return {"both": of[second] - of[first]}

    return difference


def on_both(
    drawn: Callable[[Results], Sequence[Panel]], *, fitted: bool = False
) -> Callable[[Runs], list[Panel]]:
    """Panels of both geometries side by side."""

    def panels(runs: Runs) -> list[Panel]:
        columns = [drawn(_results(runs, name, fitted)) for name in GEOMETRIES]
        return [panel for row in zip(*columns, strict=True) for panel in row]

    return panels


def _results(runs: Runs, name: str, fitted: bool) -> Results:
    return runs.fitted(name) if fitted else runs.geometry(name)
