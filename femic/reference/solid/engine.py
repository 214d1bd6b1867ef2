"""The solid engine: displacements of one body under unit patch loads in 3D, before any discount.

The steps are: model, load, solve, observe. The model is a quarter of the body where the section is symmetric,
else half of it. Loads and observers elsewhere on the surface follow by parity. Models are solved in parallel
processes, and kept.

The expected cost of a model takes no mesh: the number of cells is in proportion to the integral of 1 / h^3
over the body. Seconds and memory follow laws that were fitted on one machine of 2 cores: their ratios are
more reliable than their values.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from time import perf_counter

import numpy as np
import xarray as xr
from joblib.externals.loky.process_executor import TerminatedWorkerError
from scipy.sparse import bsr_matrix, coo_array, csr_matrix, vstack
from scipy.sparse import eye as identity
from scipy.spatial import KDTree

from femic.cache.store import Store
from femic.cache.workers import in_processes
from femic.reference.engine import (
    BASE_MEMORY,
    Cost,
    ExpectedCost,
    Points,
    RawICs,
    Request,
    SolverChoice,
    cost_from,
    peak_memory,
)
from femic.reference.job import NotConverged
from femic.reference.run_options import RunOptions, Solved, Step, Task
from femic.reference.solid.linear import Solution, System, prepare, rigid_body_modes, stiffness
from femic.reference.solid.mesh import Focus, SolidMesh, solid_mesh
from femic.reference.symmetry import Parity, Y, held_by_supports, held_by_symmetry, parities
from geometries.arrays import Array, Mask
from geometries.errors import Failure
from geometries.patches import Load, X
from geometries.quadrature import on_panels

# --- model, load, solve, observe ---

Field = tuple[tuple[Parity, Solution], ...]  # the parts that add up to the field of a load

LOAD_QUADRATURE = 4  # Gauss points per interval, which is as long as the smallest surface cell
INTERVALS = 24, 2000  # smallest and largest number of intervals per side of the patch
RESIDUAL = 1e-7  # relative, of systems; it changes displacements by less than 1e-7 of the largest


@dataclass(frozen=True, eq=False)
class SolidModel:
    """A meshed and assembled body, which serves all loads."""

    solid: SolidMesh
    stiffness: bsr_matrix  # [N/mm]
    supported: Mask  # (n_nodes, 3) components held by the supports

    @property
    def unknowns(self) -> int:
        """Number of displacement components of the model, held ones included."""
        return int(self.stiffness.shape[0])


def raw_ics(request: Request, most_unknowns: int | None = None) -> RawICs:
    """Mesh, assemble and solve a request: displacements [mm/N] at its points under its loads.

    Raises NotConverged if the mesh has more than `most_unknowns`.
    """
    start = perf_counter()
    solid = build_mesh(request)
    meshed = perf_counter()
    unknowns = 3 * solid.nodes.shape[1]
    if most_unknowns is not None and unknowns > most_unknowns:
        raise NotConverged(
            f"a model needs {unknowns:,} unknowns, `most_unknowns` = {most_unknowns:,}: give a larger "
            "`tolerance`, larger cells (`growth`, `line_growth`) or a larger `most_unknowns`"
        )
    model = assemble(solid)
    assembled = perf_counter()
    fields = solve(model, request.loads, request.solver)
    u = np.stack([observe(model, load, field, request.points) for load, field in fields.items()])
    seconds = {
        "mesh": meshed - start,
        "assembly": assembled - meshed,
        "solution": perf_counter() - assembled,
    }
    solutions = [solution for field in fields.values() for _, solution in field]
    cost = Cost(
        model.unknowns,
        int(solid.mesh.nelements),
        ", ".join(sorted({solution.solver for solution in solutions})),
        tuple(solution.iterations for solution in solutions),
        max(solution.residual for solution in solutions),
        seconds,
        peak_memory(),
    )
    return RawICs(u, cost)


def build_mesh(request: Request) -> SolidMesh:
    """Mesh the body of a request, a quarter of it where symmetry allows, fine at patches and points."""
    body, points, smallest = request.body, request.points, request.cells.smallest
    surface, half_section = body.surface, body.symmetric
    patches = list(dict.fromkeys(load.patch for load in request.loads))
    covering = []  # centres of squares that cover a patch; one if the patch is square
    for patch in patches:
        width, sides = min(patch.a, patch.b), (patch.a, patch.b)
        x, s = (np.linspace(-1, 1, round(np.ceil(side / width))) * (side - width) for side in sides)
        covering.append([grid.ravel() for grid in np.meshgrid(x, patch.s + s, indexing="ij")])
    x, s = np.hstack(covering)
    s_loads = [patch.s for patch in patches]
    at_patches = np.stack([surface.chart_x(x, s, s), s])
    at_points = np.hstack([[surface.chart_x(points.x, points.s, s_load), points.s] for s_load in s_loads])
    focus = []
    for xi, s in (at_patches, np.hstack([at_points, at_patches])):
        places = surface.position(np.abs(xi), np.abs(s) if half_section else s)
        rounded = (places / smallest).round(3)
        focus.append(places[:, np.sort(np.unique(rounded, axis=1, return_index=True)[1])])
    return solid_mesh(body, request.cells, Focus(*focus), half_section=half_section)


def assemble(solid: SolidMesh) -> SolidModel:
    """Assemble the stiffness of a mesh; nodes on the far arc, the hub and the end face are clamped."""
    body = solid.body
    xi, y, z = body.surface.to_chart(solid.nodes[:, : solid.n_vertices])
    on_end = (xi > (1 - 1e-6) * body.xi_end) & (not body.closed)
    supported = held_by_supports(body, solid.mesh, y, z, on_end)
    return SolidModel(solid, stiffness(solid.mesh, body.material), supported)


def patch_load(solid: SolidMesh, load: Load, parity: Parity) -> Array:
    """Consistent nodal forces [N], shape (n_nodes, 3), of the part of a unit load that has a parity.

    The traction is uniform in the local direction, which turns with the surface. Only the traction on the
    modelled side counts. Gauss points in the chart reproduce force, moments and second moments exactly on any
    mesh, so cells need not end at the edges of the patch.
    """
    surface, patch = solid.body.surface, load.patch
    s_ends = patch.s - patch.b, patch.s + patch.b
    middle_break = [0.0] if parity.y and s_ends[0] < 0 < s_ends[1] else []
    modelled_ends = sorted(np.abs(s_ends)) if parity.y else s_ends
    smallest = solid.trace.smallest(
        (0.0, patch.a), (0.0 if middle_break else modelled_ends[0], modelled_ends[1])
    )
    x, w_x = _composite_gauss([0.0, patch.a], smallest)
    s, w_s = _composite_gauss([s_ends[0], *middle_break, s_ends[1]], smallest)
    x, s = (grid.ravel() for grid in np.meshgrid(x, s, indexing="ij"))
    xi = surface.chart_x(x, s, s)
    traction = surface.axes(xi, s)[load.direction] * np.outer(w_x, w_s).ravel() / patch.area  # (3, n)
    if parity.y:  # half of f(s), and half of its mirror image
        traction = np.where(s < 0, parity.signs(Y)[:, None], 1.0) * traction / 2
        s = np.abs(s)
    force = np.zeros((solid.nodes.shape[1], 3))
    force[solid.trace.nodes] = solid.trace.interpolation(xi, s).T @ traction.T
    return force


def _composite_gauss(breaks: list[float], longest: float) -> tuple[Array, Array]:
    """Gauss points and weights on the spans between breaks, (n,) each, in intervals up to `longest`.

    `INTERVALS` bounds the number of intervals per span.
    """
    spans = [
        np.linspace(low, high, int(np.clip(np.ceil((high - low) / longest), *INTERVALS)) + 1)
        for low, high in pairwise(breaks)
    ]
    start, end = (np.concatenate([span[ends] for span in spans]) for ends in (np.s_[:-1], np.s_[1:]))
    nodes, weights = on_panels(start, end, LOAD_QUADRATURE)
    return nodes.ravel(), weights.ravel()


def solve(model: SolidModel, loads: Sequence[Load], solver: SolverChoice) -> dict[Load, Field]:
    """Fields of a model under unit total loads; loads of one parity share a factorisation or hierarchy."""
    solid = model.solid
    load_parities = [(load, p) for load in loads for p in parities(load, half_section=solid.half_section)]
    modes, to_nodes = rigid_body_modes(solid.nodes), from_vertices(solid)
    parts: dict[Load, list[tuple[Parity, Solution]]] = {load: [] for load in loads}
    for parity in dict.fromkeys(p for _, p in load_parities):
        loads_of_parity = [load for load, p in load_parities if p == parity]
        held = model.supported | held_by_symmetry(solid.nodes, parity)
        solve_load = prepare(
            System(model.stiffness, held, modes, to_nodes), solver, n_loads=len(loads_of_parity)
        )
        for load in loads_of_parity:
            parts[load].append((parity, solve_load(patch_load(solid, load, parity), RESIDUAL)))
    return {load: tuple(solutions) for load, solutions in parts.items()}


def from_vertices(solid: SolidMesh) -> csr_matrix:
    """Matrix (n_nodes, n_vertices) of linear fields: a mid-side node has the mean of its edge's ends."""
    edges = solid.mesh.edges
    n_edges = edges.shape[1]
    entries = (np.full(2 * n_edges, 0.5), (np.tile(np.arange(n_edges), 2), edges.ravel()))
    means = coo_array(entries, shape=(n_edges, solid.n_vertices))
    return csr_matrix(vstack([identity(solid.n_vertices), means]))


def observe(model: SolidModel, load: Load, field: Field, points: Points) -> Array:
    """Displacements [mm/N] in the observers' local directions, shape (3, n_points)."""
    solid, surface = model.solid, model.solid.body.surface
    xi = surface.chart_x(points.x, points.s, load.patch.s)
    to_points = solid.trace.interpolation(np.abs(xi), np.abs(points.s) if solid.half_section else points.s)
    u = np.zeros((3, len(xi)))
    for parity, solution in field:
        part = (to_points @ solution.displacement[solid.trace.nodes]).T
        part = np.where(xi < 0, parity.signs(X)[:, None] * part, part)
        if parity.y:
            part = np.where(points.s < 0, parity.signs(Y)[:, None] * part, part)
        u += part
    return np.asarray(np.einsum("icp,cp->ip", surface.axes(xi, points.s), u))


# --- models of tasks ---


def solve_tasks(tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
    """Solve models, and yield each as it is finished; models that an earlier run finished come first.

    Raises Failure where a worker process ends without a result.
    """
    store, unsolved = options.store, []
    for task in tasks:
        entry = store.get(model_key(task.request, store))
        if entry is None:
            unsolved.append(task)
        else:
            yield Solved(task, RawICs(entry.u.values, cost_from(entry.attrs["cost"])), cached=True)
    workers = options.workers

    def take() -> Iterator[Task]:
        for task in unsolved:
            options.watch.on_step(Step(task, "solid engine at work"))
            yield task

    try:
        yield from in_processes(partial(_solve_task, store=store), take(), workers)
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes ended without an answer. It was killed, most likely for "
            "memory: use fewer (`workers` = 1) or larger cells (`growth`, `line_growth`). Or the "
            "mesher crashed, which it does at the same place with one process too: change the cells a "
            "little (`smallest_cell`, `growth`). Finished models are kept"
        ) from error


def model_key(request: Request, store: Store) -> str:
    """The key of the model of a request in the store."""
    return store.key("solid", request.body, request.loads, request.points, request.cells, request.solver)


def _solve_task(task: Task, store: Store) -> Solved:
    """Solve the model of a task and keep its displacements."""
    raw = raw_ics(task.request, task.most_unknowns)
    u = xr.Variable(("load", "i", "point"), raw.u, {"units": "mm/N"})
    store.put(
        model_key(task.request, store), xr.Dataset({"u": u}, attrs={"cost": json.dumps(asdict(raw.cost))})
    )
    return Solved(task, raw, cached=False)


# --- expected cost ---

UNKNOWNS_PER_CELL = 4.2  # of quadratic tetrahedra, three per node
CELLS_PER_CUBE = 5.4  # tetrahedra in a cube of side h
PER_UNKNOWN, PER_FIELD = 6e-5, 3e-5  # seconds per unknown: mesh and assembly, each field
MEMORY = 0.0065  # MB per unknown
VOLUME_SAMPLES = 40_000  # points of the Monte Carlo integral


def expected_cost(request: Request) -> ExpectedCost:
    """The expected unknowns, seconds and memory of a model."""
    body, half_section = request.body, request.body.symmetric
    fields = sum(len(parities(load, half_section=half_section)) for load in request.loads)
    unknowns = round(UNKNOWNS_PER_CELL * CELLS_PER_CUBE * _cubes(request))
    seconds = unknowns * (PER_UNKNOWN + fields * PER_FIELD)
    memory = BASE_MEMORY + MEMORY * unknowns
    return ExpectedCost(unknowns, 0, fields, body.symmetric, seconds, memory)


def _cubes(request: Request) -> float:
    """Integral of 1 / h^3 over the model, a half or a quarter of the body; h is the size of cells."""
    body, cells, points = request.body, request.cells, request.points
    centres = body.surface.position(0.0, np.unique([load.patch.s for load in request.loads])).T
    read_points = np.hstack([body.surface.position(points.x, points.s), centres.T]).T
    read_points = np.concatenate([read_points, read_points * [-1, 1, 1]])
    if body.symmetric:
        read_points = np.concatenate([read_points, read_points * [1, -1, 1]])
    generator = np.random.default_rng(0)
    least_size, far = cells.smallest, body.domain.far_radius
    longest = np.log([[far], [body.xi_end], [far]])  # of depth below the surface, along x, and across
    samples = generator.uniform(np.log(least_size / 10), longest, (3, VOLUME_SAMPLES))  # log-uniform
    depth, along, across = np.exp(samples)
    across *= generator.choice([-1, 1], VOLUME_SAMPLES)
    inside = np.hypot(depth, across) < far
    y, z = body.contour.position(np.clip(across, *body.s_range)) + body.side * depth * body.contour.normal(
        np.clip(across, *body.s_range)
    )
    x = np.stack([along, y, z], axis=1)
    centre_distance = KDTree(centres).query(x)[0]
    read_distance = KDTree(read_points).query(x)[0]
    cell_size = np.sqrt(
        cells.smallest**2 + (cells.line_growth * centre_distance) ** 2 + (cells.growth * read_distance) ** 2
    )
    log_volume = np.log(10 * far / least_size) ** 2 * np.log(10 * body.xi_end / least_size) * 2
    volume = np.abs(depth * along * across) * log_volume / VOLUME_SAMPLES
    total = float(np.sum(inside * volume / cell_size**3))
    return total / 2 if body.symmetric else total
