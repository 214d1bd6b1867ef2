"""Maps of the contact area by friction and ICs: where it sticks and slips, and the work of friction."""

from collections.abc import Callable
from itertools import product

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.report.styles import RC, symbol_of

STICK, SLIDE = "tab:blue", "tab:orange"
EACH = 2.35  # inch of a map

Drawer = Callable[[Axes, xr.Dataset], object]


def stick_maps(dataset: xr.Dataset) -> Figure:
    """Draw where the contact sticks and where it slides: a row per friction, a column per ICs."""
    figure = _by_friction_and_ics(dataset, _draw_stick)
    handles = [Patch(color=STICK, label="sticks"), Patch(color=SLIDE, label="slides")]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def work_maps(dataset: xr.Dataset) -> Figure:
    """Draw work of friction per area, with the same colours for all ICs at a friction."""

    def draw(axes: Axes, contact: xr.Dataset) -> None:
        work = np.ma.masked_array(contact.work.values, ~_in_contact(contact))
        largest = float(dataset.work.sel(friction=contact.friction.item()).max())
        axes.pcolormesh(contact.x, contact.s, work.T, cmap="magma_r", vmin=0, vmax=largest, rasterized=True)

    figure = _by_friction_and_ics(dataset, draw)
    label = f"work of friction [{dataset.work.attrs['units']}]"
    panels, columns = figure.axes, dataset.sizes["ics"]
    for row in (panels[first : first + columns] for first in range(0, len(panels), columns)):
        figure.colorbar(row[0].collections[0], ax=row, label=label)
    return figure


def _by_friction_and_ics(dataset: xr.Dataset, draw: Drawer) -> Figure:
    """Draw a map for each friction and ICs, as far as any contact goes."""
    sizes = dataset.sizes["friction"], dataset.sizes["ics"]
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(EACH * sizes[1] + 1, EACH * sizes[0] + 0.6), layout="constrained")
        grid = figure.subplots(*sizes, squeeze=False, sharex=True, sharey=True)
        for row, column in product(*map(range, sizes)):
            axes, contact = grid[row, column], dataset.isel(friction=row, ics=column)
            draw(axes, contact)
            title = f"{symbol_of(contact.ics.item())}, friction {contact.friction.item():g}"
            axes.set_title(title, fontsize=9)
            if row == sizes[0] - 1:
                axes.set_xlabel("x [mm]")
            if column == 0:
                axes.set_ylabel("s [mm]")
        _limit(grid[0, 0], dataset)
        return figure


def _limit(axes: Axes, dataset: xr.Dataset) -> None:
    """Show what any contact covers, with an element beside it."""
    inside = (dataset.p.sel(direction="n") > 0).any(["friction", "ics"])
    for limit, name, other in ((axes.set_xlim, "x", "s"), (axes.set_ylim, "s", "x")):
        places = dataset[name].values[inside.any(other).values]
        step = float(dataset[name][1] - dataset[name][0])
        limit(places.min() - 1.5 * step, places.max() + 1.5 * step)


def _draw_stick(axes: Axes, contact: xr.Dataset) -> None:
    slides = np.ma.masked_array(1.0 - contact.stick.values, ~_in_contact(contact))
    colours = ListedColormap([STICK, SLIDE])
    axes.pcolormesh(contact.x, contact.s, slides.T, cmap=colours, vmin=0, vmax=1, rasterized=True)


def _in_contact(contact: xr.Dataset) -> np.ndarray:
    return np.asarray(contact.p.sel(direction="n").values > 0)
