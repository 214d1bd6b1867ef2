"""What there is to solve models with, and who hears of it."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from femic.level import Level
from femic.work.store import Store


@dataclass(frozen=True)
class Task:
    """A model of a job that is to be solved, and how large it may be."""

    job: str
    level: Level
    request: Any  # of the engine that solves it
    most_unknowns: int


@dataclass(frozen=True)
class Solved:
    """A solved model of a job; `kept` if an earlier run had solved it."""

    task: Task
    model: Any  # what the engine's `displacements` reads
    kept: bool


@dataclass(frozen=True)
class Step:
    """What a model that is being solved is at; how many wavenumbers it has, and may need."""

    task: Task
    stage: str
    wavenumbers: int = 0
    expected: int | None = None


def _ignored(_: object) -> None:
    """Nobody wants to hear of it."""


@dataclass(frozen=True)
class Watch:
    """Who wants to hear of the progress: which models come next, each finished one, and what follows."""

    on_round: Callable[[Sequence[Task]], None] = _ignored
    on_model: Callable[[Solved], None] = _ignored
    on_stage: Callable[[str], None] = _ignored
    on_step: Callable[[Step], None] = _ignored  # within a model


SILENT = Watch()


def cores() -> int:
    """How many there are."""
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Means:
    """How models are solved: parallel workers, a store that keeps them, who is told.

    By default one worker per core; nothing is kept or told.
    """

    workers: int = field(default_factory=cores)
    store: Store = field(default_factory=Store)
    watch: Watch = SILENT


DEFAULT = Means()
