"""Figures, sentences, tables and page of transient rolling by several ICs."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.contact.figures import reference_of
from compare.friction import maps
from compare.friction.page import band_of, names, others, write_contact_page
from compare.friction.rolling import scaled_force
from compare.friction.transient import CREEPAGES, STEADY
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import Part
from compare.report.styles import symbol_of, with_further
from compare.report.tables import Row, Table, cell, columns_of
from femic.contact.pairs.quantities import OF_ROLLING

PANEL = 4.1, 2.9  # its width and height [inch]
NEAR = 0.05  # of the steady force, within which transient forces are said to have reached it
LISTED = 4  # distances in the tables, besides rest
FORCES = {"F_x": "F_x / (friction load) [-]", "F_y": "F_y / (friction load) [-]"}
SLIDING = {"sliding_share": "sliding / contact area [-]"}
LEAST = 0.01  # of friction times load: smaller forces are not drawn


def write_transient(dataset: xr.Dataset, out: Path) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page."""
    return write_contact_page(dataset, out, summary(dataset), _parts(dataset), _tables(dataset))


def summary(dataset: xr.Dataset) -> str:
    """Sentences computed from the numbers: from which distance on rolling is steady, and how ICs differ."""
    at = ", ".join(f"{name} {dataset.attrs[name]:.3g}" for name in CREEPAGES if dataset.attrs[name])
    symbol, end = symbol_of(reference_of(dataset)), float(dataset.distance[-1])
    sentences = [
        f"{dataset.attrs['load']:g} N, from rest over {end:.3g} mm of rolling ({at or 'no creepage'})."
    ]
    for friction in dataset.friction.values:
        one = dataset.sel(friction=friction, ics=reference_of(dataset))
        sentences.append(
            f"With friction {float(friction):g} and {symbol}, F_x is {float(one.F_x[-1]):.4g} N in the end; "
            f"steady rolling has {float(one[f'{STEADY}F_x']):.4g} N, {_reached(one)}."
        )
    last, scale = dataset.F_x.isel(distance=-1), dataset.friction * dataset.attrs["load"]
    away = abs(last - last.sel(ics=reference_of(dataset))) / scale
    sentences += [
        f"{symbol_of(name)}: F_x in the end is up to {float(away.sel(ics=name).max()):.1%} of friction times "
        f"load from the force with {symbol}."
        for name in others(dataset)
    ]
    return " ".join(sentences)


def settled(one: xr.Dataset) -> float:
    """Return the distance [mm] from which on F_x is within `NEAR` of the steady force, or NaN."""
    steady = float(one[f"{STEADY}F_x"])
    outside = np.flatnonzero(~(abs(one.F_x.values - steady) <= NEAR * abs(steady)))
    first = outside[-1] + 1 if len(outside) else 0
    return float(one.distance[first]) if first < one.sizes["distance"] else np.nan


def _reached(one: xr.Dataset) -> str:
    """Where the force with one ICs reaches the steady one."""
    distance = settled(one)
    if np.isnan(distance):
        return f"to which F_x does not come within {NEAR:.0%}"
    return f"to which F_x keeps within {NEAR:.0%} from {distance:.3g} mm on"


def _parts(dataset: xr.Dataset) -> Iterator[Part]:
    symbol, end = symbol_of(reference_of(dataset)), float(dataset.distance[-1])
    yield Part(
        "Forces and sliding over the rolled distance",
        "Forces on the upper body over friction times load, where they are not small, and sliding area over "
        "contact area, from rest on. Dotted: steady rolling with the same ICs; grey: the limit of friction. "
        f"Band: estimate of {symbol}.",
        "growth",
        growth(dataset),
    )
    at_last = f"After {end:.3g} mm."
    yield Part("Where the contact sticks", at_last, "stick", maps.stick_maps(dataset))
    yield Part(
        "Work of friction",
        f"{at_last} Minus traction times slip in the last step, per unit of rolled distance and area.",
        "work",
        maps.work_maps(dataset),
    )


def growth(dataset: xr.Dataset) -> Figure:
    """Forces and sliding area over the rolled distance by all ICs, a column per friction."""
    shown = {name: label for name, label in FORCES.items() if abs(scaled_force(dataset, name)).max() > LEAST}
    shown |= SLIDING
    with figure_grid(len(shown), dataset.sizes["friction"], PANEL, sharex=True, sharey="row") as (
        figure,
        rows,
    ):
        for panels, (name, label) in zip(rows, shown.items(), strict=True):
            for number, axes in enumerate(panels):
                _draw(axes, dataset.isel(friction=number), name)
            panels[0].set_ylabel(label)
        for number, friction in enumerate(dataset.friction.values):
            rows[0, number].set_title(f"friction {float(friction):g}", fontsize=9)
            rows[-1, number].set_xlabel("rolled distance [mm]")
    return figure


def _draw(axes: Axes, one: xr.Dataset, name: str) -> None:
    """Draw a number at one friction over the distance, with its steady value and the estimate."""
    keys, is_force = (name, f"estimate_{name}", STEADY + name), name in FORCES
    values, known, steady = (scaled_force(one, key) if is_force else one[key] for key in keys)
    draw_by_ics(axes, one.distance, values, 0)
    styles = with_further(names(one))
    for ics in names(one):
        colour = styles[ics][1].get("color")
        axes.axhline(float(steady.sel(ics=ics)), color=colour, linestyle=":", linewidth=1)
    reference, band = (part.sel(ics=reference_of(one)) for part in (values, known))
    low, high = reference - band, reference + band
    if is_force:
        axes.axhline(float(np.sign(reference[-1])), color="grey", linewidth=1)
    else:
        low, high = low.clip(0, 1), high.clip(0, 1)
    draw_band(axes, one.distance, low, high, band_of(one))


def _tables(dataset: xr.Dataset) -> list[Table]:
    """The numbers at some distances and in steady rolling, a table per friction."""
    steps = dataset.sizes["distance"] - 1
    places = [steps * number // LISTED for number in range(LISTED + 1)]
    return [
        Table(
            f"friction {float(friction):g}",
            columns_of(OF_ROLLING.values()),
            [
                row
                for name in names(dataset)
                for row in _rows(dataset.sel(friction=friction, ics=name), places)
            ],
        )
        for friction in dataset.friction.values
    ]


def _rows(one: xr.Dataset, places: list[int]) -> Iterator[Row]:
    """Yield the numbers with one ICs at one friction: at some distances, and in steady rolling."""
    symbol = symbol_of(str(one.ics.values))
    for place in places:
        at = one.isel(distance=place)
        cells = [cell(at[key], at[f"estimate_{key}"]) for key in OF_ROLLING]
        yield Row(f"{symbol}, {float(at.distance):.3g} mm", cells)
    cells = [cell(one[STEADY + key], one[f"estimate_{STEADY}{key}"]) for key in OF_ROLLING]
    yield Row(f"{symbol}, steady", cells)
