"""Curves over the only axis of a campaign, a panel per column, by rows such as ICs."""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.report.looks import symbol_of
from compare.report.panels import add_legend
from compare.report.styles import RC, Style, with_further
from femic.campaigns.report.axes import ShownAxis
from femic.campaigns.report.fields import COLUMN, LOWEST, ROW, Field
from femic.campaigns.report.scales import draw_levels

COLUMNS = 4  # panels beside each other
FEW = 15  # values up to which each has a marker


def curves(field: Field, axis: ShownAxis) -> Figure:
    """Draw curves of all rows over an axis, a panel per column; errors have a common logarithmic scale."""
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
            axes.set_ylabel(field.kind if field.rates_ics else "")
        draw_levels(panels[:count], field.kind, field.values.values)
        if figure.axes[0].get_legend_handles_labels()[0]:
            add_legend(figure)
        return figure


def _draw(axes: Axes, field: Field, axis: ShownAxis) -> None:
    styles = with_further(field.rows)
    marked = len(axis.values) <= FEW
    floor = None if field.floor is None else field.floor.isel({COLUMN: 0}).values
    if floor is not None and np.any(np.isfinite(floor)):
        at, high = axis.at[np.isfinite(floor)], floor[np.isfinite(floor)]
        low = LOWEST / 100 if field.kind == "error" else -high
        label = f"estimate of {field.reference}"
        axes.fill_between(at, low, high, color="black", alpha=0.15, linewidth=0, label=label)
    for name in field.rows:
        values = field.drawn.sel({ROW: name}).isel({COLUMN: 0}).values
        known = np.isfinite(values)
        marker, style = styles[name]
        axes.plot(axis.at[known], values[known], label=symbol_of(name), **_line(style, marker, axis, marked))


def _line(style: Style, marker: str, axis: ShownAxis, marked: bool) -> dict[str, Any]:
    line = dict(style) | ({"marker": marker, "markersize": 4} if marked else {})
    return line if axis.is_number else line | {"linestyle": "none", "marker": marker, "markersize": 6}
