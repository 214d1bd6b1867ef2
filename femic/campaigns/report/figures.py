"""The figures of the page of a campaign, with their headings and texts."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import Part, join_words
from femic.campaigns.report.advised import AdvisedICs, advised_over, advised_points
from femic.campaigns.report.axes import Names, ShownAxis, axes_of, evenly_spaced, swept, values_text
from femic.campaigns.report.clouds import MOST_POINTS, clouds, strongest
from femic.campaigns.report.curves import curves
from femic.campaigns.report.fields import LOWEST, Field, plain
from femic.campaigns.report.maps import STRONG, MapRow, Plane, maps
from femic.campaigns.report.scales import share
from femic.campaigns.report.summary import judgement

MOST_MULTIPLES = 4  # values of the third axis
MOST_PANELS = 60  # of all figures of random points of a field


def parts(dataset: xr.Dataset, fields: Sequence[Field], advice: AdvisedICs | None) -> Iterator[Part]:
    """Yield the figures: curves over one axis, maps over two, points of random scenes."""
    axes = swept(axes_of(dataset))
    if not axes:
        return
    failed = dataset["failure"].astype(str) != ""
    if advice is not None:
        yield _advice_part(advice, axes, failed)
    ratings = [field for field in fields if field.rates_ics]
    for field in fields:
        parts_of_field = _of_field(field, axes, failed)
        if field in ratings[1:]:  # sentences on the first one begin the page
            first = next(parts_of_field)
            yield replace(first, text=f"{first.text} {' '.join(judgement(dataset, field))}")
        yield from parts_of_field


def _of_field(field: Field, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Iterator[Part]:
    """Yield the figures of a field: curves over one axis, maps over two, points of random scenes."""
    are_samples = "sample" in failed.dims
    if len(axes) == 1:
        (axis,) = axes
        if are_samples:
            order = np.argsort(axis.at, kind="stable")[evenly_spaced(len(axis.at), MOST_POINTS)]
            axis, field = replace(axis, values=axis.values[order]), field.at(sample=order)
        yield Part(
            _headed(field, axes), field.text + _levels(field, "Dotted"), field.name, curves(field, axis)
        )
    elif are_samples:
        yield from _cloud_parts(field, axes)
    else:
        yield from _map_parts(field, axes, failed)


def _map_parts(field: Field, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Iterator[Part]:
    """Yield maps over the first two axes, the worst over others; then over the third for the closest row."""
    first, second, *further = axes
    text, name = field.text, field.name
    if first.is_number and second.is_number:
        text += _levels(field, "Lines")
    elif field.rates_ics and (first.is_number or second.is_number):
        text += f" Lines: {share(STRONG)}."
    if field.rates_ics or not further:
        worst = field
        for axis in further:
            worst = worst.worst_over(axis.name)
        over = f" The worst over {join_words(axis.name for axis in further)}." if further else ""
        plane = Plane.of(axes, failed)
        rows = [MapRow(symbol_of(row), worst.of(rows=[row]), plane) for row in field.rows]
        yield from _mapped(rows, _headed(field, axes[:2]), text + over, name)
    if not further:
        return
    for number, row in enumerate([field.closest] if field.rates_ics else field.rows):
        row_field, note = field.of(rows=[row]), ""
        for axis in further[1:]:
            row_field = row_field.worst_over(axis.name)
        rows = [MapRow(title, row_field.at(**at), plane) for title, at, plane in _by_third(axes, failed)]
        if field.rates_ics and len(field.rows) > 1:
            note = f"{symbol_of(row)} only, which is the closest on the average. "
        heading = f"{symbol_of(row)}: {_headed(field, axes[:3])}"
        yield from _mapped(
            rows, heading, note + _left_out(field, axes), f"{name}_by_{further[0].name}_{number}"
        )


def _mapped(rows: Sequence[MapRow], heading: str, text: str, name: str) -> Iterator[Part]:
    for k, figure in enumerate(maps(rows)):
        yield Part(f"{heading}, continued" if k else heading, "" if k else text, f"{name}_{k}", figure)


def _by_third(axes: Sequence[ShownAxis], failed: xr.DataArray) -> Iterator[tuple[str, Names, Plane]]:
    """Yield titles and places of some values of the third axis, and planes of the first two axes."""
    third = axes[2]
    for k in evenly_spaced(len(third.values), MOST_MULTIPLES):
        at = {third.name: k}
        yield values_text({third.name: third.values[k]}), at, Plane.of(axes, failed.isel(at))


def _left_out(field: Field, axes: Sequence[ShownAxis]) -> str:
    """Return a note on the scenes that figures of three axes and more leave out."""
    third, *rest = axes[2:]
    shown = len(evenly_spaced(len(third.values), MOST_MULTIPLES))
    text = f"A row per value of {third.name}, {shown} of {len(third.values)}; the file has all."
    if rest:
        over = join_words(axis.name for axis in rest)
        text += f" The worst over {over}." if field.rates_ics else f" At the first value of {over}."
    return text


def _cloud_parts(field: Field, axes: Sequence[ShownAxis]) -> Iterator[Part]:
    """Yield scatter plots over each axis, a figure per column, up to `MOST_PANELS` panels."""
    count = field.values.sizes["sample"]
    text = field.text + _levels(field, "Dotted")
    if count > MOST_POINTS:
        text += f" {MOST_POINTS} of {count} scenes are drawn."
    most = max(1, MOST_PANELS // (len(field.rows) * len(axes)))
    left_out = [plain(column) for column in field.columns[most:]]
    if left_out:
        text += (
            f" Not drawn: {join_words(left_out)}; they are in the tables, and in the file of the campaign."
        )
    for k, column in enumerate(field.columns[:most]):
        one = field.of(columns=[column])
        axis, correlation = strongest(one, axes)
        note = f" Colours: {axis.name}{', with the strongest correlation' if correlation else ''}."
        heading = f"{plain(column)}: {_headed(field, axes)}"
        yield Part(heading, text + note, f"{field.name}_{k}", clouds(one, axes))
        text = ""


def _advice_part(advice: AdvisedICs, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Part:
    """Return the part on advised ICs, over one axis, two or three, or as points."""
    heading = "Which ICs are good enough"
    text = "The cheapest ICs whose error, with the estimate of C, is at most `ics_tolerance`."
    if "sample" in failed.dims:
        if len(axes) > 2:
            text += f" Over two of {len(axes)} axes."
        return Part(heading, text, "advice", advised_points(advice, axes))
    if len(axes) <= 2:
        return Part(heading, text, "advice", advised_over([("", advice, Plane.of(axes, failed))]))
    rest = {axis.name: 0 for axis in axes[3:]}
    if rest:
        text += f" At the first value of {join_words(rest)}."
        advice, failed = advice.at(**rest), failed.isel(rest)
    panels = [(title, advice.at(**at), plane) for title, at, plane in _by_third(axes, failed)]
    return Part(heading, text, "advice", advised_over(panels))


def _levels(field: Field, what: str) -> str:
    if not field.rates_ics:
        return ""
    text = f" {what}: 1, 2, 5 and 10 %."
    if what == "Lines" and np.any(np.isnan(field.values)):
        text = f"{text.removesuffix('.')}, where most scenes are known."
    if what == "Dotted" and field.kind == "error" and np.any(field.values < LOWEST):
        text += f" Errors below {share(LOWEST)} are drawn there."
    return text


def _headed(field: Field, axes: Sequence[ShownAxis]) -> str:
    return f"{field.title} over {join_words(axis.name for axis in axes)}"
