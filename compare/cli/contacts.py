"""The command `contact`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.cli.work import StoreAt, Work, Workers
from compare.reports.contact.page import write_contact, write_sensitivity
from compare.results import folders
from compare.results.contact.compute import cases_of, compute_contact
from compare.scenes import plausibility
from compare.scenes.load import load_scene
from geometries.errors import WrongInput


def contact(
    *scene: Annotated[str, Parameter(help="built-in name (see `femic scenes`) or TOML file")],
    ics: Annotated[
        str | None, Parameter(help="such as A,B,Bhat,C: which ICs to solve it with; default: the scene's")
    ] = None,
    out: Annotated[Path, Parameter(help="folder that gets the results of each scene in SCENE/")] = Path(
        "out"
    ),
    workers: Workers = None,
    store: StoreAt = None,
) -> None:
    """Solve the frictionless contact of scenes with several ICs; write contact.nc and a report of each.

    Of two scenes or more, maps show where A and B-hat differ under pressures of one on the patch of another.
    """
    if not scene:
        raise WrongInput("SCENE: name one scene or more, such as wide tall")
    changes = {"contact": {"ics": ics.split(",")}} if ics else None
    scenes = {name: load_scene(name, changes) for name in scene}
    for loaded in scenes.values():
        cases_of(loaded)  # raises before any work starts
    console, results = Console(), {}
    for loaded in scenes.values():
        for text in plausibility.warnings(loaded):
            console.print(f"note: {text}", markup=False, highlight=False, soft_wrap=True)
        work = Work(out / loaded.name, workers, store)
        with work.means(folders.checked(work.folder(loaded)), console) as means:
            results[loaded.name] = compute_contact(loaded, means)
        report = write_contact(results[loaded.name], work.folder(loaded))
        console.print(f"Report: {report}", soft_wrap=True)
    if len(results) > 1:
        console.print(f"Report: {write_sensitivity(results, out / '_'.join(results))}", soft_wrap=True)
