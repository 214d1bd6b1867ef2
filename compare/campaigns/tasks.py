"""Tasks of a campaign: scenes, their models and results, which workers compute.

Scenes are identified by their tables and by the contents of the files that they name: campaigns that share a
store share scenes, too. A task gets the table of a scene and the location of the store; it leaves its result
in the store and returns a receipt. So tasks can be repeated at will, and compute missing results only.

Workers must have the registrations of the session, such as forms of ICs of its own: one that does not know a
form would fail all scenes that use it; one that knows another form of that name would give other results.
"""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any

import dask
import xarray as xr

from approx.forms import FORMS
from approx.variants import VARIANTS, forms_of
from compare.campaigns import collected as outcomes
from compare.campaigns.campaign import Campaign
from compare.campaigns.collected import SceneOutcome
from compare.campaigns.results import registry
from femic.cache.digests import STUDY_FOLDERS, results_digest
from femic.cache.store import Store
from femic.cache.workers import one_blas_thread
from femic.contact.motions import MOTIONS
from femic.reference.engine import peak_memory
from femic.reference.engines import ENGINES
from femic.reference.job import Job
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import matrices
from femic.reference.refinement import references
from femic.reference.run_options import Level, RunOptions, Solved, Watch
from femic.scenes.bodies import CONTOURS
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.errors import Failure, WrongInput

# --- registrations --------------------------------------------------------------------------------------


ADDRESS = re.compile(r" at 0x\w+")  # of a function, in its repr
MAIN_OF_WORKER = "__mp_main__"  # the name of the script that is run, in processes that it starts


def registrations() -> dict[str, str]:
    """Return the definitions of all registered names as texts, which are the same in all processes."""
    registered: dict[str, Mapping[str, object]] = {
        "form": FORMS,
        "variant": {name: forms_of(name) for name in VARIANTS},
        "contour": CONTOURS,
        "motion": MOTIONS,
        "engine": ENGINES,
        "kind of results": dict.fromkeys(registry.KINDS),
    }
    return {
        f"{what} {name!r}": ADDRESS.sub("", repr(entry)).replace(MAIN_OF_WORKER, "__main__")
        for what, entries in registered.items()
        for name, entry in entries.items()
    }


def differing(expected: Mapping[str, str]) -> list[str]:
    """Return the registrations that this process lacks, has in addition, or has with another definition."""
    own = registrations()
    return [name for name in {**expected, **own} if own.get(name) != expected.get(name)]


# --- scenes as tasks ------------------------------------------------------------------------------------


NAME = "scene"  # of every scene in messages: scenes that campaigns share have no other


@dataclass(frozen=True)
class SceneTask:
    """A scene: its table, and the keys of its results in the store by kind."""

    table: Mapping[str, Any]
    keys: Mapping[str, str]
    retry: bool = False  # whether to compute again what failed before

    @property
    def digest(self) -> int:
        """A number of 64 bits, not 0, that depends on all inputs of the scene's results."""
        return int.from_bytes(sha256("".join(self.keys.values()).encode()).digest()[:8]) or 1

    @property
    def scene(self) -> Scene:
        """The scene, without the check with the other engine; raises BadScene."""
        return replace(scene_from_table(dict(self.table), NAME), check=None)


def scene_task(table: Mapping[str, Any], keep: tuple[str, ...], store: Store) -> SceneTask:
    """Return the task of a scene; keys depend on its table, its files, and the code."""
    plain = json.loads(json.dumps(table, default=str), parse_int=float)  # 1 and 1.0 are the same
    facts = results_digest(*STUDY_FOLDERS), json.dumps(plain, sort_keys=True), *_contents(table)
    return SceneTask(table, {name: store.key(f"sweep-{name}", name, *facts) for name in keep})


def task_of(campaign: Campaign, number: int, store: Store) -> SceneTask:
    """Return the task of the scene at a point of a campaign."""
    return scene_task(campaign.scene_table(campaign.point(number)), campaign.keep, store)


def tasks_of(campaign: Campaign, store: Store) -> Iterator[tuple[int, SceneTask]]:
    """Yield the numbers and tasks of all scenes of a campaign, in its order."""
    for number in campaign.order:
        yield number, task_of(campaign, number, store)


def stored_parts(task: SceneTask, store: Store) -> dict[str, SceneOutcome]:
    """Return what the store has of a scene, by kind of results."""
    parts = {kind: outcomes.get(store, key) for kind, key in task.keys.items()}
    return {kind: part for kind, part in parts.items() if part is not None}


def stored_outcome(task: SceneTask, store: Store) -> SceneOutcome | None:
    """Return the outcome of a scene, None where the store lacks a part of it."""
    parts = stored_parts(task, store)
    return merged_outcome(parts) if len(parts) == len(task.keys) else None


def merged_outcome(parts: Mapping[str, SceneOutcome]) -> SceneOutcome:
    """Return all parts of a scene as one; where some failed, it has the others, and says why."""
    failures: dict[str, list[str]] = {}
    for kind, part in parts.items():
        if part.failure:
            failures.setdefault(part.failure, []).append(kind)
    everything = len(parts) == len(next(iter(failures.values()), ()))
    messages = [
        message if everything else f"{', '.join(names)}: {message}" for message, names in failures.items()
    ]
    datasets = {kind: part.dataset for kind, part in parts.items() if not part.failure}
    try:
        merged = registry.merge(datasets)
    except ValueError as error:
        merged, messages = xr.Dataset(), [*messages, f"results of several kinds do not fit together: {error}"]
    return SceneOutcome(merged, "; ".join(messages), sum(part.seconds for part in parts.values()))


def _contents(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield digests of the files that a scene names: contours, gaps, maps of C."""
    contact = _table(table, "contact")
    contours = [_table(_table(table, body), "contour") for body in ("lower", "upper")]
    ics = contact.get("ics")
    maps = [name.removeprefix(MAP) for name in ics if is_map(str(name))] if isinstance(ics, list) else []
    for name in (*(contour.get("file") for contour in contours), contact.get("extra_gap"), *maps):
        if isinstance(name, str) and (path := Path(name)).exists():
            files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
            yield _digest(tuple((file, file.stat().st_mtime_ns) for file in files))


def _table(table: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table in a table, empty where there is none; other entries are refused elsewhere."""
    inner = table.get(name)
    return inner if isinstance(inner, Mapping) else {}


@cache
def _digest(files: tuple[tuple[Path, int], ...]) -> str:
    """Return the digest of files with their times of modification."""
    digest = sha256()
    for file, _ in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()


# --- what workers do ------------------------------------------------------------------------------------


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
            key = job.settings.engine.key(job.request(Level()), store)
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
    own = results_digest(*STUDY_FOLDERS)
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
    return _compute_part(task, kind, work) if part is None or (part.failure and task.retry) else part


def _compute_part(task: SceneTask, name: str, work: "_Work") -> SceneOutcome:
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
