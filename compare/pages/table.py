"""The page of a table of creep forces: how accurate it is, what it is over, and what is in it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import FURTHER, ics_symbol
from compare.report.parts import Folded, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Cell, Row, Table, number_text, numbers, texts
from femic.contact.pairs.ics import C
from femic.results.tables import NUMBERS, OF_AXES, error, interpolated
from femic.tables.creep_table import AXES

FORCES = ("f_x", "f_y", "m_n")
CURVES = 61  # points of a curve
MOST_CURVES = 6
MEASURE = (
    "The table is compared with {n} contacts at random places between its nodes, which are solved on "
    "elements of half the size. “95 %” is the deviation that 95 % of them have at most, relative to friction "
    "times normal force for forces, also times half_size for moments."
)
MEANING = (
    "The approach is that of the load without friction and stays the same with friction. f_x, f_y and m_n "
    "are shares of friction times normal force: along x, along the contact plane (positive away from the "
    "gauge side, as y), and the moment about the normal through the centre of pressures. Creepages are "
    "relative to those of full sliding, friction times creepage_scale."
)
FILES = (
    "table.txt holds all numbers and says what they are. creep_table.py (NumPy) and creep_table.h (C99) "
    "beside it read and interpolate it; neither needs femic."
)


def write_report(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `table.html` and its figures; returns the path of the page."""
    title = f"Table of creep forces: {dataset.attrs['title']}"
    page = Page(title, summary(dataset), _sections(dataset), answer(dataset), list(doubts(dataset)))
    return write_results(page, folder, "table")


def summary(dataset: xr.Dataset) -> str:
    """Return how accurate the table is, and what it is over."""
    tolerance = dataset.attrs["tolerance"]
    forces = max(error(dataset, name) for name in FORCES)
    ranges = ", ".join(_range_text(dataset, axis) for axis in ("shift", "load", "friction"))
    return (
        f"95 % of other contacts differ by at most {100 * forces:.1f} % of friction times normal force from "
        f"the table (limit {100 * tolerance:g} %), and by {100 * error(dataset, 'p_max'):.1f} % of p_max. "
        f"It is by {ics_symbol(dataset.attrs['ics'])}, over {ranges}, spin and creepages: "
        f"{dataset.attrs['solved']} contacts were solved."
    )


def doubts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what the deviations of the table do not contain, and what of the scene it does not use."""
    if (ics := dataset.attrs["ics"]) != C:
        symbol = ics_symbol(ics)
        yield (
            f"Contacts are solved with {symbol}. How much contacts with C differ is in no number here: "
            f"`femic contact` with ics = [{ics!r}, 'C'] shows it for one contact."
        )
    if unused := dataset.attrs["unused"]:
        yield f"The table does not use {unused}: each of its contacts has a load and a grid of its own."


def _range_text(dataset: xr.Dataset, axis: str) -> str:
    """Return the range of an axis with its unit."""
    values, unit = dataset[axis].values, OF_AXES[axis][0]
    unit = "" if unit == "1" else f" {unit}"
    low, high = (number_text(value, ".6g") for value in (values[0], values[-1]))
    name = "shifts" if axis == "shift" else "loads" if axis == "load" else axis
    return f"{name} {low}{unit}" if len(values) == 1 else f"{name} {low} to {high}{unit}"


def answer(dataset: xr.Dataset) -> Table:
    """Return the deviations of the table from other contacts."""
    rows = []
    for name, meaning in NUMBERS.items():
        values = np.abs(dataset[f"deviation_{name}"].values)
        known = error(dataset, name)
        texts_ = [f"{known:.2g} rad", f"{values.max():.2g} rad"] if name == "contact_angle" else None
        rows.append(Row(meaning, texts_ or [f"{100 * known:.2f} %", f"{100 * values.max():.2f} %"]))
    return Table("deviation from other contacts", numbers("95 %", "largest"), rows)


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    yield Section("Creep forces", [creep_forces(dataset), Note(MEANING)])
    if dataset.sizes["shift"] > 1:
        yield Section("Contacts without friction", [contacts(dataset)])
    yield Section("", [MEASURE.format(n=dataset.sizes["case"]), FILES])
    yield Folded("Nodes of the table", [nodes(dataset)])
    yield Folded("Scene file", [Verbatim(dataset.attrs["scene"])])


def creep_forces(dataset: xr.Dataset) -> Chart:
    """Return creep forces over longitudinal and lateral creepage at some shifts, by the table itself."""
    table = interpolated(dataset)
    load, friction = (float(dataset[axis].values[-1]) for axis in ("load", "friction"))
    shifts = dataset["shift"].values
    shown = shifts[
        np.unique(np.linspace(0, len(shifts) - 1, min(MOST_CURVES, len(shifts))).round().astype(int))
    ]
    signed = np.linspace(-1.0, 1.0, CURVES) * 0.9
    sizes = np.abs(signed) / (1 - np.abs(signed)) * np.sign(signed)
    panels = []
    for angle, name, title in ((0.0, "f_x", "longitudinal"), (np.pi / 2, "f_y", "lateral")):
        curves = []
        for shift, look in zip(shown, FURTHER, strict=False):
            at = [(angle + np.pi * (size < 0), abs(size) / (1 + abs(size))) for size in sizes]
            values = [table.shares(shift, load, friction, 0.0, *polar)[name] for polar in at]
            curves.append(Curve(f"shift {shift:.4g} mm", sizes, values, look))
        panels.append(
            Panel(
                f"{title} creepage",
                "creepage over that of full sliding",
                f"{name} [share of friction × normal force]",
                curves,
                limits_x=(-3.0, 3.0),
            )
        )
    alt = "longitudinal and lateral creep force over creepage at several shifts"
    return Chart("creep_forces", {"": panels}, 2, heights=1.2, alt=alt)


def contacts(dataset: xr.Dataset) -> Chart:
    """Return contact angle, largest pressure and normal force over the shift, at each load."""
    shown = (("contact_angle", 180 / np.pi, "°"), ("p_max", 1.0, "MPa"), ("normal_force", 1e-3, "kN"))
    shifts, loads, panels = dataset["shift"].values, dataset["load"].values[-MOST_CURVES:], []
    for name, factor, unit in shown:
        curves = [
            Curve(f"load {load:.6g} N", shifts, factor * dataset[name].sel(load=load).values, look)
            for load, look in zip(loads, FURTHER, strict=False)
        ]
        title = name.replace("p_max", "largest pressure").replace("_", " ")
        panels.append(Panel(title, "lateral shift [mm]", f"{name} [{unit}]", curves))
    alt = "contact angle, largest pressure and normal force over the shift"
    return Chart("contacts", {"": panels}, 3, alt=alt)


def nodes(dataset: xr.Dataset) -> Table:
    """Return the nodes of all axes."""
    rows = [
        Row(
            axis,
            [
                OF_AXES[axis][1],
                Cell(OF_AXES[axis][0]),
                Cell(f"{dataset.sizes[axis]}"),
                ", ".join(f"{value:.5g}" for value in dataset[axis].values),
            ],
        )
        for axis in AXES
    ]
    return Table("axis", texts("meaning", "unit", "nodes", "values"), rows)
