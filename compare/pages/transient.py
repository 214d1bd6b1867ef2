"""The page of transient rolling by several ICs, from its dataset."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from compare.pages.contact_numbers import tolerance
from compare.pages.friction import (
    MotionPage,
    PageParts,
    abscissa,
    by_friction,
    curves_by_ics,
    difference_panel,
    difference_unit,
    friction_text,
    largest_load,
    load_text,
    places,
    quantity_label,
    reference_symbol,
    verdict_cells,
    verdict_text,
    worst_friction,
)
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import Look, drawing_order, ics_looks, ics_symbol
from compare.report.parts import join_words
from compare.report.tables import Cell, Column, Row, Table, with_estimate
from femic.contact.datasets import STEADY
from femic.contact.motions.rolling import scaled_force
from femic.results.contact import compared_ics, ics_names, reference_ics

EVERYWHERE = "at every distance", "at one distance or more"
NOTE = (
    "F_x is the longitudinal force on the wheel. Band: estimated error of {0}. Bars: estimated errors of the "
    "differences; dotted horizontal lines there: the tolerance, key ics_tolerance of the scene. Dotted lines "
    "elsewhere: steady rolling with the same ICs. Grey: friction × load."
)
UNSTEADY = (
    "Rolling has not become steady at the end, with friction {}. Roll further (contact.distance) to see the "
    "steady forces."
)
NEAR = 0.05  # of the steady force, within which transient forces have reached it
LEAST = 0.01  # of friction times load: smaller forces are not drawn
LIMIT = Look("#808080", "solid", width=1)
UNITS = {"creepage": (100.0, " %"), "lateral": (100.0, " %"), "spin": (1.0, " /mm")}


def parts(dataset: xr.Dataset) -> PageParts:
    """Return with which ICs forces are within the tolerance, and where rolling becomes steady."""
    symbol, end = reference_symbol(dataset), f"{float(dataset.distance[-1]):.3g} mm"
    creepages = ", ".join(
        f"{name} {factor * dataset.attrs[name]:.3g}{unit}" for name, (factor, unit) in UNITS.items()
    )
    return PageParts(
        summary=(
            f"{verdict_text(dataset, 'F_x', EVERYWHERE)} From rest, the wheel rolls {end} ({creepages}). "
            f"Load: {load_text(dataset)}; friction: {friction_text(dataset)}; ± is the estimated error."
        ).strip(),
        answer=answer(dataset),
        note=NOTE.format(symbol),
        contact=f"After {end}.",
        work="The maps show the work of friction in the last step, per rolled distance and area: "
        "−(traction · slip).",
        doubts=list(doubts(dataset)),
        steady=STEADY,
    )


def doubts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield at which friction coefficients rolling does not become steady."""
    reference = dataset.sel(ics=reference_ics(dataset))
    unsteady = [
        f"{friction:g}"
        for friction in dataset.friction.values
        if np.isnan(settling_distance(reference.sel(friction=friction)))
    ]
    if unsteady:
        yield UNSTEADY.format(join_words(unsteady))


def settling_distance(rolling: xr.Dataset) -> float:
    """Return the distance [mm] from which on F_x is within `NEAR` of the steady force, or NaN."""
    steady = float(rolling[f"{STEADY}F_x"])
    outside = np.flatnonzero(~(abs(rolling.F_x.values - steady) <= NEAR * abs(steady)))
    first = outside[-1] + 1 if len(outside) else 0
    return float(rolling.distance[first]) if first < rolling.sizes["distance"] else np.nan


def answer(dataset: xr.Dataset) -> Table:
    """Return with which ICs forces are within the tolerance, and forces where ICs differ most."""
    friction, cells = worst_friction(dataset), verdict_cells(dataset)
    force, at = quantity_label(dataset, "F_x"), dataset.sel(friction=friction)
    rows = []
    for name in [reference_ics(dataset), *compared_ics(dataset)]:
        rolling = at.sel(ics=name)
        end = rolling.isel(distance=-1)
        forces: list[Cell | str] = [
            with_estimate(force.factor * end.F_x, force.factor * end.estimate_F_x),
            with_estimate(*(force.factor * end[f"{prefix}F_x"] for prefix in (STEADY, f"estimate_{STEADY}"))),
            Cell(settling_distance(rolling), ".3g"),
        ]
        rows.append(Row(ics_symbol(name), [cells.get(name, Cell("reference")), *forces]))
    columns = [
        Column(f"F_x within {tolerance(dataset):g} {difference_unit(dataset)}?"),
        Column(f"F_x at the end, friction {friction:g}", force.unit),
        Column(f"F_x in steady rolling, friction {friction:g}", force.unit),
        Column(f"within {100 * NEAR:g} % of steady rolling from", "mm"),
    ]
    return Table("ICs", columns, rows)


def growth(dataset: xr.Dataset) -> Chart:
    """Return forces and sliding area over the rolled distance by all ICs, and the difference of F_x."""
    forces = [name for name in ("F_x", "F_y") if abs(scaled_force(dataset, name)).max() > LEAST]
    looks, ends = ics_looks(ics_names(dataset)), places(dataset)[[0, -1]]

    def panel(contacts: xr.Dataset, name: str) -> Panel:
        """Return a number with its steady values as lines, and a force with friction times load as a line."""
        number, is_force = quantity_label(dataset, name), name != "sliding_share"
        values, estimate, steady = (
            number.factor * contacts[key] for key in (name, f"estimate_{name}", STEADY + name)
        )
        curves = [
            Curve(
                ics_symbol(ics),
                ends,
                [float(steady.sel(ics=ics))] * 2,
                Look(looks[ics].colour, "dot", width=1),
            )
            for ics in drawing_order(looks)
        ]
        curves += curves_by_ics(places(dataset), values, estimate, share=not is_force)
        if is_force:
            limit = number.factor * float(contacts.friction) * largest_load(dataset)
            level = limit * np.sign(float(values[0, -1]))
            curves.append(Curve("friction × load", ends, [level, level], LIMIT))
        return Panel(number.meaning, abscissa(dataset).title, number.title, curves)

    def panels(contacts: xr.Dataset) -> list[Panel]:
        cells = [panel(contacts, name) for name in forces]
        if compared_ics(dataset):
            title = f"F_x minus F_x with {reference_symbol(dataset)}"
            cells.insert(1, difference_panel(dataset, contacts, title))
        return [*cells, panel(contacts, "sliding_share")]

    alt = "forces and sliding area against rolled distance with each of the ICs"
    columns, heights = (2, 0.8) if len(forces) > 1 else (3, 1.2)
    return by_friction(dataset, "growth", panels, columns, heights, alt)


TRANSIENT = MotionPage(growth, parts)
