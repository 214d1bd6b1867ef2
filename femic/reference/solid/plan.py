"""The expected cost of a model of the solid engine, without a mesh.

The number of cells is in proportion to the integral of 1 / h^3 over the body. Seconds and memory follow laws
that were fitted on one machine of 2 cores: their ratios are more reliable than their values.
"""

import numpy as np
from scipy.spatial import KDTree

from femic.reference.models import BASE_MEMORY, ExpectedCost
from femic.reference.solid.request import SolidRequest
from femic.reference.symmetry import parities

UNKNOWNS_PER_CELL = 4.2  # of quadratic tetrahedra, three per node
CELLS_PER_CUBE = 5.4  # tetrahedra in a cube of side h
PER_UNKNOWN, PER_FIELD = 6e-5, 3e-5  # seconds per unknown: mesh and assembly, each field
MEMORY = 0.0065  # MB per unknown
VOLUME_SAMPLES = 40_000  # points of the Monte Carlo integral


def expected_cost(request: SolidRequest, _workers: int) -> ExpectedCost:
    """The expected unknowns, seconds and memory of a model."""
    body, half_section = request.body, request.body.symmetric
    fields = sum(len(parities(load, half_section=half_section)) for load in request.loads)
    unknowns = round(UNKNOWNS_PER_CELL * CELLS_PER_CUBE * _cubes(request))
    seconds = unknowns * (PER_UNKNOWN + fields * PER_FIELD)
    memory = BASE_MEMORY + MEMORY * unknowns
    return ExpectedCost(unknowns, 0, fields, body.symmetric, seconds, memory)


def _cubes(request: SolidRequest) -> float:
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
