"""Input and output of the engines: observers, raw displacements, and costs."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from typing import Literal

from geometries.arrays import Array, Indices

SolverChoice = Literal["auto", "multigrid", "direct"]  # of the solid engine

STATE = Path("/proc/self/status")
BASE_MEMORY = 200.0  # MB, of a process before it has a model


@dataclass(frozen=True)
class Points:
    """Observers on the contact surface: x and arc length s [mm], shape (n,) each."""

    x: Array
    s: Array


@dataclass(frozen=True)
class Cost:
    """The cost of a model: iterations per field, worst residual, seconds per stage, memory [MB].

    `peak_memory` is the peak of the process so far, and of those that solved the model for it.
    """

    unknowns: int
    cells: int
    solver: str
    iterations: tuple[int, ...]  # 0 for the direct solver
    residual: float
    seconds: dict[str, float]
    peak_memory: float


@dataclass(frozen=True)
class ExpectedCost:
    """The expected cost of a model.

    `wavenumbers` is 0 except for the harmonic engine, `fields` counts the right-hand sides, `memory` is the
    peak [MB].
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

    `u` has shape (n_loads, 3, n_points): local components x, s, n at each observer. `perturbed` has less
    accurate `u`, by name, to estimate the error of `u`, where the engine can give them at little cost.
    `drawn` are vertices (2, n) [mm] and triangles (3, m) of the section mesh, for pictures.
    """

    u: Array
    cost: Cost
    perturbed: Mapping[str, Array] = field(default_factory=dict)
    drawn: tuple[Array, Indices] | None = None


def peak_memory() -> float:
    """Return the peak memory of this process so far [MB].

    Most Linux systems say it in a file of its state. Elsewhere it is not less than the peak of the process
    that started this one.
    """
    state = STATE.read_bytes() if STATE.exists() else b""
    found = re.search(rb"VmHWM:\s+(\d+) kB", state)
    return (float(found[1]) if found else getrusage(RUSAGE_SELF).ru_maxrss) / 1024


def cost_from(text: str) -> Cost:
    """Return a cost from its JSON text."""
    values = json.loads(text)
    return Cost(**values | {"iterations": tuple(values["iterations"])})
