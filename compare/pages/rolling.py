"""The page of rolling with friction by several ICs, from its dataset."""

from collections.abc import Iterator
from itertools import product

import xarray as xr

from compare.pages.contact_numbers import verdict
from compare.pages.friction import (
    MotionPage,
    PageParts,
    by_friction,
    covered_ranges,
    curves_by_ics,
    difference_panel,
    difference_unit,
    load_text,
    percent_change,
    places,
    quantity_label,
    reference_symbol,
    signed_text,
    worst_friction,
)
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import Look, ics_symbol
from compare.report.parts import Folded, Section, extreme, range_text
from compare.report.tables import Cell, Column, Row, Table, number_text, numbers, with_estimate
from femic.contact.datasets import DISPLACED
from femic.contact.motions.rolling import OF_CURVE
from femic.results.contact import compared_ics, ics_names, reference_ics

SUFFICES = 2.0  # % of friction times load: largest distance of curves up to which ICs suffice
LIMIT = Look("#808080", "solid", width=1)
ACROSS = "creepage [%]"


def parts(dataset: xr.Dataset) -> PageParts:
    """Return how far the creep-force curves of ICs are from the reference's, tractions, and free rolling."""
    symbol = reference_symbol(dataset)
    zero = 100 * dataset.zero_creepage.sel(ics=reference_ics(dataset))
    pressed_too = "The force can exceed friction times load because the flanks also press on each other. "
    share = dataset.attrs["equal_force"]
    contact = f"All contacts carry the same force, F_x = {share:g} × friction × load; their creepages differ."
    tractions = (
        f"{contact} The wheel rolls towards +x. Grey: the friction limit with {symbol}, friction times "
        "pressure."
    )
    return PageParts(
        summary=(
            f"With {symbol}, under {load_text(dataset)} and friction {range_text(dataset.friction, 'g')}, "
            f"the longitudinal force is zero at a creepage of {range_text(zero, '.2g')}%."
        ),
        answer=answer(dataset),
        note=(
            f"{load_text(dataset)}. {'' if dataset.attrs['friction_by_angle'] else pressed_too}Band: "
            f"estimated error of {symbol}."
        ),
        contact=contact,
        work="Work of friction per unit of rolled distance and area (minus traction times slip).",
        sections=[Section("Tractions along the centre line", [tractions, centre_line(dataset)])],
        tables=[curve_tables(dataset)],
        remarks=list(remarks(dataset)),
    )


def answer(dataset: xr.Dataset) -> Table:
    """Return the largest distances of curves at any friction, and free rolling where ICs differ most."""
    friction, symbol = worst_friction(dataset), reference_symbol(dataset)
    zero, slope = (quantity_label(dataset, name) for name in ("zero_creepage", "slope"))
    largest, estimates = (100 * dataset[name].max("friction") for name in ("largest", "estimate_largest"))
    at = dataset.sel(friction=friction)
    reference = at.sel(ics=reference_ics(dataset))
    rows = []
    for name in ics_names(dataset):
        curve, off, known = at.sel(ics=name), largest.sel(ics=name), estimates.fillna(0.0).sel(ics=name)
        away = zero.factor * (curve.zero_creepage - reference.zero_creepage)
        cells: list[Cell | str] = [
            Cell(with_estimate(off, known), below=verdict(off, known, SUFFICES)),
            _estimate_text(curve, "zero_creepage", zero.factor),
            signed_text(away, zero.factor * reference.estimate_zero_creepage),
            _estimate_text(curve, "slope", slope.factor),
            number_text(percent_change(curve.slope, reference.slope), "+.1f"),
        ]
        if name == reference_ics(dataset):
            cells[0] = cells[2] = cells[4] = ""
        rows.append(Row(ics_symbol(name), cells))
    columns = [
        Column(f"largest difference from the curve with {symbol}", difference_unit(dataset)),
        Column(f"creepage at F_x = 0, friction {friction:g}", zero.unit),
        Column(f"minus that with {symbol}", zero.unit),
        Column(f"slope at F_x = 0, friction {friction:g}", slope.unit),
        Column(f"off {symbol} by", "%"),
    ]
    return Table("ICs", columns, rows)


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
        limits = [Curve("friction times pressure", along.x, sign * bound, LIMIT) for sign in (1, -1)]
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
        Column("ξ_0, distance of the displaced wheel", labels["zero_creepage"].unit),
        Column("contacts took", "s"),
    ]
    sizes = numbers("largest", "root mean square", unit=difference_unit(dataset))
    meanings = "; ".join(f"{labels[name].symbol}: {OF_CURVE[name].meaning}" for name in OF_CURVE)
    return Folded(
        "Free rolling, and differences of the curves, at each friction coefficient",
        [
            f"{meanings}.",
            Table("curve", columns, free),
            Table(f"largest difference from the curve with {reference_symbol(dataset)}", sizes, apart),
        ],
    )


def remarks(dataset: xr.Dataset) -> Iterator[str]:
    """Yield the effect of the distance of the displaced wheel, and which contacts are less accurate."""
    reference = dataset.sel(ics=reference_ics(dataset))
    solved = reference.isel(friction=reference[f"{DISPLACED}zero_creepage"].notnull())
    if solved.sizes["friction"]:
        zero = 100 * (solved[f"{DISPLACED}zero_creepage"] - solved.zero_creepage)
        known = 100 * float(solved.estimate_zero_creepage.max())
        linearised = solved.p_max.sel(xi=solved[f"{DISPLACED}xi"])
        p_max = solved[f"{DISPLACED}p_max"] / linearised - 1
        yield (
            f"With {reference_symbol(dataset)}, the distance of the displaced wheel, used instead of the "
            "linearised distance, would change the creepage at F_x = 0 by "
            f"{signed_text(extreme(zero), known)}% and p_max by {number_text(extreme(p_max), '+.1%')}."
        )
    for name in ics_names(dataset):
        simplified = dataset.simplified.sel(ics=name)
        if number := int(simplified.sum()):
            yield (
                f"{ics_symbol(name)}: {number} of {simplified.size} contacts were only solved in a "
                "simplified form at the leading edge. These contacts are less accurate."
            )


ROLLING = MotionPage(creep_force, parts)
