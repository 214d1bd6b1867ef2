"""The run of a campaign: tasks are submitted to a cluster a few at a time, and their results collected.

Dask repeats the tasks of workers that die, and gives up those that kill workers again and again. It waits
forever for workers, and for those that it has paused because memory is short: a run says so, and ends where
all are paused without work.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from queue import Empty, SimpleQueue
from time import perf_counter
from typing import Any

from distributed import CancelledError, Client, Future, KilledWorker

from compare.campaigns import dataset as outcomes
from compare.campaigns import tasks
from compare.campaigns.dataset import CampaignDataset, SceneOutcome
from compare.campaigns.tasks import ModelTask, SceneTask, TaskReport, Unusable, campaign_tasks, stored_outcome
from femic.cache import folders
from femic.cache.store import Store
from geometries.errors import Failure

FIRST = 1  # priority of tasks for which others wait
SCENES_PER_WORKER = 4  # submitted at a time, so that no worker waits for this process
WRITE_EVERY = 30.0  # least seconds between writings of the dataset
WRITE_SHARE = 0.05  # largest share of the time that goes into it


@dataclass(frozen=True)
class Progress:
    """The progress of a campaign; `reused` scenes were finished by earlier runs."""

    scenes: int
    finished: int = 0
    reused: int = 0
    failed: int = 0
    models: int = 0  # solved by this run
    models_reused: int = 0  # times that a model was in the store
    memory: float = 0.0  # largest of a worker [MB]
    seconds: float = 0.0

    @property
    def seconds_left(self) -> float | None:
        """Seconds until all are finished, None before the first scene."""
        computed = self.finished - self.reused
        return self.seconds / computed * (self.scenes - self.finished) if computed else None


Numbered = tuple[int, SceneTask]  # the number of a point, and the task of its scene
Cluster = Callable[[int], AbstractContextManager[Client]]  # for a number of scenes


@dataclass(frozen=True)
class Options:
    """Callbacks for progress and messages, and whether failed scenes are computed again."""

    on_progress: Callable[[Progress], None] = lambda _: None
    retry: bool = False
    on_message: Callable[[str], None] = lambda _: None


def compute_sweep(
    dataset: CampaignDataset, store: Store, cluster: Cluster, options: Options | None = None
) -> Progress:
    """Compute all scenes of a campaign that are not in the store, and collect all in a dataset.

    A cluster is started only where there are such scenes. The dataset is written now and then, and at
    the end, also of an interrupted run. Raises Failure if a worker has other code, the store is full, or
    the scheduler is gone; finished scenes are in the store and in the dataset.
    """
    with folders.locked(dataset.folder):
        run = _Run(dataset, store, options or Options())
        try:
            first = run.next_unfinished()
            if first is not None:
                run.write()
                with cluster(dataset.campaign.size - run.progress.finished) as client:
                    run.compute_others(client, first)
        except BaseException:
            with suppress(OSError):  # the error that ended the run is raised
                run.write()
            raise
        run.write()
    return run.progress


@dataclass(eq=False)
class _Run:
    """A campaign in progress."""

    dataset: CampaignDataset
    store: Store
    options: Options
    client: Client = field(init=False)
    progress: Progress = field(init=False)
    todo: Iterator[Numbered] = field(init=False)  # a generator: a million tasks are gigabytes
    keys: set[str] = field(init=False)  # of all outcomes of earlier runs
    # after each open task
    following: dict[Future, Callable[[TaskReport], None]] = field(default_factory=dict)
    ended: SimpleQueue[Future] = field(default_factory=SimpleQueue)
    begun: int = 0  # scenes of which tasks are open
    models: dict[str, Future] = field(default_factory=dict)  # submitted, by key
    solved: dict[str, str] = field(default_factory=dict)  # models by key: "", or why there are none
    start: float = field(default_factory=perf_counter)
    written: float = field(default_factory=perf_counter)  # when the dataset was written last
    writing: float = 0.0  # seconds that it took

    def __post_init__(self) -> None:
        campaign = self.dataset.campaign
        self.progress, self.todo = Progress(campaign.size), campaign_tasks(campaign, self.store)
        _, first = next(campaign_tasks(campaign, self.store))
        with self._unwritable_reported():
            damage = self.dataset.resume(first.digest)
        if damage:
            self.options.on_message(damage)
        self.keys = outcomes.keys_in(self.store)

    def next_unfinished(self) -> Numbered | None:
        """Return the next scene that is not in the store, None without one; collect those before it."""
        retry = self.options.retry
        for number, task in self.todo:
            if self.dataset.has(number, task.digest) and not (retry and number in self.dataset.failures):
                self._report(reused=1)
                continue
            self.dataset.remove(number)
            outcome = stored_outcome(task, self.store) if self.keys.intersection(task.keys.values()) else None
            if outcome is None or (outcome.failure and retry):
                return number, replace(task, retry=retry)
            self._collect(number, outcome, task.digest, reused=1)
        return None

    def compute_others(self, client: Client, waiting: Numbered | None) -> None:
        """Submit tasks to the cluster, a window of scenes at a time, and collect their results."""
        self.client, self.start = client, perf_counter()
        self._require_workers()
        stall, checked = Stall(self.options.on_message), -CHECK_EVERY
        while waiting is not None or self.following:
            if perf_counter() - checked >= CHECK_EVERY:
                checked, workers = perf_counter(), stall.update(_workers(client))
            while waiting is not None and self.begun < SCENES_PER_WORKER * max(1, workers):
                self._begin(*waiting)
                waiting = self.next_unfinished()
            with suppress(Empty):
                future = self.ended.get(timeout=CHECK_EVERY)
                report = task_report(future)
                self.progress = replace(
                    self.progress,
                    models=self.progress.models + report.solved,
                    models_reused=self.progress.models_reused + report.reused,
                    memory=max(self.progress.memory, report.memory),
                )
                self.following.pop(future)(report)
            self._write_now_and_then()

    def _require_workers(self) -> None:
        """Raise Failure where a worker has other code, or does not see the store."""
        outcomes.put(self.store, tasks.PROBE, SceneOutcome())
        tasks.require_writable(self.store)
        try:
            problems = self.client.run(tasks.worker_problem, tasks.origin(self.store))
        except Exception as error:  # whatever a worker without femic raises
            raise Failure(
                f"a worker cannot run femic ({type(error).__name__}: {error}): install the same version of "
                "femic, Python and Dask on all workers"
            ) from error
        for worker, problem in problems.items():
            if problem:
                raise Unusable(f"{worker}: {problem}")

    def _submit(
        self,
        then: Callable[[TaskReport], None],
        task: Callable[..., TaskReport],
        *given: object,
        priority: int = 0,
    ) -> Future:
        """Submit a task, and what to do with its report."""
        future = self.client.submit(task, *given, priority=priority, pure=False)
        self.following[future] = then
        future.add_done_callback(self.ended.put)
        return future

    def _begin(self, number: int, task: SceneTask) -> None:
        """List the models of a scene on a worker; then submit those that no earlier scene needs, and it."""
        origin = tasks.origin(self.store)
        self.begun += 1

        def solve(key: str, model: ModelTask) -> Future:
            if key not in self.models:
                self.models[key] = self._submit(
                    partial(self._finish_model, key), tasks.solve_models, model, origin
                )
            return self.models[key]

        def compute(listed: TaskReport) -> None:
            lost = [self.solved[key] for key in listed.needed if self.solved.get(key)]
            if listed.failure or lost:
                self._collect_failed(number, task, listed.failure or lost[0])
                return
            models = [solve(key, model) for key, model in listed.needed.items() if key not in self.solved]
            self._submit(partial(self._finish_scene, number, task), tasks.compute_scene, task, origin, models)

        self._submit(compute, tasks.list_models, task, origin, priority=FIRST)

    def _finish_model(self, key: str, report: TaskReport) -> None:
        """Note that a model is in the store, and forget its task."""
        del self.models[key]
        self.solved[key] = report.failure

    def _finish_scene(self, number: int, task: SceneTask, report: TaskReport) -> None:
        """Collect the scene of a task that has ended."""
        outcome = stored_outcome(task, self.store)
        if outcome is not None and outcome.failure == report.failure:
            self.begun -= 1
            self._collect(number, outcome, task.digest)
        elif report.failure:
            self._collect_failed(number, task, report.failure)
        else:
            raise Unusable(
                f"the store {self.store.location} has lost the result of a task; run the command again"
            )

    def _collect_failed(self, number: int, task: SceneTask, failure: str) -> None:
        """Collect the stored parts of a scene whose failure may not repeat itself."""
        self.begun -= 1
        stored = stored_outcome(task, self.store, partial=True) or SceneOutcome()
        self._collect(number, replace(stored, failure=failure))

    def _collect(self, number: int, outcome: SceneOutcome, digest: int = 0, reused: int = 0) -> None:
        """Put a finished scene into the dataset, and report it."""
        with self._unwritable_reported():
            self.dataset.add(number, outcome, digest)
        self._report(reused)

    def _report(self, reused: int = 0) -> None:
        """Report that one more scene is in the dataset."""
        self.progress = replace(
            self.progress,
            finished=self.progress.finished + 1,
            reused=self.progress.reused + reused,
            failed=len(self.dataset.failures),
            seconds=perf_counter() - self.start,
        )
        self.options.on_progress(self.progress)

    @contextmanager
    def _unwritable_reported(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise Failure(
                f"{self.dataset.path} cannot be written ({error}): make room, or give another folder "
                "(--out); finished scenes are in the store: run the same command to continue"
            ) from error

    def write(self) -> None:
        """Write the dataset."""
        if self.progress.finished:
            start = perf_counter()
            self.dataset.write()
            self.written = perf_counter()
            self.writing = self.written - start

    def _write_now_and_then(self) -> None:
        """Write the dataset where that was long ago; a full disk gives a message only."""
        if perf_counter() - self.written < max(WRITE_EVERY, self.writing / WRITE_SHARE):
            return
        try:
            self.write()
        except OSError as error:
            self.options.on_message(
                f"the dataset cannot be written at present ({error}); the campaign goes on"
            )
            self.written = perf_counter()


# --- the cluster ----------------------------------------------------------------------------------------


GONE = (
    "lost contact with the scheduler. Finished scenes are stored: start the scheduler again and repeat "
    "the command"
)
CHECK_EVERY = 1.0  # s from a look at the workers to the next
ANSWERS_WITHIN = 60.0  # s in which the scheduler returns a report
GIVE_UP_AFTER = 25.0  # s in which all workers are paused, and none has a task at work
REMEDY = (
    "give the workers more memory (dask worker --memory-limit) and one thread each (--nthreads 1), or "
    "start fewer workers on each machine"
)

Workers = Mapping[str, Mapping[str, Any]]  # by address, as a scheduler describes them


def _workers(client: Client) -> Workers:
    """Return the workers of a cluster; raise Failure where the scheduler is gone."""
    workers: Workers | None = client.scheduler_info(n_workers=-1).get("workers")
    if workers is None or client.status != "running":
        raise Failure(GONE)
    return workers


@dataclass
class Stall:
    """The time in which no worker takes a task or has one at work."""

    on_message: Callable[[str], None]
    clock: Callable[[], float] = perf_counter
    since: float | None = None
    had_workers: bool = False

    def update(self, workers: Workers) -> int:
        """Return the number of workers that take tasks; raise Failure where all are paused for long."""
        paused = [worker for worker in workers.values() if worker.get("status") == "paused"]
        at_work = [worker.get("metrics", {}).get("task_counts", {}).get("executing", 0) for worker in paused]
        if self.had_workers and not workers:
            self.on_message("no workers are left; waiting for new ones (Ctrl-C: stop and continue later)")
        self.had_workers = bool(workers)
        if not paused or len(paused) < len(workers) or any(at_work):
            self.since = None
        elif self.since is None:
            self.since = self.clock()
        elif self.clock() - self.since >= GIVE_UP_AFTER:
            largest = max(paused, key=lambda worker: float(worker.get("metrics", {}).get("memory", 0)))
            memory, limit = largest.get("metrics", {}).get("memory", 0), largest.get("memory_limit") or 0
            used = f" ({memory / 2**20:.0f} of {limit / 2**20:.0f} MB)" if limit else ""
            raise Failure(
                f"{len(paused)} of {len(workers)} workers are paused by Dask because of their "
                f"memory{used}, and no task is running: {REMEDY}. Finished scenes are stored: repeat the "
                "command to continue"
            )
        return len(workers) - len(paused)


def task_report(future: Future) -> TaskReport:
    """Return the report of a task; raise Failure where the campaign cannot go on."""
    try:
        report: TaskReport = future.result(timeout=ANSWERS_WITHIN)
    except CancelledError as error:
        raise Failure(GONE) from error
    except KilledWorker as error:
        return TaskReport(
            f"its worker died {error.allowed_failures + 1} times, most likely because memory ran out. Use "
            "fewer workers (--workers), larger cells or a larger tolerance, and run the command again"
        )
    except Unusable:
        raise
    except Exception as error:  # one scene must not end the others
        return TaskReport(f"{type(error).__name__}: {error}")
    return report
