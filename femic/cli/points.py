"""Scenes of a campaign as files, for commands that take scenes."""

from hashlib import sha256
from pathlib import Path

import tomlkit

from compare.campaigns.campaign import Campaign, find_points
from compare.campaigns.load import load_campaign
from compare.pages.ics_results import MOST_SCENES
from femic.cache import folders
from femic.cache.files import write_text
from femic.cli.work import AT
from geometries.errors import WrongInput

LONGEST_NAME = 100  # of a file


def write_scenes(campaign: Campaign, name: str, folder: Path) -> list[Path]:
    """Return the files of the scenes at some points, in a folder; raise BadScene before any is written.

    They are as the campaign computes them, without the check by the other engine.
    """
    points, paths = find_points(campaign, name), []
    for point in points:
        campaign.scene(point)
    for point in points:
        table, file = campaign.scene_table(point), campaign.point_name(point)
        if table.get("engine", {}).get("check"):
            table = table | {"engine": table["engine"] | {"check": False}}
        if len(file) > LONGEST_NAME:
            file = f"{file[:LONGEST_NAME]}_{sha256(file.encode()).hexdigest()[:8]}"
        path = folders.make(folder) / f"{file.replace('/', '_')}.toml"
        paths.append(write_text(tomlkit.dumps(table), path))
    return paths


def find_scenes(argument: str, results: Path) -> dict[str, str | None]:
    """Return the scenes of an argument, and the store of the models of each; None: no store yet.

    The scenes are the argument itself, or files of points of a campaign such as CAMPAIGN.toml@flank=30,
    some of whose models the campaign has stored.
    """
    file, at, name = argument.rpartition(AT)
    if not at or Path(argument).exists():
        return {argument: None}
    campaign = load_campaign(Path(file))
    if (count := len(find_points(campaign, name))) > MOST_SCENES:
        raise WrongInput(f"{argument}: {count} scenes; at most {MOST_SCENES} are compared: name another axis")
    folder = results / campaign.name
    store = str(folder / "store") if (folder / "store").is_dir() else None
    return {str(path): store for path in write_scenes(campaign, name, folder)}
