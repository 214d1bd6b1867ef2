"""What a model of the solid engine will take, without a mesh.

The number of its cells is the integral of 1 / h^3 over the body. Seconds and memory follow laws that were
fitted on one machine of 2 cores: trust their ratios more than themselves.
"""

import numpy as np
from scipy.spatial import KDTree

from femic.models import BASE_MEMORY, Planned
from femic.solid.request import SolidRequest
from femic.symmetry import parities

UNKNOWNS_PER_CELL = 4.2  # of quadratic tetrahedra, three per node
CELLS_PER_CUBE = 5.4  # tetrahedra in a cube of side h
PER_UNKNOWN, PER_FIELD = 6e-5, 3e-5  # seconds per unknown: mesh and assembly, each field
MEMORY = 0.0065  # MB per unknown
SAMPLES = 40_000


def planned(request: SolidRequest, _workers: int) -> Planned:
    """What a model will take."""
    body, half = request.body, request.body.contour.symmetric
    fields = sum(len(parities(load, half_section=half)) for load in request.loads)
    unknowns = round(UNKNOWNS_PER_CELL * CELLS_PER_CUBE * _cubes(request))
    seconds = unknowns * (PER_UNKNOWN + fields * PER_FIELD)
    memory = BASE_MEMORY + MEMORY * unknowns
    return Planned(unknowns, 0, fields, body.contour.symmetric, seconds, memory)


def _cubes(request: SolidRequest) -> float:
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
