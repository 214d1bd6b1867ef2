"""The command `fe-contact`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.contact.compute import compute_contact
from compare.contact.dataset import to_dataset
from compare.contact.page import write_contact
from compare.finite_elements.compute import compute_fe_contact, require_suitable
from compare.finite_elements.page import write_fe_contact
from femic.cli.work import SceneName, Work
from femic.contact.finite_elements.result import CELLS, require_enough
from femic.scenes.load import load_scene


def fe_contact(
    scene: SceneName,
    *,
    cells: Annotated[
        float, Parameter(help="of the finest mesh, along the patch's shorter half-length")
    ] = CELLS,
    work: Work | None = None,
) -> None:
    """Solve the contact of a scene by finite elements, without ICs, and compare contact with its ICs to it.

    Writes fe_contact.nc and fe_contact.html, and contact.html with both. A load takes minutes and gigabytes;
    finished loads are stored.
    """
    loaded, work, console = load_scene(scene), work or Work(), Console()
    require_suitable(loaded)
    require_enough(cells)
    folder = work.folder(loaded)
    with work.options(folder, console) as options:
        with_ics = compute_contact(loaded, options)
        report = write_fe_contact(compute_fe_contact(loaded, to_dataset(with_ics), options, cells), folder)
        beside = write_contact(with_ics, folder, options.store)
    console.print(f"Report: {report}, and with ICs {beside}", soft_wrap=True)
