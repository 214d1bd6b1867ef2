"""Verdicts of statements: which criteria are met in which cases, and the verdict that follows."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from compare.report.charts import Panel
from femic.scenes.messages import in_keys
from femic.validation.statements.criteria import Criterion, Statement
from femic.validation.statements.registry import STATEMENTS
from femic.validation.statements.runs import Runs
from geometries.errors import Failure, WrongInput

REPRODUCED, NOT_REPRODUCED, DEPENDS = "reproduced", "not reproduced", "depends"
NOT_DECIDED = "not decided"


@dataclass(frozen=True)
class Finding:
    """A statement with its numbers by criterion and case, panels and further numbers, and its verdict."""

    statement: Statement
    values: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    panels: Sequence[Panel] = ()
    details: Mapping[str, float] = field(default_factory=dict)
    failed: str = ""  # why nothing could be measured

    @property
    def verdict(self) -> str:
        """Reproduced if every criterion is met in every case, not reproduced if none is met in any case.

        Otherwise it depends. Cases whose numbers are too close to the threshold to tell do not count; a
        statement of which nothing, or no case of some criterion, can be told is not decided, unless it
        depends anyway.
        """
        told = {
            name: [criterion.met(value) for criterion, _, value in self.decided if criterion.name == name]
            for name in self.values
        }
        met = [is_met for by_case in told.values() for is_met in by_case]
        if any(met) and not all(met):
            return DEPENDS
        if self.failed or not all(told.values()):
            return NOT_DECIDED
        return REPRODUCED if all(met) else NOT_REPRODUCED

    @property
    def numbers(self) -> Iterator[tuple[Criterion, str, float]]:
        """Each criterion with each of its cases and values; empty if nothing could be measured."""
        for criterion in self.statement.criteria:
            for case, value in self.values.get(criterion.name, {}).items():
                yield criterion, case, value

    @property
    def decided(self) -> list[tuple[Criterion, str, float]]:
        """The criteria, cases and values that are not too close to the threshold to tell."""
        return [
            (criterion, case, value) for criterion, case, value in self.numbers if not criterion.close(value)
        ]

    @property
    def unmet(self) -> list[tuple[Criterion, str, float]]:
        """The criteria, cases and values that are not met, those too close to tell included."""
        return [
            (criterion, case, value) for criterion, case, value in self.numbers if not criterion.met(value)
        ]


def assess(number: int, runs: Runs) -> Finding:
    """Measure the numbers of a statement and decide it; it is not decided if C cannot be computed."""
    statement = STATEMENTS[number]
    try:
        values = {criterion.name: criterion.measure(runs) for criterion in statement.criteria}
        return Finding(statement, values, statement.panels(runs), statement.details(runs))
    except Failure as error:
        return Finding(statement, failed=in_keys(error))


def selection(only: Iterable[int] | None) -> tuple[int, ...]:
    """Return the numbers of the selected statements, by default all; raises WrongInput for unknown ones."""
    numbers = tuple(dict.fromkeys(only)) if only is not None else tuple(STATEMENTS)
    unknown = [number for number in numbers if number not in STATEMENTS]
    if unknown or not numbers:
        raise WrongInput(f"--only {' '.join(map(str, unknown)) or '?'}: give some of 1 to {max(STATEMENTS)}")
    return numbers
