"""What is found at the ends of what may be asked for."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from compare.scenes.messages import in_keys
from geometries.errors import Failure

ANALYTIC, HARMONIC, SOLID = "analytic", "harmonic", "solid"


def available() -> bool:
    """Whether what draws cases and computes in many digits is installed."""
    return all(find_spec(name) is not None for name in ("hypothesis", "mpmath"))


@dataclass(frozen=True)
class Reached:
    """A case within the limits: the largest error, and of what has estimates the largest and how they hold.

    Errors and estimates are shares; `used` is the largest error over its own estimate, of any component on
    any line. `exact`: against what errors were measured. `note`: more, or why the case failed.
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
        """Whether every estimate is at least the error."""
        return self.used is None or self.used <= 1


@dataclass(frozen=True)
class Beyond:
    """A case beyond the limits: what the program says; empty if it says nothing."""

    at: str
    says: str


@dataclass(frozen=True)
class Parameter:
    """A parameter of an engine: its range, and how cases within and beyond it are tried."""

    engine: str
    name: str
    range: str
    reached: Sequence[Callable[[], Reached]]
    beyond: Sequence[Callable[[], Beyond]] = ()


@dataclass(frozen=True)
class Found:
    """A parameter with what was found."""

    parameter: Parameter
    reached: tuple[Reached, ...]
    beyond: tuple[Beyond, ...]

    @property
    def worst(self) -> Reached:
        """The case of the largest error."""
        return max(self.reached, key=lambda case: case.error)

    @property
    def seconds(self) -> float:
        """Of its most expensive case."""
        return max(case.seconds for case in self.reached)


def _caught(case: Callable[[], Reached]) -> Reached:
    """A case; where it fails, what the program says."""
    try:
        return case()
    except Failure as error:
        return Reached("failed", np.inf, None, np.inf, "", 0.0, in_keys(error))


def tried(parameters: Sequence[Parameter], say: Callable[[str], None]) -> Iterator[Found]:
    """Try all cases of all parameters."""
    for parameter in parameters:
        reached = []
        for case in parameter.reached:
            reached.append(_caught(case))
            one = reached[-1]
            known = "" if one.estimate is None else f", estimate {one.estimate:.1e}"
            text = f"  {parameter.engine}: {parameter.name}: {one.at}: error {one.error:.1e}{known}"
            say(f"{text}, {one.seconds:.1f} s")
        yield Found(parameter, tuple(reached), tuple(case() for case in parameter.beyond))
