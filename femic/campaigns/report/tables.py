"""Tables of the page of a campaign: where ICs fail, worst numbers, correlations, failed scenes."""

import csv
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.tables import Cell, Row, Table
from femic.cache.files import replacing
from femic.campaigns.report.axes import ShownAxis, point_of, swept, text_of
from femic.campaigns.report.clouds import rank_correlation
from femic.campaigns.report.crossings import (
    Crossing,
    exceeded,
    extreme_crossings,
    known_count,
    lines_of,
    main_axis,
)
from femic.campaigns.report.fields import COLUMN, LEVELS, ROW, Field, plain, swept_dims
from femic.campaigns.report.scales import share

MOST_FAILURES = 20
OVER = [f"more than {share(level)}" for level in LEVELS]  # heads


def crossing_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Return where along an axis numbers exceed levels, by column and row, at extremes of the other axes."""

    def cells(sizes: xr.DataArray) -> list[Cell | str]:
        lines = lines_of(sizes, axes)
        crossings = [_crossing_cell(extreme_crossings(lines, level)) for level in LEVELS]
        return [*crossings, known_count(sizes) or "all"]

    axis = main_axis(axes)
    caption = f"{field.title}: where along {axis.name} ({axis.heading})"
    return Table(caption, [*OVER, "known"], _rows(field, cells))


def _crossing_cell(crossings: Sequence[Crossing]) -> Cell:
    if not crossings:
        return Cell("–")
    most, *least = crossings
    notes = [most.more, *(f"at {crossing.place}" for crossing in crossings if crossing.place)]
    if least:
        notes[-1] = f"{least[0].text} {notes[-1]}"
    return Cell(most.text, below="; ".join(filter(None, notes)))


def write_crossings(fields: Sequence[Field], axes: Sequence[ShownAxis], path: Path) -> None:
    """Write all ranges in which numbers exceed levels along the axis of `crossing_table` as CSV.

    An empty start or end: the level is exceeded from the first, or up to the last known scene.
    """
    axis = main_axis(axes)
    others = [other.name for other in swept(axes) if other is not axis]
    with replacing(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["of", "number", "ics", "more_than", *others, f"{axis.name}_from", f"{axis.name}_to"])
        for field in fields:
            for column, row, level in product(field.columns, field.rows, LEVELS):
                for line in lines_of(field.sizes.sel({COLUMN: column, ROW: row}), axes):
                    for part in exceeded(axis.values, line.sizes, level):
                        ends = ["" if end is None else f"{end:.6g}" for end in (part.start, part.end)]
                        place = line.place.values()
                        rows.writerow([field.name, plain(column), row, level, *place, *ends])


def share_table(field: Field) -> Table:
    """Return the share of the scenes whose numbers exceed levels, by column and row."""

    def cells(sizes: xr.DataArray) -> list[Cell | str]:
        known = sizes.values[np.isfinite(sizes.values)]
        shares = [f"{np.mean(known > level):.0%}" if known.size else "–" for level in LEVELS]
        return [*shares, str(known.size)]

    return Table(f"{field.title}: share of the scenes", [*OVER, "scenes known"], _rows(field, cells))


def correlation_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Return rank correlations with the axes, by row and column."""

    def cells(sizes: xr.DataArray) -> list[Cell | str]:
        return [Cell(rank_correlation(axis, sizes.values), "+.2f") for axis in axes]

    return Table(f"Rank correlation of {field.what} with", [axis.name for axis in axes], _rows(field, cells))


def _rows(field: Field, cells: Callable[[xr.DataArray], list[Cell | str]]) -> list[Row]:
    """Return rows by column and row of a field, with cells for the sizes of each."""
    return [
        Row(f"{column}, {symbol_of(row)}", cells(field.sizes.sel({COLUMN: column, ROW: row})))
        for column, row in product(field.columns, field.rows)
    ]


def worst_table(field: Field, dataset: xr.Dataset) -> Table:
    """Return the largest number of each row and column with its scene; of values the range."""
    rows = [
        Row(symbol_of(row), [_worst_cell(field, dataset, row, column) for column in field.columns])
        for row in field.rows
    ]
    if field.floor is not None and np.any(np.isfinite(field.floor)):
        largest = field.floor.max(swept_dims(dataset)).sel({COLUMN: field.columns}).values
        texts = ["–" if np.isnan(estimate) else share(estimate) for estimate in largest]
        rows.append(Row(f"estimate of {field.reference}", texts))
    heading = "Range of" if field.kind == "value" else "Largest"
    return Table(f"{heading} {field.what}", field.columns, rows)


def _worst_cell(field: Field, dataset: xr.Dataset, row: str, column: str) -> Cell | str:
    values = field.values.sel({ROW: row, COLUMN: column}).transpose(*swept_dims(dataset))
    if not np.any(np.isfinite(values)):
        return "–"
    if field.kind == "value":
        low, high = float(values.min()), float(values.max())
        return text_of(low) if low == high else f"{text_of(low)} ... {text_of(high)}"
    place = np.unravel_index(np.nanargmax(abs(values.values)), values.shape)
    worst = float(values.values[place])
    text = share(worst) if field.kind == "error" else f"{'+' if worst > 0 else ''}{share(worst)}"
    return Cell(text, below=point_of(dataset, place) if values.size > 1 else "")


def failure_table(dataset: xr.Dataset) -> Table | None:
    """Return the failed scenes with reasons, the first `MOST_FAILURES`; None without any."""
    failures = dataset["failure"].values.astype(str)
    failed = np.argwhere(failures != "")
    if not len(failed):
        return None
    rows = [Row(point_of(dataset, place), [failures[tuple(place)]]) for place in failed[:MOST_FAILURES]]
    if len(failed) > MOST_FAILURES:
        rows.append(Row(f"and {len(failed) - MOST_FAILURES} more", ["see `failure` in the file"]))
    return Table("Failed scenes", ["why"], rows, is_text=True)


def slowest(dataset: xr.Dataset, count: int = 3) -> list[str]:
    """Return the slowest scenes with their seconds."""
    seconds = dataset["seconds"].values
    order = np.argsort(-seconds, axis=None, kind="stable")[: min(count, np.isfinite(seconds).sum())]
    places = [np.unravel_index(number, seconds.shape) for number in order]
    return [f"{point_of(dataset, place)} ({text_of(seconds[place])} s)" for place in places]
