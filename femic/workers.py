"""Models solved in parallel processes, and kept for the next run of the same code."""

import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from joblib import Memory, Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.harmonic import engine as harmonic
from femic.models import RawICs
from femic.provenance import code_digest
from femic.reference import Job, Level, harmonic_request, solid_request
from femic.solid import engine as solid
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
    jobs: Mapping[str, Job],
    todo: list[tuple[str, Level]],
    *,
    workers: int,
    memory: Memory,
    on_step: Callable[[str], None],
) -> Iterator[Solved]:
    """Solve models, solid ones in parallel processes, harmonic ones by themselves in parallel threads.

    Yields them as they finish. Finished models are kept in `memory`: an interrupted run resumes behind the
    last of them. `on_step` hears what is going on within a model.
    """
    for name, level in todo:
        if jobs[name].engine == "harmonic":
            solve = memory.cache(harmonic.raw_ics, ignore=["most_unknowns", "workers", "progress"])
            heard = partial(_tell, on_step, name)
            asked = harmonic_request(jobs[name], level), jobs[name].most_unknowns, workers, heard
            kept = solve.check_call_in_cache(*asked)
            yield Solved(name, level, solve(*asked), kept)
    yield from _solve_solid(memory, [one for one in todo if jobs[one[0]].engine == "solid"], jobs, workers)


def _tell(on_step: Callable[[str], None], name: str, solved: int) -> None:
    on_step(f"{name} body: {solved} wavenumbers")


def _solve_solid(
    memory: Memory, todo: list[tuple[str, Level]], jobs: Mapping[str, Job], workers: int
) -> Iterator[Solved]:
    run = Parallel(n_jobs=workers, return_as="generator_unordered")
    try:
        yield from run(
            delayed(_solve_once)(
                memory, name, level, solid_request(jobs[name], level), jobs[name].most_unknowns
            )
            for name, level in todo
        )
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes ended without an answer. It was killed, most likely for "
            "memory: use fewer (--workers 1) or larger cells (engine.growth, engine.line_growth). Or the "
            "mesher crashed, which it does at the same place with one process too: change the cells a "
            "little (engine.smallest_cell, engine.growth). Finished models are kept"
        ) from error


def _solve_once(memory: Memory, job: str, level: Level, asked: solid.Request, most_unknowns: int) -> Solved:
    solve = memory.cache(solid.raw_ics, ignore=["most_unknowns"])
    kept = solve.check_call_in_cache(asked, most_unknowns)
    return Solved(job, level, solve(asked, most_unknowns), kept)
