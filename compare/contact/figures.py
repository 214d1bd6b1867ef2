"""Figures of contacts: numbers over the angle of the patch, profiles across it, pressures on the surface."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import AbstractPathEffect, withStroke

from compare.contact.dataset import reference_of
from compare.report.panels import Panel, add_legend, draw_band, draw_by_ics, figure_grid, panel_figure
from compare.report.styles import RC, symbol_of, with_further
from compare.report.tables import Column
from femic.contact.pairs.quantities import OF_FRICTIONLESS

HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.6, foreground="white")]  # about lines on shades
DRAWN = ("a", "b", "aspect", "p_max", "approach", "stiffness")  # quantities over the angle of the patch


def over_angle(dataset: xr.Dataset) -> Figure:
    """Draw numbers with all ICs over the angle of the patch with the reference; below, their ratios."""
    reference = reference_of(dataset)
    order = np.argsort(dataset.angle.sel(ics=reference).values)
    cases = dataset.isel(case=order)
    angle = cases.angle.sel(ics=reference)
    with figure_grid(2, len(DRAWN), (2.9, 2.45), sharex=True) as (figure, rows):
        for column, name in zip(rows.T, DRAWN, strict=True):
            values = cases[name]
            draw_by_ics(column[0], angle, values)
            draw_by_ics(column[1], angle, values / values.sel(ics=reference))
            positive = bool((values > 0).all())  # approaches are negative over raised spots
            title = Column(OF_FRICTIONLESS[name].symbol, OF_FRICTIONLESS[name].unit).title
            column[0].set(title=title, yscale="log" if positive else "linear")
            column[1].set(xlabel=f"Δδ with {symbol_of(reference)} [deg]")
            estimate = (cases[f"estimate_{name}"] / values).sel(ics=reference)
            draw_band(column[1], angle, 1 - estimate, 1 + estimate)
        rows[1, 0].set(ylabel=f"over {symbol_of(reference)} [-], band: its estimate")
    return figure


def profiles(dataset: xr.Dataset) -> Figure:
    """Draw pressures along s through the largest, over the mean pressure on the patch, a panel per case."""
    count = dataset.sizes["case"]
    return panel_figure([_profile(dataset, number) for number in range(count)], min(count, 3))


def _profile(dataset: xr.Dataset, number: int) -> Panel:
    case, p = dataset.isel(case=number), dataset[f"p_{number}"]
    along_x = f"x_{number}"
    at = _section(p.sel(ics=reference_of(dataset)).values)
    across, middle = p.isel({along_x: at}), at == p.sizes[along_x] // 2
    x = "x = 0" if middle else f"x = {float(p[along_x][at]):.2g} mm"
    mean = case["load"] / case["area"]
    part = loaded_part(across)
    return Panel(
        f"{dataset.case.values[number]}",
        "s [mm]",
        across[f"s_{number}"].values[part],
        f"pressure at {x} over N / area [-]" if number == 0 or not middle else "",
        {symbol_of(str(name)): (across / mean).sel(ics=name).values[part] for name in dataset.ics.values},
    )


def loaded_part(p: xr.DataArray) -> slice:
    """Return where along s any of the ICs has pressures, (ics, s), with an element on each side."""
    loaded = np.flatnonzero((p > 0).any("ics"))
    return slice(max(loaded[0] - 1, 0), loaded[-1] + 2)


def _section(p: np.ndarray) -> int:
    """Return the index along x of the drawn section: the middle, or the largest pressure."""
    middle = len(p) // 2
    return middle if np.any(p[middle] > 0) else int(np.argmax(p.max(axis=1)))


def surfaces(dataset: xr.Dataset) -> Figure:
    """Draw pressures of the reference on the developed surface, with contact edges of all ICs."""
    reference, count = reference_of(dataset), dataset.sizes["case"]
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(4.3 * min(count, 3), 3.6 * -(-count // 3)), layout="constrained")
        for number, axes in enumerate(figure.subplots(-(-count // 3), min(count, 3), squeeze=False).ravel()):
            if number >= count:
                axes.remove()
                continue
            p = dataset[f"p_{number}"]
            x, s = p[f"x_{number}"].values, p[f"s_{number}"].values
            reference_p = np.ma.masked_equal(p.sel(ics=reference).values, 0)
            shades = axes.pcolormesh(x, s, reference_p.T, cmap="viridis", rasterized=True)
            figure.colorbar(shades, ax=axes, label=f"pressure with {symbol_of(reference)} [MPa]")
            _edges(axes, x, s, {str(name): p.sel(ics=name).values for name in p.ics.values})
            axes.set(xlabel="x [mm]", ylabel="s [mm]", title=str(dataset.case.values[number]))
        add_legend(figure)
        return figure


def _edges(axes: Axes, x: np.ndarray, s: np.ndarray, pressures: Mapping[str, np.ndarray]) -> None:
    """Draw the edge of the contact with each of the ICs."""
    looks = with_further(pressures)
    for name, p in pressures.items():
        _, style = looks[name]
        look = {key: style[key] for key in ("color", "linestyle") if key in style}
        edge = axes.contour(
            x,
            s,
            (p > 0).T.astype(float),
            levels=[0.5],
            colors=[look["color"]],
            linestyles=[look.get("linestyle", "-")],
            linewidths=1.2,
        )
        edge.set_path_effects(HALO)
        axes.plot([], [], label=f"edge with {symbol_of(name)}", linewidth=1.2, **look)
