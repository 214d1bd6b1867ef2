"""What an engine is: a way to compute displacements of loaded bodies, with all that is known about it.

An engine is a folder with one record of this type; `femic.engines` lists them. Everything that depends on
which engine computes C asks its record.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from femic.level import MESH_ORDER
from femic.means import Means, Solved, Task
from femic.meshing.cell_size import Cells
from femic.models import Planned, Points, RawICs, SolverChoice
from geometries.bodies import Body
from geometries.patches import Load, Patch


@dataclass(frozen=True)
class Specification:
    """A model that is to be solved: a body with its domain, loads, and points relative to each load in x.

    `tolerance` is that of the job, `least_scale` [mm/N] the least scale of refinement that it is a share of,
    `waves` the steps by which the wavenumbers are refined; `solver` is that of the solid engine.
    """

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    tolerance: float
    least_scale: float
    waves: int
    solver: SolverChoice


class Request(Protocol):
    """What an engine solves; it has more of its own."""

    @property
    def body(self) -> Body:
        """With its domain."""

    @property
    def loads(self) -> tuple[Load, ...]:
        """Unit total loads."""

    @property
    def points(self) -> Points:
        """Where displacements are read, relative to each load in x."""


@dataclass(frozen=True)
class Tuned:
    """A first model that meets a tolerance on the built-in scenes."""

    tolerance: float
    cells: Callable[[Patch], Cells]
    coarsest: float  # times these, however large the tolerance

    def cells_for(self, tolerance: float, patch: Patch) -> Cells:
        """Cells that are likely to meet a tolerance: errors fall like the cube of the cell size."""
        return self.cells(patch).scaled(min((tolerance / self.tolerance) ** (1 / MESH_ORDER), self.coarsest))

    def tighter(self, tolerance: float) -> float:
        """How much tighter a tolerance is, at least 1."""
        return max(1.0, self.tolerance / tolerance)


@dataclass(frozen=True)
class Limits:
    """As far as an engine has been shown to go."""

    nu: float  # largest Poisson's ratio
    aspect: float  # largest a / b of the patch, and b / a
    rolling_radius: float  # mm, least
    inclination: float  # degrees, largest of a contour
    distance: float  # of points from the load, in least half-sides of the patch


@dataclass(frozen=True, eq=False)
class Engine:
    """A way to compute C."""

    name: str
    describes: str  # it, in a line
    models: tuple[str, ...]  # of `level.MODELS`: those that give C and its error
    safety: float  # of the part of the estimate that comes from the mesh
    growth_of_unknowns: float  # exponent of 1 / cell size, measured
    tuned: Tuned
    far_radius: Callable[[float], float]  # mm, of the far arc, that is likely to meet a tolerance
    least_side: Callable[[Patch], float]  # mm, of a patch, that cells must resolve
    limits: Limits
    endless: bool  # whether prismatic bodies have no ends along x
    both_loads: bool  # whether the loads of C_ji are solved with those of C_ij
    shares_a_model: bool  # among parallel workers, else each works at one
    has_fields: bool  # whether its models have meshes and displacements in 3D
    request: Callable[[Specification], Any]
    solve: Callable[[Sequence[Task], Means], Iterator[Solved]]
    displacements: Callable[[Any, Any], RawICs]  # of a request and its solved model
    planned: Callable[[Any, int], Planned]  # what a request takes with so many workers
