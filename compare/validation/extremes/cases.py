"""Cases at and beyond the limits of parameters, and their results."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Literal, get_args

import numpy as np

from femic.scenes.load import in_keys
from geometries.errors import Failure, WrongInput

ANALYTIC, HARMONIC, SOLID = "analytic", "harmonic", "solid"
CONTACT, FRICTION = "contact", "friction"
Part = Literal["analytic", "harmonic", "solid", "contact", "friction"]
PARTS: tuple[Part, ...] = get_args(Part)


def available() -> bool:
    """Whether hypothesis and mpmath are installed, which draw cases and provide many digits."""
    return all(find_spec(name) is not None for name in ("hypothesis", "mpmath"))


@dataclass(frozen=True)
class WithinLimit:
    """A case within the limits, under the label `at`, with its largest error and its largest estimate.

    Errors and estimates are shares [-]; `used` is the largest error over its own estimate, of any component
    on any line. `estimate` and `used` are None without estimates. `exact` says what errors were measured
    against, `note` has further facts, or the reason why the case failed.
    """

    at: str
    error: float
    estimate: float | None
    used: float | None
    exact: str
    seconds: float
    note: str = ""

    @property
    def finished(self) -> bool:
        """Whether the case was computed."""
        return bool(np.isfinite(self.error))

    @property
    def honest(self) -> bool:
        """Whether every estimate is at least as large as its error."""
        return self.used is None or self.used <= 1


@dataclass(frozen=True)
class BeyondLimit:
    """A case beyond the limits, under the label `at`, with the program's message, or an empty text.

    `computed`: it is computed all the same, and the text has its error. `failed`: it is not refused, but
    fails on the way, and the text says why.
    """

    at: str
    says: str
    computed: bool = False
    failed: bool = False


@dataclass(frozen=True)
class Limit:
    """A parameter of a part with its range, and functions that run cases within and beyond it.

    `engine` is the name of the part: of the analytic ICs, an engine, or contact without or with friction.
    """

    engine: str
    name: str
    range: str
    reached: Sequence[Callable[[], WithinLimit]]
    beyond: Sequence[Callable[[], BeyondLimit]] = ()


@dataclass(frozen=True)
class LimitResult:
    """A limit with the results of its cases."""

    limit: Limit
    reached: tuple[WithinLimit, ...]
    beyond: tuple[BeyondLimit, ...]

    @property
    def worst(self) -> WithinLimit:
        """The case with the largest error."""
        return max(self.reached, key=lambda case: case.error)


def refusal(
    label: str, call: Callable[[], object], also: tuple[type[Failure], ...] = ()
) -> Callable[[], BeyondLimit]:
    """Return a case that makes a call beyond the limits; its text is the last line of the error message.

    Input is refused before any work. What shows on the way only is refused by the failures `also`; any other
    failure is one of the case.
    """

    def case() -> BeyondLimit:
        try:
            call()
        except WrongInput as error:
            return BeyondLimit(label, _last_line(str(error)))
        except Failure as error:
            return BeyondLimit(label, _last_line(in_keys(error)), failed=not _is_of(error, also))
        return BeyondLimit(label, "")

    return case


def _last_line(message: str) -> str:
    return message.rsplit("\n", maxsplit=1)[-1].strip()


def _is_of(error: BaseException | None, kinds: tuple[type[Failure], ...]) -> bool:
    """Whether a failure is of some kinds; a plain `Failure` is of the kind that it was raised in place of."""
    while type(error) is Failure:
        error = error.__context__
    return isinstance(error, kinds)


def _result(case: Callable[[], WithinLimit]) -> WithinLimit:
    """Run a case; if it fails, the result has infinite errors and the program's message."""
    try:
        return case()
    except Failure as error:
        return WithinLimit("failed", np.inf, None, np.inf, "", 0.0, in_keys(error))


def results_of(limits: Sequence[Limit], report: Callable[[str], None]) -> Iterator[LimitResult]:
    """Run all cases of all limits, report each, and yield the results limit by limit."""
    for limit in limits:
        reached = []
        for case in limit.reached:
            reached.append(_result(case))
            last = reached[-1]
            estimate_text = "" if last.estimate is None else f", estimate {last.estimate:.1e}"
            text = f"  {limit.engine}: {limit.name}: {last.at}: error {last.error:.1e}{estimate_text}"
            report(f"{text}, {last.seconds:.1f} s")
        yield LimitResult(limit, tuple(reached), tuple(case() for case in limit.beyond))
