"""What models will take, before anything is solved.

Sections are meshed and their wavenumbers counted on a half-space (a second); of solids, which are not
meshed, the number of cells is the integral of 1 / h^3 over the body. Seconds and memory follow laws that
were fitted on one machine of 2 cores (docs/matrix.md): trust their ratios more than themselves.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from femic.harmonic.engine import HarmonicRequest, build_section
from femic.harmonic.expected import expected_wavenumbers
from femic.solid.engine import Request
from femic.symmetry import parities

Array = NDArray[np.float64]

FACTOR, FACTOR_GROWTH = 0.22 / 45_700**1.5, 1.5  # seconds of a factorisation: (per unknown, exponent)
SOLVE, SOLVE_GROWTH = 0.27 / 45_700**1.25 / 99, 1.25  # seconds per load
IN_PARALLEL = 0.75  # of the cores' number: memory is shared
SECTION_START, SECTION_PER_UNKNOWN = 0.3, 5e-5  # seconds of mesh and assembly
BASE_MEMORY, SECTION_MEMORY, SOLID_MEMORY = 200.0, 0.036, 0.0065  # MB, MB per unknown
UNKNOWNS_PER_CELL = 4.2  # of quadratic tetrahedra, three per node
CELLS_PER_CUBE = 5.4  # tetrahedra in a cube of side h
SOLID_PER_UNKNOWN, SOLID_PER_FIELD = 6e-5, 3e-5  # seconds: mesh and assembly, each field
SAMPLES = 40_000


@dataclass(frozen=True)
class Planned:
    """Unknowns, wavenumbers (harmonic engine), fields that are solved, seconds, peak memory [MB]."""

    unknowns: int
    wavenumbers: int
    fields: int
    half_section: bool
    seconds: float
    memory: float


def planned(request: Request | HarmonicRequest, workers: int) -> Planned:
    """What a model will take."""
    if isinstance(request, HarmonicRequest):
        return _planned_section(request, workers)
    return _planned_solid(request)


def _planned_section(request: HarmonicRequest, workers: int) -> Planned:
    section = build_section(request)
    unknowns = 3 * section.mesh.doflocs.shape[1]
    half = section.half_section
    in_y = {parity.y for load in request.loads for parity in parities(load, half_section=half)}
    columns = sum(_columns(request, y) for y in in_y)
    axis = request.axis
    wavenumbers = expected_wavenumbers(request)
    felt = float(np.arcsinh(request.felt / axis.scale) / np.arcsinh(axis.k_max / axis.scale))
    each = len(in_y) * FACTOR * unknowns**FACTOR_GROWTH + columns * SOLVE * unknowns**SOLVE_GROWTH
    at_once = max(1.0, IN_PARALLEL * workers)
    seconds = SECTION_START + SECTION_PER_UNKNOWN * unknowns + wavenumbers * (1 + felt) * each / at_once
    memory = BASE_MEMORY + SECTION_MEMORY * unknowns
    return Planned(unknowns, wavenumbers, columns, half, seconds, memory)


def _columns(request: HarmonicRequest, y: int) -> int:
    """Right-hand sides of a parity in y: loads at s and -s share one."""
    loads = {(abs(load.patch.s) if y else load.patch.s, load.direction) for load in request.loads}
    return len(loads)


def _planned_solid(request: Request) -> Planned:
    body, half = request.body, request.body.contour.symmetric
    fields = sum(len(parities(load, half_section=half)) for load in request.loads)
    unknowns = round(UNKNOWNS_PER_CELL * CELLS_PER_CUBE * _cubes(request))
    seconds = unknowns * (SOLID_PER_UNKNOWN + fields * SOLID_PER_FIELD)
    memory = BASE_MEMORY + SOLID_MEMORY * unknowns
    return Planned(unknowns, 0, fields, body.contour.symmetric, seconds, memory)


def _cubes(request: Request) -> float:
    """Integral of 1 / h^3 over the model: cells of size h, a half or a quarter of the body."""
    body, cells, points = request.body, request.cells, request.points
    patches = sorted({(load.patch.s, load.patch.a) for load in request.loads})
    centres = np.concatenate([body.surface.position(0.0, s).reshape(3, -1).T for s, _ in patches])
    read = np.hstack([body.surface.position(points.x, points.s), centres.T]).T
    read = np.concatenate([read, read * [-1, 1, 1]])
    if body.contour.symmetric:
        read = np.concatenate([read, read * [1, -1, 1]])
    chance = np.random.default_rng(0)
    least, far = cells.smallest, body.domain.far_radius
    depth = np.exp(chance.uniform(np.log(least / 10), np.log(far), SAMPLES))  # log-uniform below the surface
    along = np.exp(chance.uniform(np.log(least / 10), np.log(body.xi_end), SAMPLES))
    across = np.exp(chance.uniform(np.log(least / 10), np.log(far), SAMPLES)) * chance.choice(
        [-1, 1], SAMPLES
    )
    inside = np.hypot(depth, across) < far
    y, z = body.contour.position(np.clip(across, *body.s_range)) + body.side * depth * body.contour.normal(
        np.clip(across, *body.s_range)
    )
    x = np.stack([along, y, z], axis=1)
    r = KDTree(centres).query(x)[0]
    d = KDTree(read).query(x)[0]
    h = np.sqrt(cells.smallest**2 + (cells.line_growth * r) ** 2 + (cells.growth * d) ** 2)
    logs = np.log(10 * far / least) ** 2 * np.log(10 * body.xi_end / least) * 2
    volume = np.abs(depth * along * across) * logs / SAMPLES
    total = float(np.sum(inside * volume / h**3))
    return total / 2 if body.contour.symmetric else total
