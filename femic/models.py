"""What the engines take and give: observers, raw displacements, and what they cost."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from resource import RUSAGE_SELF, getrusage
from typing import Literal

from geometries.arrays import Array, Indices

SolverChoice = Literal["auto", "multigrid", "direct"]  # of the solid engine

BASE_MEMORY = 200.0  # MB, of a process that has not done anything yet


@dataclass(frozen=True)
class Points:
    """Observers on the contact surface: x and arc length s [mm], shape (n,) each."""

    x: Array
    s: Array


@dataclass(frozen=True)
class Cost:
    """What a model took: iterations per field, worst residual, seconds per stage, memory in MB.

    `peak_memory` is the largest that the process has had so far.
    """

    unknowns: int
    cells: int
    solver: str
    iterations: tuple[int, ...]  # 0 for the direct solver
    residual: float
    seconds: dict[str, float]
    peak_memory: float


@dataclass(frozen=True)
class Planned:
    """What a model will take.

    `wavenumbers` are those of the harmonic engine, `fields` the right-hand sides that are solved, `memory` is
    the peak [MB].
    """

    unknowns: int
    wavenumbers: int
    fields: int
    half_section: bool
    seconds: float
    memory: float


@dataclass(frozen=True)
class RawICs:
    """Displacements per unit total load [mm/N] with clamped far boundaries, before any discount.

    `u` has shape (n_loads, 3, n_points): local components x, s, n at each observer. `perturbed` are what `u`
    would be with something less, for estimates of its error, where the engine can tell at little cost.
    `drawn`: vertices (2, n) and triangles (3, m) of the section that was solved, to be looked at.
    """

    u: Array
    cost: Cost
    perturbed: Mapping[str, Array] = field(default_factory=dict)
    drawn: tuple[Array, Indices] | None = None


def peak_memory() -> float:
    """Largest memory that this process has had so far [MB]."""
    return getrusage(RUSAGE_SELF).ru_maxrss / 1024


def cost_from(text: str) -> Cost:
    """The cost that was written as JSON."""
    values = json.loads(text)
    return Cost(**values | {"iterations": tuple(values["iterations"])})
