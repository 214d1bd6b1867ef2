"""The page of a campaign: the number of scenes, the largest errors, charts over the swept keys, tables."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr

from compare.campaigns.report.charts import (
    MOST_POINTS,
    MOST_STEPS,
    Plane,
    advised_chart,
    clouds,
    curves,
    field_chart,
    third_axis_chart,
    within_chart,
)
from compare.campaigns.report.fields import (
    LEVELS,
    LOWEST,
    Field,
    ShownAxis,
    evenly_spaced,
    find_advice,
    find_fields,
    is_grid,
    prepare,
    read_axes,
    share,
    swept,
    value_text,
)
from compare.campaigns.report.tables import (
    advice_table,
    answer_note,
    answer_table,
    cost_table,
    doubts,
    failure_table,
    field_tables,
    has_crossings,
    largest_sentence,
    main_axis,
    write_crossings,
)
from compare.report.looks import ics_symbol
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_results
from femic.cache import folders

# --- the page -------------------------------------------------------------------------------------------


CROSSINGS = "sweep_crossings.csv"
MOST_CATEGORIES = 4  # of an axis in the first sentence


def write_sweep(dataset: xr.Dataset, out: Path) -> Path:
    """Write `sweep.html` of a campaign's dataset into a folder, with figures and a table of crossings.

    Returns the path of the page.
    """
    folders.make(out)
    for old in [*(out / "figures").glob("sweep_*"), *out.glob(CROSSINGS)]:
        old.unlink()
    dataset = prepare(dataset)
    fields = find_fields(dataset)
    if has_crossings(dataset, fields):
        write_crossings([field for field in fields if field.rates_ics], read_axes(dataset), out / CROSSINGS)
    return write_results(sweep_page(dataset, fields), out, "sweep")


def sweep_page(dataset: xr.Dataset, fields: Sequence[Field]) -> Page:
    """Return the page of a prepared dataset and its fields."""
    ratings = [field for field in fields if field.rates_ics]
    answer = answer_table(ratings[0], dataset) if ratings else None
    note = [Section("", [Note(answer_note(ratings[0], dataset))])] if ratings else []
    sections = chain(note, _chart_sections(dataset, fields), _folded_sections(dataset, fields))
    summary = " ".join([*(largest_sentence(field, dataset) for field in ratings[:1]), count_scenes(dataset)])
    return Page(str(dataset.attrs["title"]), summary, sections, answer, list(doubts(dataset)))


def count_scenes(dataset: xr.Dataset) -> str:
    """Return the numbers of scenes, and the ranges of the axes."""
    scenes, computed, failed = (int(dataset.attrs[name]) for name in ("scenes", "computed", "failed"))
    ranges = []
    for axis in read_axes(dataset):
        values = [
            value_text(value) for value in (np.sort(axis.values) if axis.is_number else axis.categories)
        ]
        if axis.is_number and len(values) > 2:
            text = f"{values[0]} ... {values[-1]}"
        else:
            more = [f"{len(values) - MOST_CATEGORIES} more"] if len(values) > MOST_CATEGORIES else []
            text = join_words([*values[:MOST_CATEGORIES], *more])
        ranges.append(f"{axis.name} = {text} {axis.unit}".rstrip())
    return (
        f"{scenes} scenes over {join_words(ranges)}: {computed} computed, {failed} failed, "
        f"{scenes - computed - failed} not computed yet."
    )


def _folded_sections(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Folded | Section]:
    """Yield tables, failures, cost and the campaign, shown on request."""
    if fields:
        note = ""
        if not is_grid(dataset):
            note = (
                "Rank correlation (Spearman) of absolute values: +1 if both always grow together, 0 if "
                "there is no order."
            )
        elif has_crossings(dataset, fields):
            note = (
                f"Places along {main_axis(read_axes(dataset)).name} are interpolated linearly between "
                "scenes. Small: first where a level is exceeded most, then where it is exceeded least. "
                f"All places: `{CROSSINGS}`."
            )
        tables = [table for field in fields for table in field_tables(field, dataset)]
        yield Folded("Largest numbers, and where they occur", [Note(note), *tables])
    else:
        yield Section("", ["Nothing is computed yet."])
    if failures := failure_table(dataset):
        yield Folded(f"Failed scenes ({dataset.attrs['failed']})", [failures])
    yield Folded("Cost", [cost_table(dataset)])
    yield Folded("The campaign", [Verbatim(str(dataset.attrs["campaign"]))])


# --- charts ---------------------------------------------------------------------------------------------


ADVISED = (
    "The cheapest ICs whose error plus the estimated error of C is at most `ics_tolerance`. Random scenes "
    "are shown over the first two axes; otherwise axes beyond the third are at their first values."
)
LINES = f"Lines: {join_words(f'{100 * level:g}' for level in LEVELS)} %."


def _chart_sections(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Section | Folded]:
    """Yield the charts: the advice, then curves over one axis, maps over two, points of random scenes.

    Only the advice and the first field are shown at once.
    """
    axes = swept(read_axes(dataset))
    if not axes:
        return
    failed, meanings = dataset["failure"].astype(str) != "", f"{'; '.join(axis.meaning for axis in axes)}."
    if advice := find_advice(dataset):
        shown: list[Block] = [
            advice_table(advice),
            advised_chart(advice, axes, failed),
            Note(f"{ADVISED} {meanings}"),
        ]
        yield Section("Which ICs are accurate enough", shown)
    ratings = [field for field in fields if field.rates_ics]
    for number, field in enumerate(sorted(fields, key=lambda field: not field.rates_ics)):
        if "sample" not in failed.dims and len(axes) > 1:
            sections = [*_map_sections(field, axes, failed, meanings)]
        else:
            heading = f"{field.title} over {join_words(axis.name for axis in axes)}"
            sections = [Section(heading, [*_line_blocks(field, axes, meanings)])]
        if field in ratings[1:]:  # the table of the first one begins the page
            sections[0] = replace(sections[0], blocks=[answer_table(field, dataset), *sections[0].blocks])
        elif field in ratings and not advice:
            sections[0] = replace(sections[0], heading="")
        yield from sections if not number else (Folded(one.heading, one.blocks) for one in sections)


def _line_blocks(field: Field, axes: Sequence[ShownAxis], meanings: str) -> Iterator[Block]:
    """Yield curves over the only axis, or points over each axis, and what they show."""
    count = field.values.sizes.get("sample", 0)
    if len(axes) == 1:
        axis = axes[0]
        if count:
            order = np.argsort(axis.at, kind="stable")[evenly_spaced(len(axis.at), MOST_POINTS)]
            axis, field = replace(axis, values=axis.values[order]), field.at(sample=order)
        yield curves(field, axis)
    else:
        yield clouds(field, axes)
    drawn = f" {min(count, MOST_POINTS)} of {count} scenes are drawn." if count else ""
    rated = f" {LINES} Bands: the estimated error of {field.reference}." if field.rates_ics else ""
    lowest = f" Errors below {share(LOWEST)} are drawn there." if field.kind == "error" else ""
    yield Note(f"{field.text}{drawn}{rated}{lowest} {meanings}")


def _map_sections(
    field: Field, axes: Sequence[ShownAxis], failed: xr.DataArray, meanings: str
) -> Iterator[Section | Folded]:
    """Yield maps over the first two axes: which ICs are within a tolerance, then the numbers of each."""
    further, plane = axes[2:], Plane.from_axes(axes, failed)
    over = join_words([*(axis.name for axis in axes[:2])])
    if field.rates_ics:
        worst = field
        for axis in further:
            worst = worst.worst_over(axis.name)
        note = (
            "Colours: the ICs within the tolerance in each scene; with more than two axes, for the most "
            "unfavourable values of the other axes. Lines: where each of the ICs exceeds the tolerance. "
            f"{meanings}"
        )
        yield Section(f"ICs within the tolerance over {over}", [within_chart(worst, plane), Note(note)])
    rated = f" {LINES}" if field.rates_ics and plane.has_lines else ""
    heading = f"{field.title} over {join_words(axis.name for axis in axes[:3])}"
    if not further:
        title = f"{ics_symbol(field.rows[0])}: {heading}" if len(field.rows) == 1 else heading
        chart = field_chart(field, plane, "ICs" if field.rates_ics else "body")
        yield Section(title, [chart, Note(f"{field.text}{rated} {meanings}")])
        return
    for axis in further[1:]:
        field = field.worst_over(axis.name)
    rest = (
        "the largest error over the other axes" if field.rates_ics else "the first values of the other axes"
    )
    note = (
        f"{field.text}{rated} At most {MOST_STEPS} values of {further[0].name} are shown, {rest}. {meanings}"
    )
    first = field.closest if field.rates_ics else field.rows[0]
    for number, row in enumerate(sorted(field.rows, key=lambda row: row != first)):
        name = f"{field.name}_by_{further[0].name}_{number}"
        blocks: list[Block] = [third_axis_chart(field, row, axes, failed, name), Note(note)]
        title = f"{ics_symbol(row)}: {heading}"
        yield Folded(title, blocks) if number else Section(title, blocks)
