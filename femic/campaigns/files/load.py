"""Load campaigns from TOML files.

scene = "geometry1"                     # built-in name, or a file beside this one
keep = ["errors"]

[set]                                   # keys that all scenes of the campaign share
engine = { tolerance = 0.02 }

[sweep.flank]                           # an axis
keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
from = 0
to = 60
count = 7

[sweep.ratio]
keys = { "upper.contour.radius" = 10 }  # value times 10
values = [1.05, 1.2, 1.5]
"""

from collections.abc import Iterator
from copy import deepcopy
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from pydantic import ValidationError

from femic.campaigns.files.campaign import Campaign, SweptAxis
from femic.campaigns.files.keys import DIGITS, AxisTable, CampaignFile
from femic.campaigns.files.point_order import Point
from femic.campaigns.files.points_table import points_in
from femic.scenes.errors import BadScene, bad_scene
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute
from femic.scenes.load import merged, name_of, read_scene, read_toml, scene_path
from femic.scenes.messages import message

MOST_SCENES = 10_000_000
MOST_AXES = 32  # of a grid


def load_campaign(path: Path) -> Campaign:
    """Load the campaign of a TOML file; raise BadScene before any work.

    Scenes at the first point and at the ends of each axis are built, to see whether keys and values fit.
    """
    if not path.is_file():
        raise BadScene(
            f"campaign {str(path)!r}: no such file; docs/how-to/campaigns.md has one to begin with"
        )
    text, given = read_toml(path)
    parsed = _parsed(given, path)
    local = path.parent / parsed.scene
    base = local if local.is_file() else scene_path(parsed.scene)
    _, table = read_scene(base)
    changes = deepcopy(parsed.set)
    make_files_absolute(changes, SceneFile, path.parent)
    campaign = Campaign(
        name_of(path),
        parsed.title or name_of(path),
        text,
        parsed.keep,
        merged(table, changes),
        _axes(parsed, path),
        tuple(_listed(parsed, path)),
        parsed.points == "random",
        path.parent.absolute(),
    )
    for point in _first_points(campaign):
        try:
            campaign.scene(point)
        except BadScene as error:
            if all(any(map(campaign.is_possible, points)) for points in campaign.others(point)):
                continue  # this combination will be recorded as a failure
            raise BadScene(f"{path}: at {campaign.point_name(point)}: {error}") from error
    return campaign


def _parsed(given: dict[str, Any], path: Path) -> CampaignFile:
    if isinstance(given.get("points"), str) and given["points"] not in ("all", "random"):
        given["points"] = path.parent / given["points"]
    try:
        return CampaignFile.model_validate(given)
    except ValidationError as error:
        raise bad_scene(path, map(message, error.errors())) from error


def _axes(parsed: CampaignFile, path: Path) -> tuple[SweptAxis, ...]:
    """Return the axes; raise BadScene where a grid is too large."""
    is_grid, axes = parsed.points == "all", []
    for name, table in parsed.sweep.items():
        try:
            axes.append(_axis(name, table, is_grid=is_grid))
        except BadScene as error:
            raise BadScene(f"{path}: sweep.{name}: {error}") from error
    scenes = prod(len(axis.values) for axis in axes)
    if is_grid and (scenes > MOST_SCENES or len(axes) > MOST_AXES):
        raise BadScene(
            f"{path}: sweep: {scenes:.3g} scenes over {len(axes)} axes; at most {MOST_SCENES:.0e} over "
            f"{MOST_AXES}: give fewer values, or points = 'random'"
        )
    return tuple(axes)


def _axis(name: str, table: AxisTable, *, is_grid: bool) -> SweptAxis:
    factors = dict(table.keys) if isinstance(table.keys, dict) else dict.fromkeys(table.keys)
    values = _values(table) if is_grid else ()
    return SweptAxis(name, table.label or name, table.unit, values, factors, table.spacing)


def _values(table: AxisTable) -> Point:
    """Return the values of an axis of a grid; raise BadScene where a range gives one value twice."""
    if table.start is None or table.to is None or table.count is None:
        return table.values
    values = (table.start, *map(table.between, np.linspace(0, 1, table.count)[1:-1].tolist()), table.to)
    if not np.all(np.diff(values) > 0):
        raise BadScene(f"count = {table.count}: values are the same to {DIGITS} digits: give fewer")
    return values


def _listed(parsed: CampaignFile, path: Path) -> list[Point]:
    """Return the points of a campaign that is not a grid."""
    if parsed.points == "all":
        return []
    if parsed.points == "random":
        return _random(parsed)
    try:
        return points_in(Path(parsed.points), list(parsed.sweep))
    except BadScene as error:
        raise BadScene(f"{path}: points = {error}") from error


def _random(parsed: CampaignFile) -> list[Point]:
    """Return points of a scrambled Sobol sequence, whose first points cover the ranges, too."""
    sequence = scipy.stats.qmc.Sobol(len(parsed.sweep), rng=parsed.seed)
    shares = sequence.random_base2(int(np.ceil(np.log2(max(parsed.samples, 2)))))[: parsed.samples]
    columns = []
    for axis, share in zip(parsed.sweep.values(), shares.T, strict=True):
        columns.append([axis.between(float(value)) for value in share])
    return list(zip(*columns, strict=True))


def _first_points(campaign: Campaign) -> Iterator[Point]:
    """Yield points whose scenes are built when a file is loaded: the first one, then one axis at its end."""
    if not campaign.is_grid:
        yield from islice(campaign.listed, 2)
        return
    first = campaign.point(0)
    yield first
    for k, axis in enumerate(campaign.axes):
        yield (*first[:k], axis.values[-1], *first[k + 1 :])
