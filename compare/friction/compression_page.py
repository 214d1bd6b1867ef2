"""Figures, sentences and tables of compression with friction by several ICs."""

from collections.abc import Iterator

import xarray as xr
from matplotlib.figure import Figure

from compare.contact.dataset import others_of, reference_of
from compare.friction.page import MotionPage, map_parts, reference_symbol, tables_by_friction
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import Part, join_words
from compare.report.styles import symbol_of

SUFFICES = 0.05  # difference of sliding over contact area up to which ICs are said to suffice


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: the sliding area, and which ICs suffice to predict it."""
    last, symbol = dataset.isel(load=-1), reference_symbol(dataset)
    of_reference = last.sel(ics=reference_of(dataset))
    sentences = [
        f"At {float(last['load']):g} N the patch covers {float(of_reference.angle.min()):.0f} ... "
        f"{float(of_reference.angle.max()):.0f} degrees with {symbol}."
    ]
    for friction in dataset.friction.values:
        share, estimate = (
            float(of_reference[name].sel(friction=friction))
            for name in ("sliding_share", "estimate_sliding_share")
        )
        of_others = [
            f", {float(last.sliding_share.sel(ics=name, friction=friction)):.0%} with {symbol_of(name)}"
            for name in others_of(dataset)
        ]
        sentences.append(
            f"With friction {friction:g}, {share:.0%} of the contact area slides with {symbol} "
            f"(± {estimate:.0%} of the area){''.join(of_others)}."
        )
    return " ".join([*sentences, *_verdicts(dataset)])


def _verdicts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which ICs have ratios close enough to the reference's at all loads, and which do not."""
    reference = dataset.sel(ics=reference_of(dataset))
    away = abs(dataset.sliding_share - reference.sliding_share)
    worst = (away - reference.estimate_sliding_share).clip(0).max(["friction", "load"])
    for enough, verb in ((True, "within"), (False, "further than")):
        selected = [name for name in others_of(dataset) if (float(worst.sel(ics=name)) <= SUFFICES) == enough]
        if selected:
            furthest = ", ".join(f"{float(away.sel(ics=name).max()):.0%}" for name in selected)
            yield (
                f"{join_words(map(symbol_of, selected))}: {verb} {SUFFICES:.0%} of the area of "
                f"{reference_symbol(dataset)} beyond its estimate (at most {furthest} away)."
            )


def parts(dataset: xr.Dataset) -> Iterator[Part]:
    """Yield the figures."""
    yield Part(
        "How much of the contact slides",
        "Sliding area over contact area, over the load, and over the angle of the patch with these ICs. "
        f"Band: estimate of {reference_symbol(dataset)}, which includes the error of the steps of load.",
        "sliding",
        sliding(dataset),
    )
    last = f"At {float(dataset['load'][-1]):g} N."
    yield from map_parts(dataset, last, "Minus traction times slip in the last step of load, per area.")


def sliding(dataset: xr.Dataset) -> Figure:
    """Draw sliding over contact area by all ICs, a column per friction: over the load, over the angle."""
    reference, label = reference_of(dataset), f"estimate of {reference_symbol(dataset)}"
    with figure_grid(2, dataset.sizes["friction"], sharex="row", sharey=True) as (figure, rows):
        for number, (above, below) in enumerate(rows.T):
            of_friction, kilonewtons = dataset.isel(friction=number), dataset["load"] / 1e3
            draw_by_ics(above, kilonewtons, of_friction.sliding_share, 3)
            draw_by_ics(below, of_friction.angle, of_friction.sliding_share, 3)
            known = of_friction.sel(ics=reference)
            low = (known.sliding_share - known.estimate_sliding_share).clip(0, 1)
            high = (known.sliding_share + known.estimate_sliding_share).clip(0, 1)
            for axes, at in ((above, kilonewtons), (below, known.angle)):
                draw_band(axes, at, low, high, label)
            above.set(xlabel="load [kN]", title=f"friction {float(dataset.friction[number]):g}")
            below.set_xlabel("Δδ with the same ICs [deg]")
        for axes in rows[:, 0]:
            axes.set_ylabel("sliding / contact area [-]")
    return figure


COMPRESSION = MotionPage(summary, parts, tables_by_friction, sliding)
