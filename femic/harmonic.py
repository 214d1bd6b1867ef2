"""The harmonic engine: displacements of one body under unit patch loads, one section problem per wavenumber.

A body that does not change along x (round its axis) answers a load that varies as cos(k x) by
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), amplitudes of the section alone (`section_model`).
A load along x exchanges sines and cosines: its K is K(-k), which is K(k) with the sign of U changed. So one
factorisation per wavenumber serves all loads. On a body of revolution k = m / R_roll. Source: design
section 4.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from approx.halfspace import HalfSpace
from femic.cell_size import Cells
from femic.engine import Cost, Points, RawICs, peak_memory
from femic.linear import NotConverged
from femic.section import SectionMesh, section_mesh
from femic.section_model import SectionModel, assemble
from femic.symmetry import X
from femic.waves import interpolated, spectrum, synthesis, tail
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LOAD_POINTS = 4  # Gauss points per edge of a strip
LOWEST = 0.2  # scale of the wavenumbers, times 1 / far radius: below it the clamped far arc rules
HIGHEST = 6.0  # largest wavenumber, times 1 / least half-side: beyond it the half-space does
REACH = 40.0  # lengths 1 / k beyond which nothing is left of a wave


@dataclass(frozen=True)
class HarmonicRequest:
    """What one model is solved for; points are relative to each load in x.

    `cells`: smallest and growth, away from the loaded strips. `spacing` is that of the solved wavenumbers in
    asinh(k / scale), far from 0 in ln k.
    """

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    spacing: float

    @property
    def scale(self) -> float:
        """Wavenumber [1/mm] below which the solved ones lie evenly, above it evenly in ln k."""
        return LOWEST / self.body.domain.far_radius

    @property
    def k_max(self) -> float:
        """Largest wavenumber [1/mm]."""
        return HIGHEST / min(min(load.patch.a, load.patch.b) for load in self.loads)

    @property
    def wavenumbers(self) -> Array:
        """The wavenumbers to solve [1/mm], 0 and k_max among them."""
        end = np.arcsinh(self.k_max / self.scale)
        return np.asarray(self.scale * np.sinh(np.linspace(0, end, int(np.ceil(end / self.spacing)) + 1)))


def raw_ics(request: HarmonicRequest, most_unknowns: int | None = None) -> RawICs:
    """Mesh, assemble, solve the wavenumbers, and sum them at the points.

    Raises NotConverged if the section has more than `most_unknowns`.
    """
    start = perf_counter()
    section = section_mesh(request.body, request.cells, strips(request.loads))
    meshed = perf_counter()
    model = assemble(section)
    if most_unknowns is not None and model.unknowns > most_unknowns:
        raise NotConverged(
            f"a section needs {model.unknowns:,} unknowns, engine.most_unknowns = {most_unknowns:,}: give a "
            "larger engine.tolerance, larger cells (engine.growth) or a larger most_unknowns"
        )
    assembled = perf_counter()
    s, place = np.unique(request.points.s, return_inverse=True)
    at, k = responses(model, request.loads, s), request.wavenumbers
    found, residuals = zip(*(at(value) for value in k), strict=True)
    solved = perf_counter()
    u = np.stack(
        [observed(request, load, np.stack(found)[:, j], (s, place)) for j, load in enumerate(request.loads)]
    )
    seconds = {
        "mesh": meshed - start,
        "assembly": assembled - meshed,
        "solution": solved - assembled,
        "synthesis": perf_counter() - solved,
    }
    solver = f"direct, {len(k)} wavenumbers"
    cells = int(section.mesh.nelements)
    return RawICs(u, Cost(model.unknowns, cells, solver, (), max(residuals), seconds, peak_memory()))


def strips(loads: Sequence[Load]) -> Array:
    """Ends [mm] of the strips of s under the loads, (n, 2)."""
    return np.unique([[load.patch.s - load.patch.b, load.patch.s + load.patch.b] for load in loads], axis=0)


def strip_force(section: SectionMesh, load: Load) -> Array:
    """Consistent forces (unknowns,) of a unit line load along a load's direction, uniform over its strip."""
    low, high = load.patch.s - load.patch.b, load.patch.s + load.patch.b
    inside = section.knots[(section.knots > low) & (section.knots < high)]
    edges = np.array([low, *inside, high])
    at, weights = np.polynomial.legendre.leggauss(LOAD_POINTS)
    half = np.diff(edges)[:, None] / 2
    s, w = (edges[:-1, None] + half * (1 + at)).ravel(), (half * weights).ravel() / (2 * load.patch.b)
    direction = section.body.surface.axes(0.0, s)[load.direction]  # (3, n)
    return np.asarray(section.interpolation(s).T @ (w * direction).T).ravel()


def responses(model: SectionModel, loads: Sequence[Load], s: Array) -> Callable[[float], tuple[Array, float]]:
    """A function of k: local displacements (load, 3, len(s)), amplitudes of sin or cos (k x), residual."""
    forces = np.stack([strip_force(model.section, load) for load in loads], axis=1)
    trace = model.section.interpolation(s)
    axes = model.section.body.surface.axes(np.zeros_like(s), s)  # (direction, component, n)
    along_x = np.array([load.direction == X for load in loads])
    signs = np.where(along_x[:, None], [1, -1, -1], [1, 1, 1])[..., None]

    def at(k: float) -> tuple[Array, float]:
        amplitudes, residual = model.solved(k, forces)
        of_loads = amplitudes.reshape(-1, 3, len(loads))
        in_space = np.stack([trace @ of_loads[:, :, j] for j in range(len(loads))])  # (load, n, component)
        return signs * np.einsum("icn,lnc->lin", axes, in_space), residual

    return at


def observed(request: HarmonicRequest, load: Load, found: Array, where: tuple[Array, Indices]) -> Array:
    """Displacements (3, n_points) of one load, from its responses (k, 3, len(s)) at some s.

    `where`: these s, and the number of each point's.
    """
    body, patch, (s, place) = request.body, load.patch, where
    x, xi = request.points.x, body.surface.chart_x(request.points.x, request.points.s, patch.s)
    stretch = float(body.surface.chart_x(1.0, patch.s, patch.s))  # of the chart at the load
    over = spectrum(request.k_max, float(np.max(np.abs(xi))) + patch.a, body.rolling_radius)
    half_space = HalfSpace(one_body(body.material, body.side))
    near = np.abs(s - patch.s) < patch.b + REACH / request.k_max
    u = np.empty((3, len(x)))
    for m, s_m in enumerate(s):
        here = place == m
        response = interpolated(request.wavenumbers, found[..., m], load.direction, over.k, request.scale)
        u[:, here] = synthesis(response, load.direction, over, patch.a * stretch, xi[here])
        if near[m]:
            beyond = tail(half_space, patch, request.k_max * stretch, x[here], s_m - patch.s)
            u[:, here] += beyond[:, load.direction]
    return u
