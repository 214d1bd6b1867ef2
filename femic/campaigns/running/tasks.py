"""Tasks that workers execute: models of bodies, and results of scenes with them.

A task gets the table of a scene and the location of the store; it leaves its result in the store and returns
a receipt. So tasks can be repeated at will, and compute missing results only.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from time import perf_counter

import dask
import xarray as xr

from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.cache.threads import one_blas_thread
from femic.campaigns.dataset import outcomes
from femic.campaigns.dataset.outcomes import SceneOutcome
from femic.campaigns.results import registry
from femic.campaigns.running.registrations import differing
from femic.campaigns.running.scene_task import SceneTask, merged_outcome, scene_task
from femic.reference.at_points import references
from femic.reference.job import Job
from femic.reference.level import Level
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import matrices
from femic.reference.models import peak_memory
from femic.reference.run_options import RunOptions, Solved, Watch
from geometries.errors import Failure, WrongInput

PROBE = "probe"  # key of an outcome that shows whether workers share the store


class Unusable(Failure):
    """A campaign cannot go on: a worker has other code, or the store accepts nothing."""


@dataclass(frozen=True)
class Origin:
    """The program that submits tasks: its store, the digest of its code, and what it has registered."""

    store: str
    digest: str
    registrations: Mapping[str, str]


@dataclass(frozen=True)
class ModelTask:
    """The models of a body that results of a scene need."""

    body: str
    job: Job | MatrixJob


@dataclass(frozen=True)
class TaskReport:
    """The report of a task; `failure` is the message of a scene without results."""

    failure: str = ""
    seconds: float = 0.0
    memory: float = 0.0  # peak of the process so far [MB]
    solved: int = 0  # number of models that it solved
    reused: int = 0  # number of models that it took from the store
    needed: Mapping[str, ModelTask] = field(default_factory=dict)  # models that a scene needs, by key


def model_tasks(task: SceneTask, store: Store) -> dict[str, ModelTask]:
    """Return the tasks of all models that a scene is known to need, by the key of the first model of each.

    Empty for a scene that cannot be built: its own task says why.
    """
    tasks: dict[str, ModelTask] = {}
    try:
        scene = task.scene
        jobs_of_kinds = [jobs for kind in task.keys for jobs in registry.KINDS[kind].jobs(scene)]
        for body, job in (item for jobs in jobs_of_kinds for item in jobs.items()):
            key = job.settings.engine.models.key(job.request(Level()), store)
            tasks.setdefault(key, ModelTask(body, job))
    except Exception:  # a scene that cannot be built must not end the others
        return {}
    return tasks


def list_models(task: SceneTask, origin: Origin) -> TaskReport:
    """List the models that a scene needs: those that scenes share are solved once. Raises Unusable."""
    work = _Work.begin(origin)
    with _single_threaded():
        return replace(work.report(), needed=model_tasks(task, work.store))


def solve_models(task: ModelTask, origin: Origin) -> TaskReport:
    """Solve and store the models of a body until its ICs meet their tolerance. Raises Unusable.

    Models that cannot be solved are no failure here: the task of the scene meets them again.
    """
    work = _Work.begin(origin)
    with _single_threaded(), suppress(Failure, WrongInput):
        if isinstance(task.job, MatrixJob):
            matrices({task.body: task.job}, work.options)
        else:
            references({task.body: task.job}, work.options)
    return work.report()


def compute_scene(task: SceneTask, origin: Origin, _models: object = None) -> TaskReport:
    """Compute and store the results of a scene that the store lacks; `_models` only have to come first.

    A failure of the scene is stored, too: it would be the same again. Raises Unusable.
    """
    work = _Work.begin(origin)
    with _single_threaded():
        parts = {kind: _part(task, kind, work) for kind in task.keys}
    return work.report(merged_outcome(parts).failure)


def code_problem(origin: Origin) -> str:
    """Return how the code or the registrations of this process differ from the program's; "" if not."""
    own = results_digest(__name__)
    if own != origin.digest:
        return (
            f"a worker has other code or libraries (digest {own}) than this program ({origin.digest}): "
            "install the same version of femic and of its libraries on all workers (pip install -c "
            "constraints.txt), and start them again"
        )
    different = differing(origin.registrations)
    if different:
        return (
            f"{', '.join(different)}: not registered in a worker as in this program: register it in a module "
            "that workers import (dask worker --preload MODULE); workers on this machine import the script "
            "that is run, without what is below `if __name__ == '__main__'`"
        )
    return ""


def store_full(store: Store) -> str:
    """Return the message about a store that accepts nothing more."""
    return (
        f"the store {store.location} accepts no more data ({store.problem}): make room, or give another one "
        "(--store); finished scenes are stored: run the same command to continue"
    )


def worker_problem(origin: Origin) -> str:
    """Return why the process that calls this cannot be a worker; "" if it can."""
    if problem := code_problem(origin):
        return problem
    with _single_threaded():
        shares_store = outcomes.get(Store(origin.store), PROBE) is not None
    message = (
        f"a worker does not see the store {origin.store}: give a location that all workers share "
        "(--store, a folder of a network file system or a URL such as s3://...)"
    )
    return "" if shares_store else message


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Use one BLAS thread within the context, and let xarray lock files without the cluster."""
    with one_blas_thread(), dask.config.set(scheduler="synchronous"):
        yield


def _part(task: SceneTask, kind: str, work: "_Work") -> SceneOutcome:
    """Return results of one kind, computed if the store lacks them, or once more after a failure."""
    part = outcomes.get(work.store, task.keys[kind])
    return _computed(task, kind, work) if part is None or (part.failure and task.retry) else part


def _computed(task: SceneTask, name: str, work: "_Work") -> SceneOutcome:
    """Return results of one kind, stored unless a failure may not repeat itself."""
    kind, start, lasting = registry.KINDS[name], perf_counter(), True
    dataset, failure = xr.Dataset(), ""
    try:
        scene = task.scene
        kind.require(scene)
        dataset = kind.compute(scene, work.options)
    except (Failure, WrongInput) as error:
        failure = str(error)
    except Exception as error:  # one scene must not end the others
        failure, lasting = f"{type(error).__name__}: {error}", False
    if scene_task(task.table, (name,), work.store).keys[name] != task.keys[name]:
        dataset, lasting = xr.Dataset(), False
        failure = "a file that the scene names was changed meanwhile: run again"
    outcome = SceneOutcome(dataset, failure, perf_counter() - start)
    if lasting:
        outcomes.put(work.store, task.keys[name], outcome)
    return outcome


@dataclass(frozen=True, eq=False)
class _Work:
    """A task in progress: its store, its start, and the models that it has used."""

    store: Store
    start: float
    reused: list[bool] = field(default_factory=list)  # by model: whether it was in the store

    @classmethod
    def begin(cls, origin: Origin) -> "_Work":
        if problem := code_problem(origin):
            raise Unusable(problem)
        return cls(Store(origin.store), perf_counter())

    @property
    def options(self) -> RunOptions:
        """One worker and the store."""
        return RunOptions(1, self.store, Watch(on_model=self._note))

    def _note(self, model: Solved) -> None:
        self.reused.append(model.cached)

    def report(self, failure: str = "") -> TaskReport:
        """Return the report of the task; raise Unusable where its result could not be stored."""
        if not self.store.writable:
            raise Unusable(store_full(self.store))
        seconds, reused = perf_counter() - self.start, sum(self.reused)
        return TaskReport(failure, seconds, peak_memory(), len(self.reused) - reused, reused)
