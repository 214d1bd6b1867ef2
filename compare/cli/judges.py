"""The command `judge`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.cli.work import SceneName, Work
from compare.reports.judge.page import write_judged
from compare.results import folders
from compare.results.judge.compute import compute_judged, require_judgeable
from compare.scenes.load import load_scene
from contact.judge.judgement import CELLS


def judge(
    scene: SceneName,
    *,
    cells: Annotated[
        float, Parameter(help="of the finest mesh, along the patch's shorter half-length")
    ] = CELLS,
    work: Work | None = None,
) -> None:
    """Solve the contact of a scene by finite elements, without ICs, and judge that by its ICs.

    Writes judge.nc and judge.html. A load takes minutes and gigabytes; finished ones are kept.
    """
    loaded, work, console = load_scene(scene), work or Work(), Console()
    require_judgeable(loaded)
    folder = folders.checked(work.folder(loaded))
    with work.means(folder, console) as means:
        report = write_judged(compute_judged(loaded, means, cells), folder)
    console.print(f"Report: {report}", soft_wrap=True)
