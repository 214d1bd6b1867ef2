"""Tables of the page of a campaign: what fails where, worst numbers, correlations, failed scenes."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import xarray as xr

from compare.pages.parts import Row, Table
from compare.reports.sweep.axes import ShownAxis, named, point_of, spread_out, swept, text_of
from compare.reports.sweep.clouds import correlations
from compare.reports.sweep.crossings import told
from compare.reports.sweep.fields import COLUMN, LEVELS, ROW, Field, label_of, swept_dims
from compare.reports.sweep.scales import share

MOST_ALONG = 4  # values of each other axis that tables of crossings have
MOST_ROWS = 60  # of a table of crossings
MOST_FAILURES = 20
TOLD = 0.05  # the level whose places come first

Cell = dict[str, str]
Place = dict[str, int]  # places along the other axes


def _cell(text: str, below: str = "") -> Cell:
    return {"text": text, "below": below}


def along(axes: Sequence[ShownAxis]) -> ShownAxis:
    """The axis along which crossings are told: of numbers, with the most values."""
    return max(swept(axes), key=lambda axis: (axis.is_number, len(axis.values)))


def others(axes: Sequence[ShownAxis], axis: ShownAxis) -> Iterator[tuple[str, Place]]:
    """Yield places of the other axes, some of them where there are many, and their names."""
    rest = [one for one in axes if one.name != axis.name]
    shown = {one.name: spread_out(len(one.values), MOST_ALONG) for one in rest}
    for places in product(*shown.values()):
        at = dict(zip(shown, places, strict=True))
        yield named({one.name: one.values[at[one.name]] for one in swept(rest)}), at


def crossing_tables(field: Field, axes: Sequence[ShownAxis]) -> Iterator[Table]:
    """Yield a table per level: where along an axis numbers exceed it, by column and other axes, by row."""
    axis = along(axes)
    for level in sorted(LEVELS, key=lambda level: (level != TOLD, level)):
        rows: list[Row] = []
        for column, (name, at) in product(field.columns, others(axes, axis)):
            values = field.sizes.sel({COLUMN: column}).isel(at)
            cells = [told(axis, values.sel({ROW: row}).values, level) for row in field.rows]
            if len(rows) < MOST_ROWS:
                rows.append(
                    Row(
                        f"{column}, {name}" if name else column,
                        [_cell(text, below) for text, below in cells],
                    )
                )
        yield Table(
            f"More than {share(level)} along {axis.name}", [label_of(row) for row in field.rows], rows
        )


def share_table(field: Field) -> Table:
    """In which share of the scenes numbers exceed the levels, by column and level, by row."""
    rows = []
    for column, level in product(field.columns, LEVELS):
        values = field.sizes.sel({COLUMN: column})
        cells = []
        for name in field.rows:
            known = values.sel({ROW: name}).values
            known = known[np.isfinite(known)]
            cells.append(_cell(f"{np.mean(known > level):.0%}" if known.size else "–"))
        rows.append(Row(f"{column}, more than {share(level)}", cells))
    return Table("Share of the scenes", [label_of(row) for row in field.rows], rows)


def correlation_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Rank correlations with the axes, by row and column."""
    found = correlations(field, axes)
    rows = []
    for name, column in product(field.rows, field.columns):
        cells = [float(found.sel({"axis": axis.name, ROW: name, COLUMN: column})) for axis in axes]
        rows.append(
            Row(
                f"{label_of(name)}, {column}",
                [_cell("–" if np.isnan(one) else f"{one:+.2f}") for one in cells],
            )
        )
    of = "sizes of " if field.kind == "deviation" else ""
    return Table(f"Rank correlation of {of}{field.what} with", [axis.name for axis in axes], rows)


def worst_table(field: Field, dataset: xr.Dataset) -> Table:
    """The largest number of each row and column, and at which scene; values: smallest and largest."""
    rows = [
        Row(label_of(row), [_worst_cell(field, dataset, row, column) for column in field.columns])
        for row in field.rows
    ]
    if field.floor is not None and np.any(np.isfinite(field.floor)):
        known = field.floor.max(swept_dims(dataset))
        cells = [float(known.sel({COLUMN: column})) for column in field.columns]
        rows.append(Row("estimate of C", [_cell("–" if np.isnan(one) else share(one)) for one in cells]))
    heading = "Range of" if field.kind == "value" else "Largest"
    return Table(f"{heading} {field.what}", field.columns, rows)


def worst_place(values: xr.DataArray) -> tuple[int, ...] | None:
    """The place of the largest number over the swept dims; None where none is known."""
    if not np.any(np.isfinite(values)):
        return None
    return tuple(int(k) for k in np.unravel_index(int(np.nanargmax(values.values)), values.shape))


def _worst_cell(field: Field, dataset: xr.Dataset, row: str, column: str) -> Cell:
    values = field.values.sel({ROW: row, COLUMN: column}).transpose(*swept_dims(dataset))
    place = worst_place(abs(values))
    if place is None:
        return _cell("–")
    if field.kind == "value":
        low, high = float(values.min()), float(values.max())
        return _cell(f"{low:.4g}" if low == high else f"{low:.4g} ... {high:.4g}")
    worst = float(values.values[place])
    text = share(worst) if field.kind == "error" else f"{'+' if worst > 0 else ''}{share(worst)}"
    return _cell(text, point_of(dataset, place) if values.size > 1 else "")


def failure_table(dataset: xr.Dataset) -> Table | None:
    """Scenes that have failed, and why; the first ones where there are many."""
    failed = np.argwhere(dataset["failure"].values.astype(str) != "")
    if not len(failed):
        return None
    rows = [
        Row(point_of(dataset, place), [_cell(str(dataset["failure"].values[tuple(place)]))])
        for place in failed[:MOST_FAILURES]
    ]
    if len(failed) > MOST_FAILURES:
        rows.append(Row(f"and {len(failed) - MOST_FAILURES} more", [_cell("see `failure` in the file")]))
    return Table("Failed scenes", ["why"], rows, is_text=True)


def slowest(dataset: xr.Dataset, count: int = 3) -> list[str]:
    """The slowest scenes with their seconds."""
    seconds = dataset["seconds"].values
    order = np.argsort(np.where(np.isnan(seconds), -1, seconds), axis=None)[::-1][:count]
    places = [np.unravel_index(k, seconds.shape) for k in order]
    return [
        f"{point_of(dataset, [int(k) for k in place])} ({text_of(seconds[place])} s)"
        for place in places
        if np.isfinite(seconds[place])
    ]
