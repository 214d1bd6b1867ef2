"""Figures, sentences, tables and page of rolling with friction by several ICs."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from compare.contact.figures import reference_of
from compare.friction import maps
from compare.friction.page import band_of, names, others, write_contact_page
from compare.friction.rolling import DISPLACED, scaled_force
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import Part, extreme, join_words, range_text
from compare.report.styles import symbol_of
from compare.report.tables import Cell, Column, Row, Table, cell, columns_of, numbers
from femic.contact.pairs.quantities import OF_CURVE, OF_ROLLING

PANEL = 4.1, 2.9  # its width and height [inch]
SIZES = "largest", "root mean square"  # of the differences of curves
SUFFICES = 0.02  # largest distance of curves over friction times load up to which ICs are said to suffice


def write_rolling(dataset: xr.Dataset, out: Path) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page."""
    return write_contact_page(dataset, out, summary(dataset), _parts(dataset), _tables(dataset))


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: which ICs suffice, and by which number."""
    reference = reference_of(dataset)
    symbol, worst = symbol_of(reference), dataset[["largest", "rms"]].max("friction")
    zero_creepage = dataset.zero_creepage.sel(ics=reference)
    slope = dataset.slope.sel(ics=reference) / dataset.attrs["load"]
    sentences = [
        f"{dataset.attrs['load']:g} N, friction {join_words(f'{f:g}' for f in dataset.friction.values)}: "
        f"without longitudinal force the wheel rolls at a creepage of {range_text(zero_creepage, '.3g')} "
        f"with {symbol}, where the force rises by {range_text(slope, '.3g')} of the load per creepage."
    ]
    for name in others(dataset):
        zero, slope = (dataset[key].sel(ics=name) for key in ("zero_creepage", "slope"))
        shift = extreme(zero - dataset.zero_creepage.sel(ics=reference))
        steeper = extreme(slope / dataset.slope.sel(ics=reference) - 1)
        sentences.append(
            f"{symbol_of(name)}: its creep-force curve is up to {float(worst.largest.sel(ics=name)):.1%} of "
            f"friction times load from the curve with {symbol} (root mean square over the creepages at most "
            f"{float(worst.rms.sel(ics=name)):.1%}); creepage without force {shift:+.2g}, "
            f"slope {steeper:+.1%}."
        )
    return " ".join([*sentences, _verdict(dataset), *_displaced(dataset), *_simplified(dataset)])


def _verdict(dataset: xr.Dataset) -> str:
    """Return which ICs have curves close enough to the reference's at all creepages."""
    compared, symbol = others(dataset), symbol_of(reference_of(dataset))
    if not compared:
        return f"No other ICs than {symbol} are compared."
    worst = {name: float(dataset.largest.sel(ics=name).max()) for name in compared}
    estimates = {name: _distance_estimate(dataset, name) for name in compared}
    best = min(compared, key=worst.__getitem__)
    tie = [
        name for name in compared if abs(worst[name] - worst[best]) <= max(estimates[name], estimates[best])
    ]
    unsure = [name for name in compared if abs(worst[name] - SUFFICES) < estimates[name]]
    enough = [name for name in compared if name not in unsure and worst[name] <= SUFFICES]
    sentences = [*_sufficing(enough, symbol), *_undecided(unsure, symbol)] or [
        f"None of them is within {SUFFICES:.0%} of friction times load from {symbol} at all creepages; "
        f"{symbol_of(best)} is the nearest, with {worst[best]:.1%}."
    ]
    if len(tie) > 1:
        sentences.append(f"{join_words(map(symbol_of, tie))} tie: they differ by less than their estimates.")
    return " ".join(sentences)


def _sufficing(enough: list[str], symbol: str) -> Iterator[str]:
    if enough:
        suffice = "suffices" if len(enough) == 1 else "suffice"
        yield (
            f"Within {SUFFICES:.0%} of friction times load from {symbol} at all creepages, "
            f"{join_words(map(symbol_of, enough))} {suffice}."
        )


def _undecided(unsure: list[str], symbol: str) -> Iterator[str]:
    if unsure:
        are = "is" if len(unsure) == 1 else "are"
        yield (
            f"Whether {join_words(map(symbol_of, unsure))} {are} within {SUFFICES:.0%} from {symbol} at all "
            "creepages, estimates leave open."
        )


def _distance_estimate(dataset: xr.Dataset, name: str) -> float:
    """The estimated error of the largest distance of a curve over friction times load; 0 without one.

    Without an own estimate it is the sum of the estimates of both curves.
    """
    if "estimate_largest" in dataset:
        estimate = dataset.estimate_largest.sel(ics=name).max()
    else:
        of_curves = scaled_force(dataset, "estimate_F_x").max(["xi", "friction"])
        estimate = of_curves.sel(ics=name) + of_curves.sel(ics=reference_of(dataset))
    return float(estimate.fillna(0.0))


def _displaced(dataset: xr.Dataset) -> Iterator[str]:
    """Yield the effect of the distance of the displaced wheel, with the reference."""
    of_reference = dataset.sel(ics=reference_of(dataset))
    solved = of_reference.isel(friction=of_reference[f"{DISPLACED}zero_creepage"].notnull())
    if solved.sizes["friction"]:
        zero = solved[f"{DISPLACED}zero_creepage"] - solved.zero_creepage
        linearised = solved.p_max.sel(xi=solved[f"{DISPLACED}xi"])
        p_max = solved[f"{DISPLACED}p_max"] / linearised - 1
        yield (
            "The distance of the displaced wheel instead of the linearised one would move the creepage "
            f"without force by {extreme(zero):+.1g} and change p_max by {extreme(p_max):+.1%}, with "
            f"{symbol_of(reference_of(dataset))}."
        )


def _simplified(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which contacts are less accurate than others."""
    for name in names(dataset):
        of_ics = dataset.simplified.sel(ics=name)
        if number := int(of_ics.sum()):
            yield (
                f"{symbol_of(name)}: {number} of {of_ics.size} contacts were solved only with fewer "
                "elements that follow others at the leading edge; these are less accurate."
            )


def _parts(dataset: xr.Dataset) -> Iterator[Part]:
    symbol, share = symbol_of(reference_of(dataset)), dataset.attrs["equal_force"]
    equal = f"All at the same force, F_x = {share:g} friction times load, each at a creepage of its own."
    yield Part(
        "Creep-force curves",
        "Longitudinal force on the wheel over friction times load, over the creepage. Its limit is larger "
        "than 1, since the flanks are pressed together, too. Below: the difference from the curve with "
        f"{symbol}; band: its estimate.",
        "creep_force",
        creep_force(dataset),
    )
    yield Part(
        "Tractions along the centre line",
        f"{equal} Rolling is towards +x. Grey: the largest traction that friction allows with {symbol}, "
        "friction times pressure.",
        "centre_line",
        centre_line(dataset),
    )
    yield Part("Where the contact sticks", equal, "stick", maps.stick_maps(dataset))
    yield Part(
        "Work of friction",
        f"{equal} Minus traction times slip, per unit of rolled distance and area.",
        "work",
        maps.work_maps(dataset),
    )


def creep_force(dataset: xr.Dataset) -> Figure:
    """Creep-force curves by all ICs, a column per friction; below, their differences to the reference's."""
    reference, percent = reference_of(dataset), 100 * dataset.xi
    force, estimate = scaled_force(dataset), scaled_force(dataset, "estimate_F_x").sel(ics=reference)
    with figure_grid(2, dataset.sizes["friction"], PANEL, sharex=True, sharey="row") as (figure, rows):
        for number, (above, below) in enumerate(rows.T):
            of_friction, band = force.isel(friction=number), estimate.isel(friction=number)
            draw_by_ics(above, percent, of_friction, 3)
            draw_by_ics(below, percent, of_friction - of_friction.sel(ics=reference), 3)
            draw_band(below, percent, -band, band, band_of(dataset))
            above.set_title(f"friction {float(dataset.friction[number]):g}", fontsize=9)
            below.set_xlabel("creepage [%]")
        rows[0, 0].set_ylabel("F_x / (friction load) [-]")
        rows[1, 0].set_ylabel(f"minus the one with {symbol_of(reference)} [-]")
    return figure


def centre_line(dataset: xr.Dataset) -> Figure:
    """Longitudinal tractions along s = 0 at equal force by all ICs, a panel per friction."""
    reference, middle = reference_of(dataset), dataset.p.isel(s=dataset.sizes["s"] // 2)
    shown = (middle.sel(direction="n") > 0).any(["friction", "ics"])
    with figure_grid(1, dataset.sizes["friction"], PANEL) as (figure, grid):
        for number, axes in enumerate(grid[0]):
            of_friction = middle.isel(friction=number).isel(x=np.flatnonzero(shown))
            bound = float(dataset.friction[number]) * of_friction.sel(ics=reference, direction="n")
            for sign, label in ((1, "friction times pressure"), (-1, "_below")):
                axes.plot(of_friction.x, sign * bound, color="grey", linewidth=1, label=label)
            draw_by_ics(axes, of_friction.x, of_friction.sel(direction="x"), 0)
            axes.set(xlabel="x [mm]", title=f"friction {float(dataset.friction[number]):g}")
            axes.set_ylabel("p_x at s = 0 [MPa]" if number == 0 else "")
    return figure


def _tables(dataset: xr.Dataset) -> list[Table]:
    return [_free(dataset), *(_points(dataset, number) for number in range(dataset.sizes["friction"]))]


def _free(dataset: xr.Dataset) -> Table:
    """Return the table of free rolling by friction and ICs, with distances from the reference's curve."""
    symbol = symbol_of(reference_of(dataset))
    columns = [Column(one.meaning, one.unit if one.unit != "1" else "") for one in OF_CURVE.values()]
    rows = [
        Row(
            f"friction {float(friction):g}, {symbol_of(name)}",
            [
                *(cell(one[key], one[f"estimate_{key}"]) for key in OF_CURVE),
                cell(one[f"{DISPLACED}zero_creepage"]),
                *(Cell(float(one[key]), ".2%") for key in ("largest", "rms")),
                cell(one.seconds, digits=3),
            ],
        )
        for friction in dataset.friction.values
        for name in names(dataset)
        for one in [dataset.sel(friction=friction, ics=name)]
    ]
    further = [
        *numbers("creepage without longitudinal force, distance of the displaced wheel"),
        *numbers(*(f"curve minus the one with {symbol}, {size}" for size in SIZES), unit="friction load"),
        *numbers("s"),
    ]
    return Table("free rolling", [*columns, *further], rows)


def _points(dataset: xr.Dataset, number: int) -> Table:
    """Return the table of all numbers of the curves at a friction."""
    of_friction = dataset.isel(friction=number)
    rows = [
        Row(
            f"{symbol_of(name)}, {100 * float(xi):.3g} %",
            [cell(one[key], one[f"estimate_{key}"]) for key in OF_ROLLING],
        )
        for xi in dataset.xi.values
        for name in names(dataset)
        for one in [of_friction.sel(ics=name, xi=xi)]
    ]
    return Table(f"friction {float(of_friction.friction):g}", columns_of(OF_ROLLING.values()), rows)
