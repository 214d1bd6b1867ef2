"""Checks of a campaign before its run: kinds of results, names of axes, scenes at single points."""

from time import perf_counter

from femic.campaigns.dataset.frame import require_other_names
from femic.campaigns.files.campaign import Campaign
from femic.campaigns.files.point_order import Point
from femic.campaigns.results import registry
from femic.scenes.errors import BadScene, require_none
from geometries.errors import WrongInput

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
