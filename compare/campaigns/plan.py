"""Before a campaign runs: whether it can be computed, and its models, seconds and memory.

Kinds of results, names of axes, and scenes at single points are checked. The cost is estimated from some of
its scenes.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice, product
from time import perf_counter

from compare.campaigns import dataset as outcomes
from compare.campaigns import kinds
from compare.campaigns.campaign import Campaign, Point, coarse_order
from compare.campaigns.dataset import require_other_names
from compare.campaigns.keys import is_number
from compare.campaigns.tasks import SceneTask, campaign_tasks, model_tasks, stored_outcome
from femic.cache.store import Store
from femic.reference.engine import BASE_MEMORY
from femic.reference.refinement import ModelPlan, plans
from femic.scenes.errors import BadScene, require_none
from femic.scenes.values import Value
from geometries.errors import Failure, WrongInput

# --- checks ---------------------------------------------------------------------------------------------


MOST_CHECKED = 1000  # scenes that are built before the run, a few ms each
MOST_OTHERS = 16  # combinations that are tried with a value before it is refused
REQUIRES_FOR = 10.0  # s in which scenes are checked for the results to keep: some take half a second
MOST_REASONS = 5  # different reasons of impossible scenes that are listed before the run


def require_computable(campaign: Campaign) -> list[str]:
    """Return combinations of values whose scenes will fail, with different reasons, among a sample.

    Raises BadScene where a value makes a scene impossible whatever the other axes have, or no scene with it
    has the results to keep. So a wrong value in the middle of an axis is reported before the run; likewise
    unknown kinds of results, and an axis that has the name of a result. Each row of a table is a value.
    """
    for keep in campaign.keep:
        if keep not in kinds.KINDS:
            raise BadScene(
                f"{campaign.name}: unknown keep = {keep!r}: must be one of {', '.join(kinds.KINDS)}"
            )
        require_other_names(campaign, kinds.KINDS[keep].names)
    ends, first, end = _ends(campaign), campaign.point(0), perf_counter() + REQUIRES_FOR

    def reason(point: Point) -> str:
        """Return why the scene at a point is impossible, or ""; results are asked for until the end."""
        try:
            scene = campaign.scene(point)
            for keep in campaign.keep if perf_counter() < end else ():
                kinds.KINDS[keep].require(scene)
        except WrongInput as error:
            return str(error).removeprefix(f"{campaign.point_name(point)}: ")
        return ""

    def is_hopeless(point: Point, k: int) -> bool:
        """Whether no ends of the other axes are possible with the value of an axis; of tables True."""
        others = product(*ends[:k], (point[k],), *ends[k + 1 :]) if ends else ()
        return all(map(reason, islice(others, MOST_OTHERS)))

    wrong, combinations = dict[str, str](), dict[str, str]()
    for point in checked_points(campaign):
        why = reason(point)
        if why and why not in wrong | combinations:
            values = [k for k, value in enumerate(point) if value != first[k]] or range(len(point))
            is_wrong = any(is_hopeless(point, k) for k in values)
            (wrong if is_wrong else combinations)[why] = f"at {campaign.point_name(point)}: {why}"
        if len(wrong) == MOST_REASONS:
            break
    require_none(campaign.name, [*wrong.values()])
    mixed = product(*ends) if campaign.is_grid else campaign.listed if campaign.is_random else ()
    for point in islice(mixed, MOST_CHECKED):
        if len(combinations) >= MOST_REASONS:
            break
        if why := reason(point):
            combinations.setdefault(why, f"at {campaign.point_name(point)}: {why}")
    return [*combinations.values()]


def checked_points(campaign: Campaign) -> Iterator[Point]:
    """Yield up to `MOST_CHECKED` points: each value, and each row of a table, extreme ones first.

    Each value of an axis comes with the first values of the others, coarsely first, and the axes take turns;
    random points give the ends.
    """
    if campaign.is_grid or campaign.is_random:
        columns, first = _ends(campaign), campaign.point(0)
        if campaign.is_grid:
            columns = [[axis.values[k] for k in coarse_order((len(axis.values),))] for axis in campaign.axes]
        turns = ((place, k) for place in range(max(map(len, columns))) for k in range(len(columns)))
        points: Iterator[Point] = (
            (*first[:k], columns[k][place], *first[k + 1 :]) for place, k in turns if place < len(columns[k])
        )
    else:
        points = _rows_to_check(campaign.listed)
    yield from islice(points, MOST_CHECKED)


def _ends(campaign: Campaign) -> Sequence[Sequence[Value]]:
    """Return the ends of each axis; of random points the least and the largest, of tables ()."""
    if campaign.is_grid:
        return [axis.values[:: len(axis.values) - 1 or 1] for axis in campaign.axes]
    columns = zip(*campaign.listed, strict=True) if campaign.is_random else ()
    return [(min(column), max(column)) for column in columns]


def _rows_to_check(points: Sequence[Point]) -> Iterator[Point]:
    """Yield the first point, those with extreme numbers and with each text, then evenly spaced ones."""
    yield points[0]
    for column in zip(*points, strict=True):
        numbers = [k for k, value in enumerate(column) if is_number(value)]
        if numbers:
            yield points[min(numbers, key=column.__getitem__)]
            yield points[max(numbers, key=column.__getitem__)]
        texts = {str(value): k for k, value in enumerate(column) if not is_number(value)}
        yield from (points[k] for k in texts.values())
    yield from points[:: -(-len(points) // MOST_CHECKED)]


# --- cost -----------------------------------------------------------------------------------------------


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
    for _, task in campaign_tasks(campaign, store):
        if keys.intersection(task.keys.values()) and stored_outcome(task, store):
            reused += 1
        elif len(first) < COUNTED:
            first.append(task)
    models, counted, left = set[str](), 0, campaign.size - reused
    for task in _within_time_limit(first):
        models.update(model_tasks(task, store))
        counted += 1
    besides = []  # seconds besides models, of scenes that can be built
    for task in first[:SAMPLED]:
        with suppress(Failure, WrongInput):
            besides.append(sum(kinds.KINDS[keep].seconds(task.scene) for keep in task.keys))
    model_plans = _sample_plans(first[:SAMPLED])
    a_model = sum(plan.expected.seconds for plan in model_plans) / max(1, len(model_plans))
    a_scene = sum(besides) / max(1, len(besides)) + a_model * len(models) / max(1, counted)
    memory = max([plan.expected.memory for plan in model_plans], default=BASE_MEMORY)
    return SweepPlan(campaign.size, reused, counted, len(models), a_scene * left, memory)


def largest_memory(campaign: Campaign) -> float:
    """Return the memory [MB] of the largest model of the first scenes of a campaign, finished or not."""
    first = islice(campaign_tasks(campaign, Store()), SAMPLED)
    model_plans = _sample_plans([task for _, task in first])
    return max([plan.expected.memory for plan in model_plans], default=BASE_MEMORY)


def _sample_plans(tasks: list[SceneTask]) -> list[ModelPlan]:
    """Return the models of scenes, each model of a scene once; none of those that cannot be built."""
    model_plans = list[ModelPlan]()
    for task in _within_time_limit(tasks):
        with suppress(Failure, WrongInput):
            scene = task.scene
            for keep in task.keys:
                for jobs in kinds.KINDS[keep].jobs(scene):
                    model_plans += plans(jobs, 1)
    return model_plans


def _within_time_limit(tasks: list[SceneTask]) -> Iterator[SceneTask]:
    """Yield the tasks, at least one, until it takes too long."""
    start = perf_counter()
    for task in tasks:
        yield task
        if perf_counter() - start > LONGEST:
            return
