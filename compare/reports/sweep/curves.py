"""Curves over the only axis of a campaign, a panel per column, by rows such as ICs."""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from compare.pages.panels import add_legend
from compare.pages.styles import RC, Style, with_further
from compare.reports.sweep.axes import ShownAxis
from compare.reports.sweep.fields import COLUMN, LEVELS, ROW, C, Field, label_of
from compare.reports.sweep.scales import share

COLUMNS = 4  # panels beside each other
LOWEST = 1e-4  # smallest error drawn
FEW = 15  # values up to which each has a marker


def curves(field: Field, axis: ShownAxis) -> Figure:
    """Curves of all rows over an axis, a panel per column; errors are drawn on a common logarithmic scale."""
    count = len(field.columns)
    rows = -(-count // COLUMNS)
    columns = -(-count // rows)
    with mpl.rc_context(RC):
        figure = Figure(figsize=(max(3.2 * columns, 5.0), 2.9 * rows + 0.5), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False, sharey=field.kind == "error").ravel()
        for axes, column in zip(panels, field.columns, strict=False):
            _draw(axes, field.of(columns=[column]), axis)
            axes.set_title(column, fontsize=9)
            axes.set_xlabel(axis.wrapped)
            axis.scale(axes, "x")
        for axes in panels[count:]:
            axes.remove()
        for axes in panels[:count:columns]:
            axes.set_ylabel({"error": "error", "deviation": "deviation", "value": ""}[field.kind])
        _finish(panels[:count], field)
        if figure.axes[0].get_legend_handles_labels()[0]:
            add_legend(figure)
        return figure


def _draw(axes: Axes, field: Field, axis: ShownAxis) -> None:
    looks = with_further(field.rows)
    marked = len(axis.values) <= FEW
    floor = None if field.floor is None else field.floor.isel({COLUMN: 0}).values
    if floor is not None and np.any(np.isfinite(floor)):
        low = LOWEST / 100 if field.kind == "error" else -floor
        axes.fill_between(
            axis.at, low, floor, color="black", alpha=0.15, linewidth=0, label=f"estimate of {C}"
        )
    for name in field.rows:
        values = field.values.sel({ROW: name}).isel({COLUMN: 0}).values
        known = np.isfinite(values)
        marker, style = looks[name]
        axes.plot(axis.at[known], values[known], label=label_of(name), **_look(style, marker, axis, marked))


def _look(style: Style, marker: str, axis: ShownAxis, marked: bool) -> dict[str, Any]:
    look = dict(style) | ({"marker": marker, "markersize": 4} if marked else {})
    return look if axis.is_number else look | {"linestyle": "none", "marker": marker, "markersize": 6}


def _finish(panels: np.ndarray, field: Field) -> None:
    if field.kind == "value":
        return
    for axes in panels:
        for level in LEVELS:
            for signed in (level,) if field.kind == "error" else (level, -level):
                axes.axhline(signed, color="grey", linewidth=0.7, linestyle=":", zorder=0)
    if field.kind == "error":
        _percent_scale(panels, field)
        return
    for axes in panels:
        axes.axhline(0, color="grey", linewidth=0.8, zorder=0)
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: share(value)))


def _percent_scale(panels: np.ndarray, field: Field) -> None:
    """A logarithmic scale from the smallest to the largest error, in percent."""
    known = field.values.values[field.values.values > 0]
    low = max(LOWEST, float(known.min()) / 1.5)
    high = max(float(known.max()) * 1.5, LEVELS[-1] * 1.2)
    for axes in panels:
        axes.set(yscale="log", ylim=(min(low, LEVELS[0] / 1.5), high))
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: share(value)))
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.minorticks_off()
