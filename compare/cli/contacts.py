"""The command `contact`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.cli.work import DEFAULT_WORK, SceneName, Work
from compare.reports.contact.page import write_contact
from compare.scenes.load import load_scene


def contact(
    scene: SceneName,
    /,
    *,
    ics: Annotated[
        str | None, Parameter(help="such as A,B,Bhat,C: which ICs to solve it with; default: the scene's")
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the frictionless contact of a scene with several ICs; write contact.nc and a report."""
    loaded = load_scene(scene, {"contact": {"ics": ics.split(",")}} if ics else None)
    folder, console = work.folder(loaded), Console()
    with work.means(folder, console) as means:
        report = write_contact(loaded, folder, means)
    console.print(f"Report: {report}", soft_wrap=True)
