"""What refinement asks of jobs and their results, whatever they are: at points, at the lags of a grid."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol, TypeVar

from femic.accuracy import Shares
from femic.harmonic.engine import HarmonicRequest
from femic.harmonic.synthesis import Responses
from femic.models import Cost, RawICs
from femic.reference import Engine, Level
from femic.solid.engine import Request


@dataclass(frozen=True)
class Assessed:
    """Estimated errors of the bodies; of their sum, where it is judged; of each in the sum."""

    own: Mapping[str, Shares]
    combined: Shares | None = None
    in_combined: Mapping[str, Shares] = field(default_factory=lambda: MappingProxyType({}))


class Limits(Protocol):
    """How accurate a job is to be and how large it may become."""

    @property
    def tolerance(self) -> float:
        """Estimated error that is good enough."""

    @property
    def most_unknowns(self) -> int:
        """Largest model."""

    @property
    def engine(self) -> Engine:
        """Which one solves it."""


class Refinable(Protocol):
    """A result that may be not accurate enough."""

    @property
    def level(self) -> Level:
        """How far it has been refined."""

    @property
    def models(self) -> Mapping[str, Cost]:
        """What its models took."""


Model = TypeVar("Model")
Found = TypeVar("Found", bound=Refinable)


class Problem(Protocol[Model, Found]):
    """Jobs that are solved together: how models are asked for, read, combined, and judged."""

    @property
    def jobs(self) -> Mapping[str, Limits]:
        """By body."""

    def request(self, name: str, level: Level) -> Request | HarmonicRequest:
        """The model of a job at a level."""

    def read(self, asked: Request | HarmonicRequest, model: RawICs | Responses) -> Model:
        """What is needed of a solved model."""

    def combine(self, name: str, level: Level, models: Mapping[Level, Model]) -> Found:
        """The result of a job at a level, with its estimate."""

    def assess(self, found: Mapping[str, Found]) -> Assessed:
        """How large the estimates are."""
