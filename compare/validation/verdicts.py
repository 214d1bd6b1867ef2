"""From numbers to verdicts: each statement with the criteria that it meets, and in which cases."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from compare.validation import coupling, direct, program
from compare.validation.criteria import STATEMENTS, Criterion, Statement
from compare.validation.curves import Measured
from compare.validation.runs import Runs
from geometries.errors import Failure, WrongInput

REPRODUCED, NOT_REPRODUCED, DEPENDS = "reproduced", "not reproduced", "depends"
NOT_DECIDED = "not decided"

MEASURES: Mapping[int, Callable[[Runs], Measured]] = {
    1: direct.nn_follows,
    2: direct.xx_is_alike,
    3: direct.ss_falls_faster,
    4: direct.xs_of_bodies,
    5: direct.bodies_cancel_or_add,
    6: coupling.xn_of_bodies,
    7: coupling.xn_of_fit,
    8: coupling.xn_of_geometries,
    9: coupling.sn_of_bodies,
    10: coupling.factor_of_the_cylinder,
    11: program.nu_matters,
    12: program.mix_is_best,
    13: coupling.xn_without_fit,
    14: program.engines_agree,
    15: program.limits,
}


@dataclass(frozen=True)
class Judged:
    """A statement with its numbers."""

    number: int
    statement: Statement
    measured: Measured
    failed: str = ""  # why nothing could be measured

    @property
    def verdict(self) -> str:
        """Reproduced if every criterion is met in every case, not if none is in any; else it depends."""
        if self.failed:
            return NOT_DECIDED
        met = [criterion.met(value) for criterion, _, value in self.numbers]
        if all(met):
            return REPRODUCED
        return DEPENDS if any(met) else NOT_REPRODUCED

    @property
    def numbers(self) -> Iterator[tuple[Criterion, str, float]]:
        """Every criterion, case and value."""
        for criterion in () if self.failed else self.statement.criteria:
            for case, value in self.measured.values[criterion.name].items():
                yield criterion, case, value

    @property
    def unmet(self) -> list[tuple[Criterion, str, float]]:
        """Where it fails."""
        return [
            (criterion, case, value) for criterion, case, value in self.numbers if not criterion.met(value)
        ]


def judge(number: int, runs: Runs) -> Judged:
    """Measure a statement, and judge it; not decided where C cannot be had."""
    statement = STATEMENTS[number]
    try:
        measured = MEASURES[number](runs)
    except Failure as error:
        return Judged(number, statement, Measured({}), str(error))
    missing = {criterion.name for criterion in statement.criteria} ^ set(measured.values)
    assert not missing, f"statement {number}: {missing}"
    return Judged(number, statement, measured)


def chosen(only: Iterable[int] | None) -> tuple[int, ...]:
    """The statements asked for, all by default; raises WrongInput for others."""
    asked = tuple(dict.fromkeys(only)) if only is not None else tuple(STATEMENTS)
    unknown = [number for number in asked if number not in STATEMENTS]
    if unknown or not asked:
        raise WrongInput(f"--only {' '.join(map(str, unknown)) or '?'}: give some of 1 to {len(STATEMENTS)}")
    return asked
