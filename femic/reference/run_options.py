"""Levels of refinement, the models to be solved at them, and how: workers, the store, reports of progress.

Errors of both engines are assumed to fall like h^3 and L^-2. Measured rates are h^3 for the solid engine, h^4
for the harmonic engine, and L^-2 for both (docs/theory/errors.md).
"""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from femic.cache.store import Store

# --- levels of refinement ---

COARSER = 1.5  # cell size of a step over cell size of the next
LARGER = 2.0  # domain size of a step over domain size of the previous one
HIGHER = 2.0  # largest wavenumber of a step over the previous one
MESH_ORDER, TRUNCATION_ORDER = 3, 2  # of the errors, in cell size and in 1 / domain size
WAVES_ORDER = 3  # of the error due to the largest wavenumber
MODELS = ("fine", "coarse", "small")  # models that give C and its error, the most expensive first


@dataclass(frozen=True)
class Level:
    """Numbers of steps by which a model is refined beyond the first model of its job."""

    cells: int = 0
    domain: int = 0
    waves: int = 0  # of the harmonic engine: each step has larger wavenumbers, and more of them

    def models(self, names: Iterable[str]) -> dict[str, "Level"]:
        """Return the levels of the models that give C at this level and its error, by name in `MODELS`."""
        coarse = replace(self, cells=self.cells - 1)
        level_of_model = {"fine": self, "coarse": coarse, "small": replace(coarse, domain=self.domain - 1)}
        return {name: level_of_model[name] for name in names}


def factors(level: Level) -> tuple[float, float]:
    """Return the sizes of cells and domain at a level, as multiples of the sizes in the job."""
    return COARSER**-level.cells, LARGER**level.domain


# --- models to be solved ---


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
    model: Any  # input of `Models.displacements` of the engine
    cached: bool


@dataclass(frozen=True)
class Step:
    """The stage of a model that is being solved, with its numbers of solved and expected wavenumbers."""

    task: Task
    stage: str
    wavenumbers: int = 0
    expected: int | None = None


# --- how they are solved ---


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
