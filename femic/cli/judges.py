"""The command `judge`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.contact.compute import compute_contact
from compare.contact.dataset import to_dataset
from compare.contact.page import write_contact
from compare.finite_elements.beside import beside_of
from compare.finite_elements.compute import compute_judged, require_judgeable
from compare.finite_elements.page import write_judged
from femic.cli.work import SceneName, Work
from femic.contact.finite_elements.result import CELLS, require_enough
from femic.scenes.load import load_scene


def judge(
    scene: SceneName,
    *,
    cells: Annotated[
        float, Parameter(help="of the finest mesh, along the patch's shorter half-length")
    ] = CELLS,
    work: Work | None = None,
) -> None:
    """Solve the contact of a scene by finite elements, without ICs, and judge that by its ICs.

    Writes judge.nc and judge.html, and contact.html with both. A load takes minutes and gigabytes; finished
    ones are kept.
    """
    loaded, work, console = load_scene(scene), work or Work(), Console()
    require_judgeable(loaded)
    require_enough(cells)
    folder = work.folder(loaded)
    with work.means(folder, console) as means:
        by_ics = compute_contact(loaded, means)
        report = write_judged(compute_judged(loaded, to_dataset(by_ics), means, cells), folder)
        beside = write_contact(by_ics, folder, beside=beside_of(by_ics, means.store))
    console.print(f"Report: {report}, and by ICs {beside}", soft_wrap=True)
