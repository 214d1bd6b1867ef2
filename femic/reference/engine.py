"""Engines: ways to compute the displacements of loaded bodies, with their input and output.

An engine is a class derived from `Engine`, registered in `femic.reference.engines`. All that depends on the
engine asks its attributes what it can do.
"""

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from typing import Any, Literal

from femic.cache.store import Store
from femic.reference.meshing import Cells
from femic.reference.run_options import MESH_ORDER, RunOptions, Solved, Task
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.patches import Grid, Load, Patch

# --- input and output ---

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


@dataclass(frozen=True)
class Request:
    """A model to be solved: unit total loads on a body. In x, points are relative to each load.

    `solver` is the linear solver of the solid engine. The harmonic engine reads what follows: the `tolerance`
    of the job; the smallest scale [mm/N] that it refers to, a number or an array (load, 1, observer); the
    number of refinements of the wavenumbers.

    A model `on_strips` is for the IC matrix of a grid, with loads on all strips; M is fitted to loads on
    `fit_patches`. Spare loads and arc lengths are among the others, but serve only later grids, which have
    wider strips. With `given_domain` the far arc is a support of the body, and not the approximation of a
    body without end.
    """

    body: Body  # with its domain
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    solver: SolverChoice = "auto"
    tolerance: float = 0.01
    least_scale: Array | float = 0.0
    waves: int = 0
    on_strips: bool = False
    fit_patches: tuple[Patch, ...] = ()
    spare_loads: tuple[Load, ...] = ()
    spare_s: tuple[float, ...] = ()
    given_domain: bool = False


# --- engines ---


@dataclass(frozen=True)
class Limits:
    """The range in which an engine has been shown to be accurate."""

    nu: float  # largest Poisson's ratio
    aspect: float  # largest a / b and b / a of the patch
    rolling_radius: float  # smallest rolling radius [mm]
    inclination: float  # largest inclination of a contour [degrees]
    distance: float  # largest distance of points from the load, in least half-sides of the patch


class Engine(ABC):
    """A way to compute C. An engine has no state; its instance is a global variable, its name in capitals.

    `models` are those of `run_options.MODELS` that give C and its error, `safety` is the factor on the part
    of the estimate that comes from the mesh.
    """

    name: str
    description: str  # one line
    limits: Limits
    models: tuple[str, ...]
    safety: float
    growth_of_unknowns: float  # measured exponent of 1 / cell size
    infinite_length = False  # whether prismatic bodies have no ends along x
    solves_transposes = False  # whether the loads of C_ji are solved with those of C_ij
    follows_outlines = False  # whether its cells follow the narrow parts of bodies with an outline
    shares_a_model = False  # whether parallel workers share one model, or each solves another
    has_matrices = False  # whether it gives `columns` of IC matrices
    has_fields = False  # whether it gives a `mesh` and `nodal_fields` in 3D

    def __reduce__(self) -> str:
        """Pickle as the global variable that it is."""
        return self.name.upper()

    def models_for(self, body: Body) -> tuple[str, ...]:
        """Return the models for a body: one in a smaller domain only where a domain truncates it."""
        return tuple(name for name in self.models if name != "small" or body.truncated)

    # Accuracy: what is likely to meet a tolerance.

    @abstractmethod
    def least_side(self, patch: Patch) -> float:
        """Return the half-side [mm] of a patch that cells must resolve."""

    @abstractmethod
    def first_cells(self, tolerance: float, patch: Patch, *, on_strips: bool = False) -> Cells:
        """Return the cells of the first model, under a patch or on all strips of a grid."""

    @abstractmethod
    def far_radius(self, tolerance: float, grid: Grid | None = None) -> float:
        """Return the radius [mm] of the far arc, for single patches or for a grid."""

    # Models.

    def request(self, model: Request) -> Any:
        """Return the engine's own request, the argument of the functions below."""
        return model

    @abstractmethod
    def key(self, request: Any, store: Store) -> str:
        """Return the key of a model in a store."""

    @abstractmethod
    def expected_cost(self, request: Any, workers: int) -> ExpectedCost:
        """Return the cost of a model before it is solved."""

    @abstractmethod
    def solve(self, tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
        """Solve models, or take them from the store, and yield them in any order.

        Models are stored, so that an interrupted run of the same code does not solve them again.
        """

    @abstractmethod
    def displacements(self, solved: Any, loads: Sequence[Load], points: Points) -> RawICs:
        """Return displacements of a solved model: loads and points are those of its request, or some."""

    def columns(
        self, solved: Any, grid: Grid, components: Sequence[str]
    ) -> Mapping[str, Callable[[int], Array]]:
        """Return what computes columns of an IC matrix: of a model (""), and of its less accurate variations.

        These have the names of `RawICs.perturbed`. Each function returns displacements [mm/N] due to unit
        total loads on a strip, shape (3, 3, n_x, n_s).
        """
        raise NotImplementedError(self.name)

    def mesh(self, request: Any) -> Any:
        """Return the mesh of a model, a `SolidMesh`."""
        raise NotImplementedError(self.name)

    def nodal_fields(self, request: Any) -> Iterator[tuple[Load, Any]]:
        """Yield the loads of a model, with a `NodalField` each."""
        raise NotImplementedError(self.name)


def scale_cells(cells: Cells, tolerance: float, tuned: float, coarsest: float) -> Cells:
    """Return cells for a tolerance from those that meet a tuned one: errors are assumed to fall like h^3.

    They are at most `coarsest` times as large.
    """
    return cells.scaled(min((tolerance / tuned) ** (1 / MESH_ORDER), coarsest))
