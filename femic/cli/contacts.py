"""The command `contact`."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.contact.compute import cases_of, compute_contact
from compare.contact.page import write_contact, write_sensitivity
from compare.contact.sensitivity import is_mapped
from compare.contact.supports import changed_supports
from compare.friction.compression import compute_compression
from compare.friction.compression_page import write_compression
from compare.friction.rolling import compute_rolling
from compare.friction.rolling_page import write_rolling
from compare.friction.supports import with_supports
from femic.cache import folders
from femic.cli.work import DEFAULT_WORK, Work
from femic.reference.run_options import RunOptions
from femic.scenes import plausibility
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

WITH_FRICTION: Mapping[str, Callable[[Scene, Path, RunOptions], Path]] = {  # by motion
    "rolling": lambda scene, folder, options: write_rolling(
        with_supports(scene, compute_rolling(scene, options), options), folder
    ),
    "compression": lambda scene, folder, options: write_compression(
        with_supports(scene, compute_compression(scene, options), options), folder
    ),
}


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
        cases_of(loaded)  # raises before any work starts
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
                solved = contacts[loaded.name] = compute_contact(loaded, options)
                supports = changed_supports(solved, options)
                report = write_contact(solved, folder, options.store, supports)
            else:
                report = WITH_FRICTION[loaded.contact.motion](loaded, folder, options)
        console.print(f"Report: {report}", soft_wrap=True)
    for folder in of_maps:
        with folders.locked(folder):
            report = write_sensitivity({name: contacts[name] for name in mapped}, folder)
        console.print(f"Report: {report}", soft_wrap=True)


def _from_here(name: str) -> str:
    """The name of ICs; a map's file is found from the working directory."""
    return MAP + str(Path(name.removeprefix(MAP)).absolute()) if is_map(name) else name
