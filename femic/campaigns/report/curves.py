"""Curves over the only axis of a campaign by rows such as ICs, and points over each axis of random scenes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from compare.report.charts import Chart, Curve, Panel, chart_of
from compare.report.looks import Look, drawing_order, looks_of, symbol_of
from femic.campaigns.report.axes import ShownAxis, evenly_spaced
from femic.campaigns.report.fields import COLUMN, LEVELS, LOWEST, ROW, Field, plain
from femic.campaigns.report.maps import columns_for

MOST_POINTS = 500  # of a panel
LEAST = 100 * LOWEST  # smallest error that is drawn [%]


def curves(field: Field, axis: ShownAxis) -> Chart:
    """Return curves of all rows over an axis, a panel per column; bands have the estimate."""
    panels = [_panel(field.of(columns=[column]), axis, column) for column in field.columns]
    return chart_of(field.name, panels, columns_for(len(panels)))


def clouds(field: Field, axes: Sequence[ShownAxis]) -> Chart:
    """Return points of all rows over each axis, by column."""
    chosen = evenly_spaced(field.values.sizes["sample"], MOST_POINTS)
    drawn = field.at(sample=chosen)
    shown = [replace(axis, values=axis.values[chosen]) for axis in axes]
    steps = {
        plain(column): [
            _panel(drawn.of(columns=[column]), axis, f"over {axis.name}", is_cloud=True) for axis in shown
        ]
        for column in field.columns
    }
    slider = "component" if field.kind == "error" else "number"
    alt = f"{field.what} over each axis"
    return Chart(field.name, steps, columns_for(len(axes)), slider, 1.1, next(iter(steps)), alt=alt)


def _panel(field: Field, axis: ShownAxis, title: str, *, is_cloud: bool = False) -> Panel:
    """Return a panel of a field of one column over an axis."""
    looks = looks_of(field.rows)
    if is_cloud or not axis.is_number:
        looks = {row: replace(look, dash="") for row, look in looks.items()}
    return Panel(
        title,
        axis.label,
        f"{field.kind} [%]" if field.rates_ics else field.columns[0],
        [
            _curve(field.of(rows=[row]), axis, looks[row], has_band=not is_cloud)
            for row in drawing_order(field.rows)
        ],
        log_x=axis.is_logarithmic,
        log_y=field.kind == "error",
        levels=_levels(field),
        names_x=axis.categories,
    )


def _levels(field: Field) -> list[float]:
    """Return the levels that errors and deviations are compared with [%]."""
    above = [100 * level for level in LEVELS]
    return {"error": above, "deviation": [*(-level for level in above), *above], "value": []}[field.kind]


def _curve(field: Field, axis: ShownAxis, look: Look, *, has_band: bool) -> Curve:
    """Return a field of one row and column over an axis where it is known, with its estimate as band."""
    values = field.shown.isel({ROW: 0, COLUMN: 0}).values
    known, is_error = np.isfinite(values), field.kind == "error"
    x, y = axis.at[known], values[known]
    if is_error:
        y = np.maximum(y, LEAST)
    band = None
    if has_band and field.floor is not None:
        estimate = 100 * field.floor.isel({COLUMN: 0}).values[known]
        band = np.array([np.minimum(estimate, y - LEAST) if is_error else estimate, estimate])
    has_estimate = band is not None and bool(np.isfinite(band).any())
    return Curve(symbol_of(field.rows[0]), x, y, look, band if has_estimate else None)
