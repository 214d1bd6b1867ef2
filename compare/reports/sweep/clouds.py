"""Random points and tables of a campaign: numbers over each axis as points, and rank correlations."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator
from scipy.stats import rankdata

from compare.pages.styles import RC
from compare.reports.sweep.axes import ShownAxis, spread_out
from compare.reports.sweep.curves import LOWEST
from compare.reports.sweep.fields import COLUMN, LEVELS, ROW, Field, label_of
from compare.reports.sweep.scales import share
from geometries.arrays import Array

MOST_POINTS = 800  # of a picture
FEWEST = 4  # points of which a correlation is told
COLUMNS = 5  # axes beside each other


def rank_correlation(axis: ShownAxis, values: Array) -> float:
    """Spearman's rank correlation of values (n,) with those of an axis; NaN for text and few points."""
    known = np.isfinite(values)
    if not axis.is_number or np.sum(known) < FEWEST:
        return np.nan
    ranks = rankdata(axis.values[known]), rankdata(values[known])
    if min(np.ptp(of) for of in ranks) == 0:
        return np.nan
    return float(np.corrcoef(*ranks)[0, 1])


def correlations(field: Field, axes: Sequence[ShownAxis]) -> xr.DataArray:
    """Rank correlations of the sizes of numbers with the axes, by row, column and "axis"."""
    return xr.concat(
        [
            xr.apply_ufunc(
                lambda values, axis=axis: rank_correlation(axis, values),
                field.sizes,
                input_core_dims=[["sample"]],
                vectorize=True,
            )
            for axis in axes
        ],
        xr.Variable("axis", [axis.name for axis in axes]),
    )


def strongest(field: Field, axes: Sequence[ShownAxis]) -> ShownAxis:
    """The axis that numbers go with most, on the average of rows and columns."""
    mean = abs(correlations(field, axes)).mean((ROW, COLUMN)).fillna(0.0)
    return axes[int(np.argmax(mean.values))]


def clouds(field: Field, axes: Sequence[ShownAxis]) -> Figure:
    """Points of one column of a field, a row of panels per row, a panel per axis.

    The colour of a point is its value of the axis that numbers go with most.
    """
    drawn, colour = list(axes)[:COLUMNS], strongest(field, axes)
    chosen = spread_out(field.values.sizes["sample"], MOST_POINTS)
    norm = _norm(colour)
    with mpl.rc_context(RC | {"grid.alpha": 0.2}):
        rows = len(field.rows)
        size = 2.5 * len(drawn) + 1.2, 1.9 * rows + 0.5
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(rows, len(drawn), squeeze=False, sharey="row", sharex="col")
        for line, name in zip(panels, field.rows, strict=True):
            values = field.values.sel({ROW: name}).isel({COLUMN: 0}).values
            for axes_, axis in zip(line, drawn, strict=True):
                _points(axes_, axis.at[chosen], values[chosen], (colour.at[chosen], norm))
            _scale(line, field, values)
            line[0].set_ylabel(label_of(name) if field.kind != "value" else f"{field.columns[0]}, {name}")
        for axes_, axis in zip(panels[-1], drawn, strict=True):
            axis.scale(axes_, "x")
            axes_.set_xlabel(axis.wrapped)
        _bar(figure, panels, colour, norm)
        return figure


def _points(axes: Axes, at: Array, values: Array, colours: tuple[Array, Normalize]) -> None:
    shown = np.isfinite(values)
    size = float(np.clip(2500 / max(np.sum(shown), 1), 3, 18))
    axes.scatter(
        at[shown],
        values[shown],
        s=size,
        c=colours[0][shown],
        norm=colours[1],
        cmap="viridis",
        linewidths=0,
        alpha=0.8,
        rasterized=True,
    )


def _scale(line: np.ndarray, field: Field, values: Array) -> None:
    """Scale, ticks and levels of a row of panels."""
    if field.kind == "value" or not np.any(np.isfinite(values)):
        return
    levels = LEVELS if field.kind == "error" else (*LEVELS, 0.0, *(-level for level in LEVELS))
    for axes in line:
        for level in levels:
            axes.axhline(level, color="grey", linewidth=0.7, linestyle=":", zorder=0)
        if field.kind == "error" and np.any(values > 0):
            low, high = np.nanmin(values[values > 0]), np.nanmax(values)
            axes.set(yscale="log", ylim=(max(LOWEST, low / 1.3), max(high, 2 * LOWEST) * 1.3))
            subs = (1.0,) if high > 100 * low else (1.0, 2.0, 5.0)
            axes.yaxis.set_major_locator(LogLocator(subs=subs))
            axes.minorticks_off()
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: share(value)))


def _norm(axis: ShownAxis) -> Normalize:
    low, high = float(np.min(axis.at)), float(np.max(axis.at))
    return LogNorm(low, high) if axis.is_logarithmic else Normalize(low, high)


def _bar(figure: Figure, panels: np.ndarray, axis: ShownAxis, norm: Normalize) -> None:
    rows = len(panels)
    bar = figure.colorbar(
        ScalarMappable(norm, "viridis"),
        ax=panels.ravel(),
        label=axis.heading,
        shrink=min(1.0, 2.2 / rows) if rows > 2 else 0.95,
        aspect=25,
    )
    if not axis.is_number:
        bar.ax.set_yticks(np.arange(len(axis.categories)), axis.categories)
