"""Computes a campaign: tasks are handed to a cluster a few at a time, and what they leave is collected."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from queue import Empty, SimpleQueue
from time import perf_counter

from distributed import CancelledError, Client, Future, KilledWorker

from femic.cache import folders
from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.campaigns import kept
from femic.campaigns.campaign import Campaign, Point
from femic.campaigns.dataset import Collected, require_other_names
from femic.campaigns.keeping import KEEPERS
from femic.campaigns.kept import Kept
from femic.campaigns.paused import Pauses, running
from femic.campaigns.tasks import (
    PROBE,
    Place,
    Receipt,
    SceneTask,
    Unusable,
    find_models,
    finished,
    found_of,
    full,
    look,
    make_scene,
    scene_task,
    solve_models,
    together,
)
from femic.scenes.errors import require_none
from geometries.errors import Failure, WrongInput

SCENES_PER_WORKER = 4  # that the scheduler has at a time: enough for no worker to wait for this process
LOOKS_FOR = 10.0  # s in which scenes are asked whether they have what is kept: some take half a second
MOST_REASONS = 5  # why scenes are impossible, that are told before the run
GONE = "the scheduler is gone; what is finished is kept: start it again, and run the same command"
FIRST = 1  # priority of what others wait for
COUNT_EVERY = 1.0  # s between countings of workers
ANSWERS_WITHIN = 60.0  # s of the scheduler, when it is asked for a receipt
WRITE_EVERY = 30.0  # least seconds from one writing of what is finished to the next
WRITE_SHARE = 0.05  # largest share of the time that goes into it


@dataclass(frozen=True)
class Progress:
    """How far a campaign is; `found` scenes were finished by earlier runs."""

    scenes: int
    finished: int = 0
    found: int = 0
    failed: int = 0
    models: int = 0  # solved by this run
    models_found: int = 0  # times that one was there already
    memory: float = 0.0  # largest of a worker [MB]
    seconds: float = 0.0

    @property
    def seconds_left(self) -> float | None:
        """Seconds until all are finished, None while nothing is known of them."""
        computed = self.finished - self.found
        return self.seconds / computed * (self.scenes - self.finished) if computed else None


Scheduled = tuple[int, SceneTask]  # the number of a point, and the task of its scene
Told = Callable[[Progress], None]
Cluster = Callable[[int], AbstractContextManager[Client]]  # for a number of scenes


@dataclass(frozen=True)
class Options:
    """How a campaign is computed: who is told, and whether scenes are tried that failed before."""

    told: Told = lambda _: None
    retry: bool = False
    note: Callable[[str], None] = lambda _: None


def require_computable(campaign: Campaign) -> None:
    """Raise BadScene where a value makes a scene impossible, or one that lacks what is to be kept.

    So a value in the middle of an axis is told of before the run. And where an axis has the name of something
    kept.
    """
    for keep in campaign.keep:
        require_other_names(campaign, KEEPERS[keep].names)
    require_none(campaign.name, _misfits(campaign, campaign.required))


def impossible(campaign: Campaign) -> list[str]:
    """Combinations of values with which scenes will fail, and why: as far as some are tried."""
    return _misfits(campaign, campaign.combined)


def _misfits(campaign: Campaign, points: Iterable[Point]) -> list[str]:
    """What is wrong with the scenes at some points: the first ones with different reasons."""
    reasons: dict[str, str] = {}
    start = perf_counter()
    for point in points:
        name = campaign.named(point)
        try:
            scene = campaign.scene(point)
            for keep in campaign.keep if perf_counter() - start < LOOKS_FOR else ():
                KEEPERS[keep].require(scene)
        except WrongInput as error:
            reasons.setdefault(str(error).removeprefix(f"{name}: "), name)
        if len(reasons) == MOST_REASONS:
            break
    return [f"at {name}: {reason}" for reason, name in reasons.items()]


def compute_sweep(
    collected: Collected, store: Store, cluster: Cluster, options: Options | None = None
) -> Progress:
    """Compute all scenes of a campaign that are not in the store, and collect all in a dataset.

    A cluster is started only where there are such scenes. The dataset is written every now and then, and at
    the end; it is up to date where this is interrupted, too. Raises Failure where a worker has other code,
    where the store is full, and where the scheduler is gone; what is finished is in the store and in the
    dataset.
    """
    with folders.locked(collected.folder):
        run = _Run(collected, store, options or Options())
        try:
            first = run.next_unfinished()
            if first is not None:
                run.write()
                with cluster(collected.campaign.size - run.progress.finished) as client:
                    run.compute_others(client, first)
        except BaseException:
            with suppress(OSError):  # what ended the run is told
                run.write()
            raise
        run.write()
    return run.progress


def tasks_of(campaign: Campaign, store: Store) -> Iterator[tuple[int, SceneTask]]:
    """Yield the numbers and tasks of all scenes of a campaign, in its order."""
    for number in campaign.order:
        yield number, _task_of(campaign, number, store)


def _task_of(campaign: Campaign, number: int, store: Store) -> SceneTask:
    return scene_task(campaign.scene_table(campaign.point(number)), campaign.keep, store)


@dataclass(eq=False)
class _Crew:
    """The workers of a cluster, and what they have been handed."""

    client: Client
    note: Callable[[str], None]
    open: set[Future] = field(default_factory=set)  # handed over, and not ended
    ended: SimpleQueue[Future] = field(default_factory=SimpleQueue)
    workers: int = 0
    running: int = 0  # workers that are not paused
    pauses: Pauses = field(init=False)

    def __post_init__(self) -> None:
        self.pauses = Pauses(self.note, perf_counter)
        self.count()

    @property
    def window(self) -> int:
        """The number of scenes that the scheduler should have; one a worker once they were out of memory."""
        return (1 if self.pauses.seen else SCENES_PER_WORKER) * max(1, self.running)

    def submit(self, task: Callable[..., Receipt], *given: object, priority: int = 0) -> Future:
        """Hand over a task."""
        future = self.client.submit(task, *given, priority=priority, pure=False)
        self.open.add(future)
        future.add_done_callback(self.ended.put)
        return future

    def endings(self) -> Iterator[Future]:
        """Yield what ends, until nothing is left; raises Failure as `count`."""
        counted = perf_counter()
        while self.open:
            if perf_counter() - counted > COUNT_EVERY:
                self.count()
                counted = perf_counter()
            with suppress(Empty):
                future = self.ended.get(timeout=COUNT_EVERY)
                self.open.remove(future)
                yield future

    def count(self) -> None:
        """Count the workers; raises Failure where the scheduler is gone, or all workers stay paused."""
        workers = self.client.scheduler_info(n_workers=-1).get("workers")
        if workers is None or self.client.status != "running":
            raise Failure(GONE)
        if self.workers and not workers:
            self.note("there are no workers any more; waiting for others (Ctrl-C: go on another time)")
        self.workers, self.running = len(workers), running(workers)
        self.pauses.look(workers)


@dataclass(eq=False)
class _Run:
    """A campaign at work."""

    collected: Collected
    store: Store
    options: Options
    progress: Progress = field(init=False)
    todo: Iterator[Scheduled] = field(init=False)  # made as it goes: a million tasks are gigabytes
    waiting: Scheduled | None = None  # the next one that is not in the store
    keys: set[str] = field(init=False)  # of all that earlier runs have kept
    looked: dict[Future, Scheduled] = field(default_factory=dict)  # of which it is found out what they need
    scenes: dict[Future, Scheduled] = field(default_factory=dict)  # handed over
    models: dict[str, Future] = field(default_factory=dict)  # handed over, by key
    solved: dict[str, str] = field(default_factory=dict)  # models by key: "", or why there are none
    start: float = field(default_factory=perf_counter)
    written: float = field(default_factory=perf_counter)  # when the dataset was written last
    writing: float = 0.0  # seconds that it took

    def __post_init__(self) -> None:
        campaign = self.collected.campaign
        self.progress, self.todo = Progress(campaign.size), tasks_of(campaign, self.store)
        try:
            damage = self.collected.begin(lambda number: _task_of(campaign, number, self.store).digest)
        except OSError as error:
            raise self._unwritable(error) from error
        if damage:
            self.options.note(damage)
        self.keys = kept.kept_keys(self.store)

    @property
    def place(self) -> Place:
        location = str(self.store.location)
        shared = location if "://" in location else str(Path(location).absolute())
        return Place(shared, results_digest(SceneTask.__module__))

    def next_unfinished(self) -> Scheduled | None:
        """The next scene that is not in the store, None if there is none; those before it are collected."""
        for number, task in self.todo:
            retry = self.options.retry
            if self.collected.has(number, task.digest) and not (retry and number in self.collected.failures):
                self._tell(found=1)
                continue
            self.collected.remove(number)
            done = finished(task, self.store) if self.keys.intersection(task.keys.values()) else None
            if done is None or (done.failure and retry):
                return number, replace(task, retry=retry)
            self._collect(number, done, task.digest, found=1)
        return None

    def compute_others(self, client: Client, first: Scheduled) -> None:
        """Hand the tasks to the cluster, a window of scenes at a time, and collect what they leave."""
        self._require_workers(client)
        self.start, self.waiting = perf_counter(), first
        crew = _Crew(client, self.options.note)
        self._hand_over(crew)
        for future in crew.endings():
            receipt = _receipt(future)
            self._count(receipt)
            if future in self.looked:
                self._hand_over_scene(crew, *self.looked.pop(future), receipt)
            elif future in self.scenes:
                self._finish_scene(*self.scenes.pop(future), receipt)
            else:
                self._finish_model(future, receipt)
            self._hand_over(crew)
            self._write_now_and_then()

    def _require_workers(self, client: Client) -> None:
        """Raise Failure where a worker has other code, or does not see the store."""
        kept.put(self.store, PROBE, Kept())
        if not self.store.writable:
            raise Unusable(full(self.store))
        try:
            problems = client.run(look, self.place)
        except Exception as error:  # whatever a worker without femic makes of it
            raise Failure(
                f"a worker cannot run femic ({type(error).__name__}: {error}): install the same version of "
                "femic, Python and Dask on all workers"
            ) from error
        for worker, problem in problems.items():
            if problem:
                raise Unusable(f"{worker}: {problem}")

    def write(self) -> None:
        """Write the dataset."""
        if self.progress.finished:
            start = perf_counter()
            self.collected.write()
            self.written = perf_counter()
            self.writing = self.written - start

    def _hand_over(self, crew: "_Crew") -> None:
        """Have it found out what scenes need, until the window is full."""
        while self.waiting is not None and len(self.looked) + len(self.scenes) < crew.window:
            self.looked[crew.submit(find_models, self.waiting[1], self.place, priority=FIRST)] = self.waiting
            self.waiting = self.next_unfinished()

    def _hand_over_scene(self, crew: "_Crew", number: int, task: SceneTask, found: Receipt) -> None:
        """Submit a scene, with the models that it is the first to need."""
        lost = [self.solved[key] for key in found.needed if self.solved.get(key)]
        if found.failure or lost:
            self._collect_failed(number, task, found.failure or lost[0])
            return
        unsolved = {key: model for key, model in found.needed.items() if key not in self.solved}
        for key in unsolved.keys() - self.models.keys():
            self.models[key] = crew.submit(solve_models, unsolved[key], self.place)
        models = [self.models[key] for key in unsolved]
        self.scenes[crew.submit(make_scene, task, self.place, models)] = number, task

    def _finish_model(self, future: Future, receipt: Receipt) -> None:
        """Note that a model is in the store; its task is not needed any more."""
        key = next(key for key, model in self.models.items() if model is future)
        del self.models[key]
        self.solved[key] = receipt.failure

    def _finish_scene(self, number: int, task: SceneTask, receipt: Receipt) -> None:
        """Collect the scene of a task that has ended."""
        done = finished(task, self.store)
        if done is not None and done.failure == receipt.failure:
            self._collect(number, done, task.digest)
        elif receipt.failure:
            self._collect_failed(number, task, receipt.failure)
        else:
            raise Unusable(f"the store {self.store.location} has lost what a task left there: run again")

    def _collect_failed(self, number: int, task: SceneTask, failure: str) -> None:
        """Collect what is there of a scene that failed, but may not the next time."""
        self._collect(number, replace(together(found_of(task, self.store)), failure=failure))

    def _count(self, receipt: Receipt) -> None:
        progress = self.progress
        self.progress = replace(
            progress,
            models=progress.models + receipt.solved,
            models_found=progress.models_found + receipt.found,
            memory=max(progress.memory, receipt.memory),
        )

    def _collect(self, number: int, done: Kept, digest: int = 0, found: int = 0) -> None:
        """Put a finished scene into the dataset, and tell."""
        try:
            self.collected.add(number, done, digest)
        except OSError as error:
            raise self._unwritable(error) from error
        self._tell(found)

    def _unwritable(self, error: OSError) -> Failure:
        return Failure(
            f"{self.collected.path} cannot be written ({error}): make room, or give another folder (--out); "
            "what is finished is in the store: run the same command to go on"
        )

    def _tell(self, found: int = 0) -> None:
        """Tell that a scene more is in the dataset."""
        self.progress = replace(
            self.progress,
            finished=self.progress.finished + 1,
            found=self.progress.found + found,
            failed=len(self.collected.failures),
            seconds=perf_counter() - self.start,
        )
        self.options.told(self.progress)

    def _write_now_and_then(self) -> None:
        """Write the dataset where that was long ago; a disk without room is only told of."""
        if perf_counter() - self.written < max(WRITE_EVERY, self.writing / WRITE_SHARE):
            return
        try:
            self.write()
        except OSError as error:
            self.options.note(f"the dataset cannot be written now ({error}); the campaign goes on")
            self.written = perf_counter()


def _receipt(future: Future) -> Receipt:
    """The receipt of a task; raises Failure where the campaign cannot go on."""
    try:
        receipt: Receipt = future.result(timeout=ANSWERS_WITHIN)
    except CancelledError as error:
        raise Failure(GONE) from error
    except KilledWorker as error:
        return Receipt(
            f"its worker died {error.allowed_failures + 1} times, most likely for memory: give fewer workers "
            "(--workers), larger cells or a larger tolerance; run again to try again"
        )
    except Unusable:
        raise
    except Exception as error:  # one scene must not end the others
        return Receipt(f"{type(error).__name__}: {error}")
    return receipt
