"""The command `fe-contact`."""

from typing import Annotated

from cyclopts import Parameter

from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce
from femic.contact.finite_elements import CELLS, require_enough
from femic.lazy import lazy_imports
from femic.scenes.load import load_scene

with lazy_imports():
    from compare.campaigns import maps as c_map
    from compare.pages import contact as page
    from compare.pages import finite_elements as fe_page
    from femic.results import contact as compute
    from femic.results import finite_elements as fe_compute


def fe_contact(
    scene: SceneName,
    *,
    cells: Annotated[
        float, Parameter(help="of the finest mesh, along the patch's shorter half-length")
    ] = CELLS,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the contact of a scene by finite elements, without ICs, and compare contact with its ICs to it.

    Writes fe_contact.nc and fe_contact.html, and contact.html with both. A load takes minutes and gigabytes;
    finished loads are stored.
    """
    loaded, console = load_scene(scene), terminal()
    fe_compute.require_suitable(loaded)
    require_enough(cells)
    folder = work.folder(loaded)
    with work.options(folder, console) as options:
        with_ics = compute.compute_contact(loaded, options, c_map.maps_of_scene(loaded))
        fe_dataset = fe_compute.compute_fe_contact(loaded, compute.to_dataset(with_ics), options, cells)
        report = fe_page.write_fe_contact(fe_dataset, folder)
        with_both = page.write_contact(
            with_ics, folder, further=fe_page.stored_solution(with_ics, options.store)
        )
    for path in (report, with_both):
        announce(path, console)
