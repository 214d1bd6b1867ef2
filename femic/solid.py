"""The solid engine: raw influence coefficients of one body from unit patch loads in 3D.

model -> load -> solve -> observe. The model is a quarter or a half of the body; observers anywhere
on its surface are served by the symmetry of the load.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from resource import RUSAGE_SELF, getrusage
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_matrix, coo_array, csr_matrix, vstack
from scipy.sparse import eye as identity

from femic.elasticity import rigid_body_modes, stiffness
from femic.linear import Solution, SolverChoice, System, prepare
from femic.mesh import SolidMesh, solid_mesh
from femic.symmetry import N, S, X, held_by_symmetry, parity, quarter_suffices
from femic.tetrahedra import Cells
from geometries.bodies import PrismaticBody
from geometries.contours import Contour
from geometries.patches import Patch

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DIRECTIONS = (X, S, N)
LOAD_QUADRATURE = 12  # Gauss points per subdivision, of which there are
LOAD_SUBDIVISIONS = 8  # per side of the patch
RESIDUAL = 1e-9


@dataclass(frozen=True)
class Points:
    """Observers on the contact surface: x and arc length s [mm], shape (n,) each."""

    x: Array
    s: Array


@dataclass(frozen=True)
class Request:
    """What one model is built and solved for."""

    body: PrismaticBody
    patch: Patch
    directions: tuple[int, ...]
    points: Points
    cells: Cells
    solver: SolverChoice = "auto"


@dataclass(frozen=True, eq=False)
class SolidModel:
    """A meshed and assembled body: prepare once, load many times."""

    solid: SolidMesh
    stiffness: bsr_matrix  # [N/mm]
    clamped: Mask  # (n_nodes,)

    @property
    def unknowns(self) -> int:
        """Displacement components of the model, held ones included."""
        return int(self.stiffness.shape[0])


@dataclass(frozen=True)
class Cost:
    """What a model took: iterations per load, worst residual, seconds per stage, memory in MB.

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
class RawICs:
    """Displacements per unit total load [mm/N] with clamped far boundaries, before any discount.

    `ic` has shape (3, 3, n_points): displacement i due to traction j, directions x, s, n; columns
    that were not asked for are NaN.
    """

    ic: Array
    cost: Cost


def raw_ics(request: Request) -> RawICs:
    """Mesh, assemble and solve what the request needs, and nothing else."""
    start = perf_counter()
    solid = build_mesh(request)
    meshed = perf_counter()
    model = assemble(solid)
    assembled = perf_counter()
    solutions = solve(model, request.patch, request.directions, request.solver)
    ic = np.full((3, 3, len(request.points.x)), np.nan)
    for direction, solution in solutions.items():
        ic[:, direction] = observe(model, solution, direction, request.points)
    seconds = {
        "mesh": meshed - start,
        "assembly": assembled - meshed,
        "solution": perf_counter() - assembled,
    }
    cost = Cost(
        model.unknowns,
        int(solid.mesh.nelements),
        ", ".join(sorted({solution.solver for solution in solutions.values()})),
        tuple(solution.iterations for solution in solutions.values()),
        max(solution.residual for solution in solutions.values()),
        seconds,
        getrusage(RUSAGE_SELF).ru_maxrss / 1024,
    )
    return RawICs(ic, cost)


def build_mesh(request: Request) -> SolidMesh:
    """The mesh for a request: a quarter where symmetry allows it, refined at patch and points."""
    body, patch = request.body, request.patch
    half_section = quarter_suffices(body, patch)
    x = np.abs(request.points.x)
    s = np.abs(request.points.s) if half_section else request.points.s
    x, s = np.concatenate([[0.0], x]), np.concatenate([[patch.s], s])
    focus = np.vstack([x, body.contour.position(s)])
    distinct = np.sort(np.unique((focus / request.cells.smallest).round(3), axis=1, return_index=True)[1])
    return solid_mesh(body, request.cells, focus[:, distinct], half_section=half_section)


def assemble(solid: SolidMesh) -> SolidModel:
    """Stiffness of the body and its clamped nodes: far arc and end face."""
    domain = solid.body.domain
    on_end = solid.mesh.facets_satisfying(
        lambda x: np.abs(x[0] - domain.half_length) < 1e-6 * domain.half_length, boundaries_only=True
    )
    on_far_arc = _facets_with_vertices(
        solid, np.hypot(*solid.nodes[1:, : solid.n_vertices]) > (1 - 1e-6) * domain.far_radius
    )
    facets = np.union1d(on_end, on_far_arc)
    clamped = np.zeros(solid.nodes.shape[1], dtype=bool)
    clamped[solid.mesh.dofs.get_facet_dofs(facets).flatten()] = True
    return SolidModel(solid, stiffness(solid.mesh, solid.body.material), clamped)


def _facets_with_vertices(solid: SolidMesh, chosen: Mask) -> NDArray[np.int64]:
    facets = solid.mesh.boundary_facets()
    return np.asarray(facets[np.all(chosen[solid.mesh.facets[:, facets]], axis=0)])


def patch_load(solid: SolidMesh, patch: Patch, direction: int) -> Array:
    """Consistent nodal forces [N], shape (n_nodes, 3), of a unit total load over the patch.

    The traction is uniform in the local direction, which turns with the surface. Only the part of
    the patch on the modelled side counts. Gauss points in the chart reproduce force, moments and
    second moments exactly on any mesh, so cells need not end at the patch's edges.
    """
    x_low, s_low = 0.0, 0.0 if solid.half_section else patch.s - patch.b
    x, w_x = _composite_gauss(x_low, patch.a)
    s, w_s = _composite_gauss(s_low, patch.s + patch.b)
    x, s = (grid.ravel() for grid in np.meshgrid(x, s, indexing="ij"))
    weights = np.outer(w_x, w_s).ravel() / patch.area
    traction = local_axes(solid.body.contour, s)[direction] * weights  # (3, n_points)
    force = np.zeros((solid.nodes.shape[1], 3))
    force[solid.trace.nodes] = solid.trace.interpolation(x, s).T @ traction.T
    return force


def _composite_gauss(low: float, high: float) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(LOAD_QUADRATURE)
    edges = np.linspace(low, high, LOAD_SUBDIVISIONS + 1)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


def local_axes(contour: Contour, s: Array) -> Array:
    """Directions x, s, n at arc length s in global axes, shape (3 directions, 3 components, n)."""
    tangent, normal = contour.tangent(s), contour.normal(s)
    zero, one = np.zeros_like(s), np.ones_like(s)
    return np.array([[one, zero, zero], [zero, *tangent], [zero, *normal]])


def solve(
    model: SolidModel, patch: Patch, directions: tuple[int, ...], solver: SolverChoice
) -> dict[int, Solution]:
    """Displacements of the model under unit total loads in local directions.

    Loads that hold the same components (s and n in a half model) share one preparation.
    """
    solid = model.solid
    held = {
        direction: model.clamped[:, None]
        | held_by_symmetry(solid.nodes, direction, half_section=solid.half_section)
        for direction in directions
    }
    modes, from_vertices = rigid_body_modes(solid.nodes), _from_vertices(solid)
    solutions: dict[int, Solution] = {}
    while len(solutions) < len(directions):
        first = next(d for d in directions if d not in solutions)
        alike = [d for d in directions if np.array_equal(held[d], held[first])]
        system = System(model.stiffness, held[first], modes, from_vertices)
        solve_load = prepare(system, solver, n_loads=len(alike))
        for direction in alike:
            solutions[direction] = solve_load(patch_load(solid, patch, direction), RESIDUAL)
    return {direction: solutions[direction] for direction in directions}


def _from_vertices(solid: SolidMesh) -> csr_matrix:
    """Linear fields on the quadratic nodes: a mid-side node has the mean of its edge's ends."""
    edges = solid.mesh.edges
    n = edges.shape[1]
    entries = (np.full(2 * n, 0.5), (np.tile(np.arange(n), 2), edges.ravel()))
    means = coo_array(entries, shape=(n, solid.n_vertices))
    return csr_matrix(vstack([identity(solid.n_vertices), means]))


def observe(model: SolidModel, solution: Solution, direction: int, points: Points) -> Array:
    """Displacements [mm] in the observers' local directions, shape (3, n_points).

    Observers outside the model are mirrored into it; `direction` is that of the load.
    """
    solid = model.solid
    mirrored_x = points.x < 0
    mirrored_s = (points.s < 0) & solid.half_section
    x, s = np.abs(points.x), np.where(mirrored_s, -points.s, points.s)
    on_surface = solution.displacement[solid.trace.nodes]
    u = solid.trace.interpolation(x, s) @ on_surface  # (n_points, 3)
    local = np.einsum("icp,pc->ip", local_axes(solid.body.contour, s), u)
    local = np.where(mirrored_x, parity(direction, X)[:, None] * local, local)
    return np.where(mirrored_s, parity(direction, S)[:, None] * local, local)


def directions_of(components: Iterable[str]) -> tuple[int, ...]:
    """Load directions that the components ("xn": displacement x due to traction n) need."""
    return tuple(sorted({"xsn".index(component[1]) for component in components}))
