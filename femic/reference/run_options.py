"""Options for solving models: workers, the store, and reports of progress."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from femic.cache.store import Store
from femic.reference.level import Level


@dataclass(frozen=True)
class Task:
    """A model of a job to be solved, and its largest size."""

    job: str
    level: Level
    request: Any  # the request of the engine that solves it
    most_unknowns: int


@dataclass(frozen=True)
class Solved:
    """A solved model of a job; `cached` if an earlier run had solved it."""

    task: Task
    model: Any  # input of the engine's `displacements`
    cached: bool


@dataclass(frozen=True)
class Step:
    """The stage of a model that is being solved, with its numbers of solved and expected wavenumbers."""

    task: Task
    stage: str
    wavenumbers: int = 0
    expected: int | None = None


def _ignored(_: object) -> None:
    """Ignore a report."""


@dataclass(frozen=True)
class Watch:
    """Callbacks for progress: the next models, each finished model, stages, and steps."""

    on_round: Callable[[Sequence[Task]], None] = _ignored
    on_model: Callable[[Solved], None] = _ignored
    on_stage: Callable[[str], None] = _ignored
    on_step: Callable[[Step], None] = _ignored  # within a model


SILENT = Watch()


def cores() -> int:
    """Return the number of processor cores."""
    return os.cpu_count() or 1


@dataclass(frozen=True)
class RunOptions:
    """How models are solved: the number of parallel workers, the store of models, reports of progress.

    By default there is one worker per core, and nothing is stored or reported.
    """

    workers: int = field(default_factory=cores)
    store: Store = field(default_factory=Store)
    watch: Watch = SILENT


DEFAULT = RunOptions()
