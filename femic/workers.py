"""Models solved in parallel processes, and kept for the next run of the same code."""

import re
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from joblib import Memory, Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.engine import RawICs
from femic.harmonic import HarmonicRequest
from femic.provenance import code_digest
from femic.reference import Job, Level, request, solve_request
from femic.solid import Request
from geometries.errors import Failure


@dataclass(frozen=True)
class Solved:
    """The raw ICs of one model of one job; `kept` if an earlier run had solved it."""

    job: str
    level: Level
    raw: RawICs
    kept: bool


def memory_in(kept: Path | None) -> Memory:
    """Where solved models are kept: under a folder, nowhere without one."""
    return Memory(kept and _folder_of_this_code(kept), verbose=0)


def _folder_of_this_code(kept: Path) -> Path:
    """Where this code keeps its models; deletes those of other versions, and nothing else."""
    folder = kept / code_digest()
    folder.mkdir(parents=True, exist_ok=True)
    for other in kept.iterdir():
        if other != folder and re.fullmatch("[0-9a-f]{12}", other.name):
            shutil.rmtree(other)
    return folder


def solve_models(
    jobs: Mapping[str, Job], todo: list[tuple[str, Level]], *, workers: int, memory: Memory
) -> Iterator[Solved]:
    """Solve models in parallel processes; yields them as they finish.

    Finished models are kept in `memory`: an interrupted run resumes behind the last of them.
    """
    run = Parallel(n_jobs=workers, return_as="generator_unordered")
    try:
        yield from run(
            delayed(_solve_once)(memory, name, level, request(jobs[name], level), jobs[name].most_unknowns)
            for name, level in todo
        )
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes ended without an answer. It was killed, most likely for "
            "memory: use fewer (--workers 1) or larger cells (engine.growth, engine.line_growth). Or the "
            "mesher crashed, which it does at the same place with one process too: change the cells a "
            "little (engine.smallest_cell, engine.growth). Finished models are kept"
        ) from error


def _solve_once(
    memory: Memory, job: str, level: Level, asked: Request | HarmonicRequest, most_unknowns: int
) -> Solved:
    solve = memory.cache(solve_request, ignore=["most_unknowns"])
    kept = solve.check_call_in_cache(asked, most_unknowns)
    return Solved(job, level, solve(asked, most_unknowns), kept)
