"""The wavenumbers of a section, solved in several threads or processes.

For each of the many small matrices of an elimination NumPy gives the interpreter's lock back and takes it
again: two threads are hardly faster than one, two processes twice as fast. But a process takes a second to
start, and prepares the equations once more. So threads serve small sections, processes large ones.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from femic.cache.processes import Prepared, in_processes
from femic.cache.threads import in_threads, one_blas_thread
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.entry import StoredWaves, WaveSolution
from femic.reference.harmonic.section import SectionMesh
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.models import peak_memory
from geometries.arrays import Array
from geometries.patches import Load

UNKNOWNS_FOR_PROCESSES = 25_000  # of a section, from which on processes are faster
MOST_PROCESSES = 8  # each has equations of its own, hundreds of MB
AT_ONCE = 4  # wavenumbers that a process solves before it takes others

Part = tuple[list[WaveSolution], float]  # solutions, and the peak memory of their process so far [MB]


class Solver(Protocol):
    """Solves wavenumbers of a section."""

    def __call__(self, k: Sequence[float]) -> Iterator[Part]:
        """Yield the solutions at wavenumbers [1/mm], in their order, part by part."""


def processes_for(unknowns: int, workers: int) -> int:
    """Return how many processes solve the wavenumbers of a section; 1 is this process, with its threads."""
    return min(workers, MOST_PROCESSES) if unknowns >= UNKNOWNS_FOR_PROCESSES else 1


@dataclass(frozen=True, eq=False)
class SectionWork:
    """A section with loads, and observers at arc lengths s [mm].

    Its solutions have responses (share, load, 3, len(s)), with the far arc at some `shares` of its radius;
    from the wavenumber `felt` [1/mm] on with the far arc at the first of them only. `kind` begins their names
    in a cache.
    """

    section: SectionMesh
    loads: tuple[Load, ...]
    s: Array
    shares: tuple[float, ...] = (1.0,)
    felt: float = 0.0
    kind: str = ""

    def solver(self, workers: int, cache: StoredWaves) -> Solver:
        """Return what solves wavenumbers in parallel, and takes them from a cache or puts them there.

        Threads share the equations, which are prepared here; each process prepares its own.
        """
        processes = processes_for(3 * self.section.mesh.doflocs.shape[1], workers)
        if processes > 1:
            each = Prepared(partial(self._prepared, cache))
            return lambda k: in_processes(each, self._parts(k, AT_ONCE, processes), processes, in_order=True)
        shared = self._prepared(cache)
        return lambda k: in_threads(shared, self._parts(k, shared.responses.together, workers), workers)

    def _prepared(self, cache: StoredWaves) -> "_PreparedSection":
        return _PreparedSection(self, SectionSolver(self.section, self.loads, self.s, self.shares), cache)

    def _parts(self, k: Sequence[float], at_once: int, workers: int) -> list[list[float]]:
        """Wavenumbers [1/mm] in parts of some at once, none of them with some on both sides of `felt`."""
        groups = [one for one in k if one < self.felt], [one for one in k if one >= self.felt]
        return [part for group in groups for part in in_parts(group, at_once, workers)]


@dataclass(frozen=True, eq=False)
class _PreparedSection:
    """The prepared equations of a section."""

    work: SectionWork
    responses: SectionSolver
    cache: StoredWaves

    def __call__(self, k: Sequence[float]) -> Part:
        """Return the solutions of a part of the wavenumbers; those that are not in the cache are solved."""
        names = {one: f"{self.work.kind}k{float(one)!r}" for one in k}
        stored = {one: self.cache.get(name) for one, name in names.items()}
        missing = [one for one, solution in stored.items() if solution is None]
        shares = self.work.shares if min(k) < self.work.felt else self.work.shares[:1]
        solved: dict[float, WaveSolution] = {}
        with one_blas_thread():
            for together in in_parts(missing, self.responses.together, workers=1):
                responses, residuals = self.responses(together, shares)
                new = dict(zip(together, zip(responses, residuals.tolist(), strict=True), strict=True))
                for one, solution in new.items():
                    self.cache.put(names[one], solution)
                solved |= new
        return [solved[one] if found is None else found for one, found in stored.items()], peak_memory()
