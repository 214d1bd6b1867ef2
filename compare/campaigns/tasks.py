"""Tasks of a campaign: scenes, their models and results, which workers compute.

Scenes are identified by their tables and by the contents of the files that they name: campaigns that share a
store share scenes, too. A task gets the table of a scene and the location of the store; it leaves its result
in the store and returns a report. So tasks can be repeated at will, and compute missing results only.

Workers must have the registrations of the session, such as forms of ICs of its own: one that does not know a
form would fail all scenes that use it; one that knows another form of that name would give other results.
"""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from copy import deepcopy
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
from compare.campaigns import dataset as outcomes
from compare.campaigns import kinds
from compare.campaigns.campaign import Campaign
from compare.campaigns.dataset import SceneOutcome
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
from femic.reference.run_options import Level, RunOptions, Watch
from femic.scenes.bodies import CONTOURS
from femic.scenes.file import SceneFile
from femic.scenes.input_files import replace_files
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.errors import Failure, WrongInput

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
    """Return the task of a scene; keys depend on its table, the content of its files, and the code."""
    contents = list[str]()

    def note(name: str) -> str:
        path = Path(name)
        files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
        if path.exists():
            contents.append(_content_digest(tuple((file, file.stat().st_mtime_ns) for file in files)))
        return name

    replace_files(deepcopy(dict(table)), SceneFile, note)
    plain = json.loads(json.dumps(table, default=str), parse_int=float)  # 1 and 1.0 are the same
    facts = results_digest(*STUDY_FOLDERS), json.dumps(plain, sort_keys=True), *contents
    return SceneTask(table, {name: store.key(f"sweep-{name}", name, *facts) for name in keep})


@cache
def _content_digest(files: tuple[tuple[Path, int], ...]) -> str:
    """Return the digest of files with their times of modification."""
    digest = sha256()
    for file, _ in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()


def campaign_tasks(campaign: Campaign, store: Store) -> Iterator[tuple[int, SceneTask]]:
    """Yield the numbers and tasks of all scenes of a campaign, in its order."""
    for number in campaign.order:
        yield number, scene_task(campaign.scene_table(campaign.point(number)), campaign.keep, store)


def stored_outcome(task: SceneTask, store: Store, *, partial: bool = False) -> SceneOutcome | None:
    """Return the outcome of a scene, None where the store lacks a part of it and `partial` is not asked for.

    Where some kinds of results failed, it has the others, and says why.
    """
    parts = {kind: outcomes.get(store, key) for kind, key in task.keys.items()}
    known = {kind: part for kind, part in parts.items() if part is not None}
    return _merge(known) if partial or len(known) == len(parts) else None


def _merge(parts: Mapping[str, SceneOutcome]) -> SceneOutcome:
    failed: dict[str, list[str]] = {}  # kinds by message
    for kind, part in parts.items():
        if part.failure:
            failed.setdefault(part.failure, []).append(kind)
    messages = [
        message if len(names) == len(parts) else f"{', '.join(names)}: {message}"
        for message, names in failed.items()
    ]
    try:
        merged = kinds.merge({kind: part.dataset for kind, part in parts.items() if not part.failure})
    except ValueError as error:
        merged, messages = xr.Dataset(), [*messages, f"results of several kinds do not fit together: {error}"]
    return SceneOutcome(merged, "; ".join(messages), sum(part.seconds for part in parts.values()))


# --- whether a process can be a worker ------------------------------------------------------------------


PROBE = "probe"  # key of an outcome that shows whether workers share the store
ADDRESS = re.compile(r" at 0x\w+")  # of a function, in its repr
MAIN_IN_WORKER = "__mp_main__"  # the name of the script that is run, in processes that it starts


class Unusable(Failure):
    """A campaign cannot go on: a worker has other code, or the store accepts nothing."""


@dataclass(frozen=True)
class Origin:
    """The program that submits tasks: its store, the digest of its code, and what it has registered."""

    store: str
    digest: str
    registrations: Mapping[str, str]


def origin(store: Store) -> Origin:
    """Return this program as the origin of tasks that use a store."""
    location = str(store.location)
    shared = location if "://" in location else str(Path(location).absolute())
    return Origin(shared, results_digest(*STUDY_FOLDERS), registrations())


def registrations() -> dict[str, str]:
    """Return the definitions of all registered names as texts, which are the same in all processes."""
    registered: dict[str, Mapping[str, object]] = {
        "form": FORMS,
        "variant": {name: forms_of(name) for name in VARIANTS},
        "contour": CONTOURS,
        "motion": MOTIONS,
        "engine": ENGINES,
        "kind of results": dict.fromkeys(kinds.KINDS),
    }
    return {
        f"{what} {name!r}": ADDRESS.sub("", repr(entry)).replace(MAIN_IN_WORKER, "__main__")
        for what, entries in registered.items()
        for name, entry in entries.items()
    }


def different_registrations(expected: Mapping[str, str]) -> list[str]:
    """Return the registrations that this process lacks, has in addition, or has with another definition."""
    own = registrations()
    return [name for name in {**expected, **own} if own.get(name) != expected.get(name)]


def code_problem(origin: Origin) -> str:
    """Return how the code or the registrations of this process differ from the program's; "" if not."""
    own = results_digest(*STUDY_FOLDERS)
    if own != origin.digest:
        return (
            f"a worker has other code or libraries (digest {own}) than this program ({origin.digest}): "
            "install the same version of femic and of its libraries on all workers (pip install -c "
            "constraints.txt), and start them again"
        )
    if different := different_registrations(origin.registrations):
        return (
            f"{', '.join(different)}: not registered in a worker as in this program: register it in a module "
            "that workers import (dask worker --preload MODULE); workers on this machine import the script "
            "that is run, without what is below `if __name__ == '__main__'`"
        )
    return ""


def worker_problem(origin: Origin) -> str:
    """Return why the process that calls this cannot be a worker; "" if it can."""
    if problem := code_problem(origin):
        return problem
    with _single_threaded():
        if outcomes.get(Store(origin.store), PROBE) is not None:
            return ""
    return (
        f"a worker does not see the store {origin.store}: give a location that all workers share "
        "(--store, a folder of a network file system or a URL such as s3://...)"
    )


def require_writable(store: Store) -> None:
    """Raise Unusable where a store accepts nothing more."""
    if not store.writable:
        raise Unusable(
            f"the store {store.location} accepts no more data ({store.problem}). Free some space, or give "
            "another store (--store). Finished scenes are stored: repeat the command to continue"
        )


# --- what workers do ------------------------------------------------------------------------------------


ModelTask = tuple[str, Job | MatrixJob]  # the models of a body that results of a scene need


@dataclass(frozen=True)
class TaskReport:
    """The report of a task; `failure` is the message of a scene without results."""

    failure: str = ""
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
        for kind in task.keys:
            for jobs in kinds.KINDS[kind].jobs(scene):
                for body, job in jobs.items():
                    key = job.settings.engine.key(job.request(Level()), store)
                    tasks.setdefault(key, (body, job))
    except Exception:  # a scene that cannot be built must not end the others
        return {}
    return tasks


def list_models(task: SceneTask, origin: Origin) -> TaskReport:
    """List the models that a scene needs: those that scenes share are solved once. Raises Unusable."""
    store = _open_store(origin)
    with _single_threaded():
        return TaskReport(needed=model_tasks(task, store))


def solve_models(task: ModelTask, origin: Origin) -> TaskReport:
    """Solve and store the models of a body until its ICs meet their tolerance. Raises Unusable.

    Models that cannot be solved are no failure here: the task of the scene meets them again.
    """
    store, cached = _open_store(origin), list[bool]()
    body, job = task
    with _single_threaded(), suppress(Failure, WrongInput):
        if isinstance(job, MatrixJob):
            matrices({body: job}, _run_options(store, cached))
        else:
            references({body: job}, _run_options(store, cached))
    return _report("", store, cached)


def compute_scene(task: SceneTask, origin: Origin, _models: object = None) -> TaskReport:
    """Compute and store the results of a scene that the store lacks; `_models` only have to come first.

    A failure of the scene is stored, too: it would be the same again. Raises Unusable.
    """
    store, cached, parts = _open_store(origin), list[bool](), dict[str, SceneOutcome]()
    with _single_threaded():
        for kind, key in task.keys.items():
            part = outcomes.get(store, key)
            if part is None or (part.failure and task.retry):
                part = _compute_part(task, kind, _run_options(store, cached))
            parts[kind] = part
    return _report(_merge(parts).failure, store, cached)


def _compute_part(task: SceneTask, name: str, options: RunOptions) -> SceneOutcome:
    """Return results of one kind, stored unless a failure may not repeat itself."""
    kind, start, lasting = kinds.KINDS[name], perf_counter(), True
    dataset, failure = xr.Dataset(), ""
    try:
        scene = task.scene
        kind.require(scene)
        dataset = kind.compute(scene, options)
    except (Failure, WrongInput) as error:
        failure = str(error)
    except Exception as error:  # one scene must not end the others
        failure, lasting = f"{type(error).__name__}: {error}", False
    if scene_task(task.table, (name,), options.store).keys[name] != task.keys[name]:
        dataset, lasting = xr.Dataset(), False
        failure = "a file named in the scene changed during the run; run the command again"
    outcome = SceneOutcome(dataset, failure, perf_counter() - start)
    if lasting:
        outcomes.put(options.store, task.keys[name], outcome)
    return outcome


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Use one BLAS thread within the context, and let xarray lock files without the cluster."""
    with one_blas_thread(), dask.config.set(scheduler="synchronous"):
        yield


def _open_store(origin: Origin) -> Store:
    """Return the store of a task; raise Unusable where this process has other code."""
    if problem := code_problem(origin):
        raise Unusable(problem)
    return Store(origin.store)


def _run_options(store: Store, cached: list[bool]) -> RunOptions:
    """Return one worker and the store; whether a model was in the store is appended to `cached`."""
    return RunOptions(1, store, Watch(on_model=lambda model: cached.append(model.cached)))


def _report(failure: str, store: Store, cached: list[bool]) -> TaskReport:
    """Return the report of a task; raise Unusable where its result could not be stored."""
    require_writable(store)
    return TaskReport(failure, peak_memory(), len(cached) - sum(cached), sum(cached))
