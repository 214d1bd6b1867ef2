"""What a campaign would take: models, seconds, memory, from plans of some of its scenes."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from compare.results.plan import Step, steps_of
from compare.results.sweep import kept
from compare.results.sweep.compute import tasks_of
from compare.results.sweep.keeping import KEEPERS
from compare.results.sweep.tasks import SceneTask, finished, model_tasks
from compare.scenes.campaign import Campaign
from femic.models import BASE_MEMORY
from femic.work.store import Store
from geometries.errors import Failure, WrongInput

SAMPLED = 8  # scenes whose models are planned: the first ones of the order lie far apart
COUNTED = 1000  # scenes whose models are counted
SECONDS_OF_SCENE = 1.0  # besides its models: approximations, errors


@dataclass(frozen=True)
class SweepPlan:
    """What a campaign takes, as far as it is not finished; models are those of the first round."""

    scenes: int
    found: int  # finished by earlier runs
    counted: int  # scenes whose models were counted
    models: int  # distinct ones of these
    seconds: float  # of one worker, for all scenes
    memory: float  # of the largest model [MB]


def planned(campaign: Campaign, store: Store) -> SweepPlan:
    """The plan of a campaign: its scenes and models counted, and some of them planned."""
    keys, unfinished, found = kept.kept_keys(store), [], 0
    for _, task in tasks_of(campaign, store):
        if keys.intersection(task.keys.values()) and finished(task, store):
            found += 1
        else:
            unfinished.append(task)
    counted = unfinished[:COUNTED]
    models = {key for task in counted for key in model_tasks(task, store)}
    steps = list(_steps(unfinished[:SAMPLED]))
    per_model = sum(step.takes.seconds for step in steps) / max(1, len(steps))
    all_models = len(models) * len(unfinished) / max(1, len(counted))
    return SweepPlan(
        campaign.size,
        found,
        len(counted),
        len(models),
        all_models * per_model + SECONDS_OF_SCENE * len(unfinished),
        _largest(steps),
    )


def largest_memory(campaign: Campaign, scenes: int = SAMPLED) -> float:
    """Memory [MB] of the largest model of the first scenes of a campaign, whether they are kept or not."""
    store = Store()
    return _largest(list(_steps([task for _, task in islice(tasks_of(campaign, store), scenes)])))


def _largest(steps: list[Step]) -> float:
    return max([step.takes.memory for step in steps], default=BASE_MEMORY)


def _steps(tasks: list[SceneTask]) -> Iterator[Step]:
    """Yield the models of scenes, each model of a scene once; none of those that cannot be built."""
    for task in tasks:
        try:
            scene = task.scene
            for keep in task.keys:
                for jobs in KEEPERS[keep].jobs(scene):
                    yield from steps_of(jobs, 1)
        except (Failure, WrongInput):
            continue
