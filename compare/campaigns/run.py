"""The run of a campaign: tasks are submitted to a cluster a few at a time, and their results collected."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter

from distributed import Client, Future

from compare.campaigns import collected as outcomes
from compare.campaigns import tasks
from compare.campaigns.collected import Collected, SceneOutcome
from compare.campaigns.crew import Crew, report_of
from compare.campaigns.tasks import (
    Origin,
    SceneTask,
    TaskReport,
    Unusable,
    merged_outcome,
    registrations,
    stored_outcome,
    stored_parts,
    task_of,
    tasks_of,
)
from femic.cache import folders
from femic.cache.digests import STUDY_FOLDERS, results_digest
from femic.cache.store import Store
from geometries.errors import Failure

FIRST = 1  # priority of tasks for which others wait
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
    collected: Collected, store: Store, cluster: Cluster, options: Options | None = None
) -> Progress:
    """Compute all scenes of a campaign that are not in the store, and collect all in a dataset.

    A cluster is started only where there are such scenes. The dataset is written now and then, and at
    the end, also of an interrupted run. Raises Failure if a worker has other code, the store is full, or
    the scheduler is gone; finished scenes are in the store and in the dataset.
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
            with suppress(OSError):  # the error that ended the run is raised
                run.write()
            raise
        run.write()
    return run.progress


def code_of_dataset() -> str:
    """Return the digest of the code that a dataset rests on."""
    return results_digest(*STUDY_FOLDERS)


@dataclass(eq=False)
class _Run:
    """A campaign in progress."""

    collected: Collected
    store: Store
    options: Options
    progress: Progress = field(init=False)
    todo: Iterator[Numbered] = field(init=False)  # a generator: a million tasks are gigabytes
    waiting: Numbered | None = None  # the next one that is not in the store
    keys: set[str] = field(init=False)  # of all outcomes of earlier runs
    listing: dict[Future, Numbered] = field(default_factory=dict)  # scenes whose models are being listed
    scenes: dict[Future, Numbered] = field(default_factory=dict)  # submitted
    models: dict[str, Future] = field(default_factory=dict)  # submitted, by key
    solved: dict[str, str] = field(default_factory=dict)  # models by key: "", or why there are none
    start: float = field(default_factory=perf_counter)
    written: float = field(default_factory=perf_counter)  # when the dataset was written last
    writing: float = 0.0  # seconds that it took

    def __post_init__(self) -> None:
        campaign = self.collected.campaign
        self.progress, self.todo = Progress(campaign.size), tasks_of(campaign, self.store)

        def digest_of(number: int) -> int:
            return task_of(campaign, number, self.store).digest

        try:
            damage = self.collected.begin(digest_of, code_of_dataset())
        except OSError as error:
            raise self._unwritable(error) from error
        if damage:
            self.options.on_message(damage)
        self.keys = outcomes.keys_in(self.store)

    @property
    def origin(self) -> Origin:
        location = str(self.store.location)
        shared = location if "://" in location else str(Path(location).absolute())
        return Origin(shared, results_digest(*STUDY_FOLDERS), registrations())

    def next_unfinished(self) -> Numbered | None:
        """Return the next scene that is not in the store, None without one; collect those before it."""
        for number, task in self.todo:
            retry = self.options.retry
            if self.collected.has(number, task.digest) and not (retry and number in self.collected.failures):
                self._report(reused=1)
                continue
            self.collected.remove(number)
            stored = self.keys.intersection(task.keys.values())
            outcome = stored_outcome(task, self.store) if stored else None
            if outcome is None or (outcome.failure and retry):
                return number, replace(task, retry=retry)
            self._collect(number, outcome, task.digest, reused=1)
        return None

    def compute_others(self, client: Client, first: Numbered) -> None:
        """Submit tasks to the cluster, a window of scenes at a time, and collect their results."""
        self._require_workers(client)
        self.start, self.waiting = perf_counter(), first
        crew = Crew(client, self.options.on_message)
        self._submit(crew)
        for future in crew.completed():
            report = report_of(future)
            self._count(report)
            if future in self.listing:
                self._submit_scene(crew, *self.listing.pop(future), report)
            elif future in self.scenes:
                self._finish_scene(*self.scenes.pop(future), report)
            else:
                self._finish_model(future, report)
            self._submit(crew)
            self._write_now_and_then()

    def _require_workers(self, client: Client) -> None:
        """Raise Failure where a worker has other code, or does not see the store."""
        outcomes.put(self.store, tasks.PROBE, SceneOutcome())
        if not self.store.writable:
            raise Unusable(tasks.store_full(self.store))
        try:
            problems = client.run(tasks.worker_problem, self.origin)
        except Exception as error:  # whatever a worker without femic raises
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

    def _submit(self, crew: Crew) -> None:
        """Submit scenes, first the listing of their models, until the window is full."""
        while self.waiting is not None and len(self.listing) + len(self.scenes) < crew.window:
            listing = crew.submit(tasks.list_models, self.waiting[1], self.origin, priority=FIRST)
            self.listing[listing] = self.waiting
            self.waiting = self.next_unfinished()

    def _submit_scene(self, crew: Crew, number: int, task: SceneTask, listed: TaskReport) -> None:
        """Submit a scene, and those of its models that no earlier scene needs."""
        lost = [self.solved[key] for key in listed.needed if self.solved.get(key)]
        if listed.failure or lost:
            self._collect_failed(number, task, listed.failure or lost[0])
            return
        unsolved = {key: model for key, model in listed.needed.items() if key not in self.solved}
        for key in unsolved.keys() - self.models.keys():
            self.models[key] = crew.submit(tasks.solve_models, unsolved[key], self.origin)
        models = [self.models[key] for key in unsolved]
        self.scenes[crew.submit(tasks.compute_scene, task, self.origin, models)] = number, task

    def _finish_model(self, future: Future, report: TaskReport) -> None:
        """Note that a model is in the store, and forget its task."""
        key = next(key for key, model in self.models.items() if model is future)
        del self.models[key]
        self.solved[key] = report.failure

    def _finish_scene(self, number: int, task: SceneTask, report: TaskReport) -> None:
        """Collect the scene of a task that has ended."""
        outcome = stored_outcome(task, self.store)
        if outcome is not None and outcome.failure == report.failure:
            self._collect(number, outcome, task.digest)
        elif report.failure:
            self._collect_failed(number, task, report.failure)
        else:
            raise Unusable(f"the store {self.store.location} has lost the result of a task: run again")

    def _collect_failed(self, number: int, task: SceneTask, failure: str) -> None:
        """Collect the stored parts of a scene whose failure may not repeat itself."""
        self._collect(number, replace(merged_outcome(stored_parts(task, self.store)), failure=failure))

    def _count(self, report: TaskReport) -> None:
        progress = self.progress
        self.progress = replace(
            progress,
            models=progress.models + report.solved,
            models_reused=progress.models_reused + report.reused,
            memory=max(progress.memory, report.memory),
        )

    def _collect(self, number: int, outcome: SceneOutcome, digest: int = 0, reused: int = 0) -> None:
        """Put a finished scene into the dataset, and report it."""
        try:
            self.collected.add(number, outcome, digest)
        except OSError as error:
            raise self._unwritable(error) from error
        self._report(reused)

    def _unwritable(self, error: OSError) -> Failure:
        return Failure(
            f"{self.collected.path} cannot be written ({error}): make room, or give another folder (--out); "
            "finished scenes are in the store: run the same command to continue"
        )

    def _report(self, reused: int = 0) -> None:
        """Report that one more scene is in the dataset."""
        self.progress = replace(
            self.progress,
            finished=self.progress.finished + 1,
            reused=self.progress.reused + reused,
            failed=len(self.collected.failures),
            seconds=perf_counter() - self.start,
        )
        self.options.on_progress(self.progress)

    def _write_now_and_then(self) -> None:
        """Write the dataset where that was long ago; a full disk gives a message only."""
        if perf_counter() - self.written < max(WRITE_EVERY, self.writing / WRITE_SHARE):
            return
        try:
            self.write()
        except OSError as error:
            self.options.on_message(f"the dataset cannot be written now ({error}); the campaign goes on")
            self.written = perf_counter()
