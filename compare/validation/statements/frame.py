"""The frame of all statements: numbers with estimated errors, criteria that decide, and verdicts.

A statement is a claim with criteria; a criterion is a threshold for a number that is measured in several
cases; the verdict follows from which criteria are met in which cases.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np

from compare.report.charts import Panel
from compare.report.verdicts import NOT_DECIDED

FOLLOWS = 0.10  # largest error of a curve that follows another one
POOR = 0.20  # smallest error of a poor curve
SATISFACTORY = 0.05  # largest error that is fully satisfactory
SMALL_PART = 1 / 3
MUCH = 1 / 2

CLOSE = 0.002  # of the threshold, or of 1 if that is 0: C, accurate to 0.001, cannot decide closer numbers


class Estimated(float):
    """A number with its estimated error; wherever the error does not matter, it is the number."""

    estimate: float

    def __new__(cls, value: float, estimate: float) -> Self:
        """Return a number with its estimated error, which is infinite where it is not known (NaN)."""
        number = super().__new__(cls, value)
        number.estimate = np.inf if np.isnan(estimate) else abs(estimate)
        return number

    def __abs__(self) -> "Estimated":
        return Estimated(super().__abs__(), self.estimate)


def estimated_error(value: float) -> float:
    """Return the estimated error of a number, 0 if it has none."""
    return value.estimate if isinstance(value, Estimated) else 0.0


def ratio(one: float, other: float) -> float:
    """Return a ratio of distances; infinite where the other is 0 and this is not, NaN where both are.

    Its estimated error is the most that those of both can make of it; infinite where the other may be 0.
    """
    if other == 0.0:
        return np.nan if one == 0.0 else np.inf
    if not (estimated_error(one) or estimated_error(other)):
        return one / other
    least = abs(other) - estimated_error(other)
    largest = (abs(one) + estimated_error(one)) / least if least > 0 else np.inf
    return Estimated(one / other, largest - abs(one / other))


# --- criteria and statements ----------------------------------------------------------------------------


Values = Mapping[str, float]  # a number in all of its cases
Measure = Callable[[Any], Values]  # from `runs.Runs`


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
        accuracy = max(CLOSE * (abs(self.threshold) or 1.0), estimated_error(value))
        return bool(abs(value - self.threshold) <= accuracy)


def below(threshold: float, name: str, description: str) -> Callable[[Measure], Criterion]:
    """Make what a function measures a criterion: it is smaller than a threshold in every case."""
    return lambda measure: Criterion(name, description, "<", threshold, measure)


def above(threshold: float, name: str, description: str) -> Callable[[Measure], Criterion]:
    """Make what a function measures a criterion: it is larger than a threshold in every case."""
    return lambda measure: Criterion(name, description, ">", threshold, measure)


def labelled(label: str, measure: Measure) -> Measure:
    """Measure a number with a label before each of its cases."""
    return lambda runs: {f"{label}: {case}": value for case, value in measure(runs).items()}


@dataclass(frozen=True)
class Statement:
    """A claim with the criteria that decide it, and panels that illustrate it in a number of columns.

    `details` measures numbers that explain the statement and decide nothing.
    """

    number: int
    claim: str
    criteria: Sequence[Criterion]
    panels: Callable[[Any], Iterable[Panel]]
    details: Measure = lambda _: {}
    columns: int = 2  # one for each geometry


# --- verdicts -------------------------------------------------------------------------------------------


REPRODUCED, NOT_REPRODUCED, DEPENDS = "reproduced", "not reproduced", "depends"


def find_verdict(statement: Statement, values: Mapping[str, Values]) -> str:
    """Return the verdict on a statement, from the values of its criteria by name and case.

    Reproduced if every criterion is met in every case, not reproduced if none is met in any case; otherwise
    it depends. Cases whose numbers are too close to the threshold to tell do not count; a statement is not
    decided, unless it depends anyway, where for some criterion these are more than the others.
    """
    known = [criterion for criterion in statement.criteria if criterion.name in values]
    told = [
        [criterion.met(value) for value in values[criterion.name].values() if not criterion.close(value)]
        for criterion in known
    ]
    met = [is_met for by_case in told for is_met in by_case]
    if any(met) and not all(met):
        return DEPENDS
    if not met or any(
        2 * len(by_case) < len(values[criterion.name]) for criterion, by_case in zip(known, told, strict=True)
    ):
        return NOT_DECIDED
    return REPRODUCED if all(met) else NOT_REPRODUCED
