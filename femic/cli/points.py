"""Scenes of a campaign as files, for commands that take scenes."""

from hashlib import sha256
from pathlib import Path
from typing import Any

import tomlkit

from compare.overlay.sources import MOST_SCENES
from femic.cache import folders
from femic.cache.files import write_text
from femic.campaigns.files.campaign import Campaign, points_named
from femic.campaigns.files.load import load_campaign
from femic.cli.work import AT
from geometries.errors import WrongInput

LONGEST_NAME = 100  # of a file


def written(campaign: Campaign, name: str, folder: Path) -> list[Path]:
    """The files of the scenes at some points, in a folder; raises BadScene before any is written.

    They are as the campaign computes them, without the check by the other engine.
    """
    points = points_named(campaign, name)
    for point in points:
        campaign.scene(point)
    return [
        _written(_unchecked(campaign.scene_table(point)), folder, campaign.named(point)) for point in points
    ]


def _unchecked(table: dict[str, Any]) -> dict[str, Any]:
    """The table of a scene without the check by the other engine."""
    engine = table.get("engine", {})
    return table | {"engine": engine | {"check": False}} if engine.get("check") else table


def scenes_of(argument: str, results: Path) -> dict[str, str | None]:
    """The scenes that an argument stands for, and where models of each are kept; None: nowhere yet.

    They are itself, or files of points of a campaign such as CAMPAIGN.toml@flank=30, of whose models the
    campaign has kept some.
    """
    file, at, name = argument.rpartition(AT)
    if not at or Path(argument).exists():
        return {argument: None}
    campaign = load_campaign(Path(file))
    if (count := len(points_named(campaign, name))) > MOST_SCENES:
        raise WrongInput(f"{argument}: {count} scenes; at most {MOST_SCENES} are compared: name another axis")
    folder = results / campaign.name
    store = str(folder / "store") if (folder / "store").is_dir() else None
    return {str(path): store for path in written(campaign, name, folder)}


def _written(table: dict[str, Any], folder: Path, name: str) -> Path:
    if len(name) > LONGEST_NAME:
        name = f"{name[:LONGEST_NAME]}_{sha256(name.encode()).hexdigest()[:8]}"
    return write_text(tomlkit.dumps(table), folders.make(folder) / f"{name.replace('/', '_')}.toml")
