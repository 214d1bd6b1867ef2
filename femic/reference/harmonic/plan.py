"""The expected cost of a model of the harmonic engine, before it is solved.

Its section is meshed and its wavenumbers are counted on a half-space, which takes a second. Seconds and
memory follow laws that were fitted on one machine of 2 cores (docs/how-to/matrix.md): their ratios are more
reliable than their values.
"""

from femic.reference.harmonic.engine import build_section
from femic.reference.harmonic.expected import expected_samples
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.models import BASE_MEMORY, ExpectedCost

FACTOR, FACTOR_GROWTH = 0.28 / 45_700**1.1, 1.1  # seconds of a wavenumber: factor and exponent of unknowns
IN_PARALLEL = 0.65  # speed-up over the number of workers, which share the memory
START, PER_UNKNOWN = 0.3, 5e-5  # seconds of mesh and assembly: in any case, and per unknown
MEMORY = 0.02  # MB per unknown


def expected_cost(request: HarmonicRequest, workers: int) -> ExpectedCost:
    """The expected unknowns, wavenumbers, seconds and memory of a model."""
    section, coarser_section = build_section(request), build_section(request.coarser)
    unknowns, coarser = (3 * mesh.doflocs.shape[1] for mesh in (section.mesh, coarser_section.mesh))
    half_section = section.half_section
    loads = {
        (abs(load.patch.s) if half_section else load.patch.s, load.patch.b, load.direction)
        for load in request.loads
    }
    samples = expected_samples(request)

    def solution(unknowns: int) -> float:
        """Seconds that a wavenumber takes."""
        return FACTOR * unknowns**FACTOR_GROWTH / max(1.0, IN_PARALLEL * workers)

    seconds = 2 * START + PER_UNKNOWN * (unknowns + coarser)
    seconds += len(samples.k) * solution(unknowns) + len(samples.sparser.k) * solution(coarser)
    memory = BASE_MEMORY + MEMORY * unknowns
    return ExpectedCost(unknowns, len(samples.k), len(loads), half_section, float(seconds), memory)
