"""The command `fe-contact`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cli.work import SceneName, Work
from femic.contact.finite_elements.fineness import CELLS, require_enough
from femic.late import Late
from femic.scenes.load import load_scene

compute_contact = Late("compare.contact.compute:compute_contact")
to_dataset = Late("compare.contact.dataset:to_dataset")
write_contact = Late("compare.contact.page:write_contact")
require_suitable = Late("compare.finite_elements.compute:require_suitable")
compute_fe_contact = Late("compare.finite_elements.compute:compute_fe_contact")
stored_solution = Late("compare.finite_elements.beside:stored_solution")
maps_of_scene = Late("femic.campaigns.maps.c_map:maps_of_scene")
write_fe_contact = Late("compare.finite_elements.page:write_fe_contact")


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
        with_ics = compute_contact(loaded, options, maps_of_scene(loaded))
        report = write_fe_contact(compute_fe_contact(loaded, to_dataset(with_ics), options, cells), folder)
        beside = write_contact(with_ics, folder, further=stored_solution(with_ics, options.store))
    console.print(f"Report: {report}, and with ICs {beside}", soft_wrap=True)
