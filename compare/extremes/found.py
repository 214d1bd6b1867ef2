"""What is found at the ends of what may be asked for."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

ANALYTIC, HARMONIC, SOLID = "analytic", "harmonic", "solid"


def available() -> bool:
    """Whether what draws cases and computes in many digits is installed."""
    return all(find_spec(name) is not None for name in ("hypothesis", "mpmath"))


@dataclass(frozen=True)
class Reached:
    """A case within the limits; errors and estimates are shares, `estimate` None of what has none.

    `exact`: against what the error was measured.
    """

    at: str
    error: float
    estimate: float | None
    exact: str
    seconds: float

    @property
    def honest(self) -> bool:
        """Whether the estimate is at least the error."""
        return self.estimate is None or self.error <= self.estimate


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


def tried(parameters: Sequence[Parameter], say: Callable[[str], None]) -> Iterator[Found]:
    """Try all cases of all parameters."""
    for parameter in parameters:
        reached = []
        for case in parameter.reached:
            reached.append(case())
            one = reached[-1]
            known = "" if one.estimate is None else f", estimate {one.estimate:.1e}"
            text = f"  {parameter.engine}: {parameter.name}: {one.at}: error {one.error:.1e}{known}"
            say(f"{text}, {one.seconds:.1f} s")
        yield Found(parameter, tuple(reached), tuple(case() for case in parameter.beyond))
