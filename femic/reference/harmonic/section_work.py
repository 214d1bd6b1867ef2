"""The wavenumbers of a section, solved in several threads or processes.

For each of the many small matrices of an elimination NumPy gives the interpreter's lock back and takes it
again, so threads wait for each other: two are 1.5 to 1.8 times as fast as one, two processes 1.9 times. But a
process takes a second to start, and prepares the equations once more. So threads serve small sections,
processes large ones.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

from femic.cache.workers import Prepared, Processes, in_threads, one_blas_thread
from femic.reference.engine import peak_memory
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.section import SectionMesh
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.stored import StoredWaves, WaveSolution
from geometries.arrays import Array
from geometries.patches import Load

UNKNOWNS_FOR_PROCESSES = 25_000  # of a section, from which on processes are faster
MOST_PROCESSES = 8  # each has equations of its own, hundreds of MB
AT_ONCE = 4  # wavenumbers that a process solves before it takes others


@dataclass(frozen=True)
class Solved:
    """Solutions at some wavenumbers, and which process has solved them, with its peak memory so far [MB]."""

    solutions: list[WaveSolution]
    process: int
    peak_memory: float


Solver = Callable[[Sequence[float]], Iterator[Solved]]  # at growing wavenumbers [1/mm], in their order


def processes_for(unknowns: int, workers: int) -> int:
    """Return how many processes solve the wavenumbers of a section; 1 is this process, with its threads."""
    return min(workers, MOST_PROCESSES) if unknowns >= UNKNOWNS_FOR_PROCESSES else 1


@dataclass(frozen=True, eq=False)
class SectionWork:
    """A section with loads, and observers at arc lengths s [mm].

    Its solutions have responses (share, load, 3, len(s)), with the far arc at some `shares` of its radius;
    from `cutoff_wavenumber` [1/mm] on with the far arc at the first of them only. `kind` begins their names
    in a cache.
    """

    section: SectionMesh
    loads: tuple[Load, ...]
    s: Array
    shares: tuple[float, ...] = (1.0,)
    cutoff_wavenumber: float = 0.0
    kind: str = ""

    @property
    def unknowns(self) -> int:
        """The number of unknowns, held ones included."""
        return 3 * int(self.section.mesh.doflocs.shape[1])

    def in_threads(self, workers: int, cache: StoredWaves) -> Solver:
        """Prepare the equations, and return what solves wavenumbers in threads, which share them."""
        shared = _PreparedSection(self, cache)
        at_once = shared.equations.batch_size
        return lambda k: in_threads(shared, self._groups(k, at_once, workers), workers)

    def in_processes(self, processes: Processes, workers: int, cache: StoredWaves) -> Solver:
        """Return what solves wavenumbers in processes, each of which prepares the equations."""
        each = Prepared(partial(_PreparedSection, self, cache))
        return lambda k: processes(each, self._groups(k, AT_ONCE, workers))

    def _groups(self, k: Sequence[float], at_once: int, workers: int) -> list[list[float]]:
        """Groups of at most `at_once` growing wavenumbers [1/mm], all on one side of `cutoff_wavenumber`."""
        sides = (
            [one for one in k if one < self.cutoff_wavenumber],
            [one for one in k if one >= self.cutoff_wavenumber],
        )
        return [group for side in sides for group in in_parts(side, at_once, workers)]


@dataclass(frozen=True, eq=False)
class _PreparedSection:
    """Solves groups of wavenumbers, or takes their solutions from a cache."""

    work: SectionWork
    cache: StoredWaves

    @cached_property
    def equations(self) -> SectionSolver:
        """The prepared equations."""
        return SectionSolver(self.work.section, self.work.loads, self.work.s, self.work.shares)

    def __call__(self, k: Sequence[float]) -> Solved:
        """Return the solutions of a group of wavenumbers; those that are not in the cache are solved."""
        names = {one: f"{self.work.kind}k{float(one)!r}" for one in k}
        stored = {one: self.cache.get(name) for one, name in names.items()}
        missing = [one for one, solution in stored.items() if solution is None]
        shares = self.work.shares if min(k) < self.work.cutoff_wavenumber else self.work.shares[:1]
        solved: dict[float, WaveSolution] = {}
        with one_blas_thread():
            for batch in in_parts(missing, self.equations.batch_size, workers=1) if missing else ():
                responses, residuals = self.equations(batch, shares)
                new = dict(zip(batch, zip(responses, residuals.tolist(), strict=True), strict=True))
                for one, solution in new.items():
                    self.cache.put(names[one], solution)
                solved |= new
        solutions = [solved[one] if found is None else found for one, found in stored.items()]
        return Solved(solutions, os.getpid(), peak_memory())
