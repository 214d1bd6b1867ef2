"""Cases at and beyond the limits of parameters, and what was found in them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from femic.scenes.messages import in_keys
from geometries.errors import Failure, WrongInput

ANALYTIC, HARMONIC, SOLID = "analytic", "harmonic", "solid"


def available() -> bool:
    """Whether hypothesis and mpmath are installed, which draw cases and compute in many digits."""
    return all(find_spec(name) is not None for name in ("hypothesis", "mpmath"))


@dataclass(frozen=True)
class Reached:
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
    def honest(self) -> bool:
        """Whether every estimate is at least as large as its error."""
        return self.used is None or self.used <= 1


@dataclass(frozen=True)
class Beyond:
    """A case beyond the limits, under the label `at`, with the program's message; empty if there is none."""

    at: str
    says: str


@dataclass(frozen=True)
class Parameter:
    """A parameter of an engine with its range, and functions that try cases within and beyond it."""

    engine: str
    name: str
    range: str
    reached: Sequence[Callable[[], Reached]]
    beyond: Sequence[Callable[[], Beyond]] = ()


@dataclass(frozen=True)
class Found:
    """A parameter with the results of its cases."""

    parameter: Parameter
    reached: tuple[Reached, ...]
    beyond: tuple[Beyond, ...]

    @property
    def worst(self) -> Reached:
        """The case with the largest error."""
        return max(self.reached, key=lambda case: case.error)


def refused(label: str, call: Callable[[], object]) -> Callable[[], Beyond]:
    """A case beyond the limits that makes a call, with the last line of the message that refuses it."""

    def case() -> Beyond:
        try:
            call()
        except WrongInput as error:
            return Beyond(label, str(error).split("\n")[-1].strip())
        return Beyond(label, "")

    return case


def _caught(case: Callable[[], Reached]) -> Reached:
    """Try a case; if it fails, the result has infinite errors and the program's message."""
    try:
        return case()
    except Failure as error:
        return Reached("failed", np.inf, None, np.inf, "", 0.0, in_keys(error))


def tried(parameters: Sequence[Parameter], say: Callable[[str], None]) -> Iterator[Found]:
    """Try all cases of all parameters, say each result, and yield the parameters with them."""
    for parameter in parameters:
        reached = []
        for case in parameter.reached:
            reached.append(_caught(case))
            last = reached[-1]
            estimate_text = "" if last.estimate is None else f", estimate {last.estimate:.1e}"
            text = f"  {parameter.engine}: {parameter.name}: {last.at}: error {last.error:.1e}{estimate_text}"
            say(f"{text}, {last.seconds:.1f} s")
        yield Found(parameter, tuple(reached), tuple(case() for case in parameter.beyond))
