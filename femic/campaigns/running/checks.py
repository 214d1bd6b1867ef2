"""Checks of a campaign before its run: kinds of results, names of axes, scenes at single points."""

from collections.abc import Iterable
from time import perf_counter

from femic.campaigns.dataset.frame import require_other_names
from femic.campaigns.files.campaign import Campaign
from femic.campaigns.files.point_order import Point
from femic.campaigns.results import registry
from femic.scenes.errors import BadScene, require_none
from geometries.errors import WrongInput

REQUIRES_FOR = 10.0  # s in which scenes are checked for the results to keep: some take half a second
MOST_REASONS = 5  # different reasons of impossible scenes that are listed before the run


def require_computable(campaign: Campaign) -> None:
    """Raise BadScene where a value makes a scene impossible, or a scene lacks the results to keep.

    So a wrong value in the middle of an axis is reported before the run; likewise unknown kinds of results,
    and an axis that has the name of a result.
    """
    for keep in campaign.keep:
        if keep not in registry.KINDS:
            raise BadScene(f"{campaign.name}: keep = {keep!r}: must be one of {', '.join(registry.KINDS)}")
        require_other_names(campaign, registry.KINDS[keep].names)
    require_none(campaign.name, _problems(campaign, campaign.checked_points))


def impossible(campaign: Campaign) -> list[str]:
    """Return combinations of values whose scenes will fail, with the reasons, among a sample."""
    return _problems(campaign, campaign.checked_combinations)


def _problems(campaign: Campaign, points: Iterable[Point]) -> list[str]:
    """Return problems of the scenes at some points: the first ones with different reasons."""
    reasons: dict[str, str] = {}
    start = perf_counter()
    for point in points:
        name = campaign.point_name(point)
        try:
            scene = campaign.scene(point)
            for keep in campaign.keep if perf_counter() - start < REQUIRES_FOR else ():
                registry.KINDS[keep].require(scene)
        except WrongInput as error:
            reasons.setdefault(str(error).removeprefix(f"{name}: "), name)
        if len(reasons) == MOST_REASONS:
            break
    return [f"at {name}: {reason}" for reason, name in reasons.items()]
