"""The tasks of a campaign: models of bodies, and what is made of scenes with them.

A task gets the table of a scene and where the store is; it leaves its result in the store and returns a
receipt. So tasks can be repeated at will, and do again only what is missing. Scenes are known by their tables
and by what is in the files that they name: campaigns that share a store share scenes, too.
"""

import json
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

from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.cache.threads import one_blas_thread
from femic.campaigns import keeping, kept
from femic.campaigns.keeping import KEEPERS, kept_together
from femic.campaigns.kept import Kept
from femic.reference.at_points import references
from femic.reference.job import Job
from femic.reference.level import Level
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import matrices
from femic.reference.models import peak_memory
from femic.reference.run_options import RunOptions, Solved, Watch
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.errors import Failure, WrongInput

NAME = "scene"  # of every scene in messages: those that campaigns share have no other
PROBE = "probe"  # key of a part by which workers are seen to share the store


class Unusable(Failure):
    """What makes a whole campaign impossible on a worker: other code, or a store that takes nothing."""


@dataclass(frozen=True)
class Place:
    """Where the store is, and the digest of the code that asks."""

    store: str
    digest: str


@dataclass(frozen=True)
class SceneTask:
    """A scene: its table, and the keys of its parts in the store by what is kept."""

    table: Mapping[str, Any]
    keys: Mapping[str, str]
    retry: bool = False  # whether it is tried where it failed before

    @property
    def digest(self) -> int:
        """A number of 64 bits, not 0, of all that the scene's results rest on."""
        return int.from_bytes(sha256("".join(self.keys.values()).encode()).digest()[:8]) or 1

    @property
    def scene(self) -> Scene:
        """The scene, without the check by the other engine; raises BadScene."""
        return replace(scene_from_table(dict(self.table), NAME), check=None)


@dataclass(frozen=True)
class ModelTask:
    """The models of a body that something kept of a scene needs."""

    body: str
    job: Job | MatrixJob


@dataclass(frozen=True)
class Receipt:
    """What a task did; `failure` is the message of a scene that has no results."""

    failure: str = ""
    seconds: float = 0.0
    memory: float = 0.0  # peak of the process so far [MB]
    solved: int = 0  # number of models that it solved
    found: int = 0  # number of models that it found in the store
    needed: Mapping[str, ModelTask] = field(default_factory=dict)  # models that a scene needs, by key


def scene_task(table: Mapping[str, Any], keep: tuple[str, ...], store: Store) -> SceneTask:
    """The task of a scene; keys are those of its table, of its files, and of the code."""
    plain = json.loads(json.dumps(table, default=str), parse_int=float)  # 1 and 1.0 are the same
    facts = json.dumps(plain, sort_keys=True), *_contents(table)
    return SceneTask(
        table,
        {name: store.key(f"sweep-{name}", results_digest(keeping.__name__), name, *facts) for name in keep},
    )


def model_tasks(task: SceneTask, store: Store) -> dict[str, ModelTask]:
    """The tasks of all models that a scene is known to need, by the key of the first model of each.

    Empty for a scene that cannot be built: its own task says why.
    """
    tasks: dict[str, ModelTask] = {}
    try:
        scene = task.scene
        wanted = [jobs for keep in task.keys for jobs in KEEPERS[keep].jobs(scene)]
        for body, job in (item for jobs in wanted for item in jobs.items()):
            key = job.settings.engine.models.key(job.request(Level()), store)
            tasks.setdefault(key, ModelTask(body, job))
    except Exception:  # a scene that cannot be built must not end the others
        return {}
    return tasks


def find_models(task: SceneTask, place: Place) -> Receipt:
    """Find out which models a scene needs: those that scenes share are solved once. Raises Unusable."""
    work = _Work.begun(place)
    with _alone():
        return replace(work.receipt(), needed=model_tasks(task, work.store))


def solve_models(task: ModelTask, place: Place) -> Receipt:
    """Solve the models of a body until its own ICs are as accurate as asked for, and keep them.

    That they cannot be is no failure here: the task of a scene finds out by itself. Raises Unusable.
    """
    work = _Work.begun(place)
    with _alone(), suppress(Failure, WrongInput):
        _solve(task.body, task.job, work.options)
    return work.receipt()


def make_scene(task: SceneTask, place: Place, _models: object = None) -> Receipt:
    """Compute what is kept of a scene and is not in the store yet; `_models` only have to come first.

    A failure of the scene is kept, too: it would be the same again. Raises Unusable.
    """
    work = _Work.begun(place)
    with _alone():
        parts = {keep: _part(task, keep, work) for keep in task.keys}
    return work.receipt(together(parts).failure)


def found_of(task: SceneTask, store: Store) -> dict[str, Kept]:
    """What the store has of a scene, by name."""
    parts = {keep: kept.get(store, key) for keep, key in task.keys.items()}
    return {keep: part for keep, part in parts.items() if part is not None}


def finished(task: SceneTask, store: Store) -> Kept | None:
    """What is kept of a scene, all parts together, None where one is missing."""
    parts = found_of(task, store)
    return together(parts) if len(parts) == len(task.keys) else None


def together(parts: Mapping[str, Kept]) -> Kept:
    """All parts of a scene as one; where some failed, it has the others, and says why."""
    failures: dict[str, list[str]] = {}
    for keep, part in parts.items():
        if part.failure:
            failures.setdefault(part.failure, []).append(keep)
    everything = len(parts) == len(next(iter(failures.values()), ()))
    messages = [
        message if everything else f"{', '.join(names)}: {message}" for message, names in failures.items()
    ]
    datasets = {keep: part.dataset for keep, part in parts.items() if not part.failure}
    try:
        joined = kept_together(datasets)
    except ValueError as error:
        joined, messages = xr.Dataset(), [*messages, f"what is kept does not fit together: {error}"]
    return Kept(joined, "; ".join(messages), sum(part.seconds for part in parts.values()))


def require_same_code(place: Place) -> None:
    """Raise Unusable where this process has other code than the one that asks."""
    if results_digest(__name__) != place.digest:
        raise Unusable(
            f"a worker has other code or libraries (digest {results_digest(__name__)}) than this program "
            f"({place.digest}): install the same version of femic and of its libraries on all workers "
            "(pip install -c constraints.txt), and start them again"
        )


def full(store: Store) -> str:
    """What to do about a store that takes nothing more."""
    return (
        f"the store {store.location} takes nothing more ({store.problem}): make room, or give another one "
        "(--store); what was finished before is kept: run the same command to go on"
    )


def look(place: Place) -> str:
    """What is wrong with the process that this is called in, as a worker; "" if nothing is."""
    try:
        require_same_code(place)
    except Unusable as error:
        return str(error)
    with _alone():
        sees = kept.get(Store(place.store), PROBE) is not None
    if not sees:
        return (
            f"a worker does not see the store {place.store}: give a location that all workers share "
            "(--store, a folder of a network file system or a URL such as s3://...)"
        )
    return ""


@contextmanager
def _alone() -> Iterator[None]:
    """A context with one BLAS thread, in which xarray locks files without asking the cluster."""
    with one_blas_thread(), dask.config.set(scheduler="synchronous"):
        yield


def _part(task: SceneTask, keep: str, work: "_Work") -> Kept:
    """What is kept of a scene by a name, made if it is not there, or tried again."""
    part = kept.get(work.store, task.keys[keep])
    return _made(task, keep, work) if part is None or (part.failure and task.retry) else part


def _made(task: SceneTask, keep: str, work: "_Work") -> Kept:
    """What is made of a scene; it is kept, unless it has failed and may not the next time."""
    keeper, start, lasting = KEEPERS[keep], perf_counter(), True
    dataset, failure = xr.Dataset(), ""
    try:
        scene = task.scene
        keeper.require(scene)
        dataset = keeper.of(scene, work.options)
    except (Failure, WrongInput) as error:
        failure = str(error)
    except Exception as error:  # one scene must not end the others
        failure, lasting = f"{type(error).__name__}: {error}", False
    if scene_task(task.table, (keep,), work.store).keys[keep] != task.keys[keep]:
        dataset, lasting = xr.Dataset(), False
        failure = "a file that the scene names was changed meanwhile: run again"
    made = Kept(dataset, failure, perf_counter() - start)
    if lasting:
        kept.put(work.store, task.keys[keep], made)
    return made


def _solve(body: str, job: Job | MatrixJob, options: RunOptions) -> None:
    """Solve the models of a job, and refine them."""
    if isinstance(job, MatrixJob):
        matrices({body: job}, options)
    else:
        references({body: job}, options)


@dataclass(frozen=True, eq=False)
class _Work:
    """A task at work: its store, when it began, and the models that it has used."""

    store: Store
    start: float
    kept: list[bool] = field(default_factory=list)  # of each model: whether it was in the store

    @classmethod
    def begun(cls, place: Place) -> "_Work":
        require_same_code(place)
        return cls(Store(place.store), perf_counter())

    @property
    def options(self) -> RunOptions:
        """One worker and the store."""
        return RunOptions(1, self.store, Watch(on_model=self._note))

    def _note(self, model: Solved) -> None:
        self.kept.append(model.cached)

    def receipt(self, failure: str = "") -> Receipt:
        """What was done; raises Unusable where it could not be kept."""
        if not self.store.writable:
            raise Unusable(full(self.store))
        seconds = perf_counter() - self.start
        found = sum(self.kept)
        return Receipt(failure, seconds, peak_memory(), len(self.kept) - found, found)


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
    """A table in a table, empty where there is none; whether it should be one is said by others."""
    found = table.get(name)
    return found if isinstance(found, Mapping) else {}


@cache
def _digest(files: tuple[tuple[Path, int], ...]) -> str:
    """The digest of files as they are since some times."""
    digest = sha256()
    for file, _ in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()
