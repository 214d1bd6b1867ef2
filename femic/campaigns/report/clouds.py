"""Scatter plots over each axis of a campaign without a grid, and rank correlations."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from scipy.stats import spearmanr

from compare.report.looks import symbol_of
from compare.report.styles import RC
from femic.campaigns.report.axes import ShownAxis, evenly_spaced
from femic.campaigns.report.fields import COLUMN, ROW, Field
from femic.campaigns.report.scales import draw_levels
from geometries.arrays import Array

MOST_POINTS = 800  # of a figure
FEWEST = 8  # points for a correlation
COLUMNS = 5  # axes beside each other


def rank_correlation(axis: ShownAxis, values: Array) -> float:
    """Return Spearman's rank correlation of values (n,) with an axis; NaN for text and few points."""
    known = np.isfinite(values)
    if not axis.is_number or np.sum(known) < FEWEST:
        return np.nan
    at, of = axis.values[known], values[known]
    return float(spearmanr(at, of).statistic) if np.ptp(at) and np.ptp(of) else np.nan


def correlations(field: Field, axes: Sequence[ShownAxis]) -> xr.DataArray:
    """Return rank correlations of the sizes of numbers with the axes, by row, column and "axis"."""
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


def strongest(field: Field, axes: Sequence[ShownAxis]) -> tuple[ShownAxis, float]:
    """Return the axis with the strongest correlation on the average of rows and columns, and this."""
    mean = abs(correlations(field, axes)).mean((ROW, COLUMN)).fillna(0.0).values
    return axes[int(np.argmax(mean))], float(np.max(mean))


def clouds(field: Field, axes: Sequence[ShownAxis]) -> Figure:
    """Draw points of one column of a field, a row of panels per row, a panel per axis.

    The colour of a point is its value of the axis with the strongest correlation.
    """
    drawn, (colour, _) = axes[:COLUMNS], strongest(field, axes)
    chosen = evenly_spaced(field.values.sizes["sample"], MOST_POINTS)
    norm = (LogNorm if colour.is_logarithmic else Normalize)(np.min(colour.at), np.max(colour.at))
    with mpl.rc_context(RC | {"grid.alpha": 0.2}):
        rows = len(field.rows)
        size = 2.5 * len(drawn) + 1.2, 1.9 * rows + 0.5
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(rows, len(drawn), squeeze=False, sharey="row", sharex="col")
        for line, name in zip(panels, field.rows, strict=True):
            values = field.drawn.sel({ROW: name}).isel({COLUMN: 0}).values
            for axes_, axis in zip(line, drawn, strict=True):
                _points(axes_, axis.at[chosen], values[chosen], (colour.at[chosen], norm))
            draw_levels(line, field.kind, values)
            line[0].set_ylabel(symbol_of(name) if field.rates_ics else f"{field.columns[0]}, {name}")
        for axes_, axis in zip(panels[-1], drawn, strict=True):
            axis.scale(axes_, "x")
            axes_.set_xlabel(axis.wrapped)
        _bar(figure, panels, colour, norm)
        return figure


def _points(axes: Axes, at: Array, values: Array, colours: tuple[Array, Normalize]) -> None:
    shown = np.isfinite(values)
    size = float(np.clip(2500 / max(np.sum(shown), 1), 3, 30))
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
