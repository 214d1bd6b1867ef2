"""The charts of the page of a campaign, in sections with headings and notes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import Block, Folded, Note, Section, join_words
from femic.campaigns.report.advised import AdvisedICs, advised_chart
from femic.campaigns.report.axes import ShownAxis, axes_of, evenly_spaced, swept
from femic.campaigns.report.curves import MOST_POINTS, clouds, curves
from femic.campaigns.report.fields import LEVELS, LOWEST, Field, share
from femic.campaigns.report.maps import MOST_STEPS, Plane, field_chart, third_axis_chart, within_chart
from femic.campaigns.report.summary import judgement


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
    further, plane = axes[2:], Plane.of(axes, failed)
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
