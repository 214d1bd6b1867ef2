"""Table of creep forces of a scene: what is refused, the dataset `table.nc`, the text file `table.txt`."""

from collections.abc import Iterator
from dataclasses import fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from femic.cache import folders
from femic.cache.digests import results_digest
from femic.cache.files import write_dataset, write_text
from femic.cache.workers import Processes
from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import require_solvable
from femic.scenes.contact import contact_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.ic_names import is_map
from femic.scenes.scene import Scene
from femic.tables.columns import CONTACT, FORCES
from femic.tables.creep_table import AXES, Table, read
from femic.tables.refinement import DRIVING, Judged, Spread, expected_contacts, refined_table
from femic.tables.specification import TableSpecification
from geometries.errors import WrongInput

READERS = "creep_table.py", "creep_table.h"
OF_AXES = {
    "shift": ("mm", "lateral shift of the upper body"),
    "load": ("N", "vertical load of the contact without friction"),
    "friction": ("1", "coefficient of friction"),
    "spin": ("1", "spin of the wheel about z times half_size over friction and creepage_scale"),
    "angle": (
        "rad",
        "angle of the creepage: atan2(lateral cos(contact_angle), longitudinal - free_creepage + spin y)",
    ),
    "creepage": ("1", "m / (1 + m), m the creepage over friction and creepage_scale"),
}
NUMBERS = {  # of which deviations are known
    "f_x": "longitudinal force over friction times normal force",
    "f_y": "lateral force in the plane of the contact over friction times normal force",
    "m_n": "moment about the normal over friction, normal force and half_size",
    "p_max": "largest pressure over itself",
    "normal_force": "force along the normal over itself",
    "work": "work over friction, normal force, saturation and 1 + creepage over saturation",
    "contact_angle": "contact angle [rad]",
}


UNUSED = ("grid", "approaches", "lateral_force")  # keys of [contact] in whose place a table has its own


def table_specification(scene: Scene) -> TableSpecification:
    """Return the specification of a scene's table; defaults are the shift and the loads of its contact."""
    own = scene.table
    loads = own.loads or tuple(sorted(scene.contact.loads))
    return replace(own, shifts=own.shifts or (scene.contact.shift,), loads=loads)


def rolling_scene(scene: Scene) -> Scene:
    """Return the scene as its table has it: a wheel that rolls, with a single name of ICs."""
    own, contact = table_specification(scene), scene.contact
    factors = contact.friction.friction_by_angle if contact.friction else ()
    rolling = replace(
        contact,
        motion="rolling",
        friction=FrictionSpecification(own.friction, friction_by_angle=factors),
        loads=own.loads[-1:],
        approaches=(),
        shift=own.shifts[0],
        ics=(own.ics,),
        gap="linear",
        grid="automatic",
        lateral_force=None,
        elements=own.elements,
    )
    return replace(scene, contact=rolling)


def unused_keys(scene: Scene) -> list[str]:
    """Return the keys of [contact] that a scene gives, and that its table does not use."""
    defaults = {field.name: field.default for field in fields(ContactSpecification)}
    return [f"contact.{key}" for key in UNUSED if getattr(scene.contact, key) != defaults[key]]


def require_table(scene: Scene) -> None:
    """Raise BadScene where a scene has no table, before any work."""
    own = table_specification(scene)
    if not own.loads:
        raise BadScene(f"{scene.name}: table.loads: give loads in N, or contact.loads")
    if is_map(own.ics):
        raise BadScene(
            f"{scene.name}: table.ics: {own.ics}: a map of C has one grid, a table needs many; give C or an "
            "approximation"
        )
    rolling = rolling_scene(scene)
    require_none(scene.name, list(contact_misfits(rolling)))
    for shift in dict.fromkeys((own.shifts[0], own.shifts[-1])):
        require_solvable(replace(rolling, contact=replace(rolling.contact, shift=shift)))


def plan_table(scene: Scene) -> tuple[int, int]:
    """Return the numbers of places and of contacts that a table of a scene has at least."""
    return expected_contacts(rolling_scene(scene).contact_problem, table_specification(scene))


def compute_table(scene: Scene, options: RunOptions = DEFAULT, spread: Spread | None = None) -> xr.Dataset:
    """Return the table of a scene, refined to its tolerance; `spread` solves jobs elsewhere, in their order.

    Raises BadScene, and Failure where contacts have no solution, or the table does not reach its tolerance.
    """
    require_table(scene)
    problem = rolling_scene(scene).contact_problem
    if spread is not None or options.workers == 1:
        judged = refined_table(problem, table_specification(scene), options, spread or map)
    else:
        with Processes(options.workers) as processes:
            judged = refined_table(problem, table_specification(scene), options, processes)
    return to_dataset(scene, judged)


def to_dataset(scene: Scene, judged: Judged) -> xr.Dataset:
    """Return a table with labels, units and meanings, and its deviations from contacts between its nodes."""
    table, own = judged.table, table_specification(scene)
    quantities = zip(table.names, table.quantities, strict=True)
    variables: dict[str, Any] = {
        name: (AXES[:2], np.exp(values) if name in table.logarithmic else values, _labels(*CONTACT[name]))
        for name, values in quantities
    }
    variables |= {
        name: (AXES, values, {"units": "1", "long_name": FORCES[name][1]})
        for name, values in zip(table.force_names, table.values, strict=True)
    }
    variables |= {
        f"deviation_{name}": (
            "case",
            values,
            {"units": "1", "long_name": f"table less contact: {NUMBERS[name]}"},
        )
        for name, values in judged.deviations.items()
    }
    places = [(*place, slip.spin, 2 * np.pi * slip.turn, slip.creepage) for place, slip in judged.places]
    coords = {axis: (axis, table.axes[axis], _labels(*OF_AXES[axis])) for axis in AXES}
    coords |= {
        f"case_{axis}": ("case", values, _labels(*OF_AXES[axis]))
        for axis, values in zip(AXES, np.array(places, float).T, strict=True)
    }
    return xr.Dataset(
        variables,
        coords,
        {
            "title": scene.title,
            "scene": scene.text,
            "ics": own.ics,
            "elements": own.elements,
            "tolerance": own.tolerance,
            "error": judged.worst,
            "solved": judged.solved,
            "unused": ", ".join(unused_keys(scene)),
            "code": results_digest(),
        },
    )


def _labels(unit: str, *meaning: object) -> dict[str, str]:
    return {"units": unit, "long_name": str(meaning[-1])}


def error(dataset: xr.Dataset, name: str) -> float:
    """Return the deviation of a number that 95 % of the contacts between nodes have at most."""
    return float(np.quantile(np.abs(dataset[f"deviation_{name}"].values), 0.95))


# --- the text file, and readers -------------------------------------------------------------------------


def table_text(dataset: xr.Dataset) -> str:
    """Return the text file of a table, as `creep_table.py` and `creep_table.h` read it."""
    return "\n".join(_lines(dataset)) + "\n"


def _lines(dataset: xr.Dataset) -> Iterator[str]:
    def numbers(name: str) -> list[str]:
        rows = dataset[name].values.reshape(-1, dataset[name].shape[-1])
        return [" ".join(f"{value:.9g}" for value in row) for row in rows]

    title = " ".join(dataset.attrs["title"].split())
    yield "femic-creep-table 1"
    yield f"# {title}; ICs: {dataset.attrs['ics']}"
    yield f"# deviation of 95 % of other contacts: {', '.join(_errors(dataset))}"
    yield "# axes: name, number of nodes, nodes"
    for axis in AXES:
        unit, meaning = OF_AXES[axis]
        yield f"# [{unit}] {meaning}"
        yield f"{axis} {dataset.sizes[axis]}"
        yield from numbers(axis)
    yield "# contacts without friction, over shift and load (the last axis fastest)"
    yield str(len(CONTACT))
    for name, (unit, scale, _, meaning) in CONTACT.items():
        yield f"# [{unit}] {meaning}"
        yield f"{name} {scale}"
        yield from numbers(name)
    yield "# contacts with friction, over all axes (the last axis fastest)"
    yield str(len(FORCES))
    for name, (_, meaning) in FORCES.items():
        yield f"# [1] {meaning}"
        yield name
        yield from numbers(name)
    yield "end"


def _errors(dataset: xr.Dataset) -> list[str]:
    return [f"{name} {error(dataset, name):.2g}" for name in DRIVING]


def write_table(dataset: xr.Dataset, folder: Path) -> None:
    """Write `table.nc`, `table.txt` and readers of the latter in Python and C into a folder."""
    folders.make(folder)
    for name in READERS:
        write_text(files("femic.tables").joinpath(name).read_text(encoding="utf-8"), folder / name)
    write_text(table_text(dataset), folder / "table.txt")
    write_dataset(dataset, folder / "table.nc")


def interpolated(dataset: xr.Dataset) -> Table:
    """Return the table of a dataset, to interpolate in it. Raises WrongInput for other datasets."""
    missing = [name for name in (*AXES, *CONTACT, *FORCES) if name not in dataset.variables]
    if missing:
        raise WrongInput(f"table: a dataset without {', '.join(missing)}: give one of compute_table")
    ordered = dataset.transpose(*AXES, ...)
    return Table(
        {axis: ordered[axis].values for axis in AXES},
        {name: ordered[name].values for name in CONTACT},
        [name for name, (_, scale, _, _) in CONTACT.items() if scale == "log"],
        {name: ordered[name].values for name in FORCES},
    )


def read_table(path: Path) -> Table:
    """Return the table in `table.nc` or `table.txt`. Raises WrongInput for other files."""
    if not path.is_file():
        raise WrongInput(f"path = {str(path)!r}: no such file; `femic table` writes table.nc and table.txt")
    try:
        if path.suffix == ".nc":
            with xr.open_dataset(path, engine="h5netcdf") as dataset:
                return interpolated(dataset.load())
        return read(path)
    except (ValueError, OSError) as error:
        raise WrongInput(f"path = {str(path)!r}: {error}") from error
