"""Figures, sentences, tables and page of compression with friction by several ICs."""

from collections.abc import Iterator
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from compare.contact.figures import reference_of
from compare.friction import maps
from compare.friction.page import band_of, names, others, write_contact_page
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import Part, join_words
from compare.report.styles import symbol_of
from compare.report.tables import Row, Table, cell, columns_of
from femic.contact.pairs.quantities import OF_COMPRESSION

PANEL = 4.1, 2.9  # its width and height [inch]
SUFFICES = 0.05  # difference of sliding over contact area up to which ICs are said to suffice


def write_compression(dataset: xr.Dataset, out: Path) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page."""
    return write_contact_page(dataset, out, summary(dataset), _parts(dataset), _tables(dataset))


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: the sliding area, and which ICs suffice to predict it."""
    reference, last = reference_of(dataset), dataset.isel(load=-1)
    symbol = symbol_of(reference)
    of_reference = last.sel(ics=reference)
    sentences = [
        f"At {float(last['load']):g} N the patch covers {float(of_reference.angle.min()):.0f} ... "
        f"{float(of_reference.angle.max()):.0f} degrees with {symbol}."
    ]
    sentences += [
        f"With friction {float(friction):g}, {float(one.sliding_share):.0%} of the contact area slides with "
        f"{symbol} (± {float(one.estimate_sliding_share):.0%} of the area)"
        + "".join(
            f", {float(last.sliding_share.sel(ics=name, friction=friction)):.0%} with {symbol_of(name)}"
            for name in others(dataset)
        )
        + "."
        for friction in dataset.friction.values
        for one in [of_reference.sel(friction=friction)]
    ]
    return " ".join([*sentences, *_verdicts(dataset)])


def _verdicts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which ICs have ratios close enough to the reference's at all loads, and which do not."""
    symbol = symbol_of(reference_of(dataset))
    away = abs(dataset.sliding_share - dataset.sliding_share.sel(ics=reference_of(dataset)))
    estimate = dataset.estimate_sliding_share.sel(ics=reference_of(dataset))
    worst = (away - estimate).clip(0).max(["friction", "load"])
    for enough, verb in ((True, "within"), (False, "further than")):
        selected = [name for name in others(dataset) if (float(worst.sel(ics=name)) <= SUFFICES) == enough]
        if selected:
            furthest = ", ".join(f"{float(away.sel(ics=name).max()):.0%}" for name in selected)
            yield (
                f"{join_words(map(symbol_of, selected))}: {verb} {SUFFICES:.0%} of the area of {symbol} "
                f"beyond its estimate (at most {furthest} away)."
            )


def _parts(dataset: xr.Dataset) -> Iterator[Part]:
    symbol, largest = symbol_of(reference_of(dataset)), float(dataset["load"][-1])
    yield Part(
        "How much of the contact slides",
        "Sliding area over contact area, over the load, and over the angle of the patch with these ICs. "
        f"Band: estimate of {symbol}, which includes the error of the steps of load.",
        "sliding",
        sliding(dataset),
    )
    at_last = f"At {largest:g} N."
    yield Part("Where the contact sticks", at_last, "stick", maps.stick_maps(dataset))
    yield Part(
        "Work of friction",
        f"{at_last} Minus traction times slip in the last step of load, per area.",
        "work",
        maps.work_maps(dataset),
    )


def sliding(dataset: xr.Dataset) -> Figure:
    """Sliding over contact area by all ICs, a column per friction: over the load, over the angle."""
    reference = reference_of(dataset)
    with figure_grid(2, dataset.sizes["friction"], PANEL, sharex="row", sharey=True) as (figure, rows):
        for number, (above, below) in enumerate(rows.T):
            one, kilonewtons = dataset.isel(friction=number), dataset["load"] / 1e3
            draw_by_ics(above, kilonewtons, one.sliding_share, 3)
            draw_by_ics(below, one.angle, one.sliding_share, 3)
            estimate, of_reference = (
                one[key].sel(ics=reference) for key in ("estimate_sliding_share", "sliding_share")
            )
            low, high = (of_reference - estimate).clip(0, 1), (of_reference + estimate).clip(0, 1)
            for axes, at in ((above, kilonewtons), (below, one.angle.sel(ics=reference))):
                draw_band(axes, at, low, high, band_of(dataset))
            above.set(xlabel="load [kN]", title=f"friction {float(dataset.friction[number]):g}")
            below.set_xlabel("Δδ with the same ICs [deg]")
        for axes in rows[:, 0]:
            axes.set_ylabel("sliding / contact area [-]")
    return figure


def _tables(dataset: xr.Dataset) -> list[Table]:
    """Return all numbers, a table per friction."""
    return [
        Table(
            f"friction {float(friction):g}",
            columns_of(OF_COMPRESSION.values()),
            [
                Row(
                    f"{symbol_of(name)}, {float(load):g} N",
                    [cell(one[key], one[f"estimate_{key}"]) for key in OF_COMPRESSION],
                )
                for load in dataset["load"].values
                for name in names(dataset)
                for one in [dataset.sel(friction=friction, ics=name, load=load)]
            ],
        )
        for friction in dataset.friction.values
    ]
