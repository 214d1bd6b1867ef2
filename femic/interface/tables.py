"""Tables of creep forces over shift, load, friction and creepages, for vehicle codes and loops."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import xarray as xr

from femic.interface.arguments import shown, with_checked_arguments
from femic.interface.bodies import Pair, checked, given
from femic.interface.contact import AUTOMATIC, ContactSetup
from femic.interface.options import DEFAULT, Options, in_turn, make_scene
from femic.results import tables
from femic.scenes.contact import CreepTable
from femic.tables.creep_table import Table
from femic.tables.specification import TableSpecification
from geometries.errors import WrongInput


@with_checked_arguments
@in_turn
def compute_table(
    pair: Pair,
    loads: Sequence[float],
    shifts: Sequence[float] = (0.0,),
    friction: Sequence[float] = TableSpecification.friction,
    *,
    spin: float = TableSpecification.spin,
    ics: str = TableSpecification.ics,
    tolerance: float = TableSpecification.tolerance,
    elements: int = TableSpecification.elements,
    setup: ContactSetup = AUTOMATIC,
    options: Options = DEFAULT,
) -> xr.Dataset:
    """Compute a table of creep forces of a pair whose upper body is a wheel.

    It is over lateral `shifts` [mm], vertical `loads` [N], coefficients of `friction`, and creepages; `spin`
    is the largest one, over that which makes a contact slide. Nodes are added until 95 % of other contacts
    differ by at most `tolerance` from the table (forces as shares of friction times normal force). Contacts
    have `elements` across the smallest patch; of `setup`, a table takes `flanks` and `extra_gap`.

    `read_table` takes the dataset and interpolates in it; `write_table` writes it. Raises WrongInput; raises
    Failure if a contact has no solution, or the table does not reach the tolerance.
    """
    if replace(setup, flanks=True, extra_gap=None).keys != AUTOMATIC.keys:
        raise WrongInput(
            f"setup = {shown(setup)}: a table takes flanks and extra_gap only; give it shifts and elements"
        )
    keys = {
        "loads": loads,
        "shifts": shifts,
        "friction": friction,
        "spin": spin,
        "ics": ics,
        "tolerance": tolerance,
        "elements": elements,
    }
    table = checked(CreepTable, given(keys))
    scene = make_scene(pair, options, {"table": table, "contact": {"flanks": setup.flanks}})
    scene = replace(scene, contact=replace(scene.contact, extra_gap=setup.added_gap))
    return tables.compute_table(scene, options.run)


@with_checked_arguments
def read_table(table: xr.Dataset | str | Path) -> Table:
    """Return a table to interpolate in: of `compute_table`, or from a file table.nc or table.txt.

    Its methods `contact` and `forces` [N, N mm, MPa] are those of `creep_table.py`, which is written beside
    the files and needs no femic. Raises WrongInput; the methods raise ValueError outside the table.
    """
    return tables.interpolated(table) if isinstance(table, xr.Dataset) else tables.read_table(Path(table))


@with_checked_arguments
def write_table(table: xr.Dataset, folder: str | Path) -> None:
    """Write table.nc and table.txt of a dataset of `compute_table` [mm, N, MPa] into a folder, with readers.

    Raises WrongInput for other datasets.
    """
    tables.interpolated(table)  # raises for other datasets
    tables.write_table(table, Path(folder))
