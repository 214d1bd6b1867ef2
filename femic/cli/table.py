"""The command `table`: creep forces of a pair at many positions, loads and creepages, for other programs."""

from contextlib import ExitStack
from functools import partial
from typing import Annotated

from cyclopts import Parameter

from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce, print_warnings
from femic.lazy import lazy_imports
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.campaigns import cluster
    from compare.pages import table as page
    from femic.results import tables

CONTACTS_PER_SECOND, PLACES_PER_SECOND = 150, 1  # of a core, roughly


def table(
    scene: SceneName,
    /,
    *,
    plan: Annotated[bool, Parameter(negative="", help="estimate the cost only")] = False,
    scheduler: Annotated[
        str | None, Parameter(help="address of a Dask scheduler; default: the cores of this machine")
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute a table of creep forces over shift, load, friction and creepages, as [table] of a scene says.

    Writes table.nc, table.txt with readers in Python and C, and a report. Nodes are added until other
    contacts agree with the table. Solved contacts are stored; after an interruption, repeat the command.
    """
    if scheduler is not None and work.workers is not None:
        raise WrongInput("--workers counts cores of this machine; leave out --workers or --scheduler")
    address = None if scheduler is None else cluster.parse_address(scheduler)
    loaded, console = load_scene(scene), terminal()
    tables.require_table(loaded)
    folder = work.folder(loaded)
    if plan:
        places, contacts = tables.plan_table(loaded)
        seconds = (places / PLACES_PER_SECOND + contacts / CONTACTS_PER_SECOND) / work.threads
        console.print(
            f"{loaded.title}: {contacts} contacts at {places} positions, loads and coefficients of friction, "
            f"and more where they are not close enough. About {seconds:.0f} s or more with {work.threads} "
            "workers, besides C",
            soft_wrap=True,
        )
        return
    print_warnings(loaded, console)
    with ExitStack() as opened:
        options = opened.enter_context(work.options(folder, console))
        spread = None
        if address is not None:
            cluster.require_scheduler(address)
            client = opened.enter_context(cluster.existing_cluster(address))
            spread = partial(cluster.in_order, client)
        dataset = tables.compute_table(loaded, options, spread)
        tables.write_table(dataset, folder)
        report = page.write_report(dataset, folder)
    console.print(page.summary(dataset), soft_wrap=True)
    console.print(f"Table: {folder / 'table.txt'}, table.nc", soft_wrap=True)
    announce(report, console)
