"""The page of a campaign: sentences, figures over the swept keys, and tables of where ICs fail."""

import csv
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, product
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from compare.campaigns.report.charts import (
    MOST_POINTS,
    MOST_STEPS,
    Plane,
    clouds,
    curves,
    field_chart,
    third_axis_chart,
    within_chart,
)
from compare.campaigns.report.fields import (
    COLUMN,
    LEVELS,
    LOWEST,
    ROW,
    Field,
    ShownAxis,
    axes_of,
    evenly_spaced,
    fields_of,
    is_grid,
    plain,
    point_of,
    prepare,
    share,
    swept,
    text_of,
)
from compare.campaigns.report.summary import (
    AdvisedICs,
    Crossing,
    advice_of,
    advised_chart,
    answer_note,
    answer_table,
    extreme_crossings,
    files,
    judgement,
    known_count,
    largest_of,
    lines_of,
    main_axis,
    over_level,
    ranges_above,
    summary,
)
from compare.report.looks import symbol_of
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Column, Row, Table, texts
from femic.cache import folders
from femic.cache.files import replacing
from geometries.arrays import Array

# --- the page -------------------------------------------------------------------------------------------


CROSSINGS = "sweep_crossings.csv"


def write_sweep(dataset: xr.Dataset, out: Path) -> Path:
    """Write `sweep.html` of a campaign's dataset into a folder, with figures and a table of crossings.

    Returns the path of the page.
    """
    folders.make(out)
    for old in [*(out / "figures").glob("sweep_*"), *out.glob(CROSSINGS)]:
        old.unlink()
    dataset = prepare(dataset)
    fields = fields_of(dataset)
    if _has_crossings(dataset, fields):
        write_crossings([field for field in fields if field.rates_ics], axes_of(dataset), out / CROSSINGS)
    return write_results(page_of(dataset, fields), out, "sweep")


def page_of(dataset: xr.Dataset, fields: Sequence[Field]) -> Page:
    """Return the page of a prepared dataset and its fields."""
    advice = advice_of(dataset)
    ratings = [field for field in fields if field.rates_ics]
    answer = answer_table(ratings[0], dataset) if ratings else None
    note = [Section("", [Note(answer_note(ratings[0], dataset))])] if ratings else []
    charts = sections(dataset, fields, advice)
    title, text = str(dataset.attrs["title"]), summary(dataset, fields, advice)
    return Page(title, text, chain(note, charts, _folded_sections(dataset, fields)), answer)


def _folded_sections(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Folded | Section]:
    """Yield tables, failures, cost and the campaign, shown on request."""
    if not fields:
        yield Section("", ["Nothing is computed yet."])
    elif all_tables := list(tables(dataset, fields)):
        yield Folded("Where numbers are large, and the largest", [Note(below(dataset, fields)), *all_tables])
    if failures := failure_table(dataset):
        yield Folded(f"Failed scenes ({dataset.attrs['failed']})", [failures])
    if texts := list(filter(None, [cost(dataset), files(dataset)])):
        yield Folded("Cost, and the file", texts)
    yield Folded("The campaign", [Verbatim(str(dataset.attrs["campaign"]))])


def tables(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Table]:
    """Yield all tables of numbers: where they exceed levels, correlations, largest numbers."""
    axes = swept(axes_of(dataset))
    for field in fields:
        if axes and field.rates_ics:
            yield crossing_table(field, axes) if is_grid(dataset) else share_table(field)
        if axes and not is_grid(dataset):
            yield correlation_table(field, axes)
        yield worst_table(field, dataset)


def below(dataset: xr.Dataset, fields: Sequence[Field]) -> str:
    """Return a note on the tables; empty where these need none."""
    axes = swept(axes_of(dataset))
    if axes and not is_grid(dataset):
        return "Rank correlations (Spearman) of sizes: +1 where both always grow together, 0 without order."
    if not _has_crossings(dataset, fields):
        return ""
    small = " Small: where a level is exceeded most, then where least." if len(axes) > 1 else ""
    name = main_axis(axes).name
    return f"Places along {name} are interpolated linearly between scenes.{small} All places: `{CROSSINGS}`."


def _has_crossings(dataset: xr.Dataset, fields: Sequence[Field]) -> bool:
    """Whether levels are exceeded along an axis of numbers."""
    axes = swept(axes_of(dataset))
    rated = any(field.rates_ics for field in fields)
    return rated and bool(axes) and is_grid(dataset) and main_axis(axes).is_number


def cost(dataset: xr.Dataset) -> str:
    """Return a sentence on the seconds of the scenes."""
    seconds = dataset["seconds"].values
    seconds = seconds[np.isfinite(seconds)]
    if not seconds.size:
        return ""
    total = f"{np.sum(seconds):.3g} s together, without models that other scenes have solved"
    if seconds.size == 1:
        return f"The scene took {total.replace(' together', '')}."
    return (
        f"Scenes took {np.min(seconds):.2g} ... {np.max(seconds):.2g} s, {total}; the slowest: "
        f"{'; '.join(slowest(dataset))}."
    )


# --- charts ---------------------------------------------------------------------------------------------


def sections(
    dataset: xr.Dataset, fields: Sequence[Field], advice: AdvisedICs | None
) -> Iterator[Section | Folded]:
    """Yield the charts: curves over one axis, maps over two, points of random scenes."""
    axes = swept(axes_of(dataset))
    if not axes:
        return
    failed = dataset["failure"].astype(str) != ""
    if advice is not None:
        chart = advised_chart(advice, axes, failed)
        yield Section("Which ICs are good enough", [chart, Note(_advice_text(axes, failed))])
    ratings = [field for field in fields if field.rates_ics]
    for field in sorted(fields, key=lambda field: not field.rates_ics):
        first, *rest = _of_field(field, axes, failed)
        if field in ratings[1:]:  # sentences on the first one begin the page
            first = replace(first, blocks=[judgement(dataset, field), *first.blocks])
        elif field in ratings and advice is None:
            first = replace(first, heading="")
        yield first
        yield from rest


def _of_field(field: Field, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Iterator[Section | Folded]:
    """Yield the charts of a field: curves over one axis, points of random scenes, maps of a grid."""
    heading = f"{field.title} over {join_words(axis.name for axis in axes)}"
    if "sample" not in failed.dims and len(axes) > 1:
        yield from _maps(field, axes, failed)
    elif len(axes) == 1:
        yield Section(heading, [_curves(field, axes[0]), Note(_text(field, axes))])
    else:
        yield Section(heading, [clouds(field, axes), Note(_text(field, axes))])


def _curves(field: Field, axis: ShownAxis) -> Block:
    if "sample" in field.values.dims:
        order = np.argsort(axis.at, kind="stable")[evenly_spaced(len(axis.at), MOST_POINTS)]
        axis, field = replace(axis, values=axis.values[order]), field.at(sample=order)
    return curves(field, axis)


def _maps(field: Field, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Iterator[Section | Folded]:
    """Yield maps over the first two axes: which ICs are within a tolerance, then the numbers of each."""
    further, plane = axes[2:], Plane.from_axes(axes, failed)
    if field.rates_ics:
        worst = field
        for axis in further:
            worst = worst.worst_over(axis.name)
        title = f"ICs within the tolerance over {join_words(axis.name for axis in axes[:2])}"
        yield Section(title, [within_chart(worst, plane), _within_note(axes, plane)])
    heading = f"{field.title} over {join_words(axis.name for axis in axes[:3])}"
    if not further:
        title = f"{symbol_of(field.rows[0])}: {heading}" if len(field.rows) == 1 else heading
        chart = field_chart(field, plane, "ICs" if field.rates_ics else "body")
        yield Section(title, [chart, Note(_text(field, axes))])
        return
    for axis in further[1:]:
        field = field.worst_over(axis.name)
    first = field.closest if field.rates_ics else field.rows[0]
    for number, row in enumerate(sorted(field.rows, key=lambda row: row != first)):
        name = f"{field.name}_by_{further[0].name}_{number}"
        blocks: list[Block] = [third_axis_chart(field, row, axes, failed, name), Note(_text(field, axes))]
        title = f"{symbol_of(row)}: {heading}"
        yield Folded(title, blocks) if number else Section(title, blocks)


def _within_note(axes: Sequence[ShownAxis], plane: Plane) -> Note:
    text = "Colours: the ICs within the tolerance at each scene"
    text += "; lines: where each of them exceeds it" if plane.has_lines else ""
    over = f"; the worst over {join_words(axis.name for axis in axes[2:])}" if axes[2:] else ""
    return Note(f"{text}{over}. {_meanings(axes)}")


def _text(field: Field, axes: Sequence[ShownAxis]) -> str:
    """Return what the numbers of charts are, and what charts leave out."""
    sentences = [field.text]
    count, third = field.values.sizes.get("sample", 0), axes[2:3]
    if count > MOST_POINTS:
        sentences.append(f"{MOST_POINTS} of {count} scenes are drawn.")
    if field.rates_ics and (count or len(axes) == 1 or all(axis.is_number for axis in axes[:2])):
        levels = join_words(f"{100 * level:g}" for level in LEVELS)
        sentences.append(f"Lines: {levels} %.")
    if len(axes) == 1 and field.floor is not None:
        sentences.append(f"Bands: the estimate of {field.reference}.")
    if (count or len(axes) == 1) and field.kind == "error" and np.any(field.values < LOWEST):
        sentences.append(f"Errors below {share(LOWEST)} are drawn there.")
    if third and not count and len(third[0].values) > MOST_STEPS:
        sentences.append(
            f"{MOST_STEPS} of {len(third[0].values)} values of {third[0].name}; the file has all."
        )
    if axes[3:] and not count:
        over = join_words(axis.name for axis in axes[3:])
        sentences.append(f"The worst over {over}." if field.rates_ics else f"At the first value of {over}.")
    return " ".join([*sentences, _meanings(axes)])


def _meanings(axes: Sequence[ShownAxis]) -> str:
    return f"{'; '.join(axis.meaning for axis in axes)}."


def _advice_text(axes: Sequence[ShownAxis], failed: xr.DataArray) -> str:
    text = "The cheapest ICs whose error, with the estimate of C, is at most `ics_tolerance`."
    if "sample" in failed.dims and len(axes) > 2:
        text += f" Over two of {len(axes)} axes."
    elif axes[3:]:
        text += f" At the first value of {join_words(axis.name for axis in axes[3:])}."
    return f"{text} {_meanings(axes)}"


# --- tables ---------------------------------------------------------------------------------------------


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
                    for part in ranges_above(axis.values, line.sizes, level):
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
        Row(f"{column}, {symbol_of(row)}", cells(field.select(rows=[row], columns=[column])))
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
