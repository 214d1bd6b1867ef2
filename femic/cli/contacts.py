"""The command `contact`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cache import folders
from femic.cli.work import DEFAULT_WORK, Work
from femic.late import Late
from femic.scenes import plausibility
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

require_solvable = Late("compare.contact.compute:require_solvable")
compute_contact = Late("compare.contact.compute:compute_contact")
write_contact = Late("compare.contact.page:write_contact")
write_sensitivity = Late("compare.contact.page:write_sensitivity")
is_mapped = Late("compare.contact.sensitivity:is_mapped")
changed_supports = Late("femic.contact.pairs.supports:changed_supports")
compute_with_friction = Late("compare.friction.compute:compute_with_friction")
PAGES = Late("compare.friction.pages:PAGES")
require_page = Late("compare.friction.pages:require_page")
with_supports = Late("compare.friction.supports:with_supports")
stored_solution = Late("compare.finite_elements.beside:stored_solution")
maps_of_scene = Late("femic.campaigns.maps.c_map:maps_of_scene")


def contact(
    *scene: Annotated[str, Parameter(help="built-in name (see `femic scenes`) or TOML file")],
    ics: Annotated[
        str | None, Parameter(help="such as A,B,Bhat,C: which ICs to solve it with; default: the scene's")
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the contact of scenes with several ICs, without or with friction; write contact.nc and a report.

    `contact.motion` of a scene says which: none without friction, else steady rolling or compression. Of two
    frictionless scenes or more, maps show where A and B-hat differ under pressures of one on the patch of
    another.
    """
    if not scene:
        raise WrongInput("SCENE: name one scene or more, such as wide tall")
    changes = {"contact": {"ics": [_from_here(name) for name in ics.split(",")]}} if ics else None
    scenes = [load_scene(name, changes) for name in scene]
    for loaded in scenes:
        require_solvable(loaded)  # raises before any work starts
        require_page(loaded)
    if len({loaded.name for loaded in scenes}) < len(scenes):
        raise WrongInput(f"SCENE: {', '.join(scene)}: two have the same name; rename a file")
    console, contacts = Console(), {}
    mapped = [loaded.name for loaded in scenes if is_mapped(loaded)]
    of_each = [work.folder_among(loaded, scenes) for loaded in scenes]
    of_maps = [work.joint_folder(mapped)] if len(mapped) > 1 else []
    for folder in (*of_each, *of_maps):
        folders.require_usable(folder)
    for loaded, folder in zip(scenes, of_each, strict=True):
        for text in plausibility.warnings(loaded):
            console.print(f"note: {text}", markup=False, highlight=False, soft_wrap=True)
        with work.options(folder, console) as options:
            if loaded.contact.friction is None:
                solved = contacts[loaded.name] = compute_contact(loaded, options, maps_of_scene(loaded))
                supports = changed_supports(solved.solved, options)
                report = write_contact(solved, folder, supports, stored_solution(solved, options.store))
            else:
                dataset = with_supports(loaded, compute_with_friction(loaded, options), options)
                report = PAGES.resolved[loaded.contact.motion](dataset, folder)
        console.print(f"Report: {report}", soft_wrap=True)
    for folder in of_maps:
        with folders.locked(folder):
            report = write_sensitivity({name: contacts[name] for name in mapped}, folder)
        console.print(f"Report: {report}", soft_wrap=True)


def _from_here(name: str) -> str:
    """Return the name of ICs; a map's file is found from the working directory."""
    return MAP + str(Path(name.removeprefix(MAP)).absolute()) if is_map(name) else name
