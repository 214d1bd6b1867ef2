"""The figures of the page of a campaign with their headings: which kind, over which axes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from compare.pages.parts import Part, listed
from compare.reports.sweep import advised
from compare.reports.sweep.advised import Advice
from compare.reports.sweep.axes import ShownAxis, axes_of, is_grid, named, spread_out, swept
from compare.reports.sweep.clouds import MOST_POINTS, clouds, strongest
from compare.reports.sweep.curves import curves
from compare.reports.sweep.fields import Field, label_of, plain, swept_dims
from compare.reports.sweep.maps import Plane, maps
from compare.reports.sweep.summary import judgement

MOST_MULTIPLES = 4  # values of the third axis


def parts(dataset: xr.Dataset, fields: Sequence[Field], advice: Advice | None) -> Iterator[Part]:
    """Yield the figures: curves over one axis, maps over two, points of random scenes."""
    axes = swept(axes_of(dataset))
    if not axes:
        return
    if advice is not None:
        yield _advice_part(dataset, advice, axes)
    judged = [field for field in fields if field.kind != "value"]
    for field in fields:
        of_field = _of_field(dataset, field, axes)
        if field in judged[1:]:  # what the first one shows, the page begins with
            first = next(of_field)
            yield replace(first, text=f"{first.text} {' '.join(judgement(dataset, field))}")
        yield from of_field


def _of_field(dataset: xr.Dataset, field: Field, axes: Sequence[ShownAxis]) -> Iterator[Part]:
    """Yield the figures of a field: curves over one axis, maps over two, points of random scenes."""
    if not is_grid(dataset) and len(axes) == 1:
        order = np.argsort(axes[0].at, kind="stable")[spread_out(len(axes[0].at), MOST_POINTS)]
        along = replace(axes[0], values=axes[0].values[order])
        yield _curve_part(field.at(sample=order), along)
    elif not is_grid(dataset):
        yield from _cloud_parts(field, axes)
    elif len(axes) == 1:
        yield _curve_part(_squeezed(field, dataset, axes), axes[0])
    else:
        yield from _map_parts(dataset, field, axes)


def _curve_part(field: Field, axis: ShownAxis) -> Part:
    text = field.text
    if field.kind != "value":
        text += " Dotted: 1, 2, 5 and 10 %."
    return Part(_headed(field, [axis]), text, field.name, curves(field, axis))


def _map_parts(dataset: xr.Dataset, field: Field, axes: Sequence[ShownAxis]) -> Iterator[Part]:
    """Yield maps over the first two axes; over a third one, those of each row by themselves."""
    first, second, *further = axes
    field = _squeezed(field, dataset, axes)
    text = field.text + (" Lines: 1, 2, 5 and 10 %." if field.kind != "value" and _has_lines(axes) else "")
    if not further:
        plane = Plane(first, second, _failed(dataset, axes).values)
        for k, figure in enumerate(maps(field, plane)):
            yield Part(_headed(field, axes, k), text if k == 0 else "", f"{field.name}_{k}", figure)
        return
    third, *rest = further
    for axis in rest:
        field = field.worst_over(axis.name)
    failed = _failed(dataset, axes, [axis.name for axis in rest])
    places = spread_out(len(third.values), MOST_MULTIPLES)
    text += _reduced(field, third, rest, len(places))
    for number, row in enumerate(field.rows):
        of_row = field.of(rows=[row])
        by_row = [
            (
                named({third.name: third.values[k]}),
                of_row.at(**{third.name: k}),
                Plane(first, second, failed.isel({third.name: k}).values),
            )
            for k in places
        ]
        for k, figure in enumerate(maps(of_row, by_row[0][2], by_row)):
            heading = f"{label_of(row)}: {_headed(field, axes[:3], k)}"
            yield Part(heading, text if number == k == 0 else "", f"{field.name}_{number}_{k}", figure)


def _has_lines(axes: Sequence[ShownAxis]) -> bool:
    return all(axis.is_number for axis in axes[:2])


def _reduced(field: Field, third: ShownAxis, rest: Sequence[ShownAxis], shown: int) -> str:
    """What figures of three axes and more leave out."""
    told_third = f" A row per value of {third.name}"
    told_third += "." if shown == len(third.values) else f", {shown} of {len(third.values)}."
    if not rest:
        return told_third
    over = listed(axis.name for axis in rest)
    if field.kind == "value":
        return f"{told_third} At the first value of {over}."
    return f"{told_third} The worst over {over}."


def _cloud_parts(field: Field, axes: Sequence[ShownAxis]) -> Iterator[Part]:
    count = field.values.sizes["sample"]
    text = field.text
    if field.kind != "value":
        text += " Dotted: 1, 2, 5 and 10 %."
    if count > MOST_POINTS:
        text += f" {MOST_POINTS} of {count} scenes are drawn."
    for k, column in enumerate(field.columns):
        one = field.of(columns=[column])
        note = f" Colours: {strongest(one, axes).name}, with which they go most."
        yield Part(
            f"{plain(column)}: {_headed(field, axes)}", text + note, f"{field.name}_{k}", clouds(one, axes)
        )
        text = ""


def _advice_part(dataset: xr.Dataset, advice: Advice, axes: Sequence[ShownAxis]) -> Part:
    """Which ICs are advised, over one axis, two or three, or as points."""
    text = "The cheapest ICs whose error, with the estimate of C, is at most `ics_tolerance`."
    heading = "Which ICs are good enough"
    if not is_grid(dataset):
        return Part(heading, text, "advice", advised.advised_points(advice, axes))
    single = {axis.name: 0 for axis in axes_of(dataset) if axis not in axes and len(axis.values) == 1}
    advice = advice.at(**single)
    if len(axes) == 1:
        return Part(
            heading, text, "advice", advised.advised_along(advice, axes[0], _failed(dataset, axes).values)
        )
    first, second, *further = axes
    rest = {axis.name: 0 for axis in further[1:]}
    if rest:
        advice = advice.at(**rest)
        text += f" At the first value of {listed(rest)}."
    if not further:
        plane = Plane(first, second, _failed(dataset, axes).values)
        return Part(heading, text, "advice", advised.advised_over(advice, plane))
    third = further[0]
    failed = _failed(dataset, axes, list(rest))
    panels = [
        (
            named({third.name: third.values[k]}),
            advice.at(**{third.name: k}),
            Plane(first, second, failed.isel({third.name: k}).values),
        )
        for k in spread_out(len(third.values), MOST_MULTIPLES)
    ]
    return Part(heading, text, "advice", advised.advised_over(advice, panels[0][2], panels))


def _squeezed(field: Field, dataset: xr.Dataset, axes: Sequence[ShownAxis]) -> Field:
    """The field without swept dims of one value."""
    names = [axis.name for axis in axes]
    return field.at(**{dim: 0 for dim in swept_dims(dataset) if dim not in names})


def _failed(dataset: xr.Dataset, axes: Sequence[ShownAxis], over: Sequence[str] = ()) -> xr.DataArray:
    """Where scenes have failed, over the axes in their order; over some of them: where all have."""
    failed = dataset["failure"].astype(str) != ""
    names = [axis.name for axis in axes]
    single = {dim: 0 for dim in swept_dims(dataset) if dim not in names}
    return failed.isel(single, drop=True).transpose(*names).all(list(over))


def _headed(field: Field, axes: Sequence[ShownAxis], k: int = 0) -> str:
    more = ", continued" if k else ""
    return f"{field.what[0].upper()}{field.what[1:]} over {listed(axis.name for axis in axes)}{more}"
