"""Tables of the page of a campaign: where ICs fail, worst numbers, correlations, failed scenes."""

import csv
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from compare.report.looks import symbol_of
from compare.report.tables import Cell, Column, Row, Table, texts
from femic.cache.files import replacing
from femic.campaigns.report.answer import largest_of
from femic.campaigns.report.axes import ShownAxis, point_of, swept, text_of
from femic.campaigns.report.crossings import (
    Crossing,
    exceeded,
    extreme_crossings,
    known_count,
    lines_of,
    main_axis,
    over_level,
)
from femic.campaigns.report.fields import COLUMN, LEVELS, ROW, Field, plain, share
from geometries.arrays import Array

MOST_FAILURES = 20
FEWEST = 8  # points for a correlation
OVER = [f"more than {share(level)}" for level in LEVELS]  # heads


def crossing_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Return where along an axis numbers exceed levels, by column and row, at extremes of the other axes."""

    def cells(part: Field) -> list[Cell | str]:
        lines = lines_of(_sizes(part), axes)
        crossings = [_crossing_cell(extreme_crossings(lines, level)) for level in LEVELS]
        return [*crossings, *([known_count(_sizes(part)).removesuffix(" scenes") or "all"] if gaps else [])]

    gaps = bool(field.values.isnull().any())
    caption = f"{field.title}: where along {main_axis(axes).label}"
    return Table(caption, [*texts(*OVER), *(["scenes known"] if gaps else [])], _rows(field, cells))


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

    def cells(part: Field) -> list[Cell | str]:
        shares = (over_level(_sizes(part), level) for level in LEVELS)
        return [*shares, str(int(np.isfinite(part.values).sum()))]

    return Table(f"{field.title}: share of the scenes", [*OVER, "scenes known"], _rows(field, cells))


def correlation_table(field: Field, axes: Sequence[ShownAxis]) -> Table:
    """Return rank correlations with the axes, by row and column."""

    def cells(part: Field) -> list[Cell | str]:
        return [Cell(rank_correlation(axis, _sizes(part).values), "+.2f") for axis in axes]

    return Table(f"Rank correlation of {field.what} with", [axis.name for axis in axes], _rows(field, cells))


def rank_correlation(axis: ShownAxis, values: Array) -> float:
    """Return Spearman's rank correlation of values (n,) with an axis; NaN for text and few points."""
    known = np.isfinite(values)
    if not axis.is_number or np.sum(known) < FEWEST:
        return np.nan
    at, of = axis.values[known], values[known]
    return float(spearmanr(at, of).statistic) if np.ptp(at) and np.ptp(of) else np.nan


def _rows(field: Field, cells: Callable[[Field], list[Cell | str]]) -> list[Row]:
    """Return rows by column and row of a field, with cells for the part of each."""
    return [
        Row(f"{column}, {symbol_of(row)}", cells(field.of(rows=[row], columns=[column])))
        for column, row in product(field.columns, field.rows)
    ]


def _sizes(field: Field) -> xr.DataArray:
    """Return the sizes of a field of one row and column."""
    return field.sizes.isel({ROW: 0, COLUMN: 0}, drop=True)


def worst_table(field: Field, dataset: xr.Dataset) -> Table:
    """Return the largest number of each column and row, and its scene; of values the range."""
    if field.kind == "value":
        return Table(f"Range of {field.what}", ["range"], _rows(field, lambda part: [_range(part)]))
    several = field.values.size > len(field.columns) * len(field.rows)

    def cells(part: Field) -> list[Cell | str]:
        largest = largest_of(part, dataset)
        texts = ["–", ""] if largest is None else [largest.text, largest.scene]
        return [*texts[: 1 + several]]

    columns = [Column("largest", "%"), Column("at", is_text=True)]
    return Table(f"Largest {field.what}", columns[: 1 + several], _rows(field, cells))


def _range(field: Field) -> str:
    if not np.any(np.isfinite(field.values)):
        return "–"
    low, high = float(field.values.min()), float(field.values.max())
    return text_of(low) if low == high else f"{text_of(low)} ... {text_of(high)}"


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
