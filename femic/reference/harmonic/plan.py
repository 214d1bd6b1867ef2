"""The expected cost of a model of the harmonic engine, before it is solved.

Its section is meshed and its wavenumbers are counted on a half-space, which takes a second. Seconds and
memory follow laws that were fitted on one machine of 2 cores (docs/how-to/matrix.md): their ratios are more
reliable than their values.
"""

from femic.reference.harmonic.engine import build_section
from femic.reference.harmonic.expected import expected_samples
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.section_work import processes_for
from femic.reference.models import BASE_MEMORY, ExpectedCost

FACTOR, FACTOR_GROWTH = 0.28 / 45_700**1.1, 1.1  # seconds of a wavenumber: factor and exponent of unknowns
BY_THREADS, BY_PROCESSES = 0.8, 0.95  # speed-up over the number of workers
START, PER_UNKNOWN = 0.1, 2e-5  # seconds of mesh and assembly: in any case, and per unknown
START_OF_PROCESSES = 1.0  # seconds
MEMORY, MEMORY_OF_PROCESS = 0.012, 0.006  # MB per unknown: in this process, or in each of several


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
        processes = processes_for(unknowns, workers)
        speed_up = BY_PROCESSES * processes if processes > 1 else max(1.0, BY_THREADS * workers)
        return FACTOR * unknowns**FACTOR_GROWTH / speed_up

    seconds = 2 * START + PER_UNKNOWN * (unknowns + coarser)
    seconds += len(samples.k) * solution(unknowns) + len(samples.sparser.k) * solution(coarser)
    memory, processes = BASE_MEMORY + MEMORY * unknowns, processes_for(unknowns, workers)
    if processes > 1:
        seconds += START_OF_PROCESSES
        memory = BASE_MEMORY + processes * (BASE_MEMORY + MEMORY_OF_PROCESS * unknowns)
    return ExpectedCost(unknowns, len(samples.k), len(loads), half_section, float(seconds), memory)
