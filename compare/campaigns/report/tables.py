"""The tables of a campaign: largest numbers, and where they exceed levels along an axis of the campaign."""

import csv
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from compare.campaigns.report.fields import (
    COLUMN,
    LEVELS,
    REPORTED,
    ROW,
    Advice,
    Field,
    Names,
    ShownAxis,
    is_grid,
    plain,
    point_name,
    read_axes,
    share,
    swept,
    swept_dims,
    value_text,
    values_text,
)
from compare.report.errors import colour
from compare.report.looks import ics_symbol
from compare.report.parts import join_words
from compare.report.tables import ROUNDING, Cell, Column, Row, Table, number_text, with_estimate
from compare.report.verdicts import NO, NOT_DECIDED, YES, decide
from femic.cache.files import replacing
from geometries.arrays import Array

# --- where numbers exceed a level -----------------------------------------------------------------------


NOWHERE, EVERYWHERE = "nowhere", "everywhere"
Range = tuple[float | None, float | None]  # of an axis; None: from its first, or up to its last value
Line = tuple[Names, Array]  # a place of the other axes, and sizes of numbers along the main axis, (n,)


def ranges_above(at: Array, values: Array, level: float) -> list[Range]:
    """Return the ranges in which values (n,) over an axis exceed a level, interpolated linearly.

    Values that are NaN are left out.
    """
    known = np.isfinite(values)
    at, values = at[known], values[known]
    above = np.concatenate([[False], values > level, [False]])
    starts, ends = (np.flatnonzero(above[1:] & ~above[:-1]), np.flatnonzero(above[:-1] & ~above[1:]))

    def crossing(k: int) -> float:
        part = (level - values[k]) / (values[k + 1] - values[k])
        return float(at[k] + part * (at[k + 1] - at[k]))

    return [
        (
            None if start == 0 else crossing(int(start) - 1),
            None if end == len(at) else crossing(int(end) - 1),
        )
        for start, end in zip(starts, ends, strict=True)
    ]


def main_axis(axes: Iterable[ShownAxis]) -> ShownAxis:
    """Return the axis along which crossings are reported: of numbers, with the most values."""
    return max(swept(axes), key=lambda axis: (axis.is_number, len(axis.values)))


def lines_along_main_axis(sizes: xr.DataArray, axes: Sequence[ShownAxis]) -> list[Line]:
    """Return sizes over the swept dims as lines along the main axis, at all places of the others."""
    axis = main_axis(axes)
    others = [other for other in swept(axes) if other is not axis]
    names = [other.name for other in others]
    rows = sizes.transpose(*names, axis.name).values.reshape(-1, len(axis.values))
    places = product(*(other.values for other in others))
    return [(dict(zip(names, place, strict=True)), row) for place, row in zip(places, rows, strict=True)]


def crossing_cell(sizes: xr.DataArray, axes: Sequence[ShownAxis], level: float) -> Cell:
    """Return where sizes exceed a level along the main axis: where most, and below it where least."""
    axis = main_axis(axes)
    lines = [line for line in lines_along_main_axis(sizes, axes) if np.any(np.isfinite(line[1]))]
    if not lines:
        return Cell("–")
    lines.sort(key=lambda line: (exceeding_share(axis, line[1], level), np.nanmax(line[1])))
    (least, least_row), (most, most_row) = lines[0], lines[-1]
    text, *repeated = crossing_texts(axis, most_row, level)
    below = [f"again {repeated[0]}"] if repeated else []
    if repeated[1:]:
        below[0] += f", and {len(repeated) - 1} times more"
    least_text = crossing_texts(axis, least_row, level)[0]
    if least_text != text:
        below += [f"at {_place_text(most)}", f"{least_text} at {_place_text(least)}"]
    return Cell(text, below="; ".join(below))


def crossing_texts(axis: ShownAxis, sizes: Array, level: float) -> list[str]:
    """Return the ranges of an axis, or its categories, where sizes (n,) along it exceed a level."""
    known = np.isfinite(sizes)
    if not axis.is_number:
        over = axis.values[known & (sizes > level)]
        if len(over) in (0, np.sum(known)):
            return [EVERYWHERE if len(over) else NOWHERE]
        return [f"at {join_words(map(value_text, over))}"]
    span, ranges = float(np.ptp(axis.values)), []
    for low, high in ranges_above(axis.values, sizes, level):
        start, end = (None if place is None else _place_digits(place, span) for place in (low, high))
        if start is None:
            ranges.append(EVERYWHERE if end is None else f"up to {end}")
        else:
            ranges.append(f"above {start}" if end is None else f"from {start} to {end}")
    return ranges or [NOWHERE]


def exceeding_share(axis: ShownAxis, sizes: Array, level: float) -> float:
    """Return the share of the known part of an axis, or of its categories, where sizes exceed a level."""
    known = np.isfinite(sizes)
    at = axis.at[known]
    if not axis.is_number or np.ptp(at) == 0:
        return float(np.mean(sizes[known] > level))
    ranges = ranges_above(axis.at, sizes, level)
    covered = [
        (at[-1] if end is None else end) - (at[0] if start is None else start) for start, end in ranges
    ]
    return float(sum(covered) / np.ptp(at))


def _place_text(place: Names) -> str:
    return join_words(values_text({name: value}) for name, value in place.items())


def _place_digits(value: float, span: float) -> str:
    """Return a value as text with three digits, and with as many as a thousandth of a span needs."""
    digits = 3
    if value and span:
        digits += max(0, int(np.floor(np.log10(abs(value) / span))))
    rounded = float(f"{value:.{digits}g}")
    if 0 < abs(value) < span / 10:
        rounded = round(rounded, 3 - int(np.floor(np.log10(span))))
    return np.format_float_positional(rounded, trim="-")


def has_crossings(dataset: xr.Dataset, fields: Sequence[Field]) -> bool:
    """Whether levels are exceeded along an axis of numbers."""
    axes = swept(read_axes(dataset))
    rated = any(field.rates_ics for field in fields)
    return rated and bool(axes) and is_grid(dataset) and main_axis(axes).is_number


def write_crossings(fields: Sequence[Field], axes: Sequence[ShownAxis], path: Path) -> None:
    """Write all ranges in which numbers exceed levels along the main axis as CSV.

    An empty start or end: the level is exceeded from the first, or up to the last known scene.
    """
    axis = main_axis(axes)
    others = [other.name for other in swept(axes) if other is not axis]
    with replacing(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["of", "number", "ics", "more_than", *others, f"{axis.name}_from", f"{axis.name}_to"])
        for field in fields:
            for column, row, level in product(field.columns, field.rows, LEVELS):
                for place, sizes in lines_along_main_axis(field.sizes.sel({COLUMN: column, ROW: row}), axes):
                    for ends in ranges_above(axis.values, sizes, level):
                        numbers = ["" if end is None else f"{end:.6g}" for end in ends]
                        rows.writerow([field.name, plain(column), row, level, *place.values(), *numbers])


# --- tables of a field ----------------------------------------------------------------------------------


MOST_COLUMNS = 6  # of the table that begins the page
FEWEST = 8  # points for a correlation
OVER = [f"more than {share(level)}" for level in LEVELS]  # heads


def answer_table(field: Field, dataset: xr.Dataset) -> Table:
    """Return the largest numbers of the first columns; below, in how many scenes they are small."""
    axes, columns = swept(read_axes(dataset)), field.columns[:MOST_COLUMNS]

    def cell(part: Field) -> Cell:
        if (largest := _largest(part, dataset)) is None:
            return Cell(np.nan)
        text, size, _ = largest
        below = [counts_text(part)]
        if axes and is_grid(dataset):
            crossing = crossing_cell(_sizes(part), axes, REPORTED).text
            below += [f"exceeded {crossing}"] if crossing != NOWHERE else []
        return Cell(text, below="; ".join(below), colour=colour(size))

    rows = [
        Row(ics_symbol(row), [cell(field.select(rows=[row], columns=[column])) for column in columns])
        for row in field.rows
    ]
    return Table(f"largest {field.kind}", [Column(column, "%") for column in columns], rows)


def answer_note(field: Field, dataset: xr.Dataset) -> str:
    """Return what the table that begins the page shows."""
    axes = swept(read_axes(dataset))
    where = ""
    if axes and is_grid(dataset):
        where = (
            f", and where along {main_axis(axes).label} it is exceeded in the worst case (interpolated "
            "linearly between scenes)"
        )
    several = len(field.columns) > MOST_COLUMNS
    more = " “Largest numbers, and where they occur” has all columns." if several else ""
    return (
        f"Largest {field.kind} over all scenes, ± the estimated error of {field.reference}. Below: in how "
        f"many of the computed scenes it is within {share(REPORTED)}, ± included{where}. “Not decided”: ± "
        f"leaves it open, or is not known.{more}"
    )


def verdict_counts(field: Field) -> dict[str, int]:
    """Return how many numbers of a field are within `REPORTED`, are not, and are not decided.

    A number with its estimate decides, as `decide` says.
    """
    floor = xr.full_like(field.sizes, np.nan) if field.floor is None else field.floor
    decided = decide(*xr.broadcast(field.sizes, floor), REPORTED)
    return {word: int(np.count_nonzero(decided == word)) for word in (YES, NO, NOT_DECIDED)}


def counts_text(field: Field) -> str:
    """Return in how many of the known scenes numbers are within `REPORTED`."""
    counts = verdict_counts(field)
    text = f"within {share(REPORTED)}: {counts[YES]} of {sum(counts.values())}"
    return f"{text}, not decided: {counts[NOT_DECIDED]}" if counts[NOT_DECIDED] else text


def largest_sentence(field: Field, dataset: xr.Dataset) -> str:
    """Return the largest numbers of the first column, the smallest first, and which ICs are always close."""
    column, found = field.columns[0], dict[str, tuple[float, list[str]]]()
    for row in field.rows:
        if largest := _largest(field.select(rows=[row], columns=[column]), dataset):
            found.setdefault(largest[0], (largest[1], []))[1].append(ics_symbol(row))
    ordered = sorted(found.items(), key=lambda item: item[1][0])
    errors = "; ".join(f"{text} % with {join_words(symbols)}" for text, (_, symbols) in ordered)
    always, unknown = list[str](), list[str]()
    for row in field.rows:
        counts = verdict_counts(field.select(rows=[row]))
        if counts[YES] and not counts[NO]:
            (unknown if counts[NOT_DECIDED] else always).append(ics_symbol(row))
    more = f" (not decided: {join_words(unknown)})" if unknown else ""
    return (
        f"Largest {field.kind} of {plain(column)} over all scenes: {errors}. Within {share(REPORTED)} in "
        f"every computed scene and column: {join_words(always) or 'none'}{more}."
    )


def field_tables(field: Field, dataset: xr.Dataset) -> list[Table]:
    """Return where the numbers of a field exceed levels, their rank correlations, and the largest."""
    axes = swept(read_axes(dataset))
    tables = []
    if axes and field.rates_ics:
        tables.append(level_table(field, axes, on_grid=is_grid(dataset)))
    if axes and not is_grid(dataset):
        tables.append(correlation_table(field, axes))
    return [*tables, worst_table(field, dataset)]


def level_table(field: Field, axes: Sequence[ShownAxis], *, on_grid: bool = True) -> Table:
    """Return where along an axis numbers exceed levels, by column and row, at extremes of the other axes.

    Of scenes that are no grid: in which share of them.
    """

    def cells(part: Field) -> list[Cell | str]:
        sizes, known = _sizes(part), int(np.sum(np.isfinite(part.values.values)))
        over = [crossing_cell(sizes, axes, x) if on_grid else Cell(share_over(sizes, x)) for x in LEVELS]
        return [*over, f"{known} of {part.values.size}"]

    where = f"where along {main_axis(axes).label}" if on_grid else "fraction of the scenes"
    columns = [Column(head, is_text=on_grid) for head in (*OVER, "scenes known")]
    return Table(f"{field.title}: {where}", columns, _rows(field, cells))


def share_over(sizes: xr.DataArray, level: float) -> str:
    """Return the share of the known scenes whose numbers exceed a level."""
    known = sizes.values[np.isfinite(sizes.values)]
    return f"{100 * np.mean(known > level):.0f} %" if known.size else "–"


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
    at, sizes = axis.values[known], values[known]
    return float(spearmanr(at, sizes).statistic) if np.ptp(at) and np.ptp(sizes) else np.nan


def worst_table(field: Field, dataset: xr.Dataset) -> Table:
    """Return the largest number of each column and row, and its scene; of values the range."""

    def cells(part: Field) -> list[Cell | str]:
        largest = _largest(part, dataset)
        return ["–", ""] if largest is None else [largest[0], largest[2]]

    def value_range(part: Field) -> list[Cell | str]:
        if not np.any(np.isfinite(part.values)):
            return ["–"]
        low, high = float(part.values.min()), float(part.values.max())
        return [value_text(low) if low == high else f"{value_text(low)} ... {value_text(high)}"]

    if field.kind == "value":
        return Table(f"Range of {field.what}", ["range"], _rows(field, value_range))
    columns = [Column("largest", "%"), Column("at", is_text=True)]
    return Table(f"Largest {field.what}", columns, _rows(field, cells))


def _rows(field: Field, cells: Callable[[Field], list[Cell | str]]) -> list[Row]:
    """Return rows by column and row of a field, with cells for the part of each."""
    return [
        Row(f"{column}, {ics_symbol(row)}", cells(field.select(rows=[row], columns=[column])))
        for column, row in product(field.columns, field.rows)
    ]


def _sizes(field: Field) -> xr.DataArray:
    """Return the sizes of a field of one row and column."""
    return field.sizes.isel({ROW: 0, COLUMN: 0}, drop=True)


def _largest(field: Field, dataset: xr.Dataset) -> tuple[str, float, str] | None:
    """Return the largest error or deviation of one row and column, None where nothing is known.

    It is a text with its estimate [%], its size as a share, and its scene.
    """
    values = field.values.isel({ROW: 0, COLUMN: 0}).transpose(*swept_dims(dataset))
    if not np.any(np.isfinite(values)):
        return None
    place = np.unravel_index(np.nanargmax(abs(values.values)), values.shape)
    worst, estimate = float(values.values[place]), np.nan
    if field.floor is not None:
        estimate = float(field.floor.isel({COLUMN: 0}).transpose(*swept_dims(dataset)).values[place])
    signed = field.kind == "deviation"
    if estimate > ROUNDING:
        text = with_estimate(100 * worst, 100 * estimate, signed=signed)
    else:
        text = number_text(100 * worst, "+.3g" if signed else ".3g")
    return "0" if abs(worst) < ROUNDING else text, abs(worst), point_name(dataset, place)


# --- tables of scenes -----------------------------------------------------------------------------------


MOST_FAILURES = 20
MOST_REASONS = 3  # for failures, that the head of the page has
SLOWEST = 3


def advice_table(advice: Advice) -> Table:
    """Return in how many scenes each of the ICs is advised."""
    advised, kinds = advice
    rows = [Row(name, [str(int((advised == k).sum()))]) for k, name in enumerate(kinds)]
    return Table("cheapest ICs that are accurate enough", ["scenes"], rows)


def doubts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield how many scenes failed and why, the most frequent reasons first, and how many are missing."""
    scenes, computed, failed = (int(dataset.attrs[name]) for name in ("scenes", "computed", "failed"))
    if failed:
        texts = dataset["failure"].values.astype(str).ravel()
        reasons = Counter(text.partition("\n")[0] for text in texts if text)
        shown = "; ".join(f"{count} × {reason}" for reason, count in reasons.most_common(MOST_REASONS))
        rest = len(reasons) - MOST_REASONS
        more = f"; further reasons: {rest}" if rest > 0 else ""
        yield f"Failed: {failed} of {scenes} scenes ({shown}{more}). Their numbers are missing below."
    if missing := scenes - computed - failed:
        yield f"Not computed yet: {missing} of {scenes} scenes. The largest numbers may still grow."


def failure_table(dataset: xr.Dataset) -> Table | None:
    """Return the failed scenes with reasons, the first `MOST_FAILURES`; None without any."""
    failures = dataset["failure"].values.astype(str)
    failed = np.argwhere(failures != "")
    if not len(failed):
        return None
    rows = [Row(point_name(dataset, place), [failures[tuple(place)]]) for place in failed[:MOST_FAILURES]]
    if len(failed) > MOST_FAILURES:
        rows.append(Row(f"and {len(failed) - MOST_FAILURES} more", ["see `failure` in the file"]))
    return Table("Failed scenes", ["why"], rows, is_text=True)


def cost_table(dataset: xr.Dataset) -> Table:
    """Return the seconds of all scenes, of the fastest and of the slowest ones."""
    seconds = dataset["seconds"].values
    order = np.argsort(seconds, axis=None, kind="stable")[: np.isfinite(seconds).sum()]  # NaN comes last
    chosen = dict.fromkeys([*order[:1], *order[: -SLOWEST - 1 : -1]])
    rows = [Row("total, excluding models that other scenes solved", [Cell(np.nansum(seconds), ".3g")])]
    for number in chosen:
        place = np.unravel_index(number, seconds.shape)
        rows.append(Row(point_name(dataset, place), [Cell(float(seconds[place]), ".2g")]))
    return Table("Seconds per scene: total, fastest and slowest", [Column("seconds", "s")], rows)
