"""Maps of an IC matrix: the nine components of the response to one loaded strip, over (x, s)."""

import matplotlib as mpl
import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from compare.report.styles import RC
from femic.contact.operators.dense import PARITY
from geometries.arrays import Array
from geometries.grids import Grid
from geometries.patches import DIRECTIONS

COLOUR_DECADES = 3  # decades of the colour scale, of each sign, below the largest value
SMALLEST = 1e-9  # of the largest value of all maps: a map without larger values is marked as zero


def maps(title: str, unit: str, grid: Grid, strip: int, column: Array) -> Figure:
    """Draw nine maps with one colour scale, at lags of both signs; `column` is (3, 3, n_x, n_s) in `unit`."""
    x = np.append(-grid.lags[:0:-1], grid.lags)
    values = np.concatenate([PARITY[..., None, None] * column[:, :, :0:-1], column], axis=2)
    largest = max(float(np.max(np.abs(values))), np.finfo(float).tiny)
    norm = SymLogNorm(largest / 10**COLOUR_DECADES, vmin=-largest, vmax=largest)
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(11, 8.2), layout="constrained")
        rows = figure.subplots(3, 3, sharex=True, sharey=True)
        for (i, j), axes in np.ndenumerate(rows):
            shades = axes.pcolormesh(
                x, grid.strips, values[i, j].T, norm=norm, cmap="RdBu_r", rasterized=True
            )
            axes.plot(0, grid.strips[strip], "k+", markersize=7)
            zero = "  (0)" if np.max(np.abs(values[i, j])) <= SMALLEST * largest else ""
            axes.set_title(f"{DIRECTIONS[i]}{DIRECTIONS[j]}{zero}", fontsize=9)
        for axes in rows[-1]:
            axes.set_xlabel("x [mm], observer − load")
        for axes in rows[:, 0]:
            axes.set_ylabel("s of the observer [mm]")
        figure.colorbar(shades, ax=rows, label=unit, shrink=0.8)
        figure.suptitle(title)
        return figure
