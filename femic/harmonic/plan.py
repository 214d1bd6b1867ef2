"""What a model of the harmonic engine will take, before it is solved.

Its section is meshed and its wavenumbers are counted on a half-space, which takes a second. Seconds and
memory follow laws that were fitted on one machine of 2 cores (docs/matrix.md): trust their ratios more than
themselves.
"""

import numpy as np

from femic.harmonic.engine import build_section
from femic.harmonic.expected import expected_wavenumbers
from femic.harmonic.request import HarmonicRequest
from femic.models import BASE_MEMORY, Planned
from femic.symmetry import parities

FACTOR, FACTOR_GROWTH = 0.22 / 45_700**1.5, 1.5  # seconds of a factorisation: (per unknown, exponent)
SOLVE, SOLVE_GROWTH = 0.27 / 45_700**1.25 / 99, 1.25  # seconds per load
IN_PARALLEL = 0.75  # of the cores' number: memory is shared
START, PER_UNKNOWN = 0.3, 5e-5  # seconds of mesh and assembly
MEMORY = 0.036  # MB per unknown


def planned(request: HarmonicRequest, workers: int) -> Planned:
    """What a model will take."""
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
    seconds = START + PER_UNKNOWN * unknowns + wavenumbers * (1 + felt) * each / at_once
    memory = BASE_MEMORY + MEMORY * unknowns
    return Planned(unknowns, wavenumbers, columns, half, seconds, memory)


def _columns(request: HarmonicRequest, y: int) -> int:
    """Right-hand sides of a parity in y: loads at s and -s share one."""
    loads = {(abs(load.patch.s) if y else load.patch.s, load.direction) for load in request.loads}
    return len(loads)
