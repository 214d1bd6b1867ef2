"""Figures, sentences and tables of rolling with friction by several ICs."""

from collections.abc import Iterator
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from compare.contact.dataset import ics_of, others_of, reference_of
from compare.friction.page import MotionPage, map_parts, number_cells, reference_symbol, tables_by_friction
from compare.friction.rolling import DISPLACED, scaled_force
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import Part, extreme, join_words, range_text
from compare.report.styles import symbol_of
from compare.report.tables import Cell, Column, Row, Table, cell, numbers
from femic.contact.pairs.quantities import OF_CURVE

SIZES = "largest", "root mean square"  # of the differences of curves
SUFFICES = 0.02  # largest distance of curves over friction times load up to which ICs are said to suffice


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: which ICs suffice, and by which number."""
    reference, symbol = reference_of(dataset), reference_symbol(dataset)
    worst = dataset[["largest", "rms"]].max("friction")
    zero_creepage = dataset.zero_creepage.sel(ics=reference)
    slope = dataset.slope.sel(ics=reference) / dataset.attrs["load"]
    sentences = [
        f"{dataset.attrs['load']:g} N, friction {join_words(f'{f:g}' for f in dataset.friction.values)}: "
        f"without longitudinal force the wheel rolls at a creepage of {range_text(zero_creepage, '.3g')} "
        f"with {symbol}, where the force rises by {range_text(slope, '.3g')} of the load per creepage."
    ]
    for name in others_of(dataset):
        zero, slope = (dataset[key].sel(ics=name) for key in ("zero_creepage", "slope"))
        shift = extreme(zero - dataset.zero_creepage.sel(ics=reference))
        steeper = extreme(slope / dataset.slope.sel(ics=reference) - 1)
        sentences.append(
            f"{symbol_of(name)}: its creep-force curve is up to {float(worst.largest.sel(ics=name)):.1%} of "
            f"friction times load from the curve with {symbol} (root mean square over the creepages at most "
            f"{float(worst.rms.sel(ics=name)):.1%}); creepage without force {shift:+.2g}, "
            f"slope {steeper:+.1%}."
        )
    return " ".join([*sentences, *_verdict(dataset), *_displaced(dataset), *_simplified(dataset)])


def _verdict(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which ICs have curves close enough to the reference's at all creepages."""
    compared, symbol = others_of(dataset), reference_symbol(dataset)
    if not compared:
        yield f"No other ICs than {symbol} are compared."
        return
    worst = dataset.largest.max("friction").to_series()
    estimates = dataset.estimate_largest.max("friction").fillna(0.0).to_series()
    unsure = [name for name in compared if abs(worst[name] - SUFFICES) < estimates[name]]
    enough = [name for name in compared if name not in unsure and worst[name] <= SUFFICES]
    best = min(compared, key=worst.get)
    if enough:
        yield (
            f"Within {SUFFICES:.0%} of friction times load from {symbol} at all creepages, "
            f"{join_words(map(symbol_of, enough))} {'suffices' if len(enough) == 1 else 'suffice'}."
        )
    if unsure:
        yield (
            f"Whether {join_words(map(symbol_of, unsure))} {'is' if len(unsure) == 1 else 'are'} within "
            f"{SUFFICES:.0%} from {symbol} at all creepages, estimates leave open."
        )
    if not enough and not unsure:
        yield (
            f"None of them is within {SUFFICES:.0%} of friction times load from {symbol} at all creepages; "
            f"{symbol_of(best)} is the nearest, with {worst[best]:.1%}."
        )
    tie = [
        name for name in compared if abs(worst[name] - worst[best]) <= max(estimates[name], estimates[best])
    ]
    if len(tie) > 1:
        yield f"{join_words(map(symbol_of, tie))} tie: they differ by less than their estimates."


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
            f"{reference_symbol(dataset)}."
        )


def _simplified(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which contacts are less accurate than others."""
    for name in ics_of(dataset):
        of_ics = dataset.simplified.sel(ics=name)
        if number := int(of_ics.sum()):
            yield (
                f"{symbol_of(name)}: {number} of {of_ics.size} contacts were solved only with fewer "
                "elements that follow others at the leading edge; these are less accurate."
            )


def parts(dataset: xr.Dataset) -> Iterator[Part]:
    """Yield the figures."""
    symbol, share = reference_symbol(dataset), dataset.attrs["equal_force"]
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
    yield from map_parts(dataset, equal, "Minus traction times slip, per unit of rolled distance and area.")


def creep_force(dataset: xr.Dataset) -> Figure:
    """Draw creep-force curves by all ICs, a column per friction; below, differences to the reference's."""
    reference, percent = reference_of(dataset), 100 * dataset.xi
    force, estimate = scaled_force(dataset), scaled_force(dataset, "estimate_F_x").sel(ics=reference)
    with figure_grid(2, dataset.sizes["friction"], sharex=True, sharey="row") as (figure, rows):
        for number, (above, below) in enumerate(rows.T):
            of_friction, band = force.isel(friction=number), estimate.isel(friction=number)
            draw_by_ics(above, percent, of_friction, 3)
            draw_by_ics(below, percent, of_friction - of_friction.sel(ics=reference), 3)
            draw_band(below, percent, -band, band, f"estimate of {reference_symbol(dataset)}")
            above.set_title(f"friction {float(dataset.friction[number]):g}", fontsize=9)
            below.set_xlabel("creepage [%]")
        rows[0, 0].set_ylabel("F_x / (friction load) [-]")
        rows[1, 0].set_ylabel(f"minus the one with {reference_symbol(dataset)} [-]")
    return figure


def centre_line(dataset: xr.Dataset) -> Figure:
    """Draw longitudinal tractions along s = 0 at equal force by all ICs, a panel per friction."""
    reference, middle = reference_of(dataset), dataset.p.isel(s=dataset.sizes["s"] // 2)
    shown = (middle.sel(direction="n") > 0).any(["friction", "ics"])
    with figure_grid(1, dataset.sizes["friction"]) as (figure, grid):
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
    return [_free(dataset), *tables_by_friction(dataset)]


def _free(dataset: xr.Dataset) -> Table:
    """Return the table of free rolling by friction and ICs, with distances from the reference's curve."""
    columns = [
        *(Column(number.meaning, number.unit if number.unit != "1" else "") for number in OF_CURVE.values()),
        *numbers("creepage without longitudinal force, distance of the displaced wheel"),
        *numbers(
            *(f"curve minus the one with {reference_symbol(dataset)}, {size}" for size in SIZES),
            unit="friction load",
        ),
        *numbers("s"),
    ]
    rows = []
    for friction, name in product(dataset.friction.values, ics_of(dataset)):
        curve = dataset.sel(friction=friction, ics=name)
        cells = [
            *number_cells(curve, OF_CURVE),
            cell(curve[f"{DISPLACED}zero_creepage"]),
            *(Cell(float(curve[key]), ".2%") for key in ("largest", "rms")),
            cell(curve.seconds, digits=3),
        ]
        rows.append(Row(f"friction {friction:g}, {symbol_of(name)}", cells))
    return Table("free rolling", columns, rows)


ROLLING = MotionPage(summary, parts, _tables, creep_force)
