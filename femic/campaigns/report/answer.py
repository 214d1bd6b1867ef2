"""The table that begins the page of a campaign: how far ICs are off, and where they fail."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from compare.report.errors import colour
from compare.report.looks import symbol_of
from compare.report.parts import join_words
from compare.report.tables import ROUNDING, Cell, Column, Row, Table, with_estimate
from femic.campaigns.report.axes import axes_of, is_grid, point_of, swept
from femic.campaigns.report.crossings import extreme_crossings, lines_of, main_axis, over_level
from femic.campaigns.report.fields import COLUMN, REPORTED, ROW, Field, plain, share, swept_dims

MOST_COLUMNS = 6


@dataclass(frozen=True)
class Largest:
    """The largest error or deviation of one row and column: with its estimate [%], and its scene."""

    text: str
    size: float  # a share
    scene: str


def largest_of(field: Field, dataset: xr.Dataset) -> Largest | None:
    """Return the largest number of a field of one row and column; None where nothing is known."""
    values = field.values.isel({ROW: 0, COLUMN: 0}).transpose(*swept_dims(dataset))
    if not np.any(np.isfinite(values)):
        return None
    place = np.unravel_index(np.nanargmax(abs(values.values)), values.shape)
    worst, estimate = float(values.values[place]), np.nan
    if field.floor is not None:
        estimate = float(field.floor.isel({COLUMN: 0}).transpose(*swept_dims(dataset)).values[place])
    text = with_estimate(100 * worst, 100 * estimate) if estimate > ROUNDING else f"{100 * worst:.3g}"
    sign = "+" if field.kind == "deviation" and worst > 0 else ""
    return Largest("0" if abs(worst) < ROUNDING else sign + text, abs(worst), point_of(dataset, place))


def answer_table(field: Field, dataset: xr.Dataset) -> Table:
    """Return the largest numbers of the first columns with their estimates; below, where they are large."""
    columns = field.columns[:MOST_COLUMNS]
    rows = [
        Row(
            symbol_of(row),
            [_cell(field.of(rows=[row], columns=[column]), dataset) for column in columns],
        )
        for row in field.rows
    ]
    return Table(f"largest {field.kind}", [Column(column, "%") for column in columns], rows)


def _cell(field: Field, dataset: xr.Dataset) -> Cell:
    largest = largest_of(field, dataset)
    if largest is None:
        return Cell(np.nan)
    sizes = field.sizes.isel({ROW: 0, COLUMN: 0})
    return Cell(largest.text, below=_where_large(sizes, dataset), colour=colour(largest.size))


def _where_large(sizes: xr.DataArray, dataset: xr.Dataset) -> str:
    """Return where numbers exceed `REPORTED` along the main axis; of samples, how many do."""
    axes = axes_of(dataset)
    if not swept(axes):
        return ""
    if not is_grid(dataset):
        return f"{over_level(sizes, REPORTED)} of scenes"
    return extreme_crossings(lines_of(sizes, axes), REPORTED)[0].text


def answer_note(field: Field, dataset: xr.Dataset) -> str:
    """Return what the table that begins the page shows."""
    axes = swept(axes_of(dataset))
    notes = [f"Largest of all scenes, ± the estimate of {field.reference} there."]
    if axes and is_grid(dataset):
        axis = main_axis(axes)
        others = join_words(other.name for other in axes if other is not axis)
        where = f", at the {others} where this range is largest" if others else ""
        interpolated = "; interpolated linearly between scenes" if axis.is_number else ""
        notes.append(f"Small: {axis.label} at which it exceeds {share(REPORTED)}{where}{interpolated}.")
    elif axes:
        notes.append(f"Small: share of the scenes in which it exceeds {share(REPORTED)}.")
    if left_out := field.columns[MOST_COLUMNS:]:
        notes.append(f"Further down: {join_words(map(plain, left_out))}.")
    return " ".join(notes)
