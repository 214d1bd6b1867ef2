"""Differences between the C of two engines, and whether they are within the sum of the estimates."""

from collections.abc import Iterator
from dataclasses import dataclass

from compare.ics.compute import Results
from compare.ics.errors import engine_differences, measure_of
from femic.ic_errors.error_measure import ROUNDING
from femic.reference.accuracy import component_of


@dataclass(frozen=True)
class Agreement:
    """Differences of C of a body on a line, in words; `within`: all are within the estimates."""

    body: str
    line: str
    largest: str
    closest: str  # to the sum of the estimates
    within: bool


def agreement(results: Results) -> Iterator[Agreement]:
    """Yield differences between C of both engines; nothing where only one ran."""
    for body in results.scene.compared if results.checks else ():
        differences, allowed = engine_differences(results, body)
        vanishing = measure_of(results, body).vanishing
        marks = {c: " †" if component_of(vanishing, c) else "" for c in results.scene.components}
        for line in results.lines:
            both = {c: tuple(component_of(of[line], c) for of in (differences, allowed)) for c in marks}
            closest = max(both, key=lambda c: both[c][0] / max(both[c][1], ROUNDING))
            largest = max(both, key=lambda c: (not marks[c], both[c][0]))
            yield Agreement(
                body,
                line,
                f"{both[largest][0]:.2%} ({largest}{marks[largest]})",
                f"{closest}{marks[closest]}: {both[closest][0]:.2%} of {both[closest][1]:.2%}",
                all(difference <= max(estimate, ROUNDING) for difference, estimate in both.values()),
            )
