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

        Otherwise it depends. It is not decided if nothing could be measured.
        """
        if self.failed:
            return NOT_DECIDED
        met = [criterion.met(value) for criterion, _, value in self.numbers]
        if all(met):
            return REPRODUCED
        return DEPENDS if any(met) else NOT_REPRODUCED

    @property
    def numbers(self) -> Iterator[tuple[Criterion, str, float]]:
        """Each criterion with each of its cases and values; empty if nothing could be measured."""
        for criterion in self.statement.criteria:
            for case, value in self.values.get(criterion.name, {}).items():
                yield criterion, case, value

    @property
    def unmet(self) -> list[tuple[Criterion, str, float]]:
        """The criteria, cases and values that are not met."""
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
