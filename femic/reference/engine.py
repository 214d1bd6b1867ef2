"""Engines: ways to compute the displacements of loaded bodies, with their input, output and properties.

An engine is a folder with one record of the type `Engine`; `femic.reference.engines` lists them. All that
depends on the engine reads its record, which says what the engine can do: ICs at points in any case, IC
matrices and displacement fields where the record has functions for them.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from typing import Any, Literal, Protocol

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
    """The input of a model; engines add fields of their own. In x, points are relative to each load."""

    body: Body  # with its domain
    loads: tuple[Load, ...]  # unit total loads
    points: Points
    cells: Cells


@dataclass(frozen=True)
class Specification(Request):
    """A model to be solved, from which an engine makes its request.

    `tolerance` is the one of the job, and `least_scale` [mm/N] the smallest scale that it refers to: a number
    or an array (load, 1, observer). `waves` counts the refinements of the wavenumbers. `solver` is the linear
    solver of the solid engine.
    """

    tolerance: float
    least_scale: Array | float
    waves: int
    solver: SolverChoice


@dataclass(frozen=True)
class MatrixSpecification(Specification):
    """A model to be solved for an IC matrix, with loads on all strips of a grid.

    M is fitted to loads on `fit_patches`. Spare loads and arc lengths are among the others, but serve only
    later grids, which have wider strips. With `given_domain` the far arc is a support of the body, and not
    the approximation of a body without end.
    """

    fit_patches: tuple[Patch, ...]
    spare_loads: tuple[Load, ...]
    spare_s: tuple[float, ...]
    given_domain: bool


# --- the record of an engine ---


@dataclass(frozen=True)
class TunedCells:
    """The first model: cells that meet a tolerance on the built-in scenes."""

    tolerance: float
    cells: Callable[[Patch], Cells]
    coarsest: float  # largest factor on these cells, for large tolerances

    def cells_for(self, tolerance: float, patch: Patch) -> Cells:
        """Return cells that are likely to meet a tolerance: errors are assumed to fall like its cube."""
        return self.cells(patch).scaled(min((tolerance / self.tolerance) ** (1 / MESH_ORDER), self.coarsest))

    def tighter(self, tolerance: float) -> float:
        """Return the factor by which a tolerance is tighter than the tuned one, at least 1."""
        return max(1.0, self.tolerance / tolerance)


@dataclass(frozen=True)
class Limits:
    """The range in which an engine has been shown to be accurate."""

    nu: float  # largest Poisson's ratio
    aspect: float  # largest a / b and b / a of the patch
    rolling_radius: float  # smallest rolling radius [mm]
    inclination: float  # largest inclination of a contour [degrees]
    distance: float  # largest distance of points from the load, in least half-sides of the patch


@dataclass(frozen=True)
class ErrorEstimate:
    """How an engine estimates the error of its ICs, and what smaller cells cost."""

    models: tuple[str, ...]  # the models of `run_options.MODELS` that give C and its error
    safety: float  # factor on the part of the estimate that comes from the mesh
    growth_of_unknowns: float  # measured exponent of 1 / cell size

    def model_names(self, body: Body) -> tuple[str, ...]:
        """Return the models for a body: one in a smaller domain only where a domain truncates it."""
        return tuple(name for name in self.models if name != "small" or body.truncated)


@dataclass(frozen=True)
class Models:
    """The functions that solve the models of an engine, from specification to displacements."""

    request: Callable[[Specification], Any]  # the engine's own `Request`
    solve: Callable[[Sequence[Task], RunOptions], Iterator[Solved]]  # in any order
    key: Callable[[Any, Store], str]  # of the model of a request in a store
    displacements: Callable[[Any, Any], RawICs]  # from a request and its solved model
    expected_cost: Callable[[Any, int], ExpectedCost]  # expected cost of a request with a number of workers


class ColumnSynthesis(Protocol):
    """The way from the solved model of a grid to the columns of its IC matrix."""

    def column(self, strip: int) -> Array:
        """Return displacements [mm/N] due to unit total loads on a strip, shape (3, 3, n_x, n_s)."""


class GridModel(Protocol):
    """The solved model of a grid."""

    @property
    def body(self) -> Body:
        """The body with the domain of the model."""

    @property
    def cost(self) -> Cost:
        """The cost of the model."""


@dataclass(frozen=True)
class Matrices:
    """How an engine computes the IC matrix of a grid: one model serves all strips.

    `columns` gives a synthesis of the components for the model ("") and for each less accurate variation of
    it, by name, as `RawICs.perturbed`. `far_radius` [mm] is likely to meet a tolerance on a grid.
    """

    tuned: TunedCells  # cells on strips
    far_radius: Callable[[float, Grid], float]
    request: Callable[[MatrixSpecification], Any]
    columns: Callable[[Any, Grid, Sequence[str]], Mapping[str, ColumnSynthesis]]
    displacements: Callable[[Any, Sequence[Load], Points], RawICs]


@dataclass(frozen=True)
class Fields:
    """How an engine gives displacements and stresses in the whole body: functions of a request."""

    mesh: Callable[[Any], Any]  # a `SolidMesh`
    nodal: Callable[[Any], Iterator[tuple[Load, Any]]]  # a `NodalField` per load


@dataclass(frozen=True)
class Comparison:
    """How an engine appears where engines are compared: its tolerances, loose to tight, and its marks.

    `options` returns the further keys of the table `engine` of a scene file that are tried at each tolerance.
    """

    tolerances: tuple[float, ...] = (1e-1, 1e-2)
    options: Callable[[], Sequence[Mapping[str, str]]] = lambda: ({},)
    colour: str = "tab:green"
    marker: str = "D"

    def __post_init__(self) -> None:
        """Raise ValueError unless there are tolerances, from loose to tight."""
        if not self.tolerances or list(self.tolerances) != sorted(self.tolerances, reverse=True):
            raise ValueError(f"tolerances = {self.tolerances}: at least one, from loose to tight")


@dataclass(frozen=True, eq=False)
class Engine:
    """A way to compute C."""

    name: str
    description: str  # one line
    limits: Limits
    tuned: TunedCells
    far_radius: Callable[[float], float]  # radius [mm] of the far arc that is likely to meet a tolerance
    least_side: Callable[[Patch], float]  # half-side [mm] of a patch that cells must resolve
    infinite_length: bool  # whether prismatic bodies have no ends along x
    solves_transposes: bool  # whether the loads of C_ji are solved with those of C_ij
    outlines: bool  # whether its cells follow the narrow parts of bodies with an outline
    shares_a_model: bool  # whether parallel workers share one model, or each solves another
    estimate: ErrorEstimate
    models: Models
    matrices: Matrices | None = None  # None: it has no IC matrices
    fields: Fields | None = None  # None: it has no fields in 3D
    comparison: Comparison = Comparison()
