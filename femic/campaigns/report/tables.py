"""Tables of the page of a campaign: what fails where, worst numbers, correlations, failed scenes."""

import csv
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.parts import Row, Table
from femic.cache.files import replacing
from femic.campaigns.report.axes import ShownAxis, point_of, text_of
from femic.campaigns.report.clouds import correlations
from femic.campaigns.report.crossings import Found, Lines, along, exceeded
from femic.campaigns.report.fields import COLUMN, LEVELS, ROW, Field, label_of, plain, swept_dims
from femic.campaigns.report.scales import share

MOST_FAILURES = 20

Cell = dict[str, str]


def _cell(text: str, below: str = "") -> Cell:
    return {"text": text, "below": below}


def crossing_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Where along an axis numbers exceed levels, by column and row; the other axes by their extremes."""
    rows = []
    for column, row, lines in _lines(field, axes):
        cells = [_crossing_cell(lines.found(level)) for level in LEVELS]
        rows.append(Row(f"{column}, {label_of(row)}", [*cells, _cell(lines.known_of or "all")]))
    heads = [*(f"more than {share(level)}" for level in LEVELS), "known"]
    return Table(f"{field.title}: where along {along(axes).name} ({along(axes).heading})", heads, rows)


def _crossing_cell(found: Sequence[Found]) -> Cell:
    if not found:
        return _cell("–")
    most, *least = found
    notes = [most.more, *(f"at {one.place}" for one in found if one.place)]
    if least:
        notes[-1] = f"{least[0].text} {notes[-1]}"
    return _cell(most.text, "; ".join(filter(None, notes)))


def write_crossings(fields: Sequence[Field], axes: Sequence[ShownAxis], path: Path) -> None:
    """Write all ranges in which numbers exceed levels along the axis of `crossing_table` as CSV.

    An empty start or end: the level is exceeded from the first, or up to the last scene that is known.
    """
    axis = along(axes)
    rest = [one.name for one in axes if len(one.values) > 1 and one is not axis]
    with replacing(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["of", "number", "ics", "more_than", *rest, f"{axis.name}_from", f"{axis.name}_to"])
        for field in fields:
            for (column, row, lines), level in product(_lines(field, axes), LEVELS):
                for line in lines.all:
                    for one in exceeded(axis.values, line.sizes, level):
                        ends = ["" if end is None else f"{end:.6g}" for end in (one.start, one.end)]
                        place = line.place.values()
                        rows.writerow([field.name, plain(column), row, level, *place, *ends])


def _lines(field: Field, axes: Sequence[ShownAxis]) -> Iterator[tuple[str, str, Lines]]:
    for column, row in product(field.columns, field.rows):
        yield column, row, Lines.of(field.sizes.sel({COLUMN: column, ROW: row}), axes)


def share_table(field: Field) -> Table:
    """In which share of the scenes numbers exceed levels, by column and row."""
    rows = []
    for column, row in product(field.columns, field.rows):
        sizes = field.sizes.sel({COLUMN: column, ROW: row})
        known = sizes.values[np.isfinite(sizes.values)]
        cells = [_cell(f"{np.mean(known > level):.0%}" if known.size else "–") for level in LEVELS]
        rows.append(Row(f"{column}, {label_of(row)}", [*cells, _cell(str(known.size))]))
    heads = [*(f"more than {share(level)}" for level in LEVELS), "scenes known"]
    return Table(f"{field.title}: share of the scenes", heads, rows)


def correlation_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Rank correlations with the axes, by row and column."""
    found = correlations(field, axes)
    rows = []
    for column, name in product(field.columns, field.rows):
        cells = [float(found.sel({"axis": axis.name, ROW: name, COLUMN: column})) for axis in axes]
        texts = ["–" if np.isnan(one) else f"{one:+.2f}" for one in cells]
        rows.append(Row(f"{column}, {label_of(name)}", [_cell(text) for text in texts]))
    return Table(f"Rank correlation of {field.what} with", [axis.name for axis in axes], rows)


def worst_table(field: Field, dataset: xr.Dataset) -> Table:
    """The largest number of each row and column, and at which scene; values: smallest and largest."""
    rows = [
        Row(label_of(row), [_worst_cell(field, dataset, row, column) for column in field.columns])
        for row in field.rows
    ]
    if field.floor is not None and np.any(np.isfinite(field.floor)):
        known = field.floor.max(swept_dims(dataset))
        texts = ["–" if np.isnan(one) else share(float(one)) for one in known.sel({COLUMN: field.columns})]
        rows.append(Row(f"estimate of {field.reference}", [_cell(text) for text in texts]))
    heading = "Range of" if field.kind == "value" else "Largest"
    return Table(f"{heading} {field.what}", field.columns, rows)


def _worst_cell(field: Field, dataset: xr.Dataset, row: str, column: str) -> Cell:
    values = field.values.sel({ROW: row, COLUMN: column}).transpose(*swept_dims(dataset))
    if not np.any(np.isfinite(values)):
        return _cell("–")
    if field.kind == "value":
        low, high = float(values.min()), float(values.max())
        return _cell(text_of(low) if low == high else f"{text_of(low)} ... {text_of(high)}")
    place = tuple(int(k) for k in np.unravel_index(int(np.nanargmax(abs(values.values))), values.shape))
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
