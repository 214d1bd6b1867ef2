"""Figures, sentences and tables of transient rolling by several ICs."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.contact.dataset import ics_of, others_of, reference_of
from compare.friction.page import (
    MotionPage,
    map_parts,
    number_cells,
    number_rows,
    reference_symbol,
    tables_by_friction,
)
from compare.friction.rolling import scaled_force
from compare.friction.transient import CREEPAGES, STEADY
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import Part
from compare.report.styles import symbol_of, with_further
from compare.report.tables import Row, Table
from femic.contact.pairs.quantities import OF_ROLLING

NEAR = 0.05  # of the steady force, within which transient forces are said to have reached it
LISTED = 4  # distances in the tables, besides rest
FORCES = {"F_x": "F_x / (friction load) [-]", "F_y": "F_y / (friction load) [-]"}
SLIDING = {"sliding_share": "sliding / contact area [-]"}
LEAST = 0.01  # of friction times load: smaller forces are not drawn


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: where rolling becomes steady, and how ICs differ."""
    at = ", ".join(f"{name} {dataset.attrs[name]:.3g}" for name in CREEPAGES if dataset.attrs[name])
    symbol, end = reference_symbol(dataset), float(dataset.distance[-1])
    sentences = [
        f"{dataset.attrs['load']:g} N, from rest over {end:.3g} mm of rolling ({at or 'no creepage'})."
    ]
    for friction in dataset.friction.values:
        rolling = dataset.sel(friction=friction, ics=reference_of(dataset))
        sentences.append(
            f"With friction {friction:g} and {symbol}, F_x is {float(rolling.F_x[-1]):.4g} N in the end; "
            f"steady rolling has {float(rolling[f'{STEADY}F_x']):.4g} N, {_reached(rolling)}."
        )
    last, scale = dataset.F_x.isel(distance=-1), dataset.friction * dataset.attrs["load"]
    away = abs(last - last.sel(ics=reference_of(dataset))) / scale
    sentences += [
        f"{symbol_of(name)}: F_x in the end is up to {float(away.sel(ics=name).max()):.1%} of friction times "
        f"load from the force with {symbol}."
        for name in others_of(dataset)
    ]
    return " ".join(sentences)


def settled(rolling: xr.Dataset) -> float:
    """Return the distance [mm] from which on F_x is within `NEAR` of the steady force, or NaN."""
    steady = float(rolling[f"{STEADY}F_x"])
    outside = np.flatnonzero(~(abs(rolling.F_x.values - steady) <= NEAR * abs(steady)))
    first = outside[-1] + 1 if len(outside) else 0
    return float(rolling.distance[first]) if first < rolling.sizes["distance"] else np.nan


def _reached(rolling: xr.Dataset) -> str:
    """Return where the force with some ICs reaches the steady one."""
    distance = settled(rolling)
    if np.isnan(distance):
        return f"to which F_x does not come within {NEAR:.0%}"
    return f"to which F_x keeps within {NEAR:.0%} from {distance:.3g} mm on"


def parts(dataset: xr.Dataset) -> Iterator[Part]:
    """Yield the figures."""
    yield Part(
        "Forces and sliding over the rolled distance",
        "Forces on the upper body over friction times load, where they are not small, and sliding area over "
        "contact area, from rest on. Dotted: steady rolling with the same ICs; grey: the limit of friction. "
        f"Band: estimate of {reference_symbol(dataset)}.",
        "growth",
        growth(dataset),
    )
    yield from map_parts(
        dataset,
        f"After {float(dataset.distance[-1]):.3g} mm.",
        "Minus traction times slip in the last step, per unit of rolled distance and area.",
    )


def growth(dataset: xr.Dataset) -> Figure:
    """Draw forces and sliding area over the rolled distance by all ICs, a column per friction."""
    shown = {name: label for name, label in FORCES.items() if abs(scaled_force(dataset, name)).max() > LEAST}
    shown |= SLIDING
    with figure_grid(len(shown), dataset.sizes["friction"], sharex=True, sharey="row") as (figure, rows):
        for panels, (name, label) in zip(rows, shown.items(), strict=True):
            for number, axes in enumerate(panels):
                _draw(axes, dataset.isel(friction=number), name)
            panels[0].set_ylabel(label)
        for number, friction in enumerate(dataset.friction.values):
            rows[0, number].set_title(f"friction {friction:g}", fontsize=9)
            rows[-1, number].set_xlabel("rolled distance [mm]")
    return figure


def _draw(axes: Axes, rolling: xr.Dataset, name: str) -> None:
    """Draw a number at one friction over the distance, with its steady value and the estimate."""
    keys, is_force = (name, f"estimate_{name}", STEADY + name), name in FORCES
    values, estimate, steady = (scaled_force(rolling, key) if is_force else rolling[key] for key in keys)
    draw_by_ics(axes, rolling.distance, values, 0)
    styles = with_further(ics_of(rolling))
    for ics in ics_of(rolling):
        colour = styles[ics][1].get("color")
        axes.axhline(float(steady.sel(ics=ics)), color=colour, linestyle=":", linewidth=1)
    reference, band = (part.sel(ics=reference_of(rolling)) for part in (values, estimate))
    low, high = reference - band, reference + band
    if is_force:
        axes.axhline(float(np.sign(reference[-1])), color="grey", linewidth=1)
    else:
        low, high = low.clip(0, 1), high.clip(0, 1)
    draw_band(axes, rolling.distance, low, high, f"estimate of {reference_symbol(rolling)}")


def _tables(dataset: xr.Dataset) -> list[Table]:
    """Return the numbers at some distances and in steady rolling, a table per friction."""
    return tables_by_friction(dataset, _rows)


def _rows(dataset: xr.Dataset) -> Iterator[Row]:
    """Yield the numbers at one friction: for each ICs at some distances, and in steady rolling."""
    steps = dataset.sizes["distance"] - 1
    shown = dataset.isel(distance=[steps * number // LISTED for number in range(LISTED + 1)])
    for name in ics_of(dataset):
        yield from number_rows(shown.sel(ics=[name]))
        yield Row(f"{symbol_of(name)}, steady", number_cells(dataset.sel(ics=name), OF_ROLLING, STEADY))


TRANSIENT = MotionPage(summary, parts, _tables, growth)
