"""An engine: a way to compute the displacements of loaded bodies, and the record of its properties.

An engine is a folder with one record of the type `Engine`; `femic.reference.engines` lists them. Code that
depends on the engine that computes C reads its record.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from femic.cache.store import Store
from femic.reference.level import MESH_ORDER
from femic.reference.meshing.cell_size import Cells
from femic.reference.models import Planned, Points, RawICs, SolverChoice
from femic.reference.run_options import Means, Solved, Task
from geometries.bodies import Body
from geometries.patches import Load, Patch


@dataclass(frozen=True)
class Request:
    """What a model is solved for; each engine's has further fields. Points are relative to each load in x."""

    body: Body  # with its domain
    loads: tuple[Load, ...]  # unit total loads
    points: Points
    cells: Cells


@dataclass(frozen=True)
class Specification(Request):
    """A model that is to be solved, before its engine makes a request of it.

    `tolerance` is that of the job, `least_scale` [mm/N] the least scale of refinement of which it is a share,
    `waves` the steps by which the wavenumbers are refined; `solver` is that of the solid engine.
    """

    tolerance: float
    least_scale: float
    waves: int
    solver: SolverChoice


@dataclass(frozen=True)
class Tuned:
    """The first model: cells that meet a tolerance on the built-in scenes."""

    tolerance: float
    cells: Callable[[Patch], Cells]
    coarsest: float  # largest factor on these cells, for large tolerances

    def cells_for(self, tolerance: float, patch: Patch) -> Cells:
        """Cells that are likely to meet a tolerance: errors are taken to fall like its cube."""
        return self.cells(patch).scaled(min((tolerance / self.tolerance) ** (1 / MESH_ORDER), self.coarsest))

    def tighter(self, tolerance: float) -> float:
        """Factor by which a tolerance is tighter than the tuned one, at least 1."""
        return max(1.0, self.tolerance / tolerance)


@dataclass(frozen=True)
class Limits:
    """The range in which an engine has been shown to be accurate."""

    nu: float  # largest Poisson's ratio
    aspect: float  # largest a / b and b / a of the patch
    rolling_radius: float  # smallest rolling radius [mm]
    inclination: float  # largest inclination of a contour [degrees]
    distance: float  # largest distance of points from the load, in least half-sides of the patch


@dataclass(frozen=True, eq=False)
class Engine:
    """A way to compute C."""

    name: str
    describes: str  # a line that describes it
    models: tuple[str, ...]  # the models of `level.MODELS` that give C and its error
    safety: float  # factor on the part of the estimate that comes from the mesh
    growth_of_unknowns: float  # exponent of 1 / cell size, measured
    tuned: Tuned
    far_radius: Callable[[float], float]  # radius [mm] of the far arc that is likely to meet a tolerance
    least_side: Callable[[Patch], float]  # half-side [mm] of a patch that cells must resolve
    limits: Limits
    endless: bool  # whether prismatic bodies have no ends along x
    both_loads: bool  # whether the loads of C_ji are solved with those of C_ij
    shares_a_model: bool  # whether parallel workers share one model, or each solves another
    has_fields: bool  # whether its models have meshes and displacements in 3D
    request: Callable[[Specification], Any]  # the request for a specified model
    solve: Callable[[Sequence[Task], Means], Iterator[Solved]]  # solves models, in any order
    key: Callable[[Any, Store], str]  # of the model of a request in a store
    displacements: Callable[[Any, Any], RawICs]  # from a request and its solved model
    planned: Callable[[Any, int], Planned]  # expected cost of a request with a number of workers
