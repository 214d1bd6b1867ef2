"""Verdict and charts of transient rolling by several ICs."""

from dataclasses import replace

import numpy as np
import xarray as xr

from compare.pages.friction import (
    MotionPage,
    abscissa,
    by_friction,
    curves_by_ics,
    difference,
    difference_unit,
    largest_differences,
    load_of,
    load_text,
    main_estimate,
    places,
    quantity_label,
    reference_symbol,
    share_curves,
    worst_friction,
)
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import Look, drawing_order, looks_of, symbol_of
from compare.report.parts import join_words
from compare.report.tables import Cell, Column, Row, Table, with_estimate
from femic.contact.datasets import STEADY
from femic.contact.motions.rolling import scaled_force
from femic.results.contact import ics_of, others_of, reference_of

NEAR = 0.05  # of the steady force, within which transient forces are said to have reached it
LEAST = 0.01  # of friction times load: smaller forces are not drawn
LIMIT = Look("#808080", "solid", width=1)
UNITS = {"creepage": (100.0, "%"), "lateral": (100.0, "%"), "spin": (1.0, " /mm")}


def summary(dataset: xr.Dataset) -> str:
    """Return where rolling becomes steady, and how ICs differ in the end."""
    symbol, end = reference_symbol(dataset), float(dataset.distance[-1])
    creepages = ", ".join(
        f"{name} {factor * dataset.attrs[name]:.3g}{unit}"
        for name, (factor, unit) in UNITS.items()
        if dataset.attrs[name]
    )
    reached = join_words(
        f"{_reached(dataset.sel(friction=friction, ics=reference_of(dataset)))} with friction {friction:g}"
        for friction in dataset.friction.values
    )
    sentences = [
        f"From rest over {end:.3g} mm of rolling ({creepages or 'no creepage'}), F_x with {symbol} "
        f"comes within {NEAR:.0%} of steady rolling {reached}."
    ]
    away = abs(difference(dataset).isel(distance=-1)).max("friction")
    if others := others_of(dataset):
        texts = join_words(f"{float(away.sel(ics=name)):.1f}% with {symbol_of(name)}" for name in others)
        sentences.append(
            f"In the end F_x is up to {texts} of friction times load from the force with {symbol}."
        )
    return " ".join(sentences)


def settling_distance(rolling: xr.Dataset) -> float:
    """Return the distance [mm] from which on F_x is within `NEAR` of the steady force, or NaN."""
    steady = float(rolling[f"{STEADY}F_x"])
    outside = np.flatnonzero(~(abs(rolling.F_x.values - steady) <= NEAR * abs(steady)))
    first = outside[-1] + 1 if len(outside) else 0
    return float(rolling.distance[first]) if first < rolling.sizes["distance"] else np.nan


def _reached(rolling: xr.Dataset) -> str:
    """Return where the force with some ICs reaches the steady one."""
    distance = settling_distance(rolling)
    return "nowhere" if np.isnan(distance) else f"from {distance:.3g} mm on"


def answer(dataset: xr.Dataset) -> Table:
    """Return forces in the end and in steady rolling where ICs differ most, and their differences."""
    friction, symbol = worst_friction(dataset), reference_symbol(dataset)
    force, at = quantity_label(dataset, "F_x"), dataset.sel(friction=friction)
    columns = [
        Column(f"F_x in the end, friction {friction:g}", force.unit),
        Column("F_x, steady rolling", force.unit),
        Column(f"within {NEAR:.0%} of steady rolling from", "mm"),
        Column(f"largest distance from {symbol}, any friction", difference_unit(dataset)),
    ]
    largest, known = largest_differences(dataset)
    rows = []
    for name in ics_of(dataset):
        rolling, is_reference = at.sel(ics=name), name == reference_of(dataset)
        end = rolling.isel(distance=-1)
        cells: list[Cell | str] = [
            with_estimate(force.factor * end.F_x, force.factor * end.estimate_F_x),
            with_estimate(*(force.factor * end[f"{prefix}F_x"] for prefix in (STEADY, f"estimate_{STEADY}"))),
            Cell(settling_distance(rolling), ".3g"),
            "" if is_reference else with_estimate(largest.sel(ics=name), known.sel(ics=name)),
        ]
        rows.append(Row(symbol_of(name), cells))
    return Table("ICs", columns, rows)


def growth(dataset: xr.Dataset) -> Chart:
    """Return forces and sliding area over the rolled distance by all ICs, and the difference of F_x."""
    forces = [name for name in ("F_x", "F_y") if abs(scaled_force(dataset, name)).max() > LEAST]
    across = abscissa(dataset).title

    def panels(of_friction: xr.Dataset) -> list[Panel]:
        cells = [_panel(dataset, of_friction, name, limited=True) for name in forces]
        if others_of(dataset):
            known = main_estimate(of_friction)
            away = curves_by_ics(places(dataset), difference(of_friction), known)
            title = f"F_x minus the one with {reference_symbol(dataset)}"
            cells.insert(1, Panel(title, across, f"difference [{difference_unit(dataset)}]", away))
        return [*cells, _panel(dataset, of_friction, "sliding_share")]

    alt = "forces and sliding area over the rolled distance by ICs"
    columns, heights = (2, 0.8) if len(forces) > 1 else (3, 1.2)
    return replace(by_friction(dataset, "growth", panels, columns), heights=heights, alt=alt)


def _panel(dataset: xr.Dataset, of_friction: xr.Dataset, name: str, *, limited: bool = False) -> Panel:
    """Return a number over the distance, with its steady values, and with friction times load."""
    number, ends = quantity_label(dataset, name), places(dataset)[[0, -1]]
    values, estimate, steady = (
        number.factor * of_friction[key] for key in (name, f"estimate_{name}", STEADY + name)
    )
    curves = []
    looks = looks_of(ics_of(dataset))
    for ics in drawing_order(looks):
        level = [float(steady.sel(ics=ics))] * 2
        curves.append(Curve(symbol_of(ics), ends, level, Look(looks[ics].colour, "dot", width=1)))
    draw = curves_by_ics if limited else share_curves
    curves += draw(places(dataset), values, estimate)
    if limited:
        limit = number.factor * float(of_friction.friction) * load_of(dataset) * np.sign(float(values[0, -1]))
        curves.append(Curve("friction times load", ends, [limit, limit], LIMIT))
    return Panel(number.meaning, abscissa(dataset).title, number.title, curves)


def note(dataset: xr.Dataset) -> str:
    """Return what the main chart shows."""
    return (
        f"{load_text(dataset)}, from rest on. Dotted: steady rolling with the same ICs; grey: friction "
        f"times load. Band: estimate of {reference_symbol(dataset)}. Small forces are not drawn."
    )


def contact(dataset: xr.Dataset) -> str:
    """Return at which distance the maps are."""
    return f"After {float(dataset.distance[-1]):.3g} mm."


TRANSIENT = MotionPage(
    summary,
    answer,
    growth,
    note,
    contact,
    "Minus traction times slip in the last step, per unit of rolled distance and area.",
    steady=STEADY,
)
