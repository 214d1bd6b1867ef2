"""How far the C of two engines differ, and whether that is within the sum of their estimates."""

from collections.abc import Iterator
from dataclasses import dataclass

from compare.ics.compute import Results
from compare.ics.error_measure import ROUNDING
from compare.ics.errors import apart, measure_of
from femic.reference.accuracy import component_of

Differences = dict[str, tuple[float, float]]  # difference and allowed difference by component


@dataclass(frozen=True)
class Agreement:
    """Differences of C of a body on a line, in words; `within`: all are within the estimates."""

    body: str
    line: str
    largest: str
    closest: str  # to the sum of the estimates
    within: bool


def agreement(results: Results) -> Iterator[Agreement]:
    """Yield how far C of both engines differ; nothing where one engine ran."""
    for body in results.scene.compared if results.checks else ():
        differences, allowed = apart(results, body)
        gone = measure_of(results, body).vanishing
        vanishing = [c for c in results.scene.components if component_of(gone, c)]
        for line in results.lines:
            yield _on_line(
                body,
                line,
                {
                    c: (component_of(differences[line], c), component_of(allowed[line], c))
                    for c in results.scene.components
                },
                vanishing,
            )


def _on_line(body: str, line: str, differences: Differences, vanishing: list[str]) -> Agreement:
    closest = max(differences, key=lambda c: differences[c][0] / max(differences[c][1], ROUNDING))
    largest = max(differences, key=lambda c: (c not in vanishing, differences[c][0]))
    marked = {c: f"{c} †" if c in vanishing else c for c in differences}
    return Agreement(
        body,
        line,
        f"{differences[largest][0]:.2%} ({marked[largest]})",
        "{}: {:.2%} of {:.2%}".format(marked[closest], *differences[closest]),
        all(difference <= max(estimate, ROUNDING) for difference, estimate in differences.values()),
    )
