"""Before a campaign runs: whether it can be computed, and its models, seconds and memory.

Kinds of results, names of axes, and scenes at single points are checked. The cost is estimated from some of
its scenes.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from time import perf_counter

from compare.campaigns import collected as outcomes
from compare.campaigns.campaign import Campaign, Point
from compare.campaigns.frame import require_other_names
from compare.campaigns.results import registry
from compare.campaigns.tasks import SceneTask, model_tasks, stored_outcome, tasks_of
from femic.cache.store import Store
from femic.reference.engine import BASE_MEMORY
from femic.reference.refinement import ModelPlan, plans
from femic.scenes.errors import BadScene, require_none
from geometries.errors import Failure, WrongInput

# --- checks ---------------------------------------------------------------------------------------------


REQUIRES_FOR = 10.0  # s in which scenes are checked for the results to keep: some take half a second
MOST_REASONS = 5  # different reasons of impossible scenes that are listed before the run


def require_computable(campaign: Campaign) -> list[str]:
    """Return combinations of values whose scenes will fail, with different reasons, among a sample.

    Raises BadScene where a value makes a scene impossible whatever the other axes have, or no scene with it
    has the results to keep. So a wrong value in the middle of an axis is reported before the run; likewise
    unknown kinds of results, and an axis that has the name of a result.
    """
    for keep in campaign.keep:
        if keep not in registry.KINDS:
            raise BadScene(f"{campaign.name}: keep = {keep!r}: must be one of {', '.join(registry.KINDS)}")
        require_other_names(campaign, registry.KINDS[keep].names)
    wrong, combinations, end = dict[str, str](), dict[str, str](), perf_counter() + REQUIRES_FOR
    for point in campaign.checked_points:
        reason = _reason(campaign, point, end)
        if reason and reason not in wrong | combinations:
            is_wrong = any(
                all(_reason(campaign, other, end) for other in points) for points in campaign.others(point)
            )
            (wrong if is_wrong else combinations)[reason] = f"at {campaign.point_name(point)}: {reason}"
        if len(wrong) == MOST_REASONS:
            break
    require_none(campaign.name, [*wrong.values()])
    for point in campaign.checked_combinations:
        if len(combinations) >= MOST_REASONS:
            break
        if reason := _reason(campaign, point, end):
            combinations.setdefault(reason, f"at {campaign.point_name(point)}: {reason}")
    return [*combinations.values()]


def _reason(campaign: Campaign, point: Point, end: float) -> str:
    """Return why the scene at a point is impossible, or "". Results to keep are asked for until the end."""
    try:
        scene = campaign.scene(point)
        for keep in campaign.keep if perf_counter() < end else ():
            registry.KINDS[keep].require(scene)
    except WrongInput as error:
        return str(error).removeprefix(f"{campaign.point_name(point)}: ")
    return ""


# --- the cost -------------------------------------------------------------------------------------------


SAMPLED = 8  # scenes whose models are planned: the first ones of the order lie far apart
COUNTED = 1000  # scenes whose models are counted
LONGEST = 10.0  # s after which no more scenes are examined: contact on automatic grids takes seconds each


@dataclass(frozen=True)
class SweepPlan:
    """The cost of the unfinished part of a campaign; models are counted before refinement."""

    scenes: int
    reused: int  # finished by earlier runs
    counted: int  # scenes whose models were counted
    models: int  # distinct ones of these
    seconds: float  # of one worker, for all scenes
    memory: float  # of the largest model [MB]


def sweep_plan(campaign: Campaign, store: Store) -> SweepPlan:
    """Return the plan of a campaign: its scenes and models counted, and some of them planned."""
    keys, first, reused = outcomes.keys_in(store), list[SceneTask](), 0
    for _, task in tasks_of(campaign, store):
        if keys.intersection(task.keys.values()) and stored_outcome(task, store):
            reused += 1
        elif len(first) < COUNTED:
            first.append(task)
    models, counted, left = set[str](), 0, campaign.size - reused
    for task in _within_time_limit(first):
        models.update(model_tasks(task, store))
        counted += 1
    model_plans = list(_sample_plans(first[:SAMPLED]))
    per_model = sum(plan.expected.seconds for plan in model_plans) / max(1, len(model_plans))
    all_models = len(models) * left / max(1, counted)
    return SweepPlan(
        campaign.size,
        reused,
        counted,
        len(models),
        all_models * per_model + _seconds_besides(first[:SAMPLED]) * left,
        _largest(model_plans),
    )


def _seconds_besides(tasks: list[SceneTask]) -> float:
    """Return the mean seconds of some scenes besides their models, of those that can be built."""
    seconds = []
    for task in tasks:
        with suppress(Failure, WrongInput):
            seconds.append(sum(registry.KINDS[keep].seconds(task.scene) for keep in task.keys))
    return sum(seconds) / max(1, len(seconds))


def largest_memory(campaign: Campaign) -> float:
    """Return the memory [MB] of the largest model of the first scenes of a campaign, finished or not."""
    store = Store()
    return _largest(list(_sample_plans([task for _, task in islice(tasks_of(campaign, store), SAMPLED)])))


def _largest(model_plans: list[ModelPlan]) -> float:
    return max([plan.expected.memory for plan in model_plans], default=BASE_MEMORY)


def _sample_plans(tasks: list[SceneTask]) -> Iterator[ModelPlan]:
    """Yield the models of scenes, each model of a scene once; none of those that cannot be built."""
    for task in _within_time_limit(tasks):
        try:
            scene = task.scene
            for keep in task.keys:
                for jobs in registry.KINDS[keep].jobs(scene):
                    yield from plans(jobs, 1)
        except (Failure, WrongInput):
            continue


def _within_time_limit(tasks: list[SceneTask]) -> Iterator[SceneTask]:
    """Yield the tasks, at least one, until it takes too long."""
    start = perf_counter()
    for task in tasks:
        yield task
        if perf_counter() - start > LONGEST:
            return
