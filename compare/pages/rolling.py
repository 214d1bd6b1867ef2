"""The page of rolling with friction by several ICs, from its dataset."""

from collections.abc import Iterator
from itertools import product

import xarray as xr

from compare.pages.contact_numbers import tolerance
from compare.pages.friction import (
    MotionPage,
    PageParts,
    by_friction,
    covered_ranges,
    curves_by_ics,
    difference_panel,
    difference_unit,
    friction_text,
    load_text,
    percent_change,
    places,
    quantity_label,
    reference_symbol,
    signed_text,
    verdict_cells,
    verdict_text,
    worst_friction,
)
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import Look, ics_symbol
from compare.report.parts import Folded, extreme
from compare.report.tables import Cell, Column, Row, Table, number_text, numbers, with_estimate
from femic.contact.datasets import DISPLACED
from femic.contact.motions.rolling import OF_CURVE, scaled_force
from femic.results.contact import compared_ics, ics_names, reference_ics

EVERYWHERE = "at every creepage", "at one creepage or more"
NOTE = (
    "Panel “longitudinal force on the wheel”: F_x; band: estimated error of {0}. Panel “difference from the "
    "curve with {0}”: bars are the estimated errors of the differences, dotted lines the tolerance, key "
    "ics_tolerance of the scene."
)
PRESSED = (
    "F_x exceeds friction × load at some creepages: the pressures on inclined flanks add up to more than the "
    "load."
)
LIMIT = Look("#808080", "solid", width=1)
ACROSS = "creepage [%]"


def parts(dataset: xr.Dataset) -> PageParts:
    """Return how far the creep-force curves of ICs are from the reference's, tractions, and free rolling."""
    symbol = reference_symbol(dataset)
    ends = [number_text(xi, ".3g") for xi in places(dataset).values[[0, -1]]]
    share = dataset.attrs["equal_force"]
    contact = f"All contacts carry the same force, F_x = {share:g} × friction × load; their creepages differ."
    tractions = f"{contact} The wheel rolls towards +x. Grey: friction × pressure with {symbol}."
    return PageParts(
        summary=(
            f"{verdict_text(dataset, 'F_x', EVERYWHERE)} Load: {load_text(dataset)}; friction: "
            f"{friction_text(dataset)}; creepages: {ends[0]} to {ends[1]} %; ± is the estimated error."
        ).strip(),
        answer=answer(dataset),
        note=NOTE.format(symbol),
        doubts=list(doubts(dataset)),
        contact=contact,
        work="Work of friction per rolled distance and area: −(traction · slip).",
        further=[
            Folded("Pressures and tractions along the centre line", [tractions, centre_line(dataset)]),
            curve_tables(dataset),
        ],
        remarks=list(remarks(dataset)),
    )


def answer(dataset: xr.Dataset) -> Table:
    """Return with which ICs forces are within the tolerance, and free rolling where ICs differ most."""
    friction, symbol, cells = worst_friction(dataset), reference_symbol(dataset), verdict_cells(dataset)
    zero, slope = (quantity_label(dataset, name) for name in ("zero_creepage", "slope"))
    at, rows = dataset.sel(friction=friction), list[Row]()
    reference = at.sel(ics=reference_ics(dataset))
    for name in [reference_ics(dataset), *compared_ics(dataset)]:
        curve, apart = at.sel(ics=name), ["", ""]
        if name in cells:
            away = zero.factor * (curve.zero_creepage - reference.zero_creepage)
            steeper = number_text(percent_change(curve.slope, reference.slope), "+.1f")
            apart = [signed_text(away, zero.factor * reference.estimate_zero_creepage), f"{steeper} %"]
        texts = [
            _estimate_text(curve, key, one.factor) for key, one in (("zero_creepage", zero), ("slope", slope))
        ]
        free = [Cell(text, below=below) for text, below in zip(texts, apart, strict=True)]
        rows.append(Row(ics_symbol(name), [cells.get(name, Cell("reference")), *free]))
    columns = [
        Column(f"F_x within {tolerance(dataset):g} {difference_unit(dataset)}?"),
        Column(f"creepage at F_x = 0, friction {friction:g}", zero.unit),
        Column(f"slope of F_x there, friction {friction:g}", slope.unit),
    ]
    return Table(f"ICs; small: difference from {symbol}", columns, rows)


def _estimate_text(curve: xr.Dataset, name: str, factor: float) -> str:
    return with_estimate(factor * curve[name], factor * curve[f"estimate_{name}"])


def creep_force(dataset: xr.Dataset) -> Chart:
    """Return creep-force curves by all ICs, and beside them their differences to the reference's."""
    force = quantity_label(dataset, "F_x")

    def panels(contacts: xr.Dataset) -> list[Panel]:
        values, estimate = (force.factor * contacts[name] for name in ("F_x", "estimate_F_x"))
        curves = curves_by_ics(places(dataset), values, estimate)
        title = f"difference from the curve with {reference_symbol(dataset)}"
        return [
            Panel("longitudinal force on the wheel", ACROSS, force.title, curves),
            *([difference_panel(dataset, contacts, title)] if compared_ics(dataset) else []),
        ]

    alt = "creep-force curves with each of the ICs, and their differences from the reference curve"
    return by_friction(dataset, "creep_force", panels, 2, 1.2, alt)


def centre_line(dataset: xr.Dataset) -> Chart:
    """Return pressures and longitudinal tractions along x through the largest pressure, at equal force."""
    reference, pressure = reference_ics(dataset), dataset.p.sel(direction="n")
    strip = int(pressure.sel(ics=reference).max(["friction", "x"]).argmax("s"))
    along = dataset.isel(s=strip, x=covered_ranges(pressure.max("friction") > 0)["x"])
    place = f"at s = {float(along.s):.3g} mm"

    def panels(contacts: xr.Dataset) -> list[Panel]:
        tractions = along.p.sel(friction=contacts.friction)
        p_n, p_x = (tractions.sel(direction=name) for name in ("n", "x"))
        bound = float(contacts.friction) * float(along.friction_factor) * p_n.sel(ics=reference)
        limits = [Curve("friction × pressure", along.x, sign * bound, LIMIT) for sign in (1, -1)]
        minus = f"traction minus that with {ics_symbol(reference)}"
        away = curves_by_ics(along.x, p_x - p_x.sel(ics=reference))
        across = "x [mm]"
        return [
            Panel(f"pressure {place}", across, "p_n [MPa]", curves_by_ics(along.x, p_n)),
            Panel(f"traction {place}", across, "p_x [MPa]", [*limits, *curves_by_ics(along.x, p_x)]),
            *([Panel(minus, across, "p_x [MPa]", away)] if compared_ics(dataset) else []),
        ]

    return by_friction(dataset, "centre_line", panels, alt="pressures and tractions along the centre line")


def curve_tables(dataset: xr.Dataset) -> Folded:
    """Return the numbers of free rolling and the distances of curves, by friction and ICs."""
    labels = {name: quantity_label(dataset, name) for name in OF_CURVE}
    free, apart = [], []
    for friction, name in product(dataset.friction.values, ics_names(dataset)):
        title, curve = f"friction {friction:g}, {ics_symbol(name)}", dataset.sel(friction=friction, ics=name)
        cells = [_estimate_text(curve, key, label.factor) for key, label in labels.items()]
        moved = 100 * float(curve[f"{DISPLACED}zero_creepage"])
        free.append(Row(title, [*cells, Cell(moved, ".3g"), Cell(float(curve.seconds), ".3g")]))
        if name != reference_ics(dataset):
            apart.append(Row(title, [_estimate_text(curve, key, 100.0) for key in ("largest", "rms")]))
    columns = [
        *(Column(label.symbol, label.unit) for label in labels.values()),
        Column("ξ_0 with the exact distance", labels["zero_creepage"].unit),
        Column("contacts took", "s"),
    ]
    sizes = numbers("largest", "root mean square", unit=difference_unit(dataset))
    meanings = "; ".join(f"{labels[name].symbol}: {OF_CURVE[name].meaning}" for name in OF_CURVE)
    meanings += f", F_x = {dataset.attrs['equal_force']:g} × friction × load"
    return Folded(
        "Free rolling, and differences of the curves, at each friction coefficient",
        [
            f"{meanings}.",
            Table("curve", columns, free),
            Table(f"largest difference from the curve with {reference_symbol(dataset)}", sizes, apart),
        ],
    )


def remarks(dataset: xr.Dataset) -> Iterator[str]:
    """Yield the effect of the distance of the displaced wheel."""
    reference = dataset.sel(ics=reference_ics(dataset))
    solved = reference.isel(friction=reference[f"{DISPLACED}zero_creepage"].notnull())
    if solved.sizes["friction"]:
        zero = 100 * (solved[f"{DISPLACED}zero_creepage"] - solved.zero_creepage)
        known = 100 * float(solved.estimate_zero_creepage.max())
        linearised = solved.p_max.sel(xi=solved[f"{DISPLACED}xi"])
        p_max = 100 * (solved[f"{DISPLACED}p_max"] / linearised - 1)
        yield (
            f"With {reference_symbol(dataset)}, the exact distance of the displaced wheel, used instead of "
            "the linearised distance, would change two numbers: the creepage at F_x = 0 "
            f"({signed_text(extreme(zero), known)} %) and p_max ({number_text(extreme(p_max), '+.1f')} %)."
        )


def doubts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which contacts are less accurate, and whether forces exceed friction times load."""
    for name in ics_names(dataset):
        simplified = dataset.simplified.sel(ics=name)
        if number := int(simplified.sum()):
            yield (
                f"With {ics_symbol(name)}, contacts solved only in a simplified form at the leading edge: "
                f"{number} of {simplified.size}. They are less accurate."
            )
    if not dataset.attrs["friction_by_angle"] and float(abs(scaled_force(dataset)).max()) > 1.0:
        yield PRESSED


ROLLING = MotionPage(creep_force, parts)
