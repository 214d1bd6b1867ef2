"""The expected cost of a model of the harmonic engine, before it is solved.

Its section is meshed and its wavenumbers are counted on a half-space, which takes a second. Seconds and
memory follow laws that were fitted on one machine of 2 cores (docs/matrix.md): their ratios are more
reliable than their values.
"""

import numpy as np

from femic.harmonic.engine import build_section
from femic.harmonic.expected import expected_samples
from femic.harmonic.request import HarmonicRequest
from femic.harmonic.traces import FEW_LOADS
from femic.models import BASE_MEMORY, Planned
from femic.symmetry import parities

FACTOR, FACTOR_GROWTH = 0.27 / 45_700**1.5, 1.5  # seconds of a factorisation: factor and exponent of unknowns
SOLVE, SOLVE_GROWTH = 0.27 / 45_700**1.25 / 99, 1.25  # seconds per right-hand side: the same
IN_PARALLEL = 0.75  # speed-up over the number of workers, which share the memory
START, PER_UNKNOWN = 0.3, 5e-5  # seconds of mesh and assembly: in any case, and per unknown
MEMORY = 0.036  # MB per unknown


def planned(request: HarmonicRequest, workers: int) -> Planned:
    """The expected unknowns, wavenumbers, seconds and memory of a model."""
    section, coarser_section = build_section(request), build_section(request.coarser)
    unknowns, coarser = (3 * mesh.doflocs.shape[1] for mesh in (section.mesh, coarser_section.mesh))
    half_section = section.half_section
    y_parities = {parity.y for load in request.loads for parity in parities(load, half_section=half_section)}
    right_hand_sides = [_right_hand_sides(request, y) for y in y_parities]
    solved = sum(n for n in right_hand_sides if n <= FEW_LOADS)
    samples = expected_samples(request)

    def solution(unknowns: int) -> float:
        """Seconds that a wavenumber takes."""
        factors = len(y_parities) * FACTOR * unknowns**FACTOR_GROWTH
        return (factors + solved * SOLVE * unknowns**SOLVE_GROWTH) / max(1.0, IN_PARALLEL * workers)

    at_both_arcs = len(samples.k) + np.sum(samples.k < request.felt)
    seconds = 2 * START + PER_UNKNOWN * (unknowns + coarser)
    seconds += at_both_arcs * solution(unknowns) + len(samples.sparser.k) * solution(coarser)
    memory = BASE_MEMORY + MEMORY * unknowns
    return Planned(unknowns, len(samples.k), sum(right_hand_sides), half_section, float(seconds), memory)


def _right_hand_sides(request: HarmonicRequest, y: int) -> int:
    """Number of right-hand sides of a parity in y: loads at s and -s share one."""
    loads = {(abs(load.patch.s) if y else load.patch.s, load.direction) for load in request.loads}
    return len(loads)
