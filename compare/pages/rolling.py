"""Verdict, charts and tables of rolling with friction by several ICs."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import xarray as xr

from compare.pages.friction import (
    MotionPage,
    by_friction,
    covered_ranges,
    curves_by_ics,
    difference,
    difference_unit,
    load_text,
    main_estimate,
    percent_change,
    places,
    quantity_label,
    reference_symbol,
    signed_text,
    worst_friction,
)
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import Look, symbol_of
from compare.report.parts import Folded, Section, extreme, join_words, range_text
from compare.report.tables import Cell, Column, Row, Table, number_text, numbers, with_estimate
from femic.contact.datasets import DISPLACED
from femic.contact.motions.rolling import OF_CURVE
from femic.results.contact import ics_of, others_of, reference_of

SUFFICES = 0.02  # largest distance of curves over friction times load up to which ICs are said to suffice
LIMIT = Look("#808080", "solid", width=1)
ACROSS = "creepage [%]"


def summary(dataset: xr.Dataset) -> str:
    """Return which ICs give the creep-force curve of the reference, how far off others are, free rolling."""
    sentences = [_verdict(dataset), _further(dataset), _free_rolling(dataset)]
    return " ".join(filter(None, sentences))


def _distances(dataset: xr.Dataset) -> tuple[dict[str, float], dict[str, float]]:
    """Return the largest distances of curves, over friction times load, and their estimates, by ICs."""
    largest, estimate = (dataset[name].max("friction") for name in ("largest", "estimate_largest"))
    names = ics_of(dataset)
    return (
        dict(zip(names, largest.values.tolist(), strict=True)),
        dict(zip(names, estimate.fillna(0.0).values.tolist(), strict=True)),
    )


def _sorted_out(dataset: xr.Dataset) -> tuple[list[str], list[str]]:
    """Return the ICs that suffice, and those of which estimates leave open whether they do; nearest first."""
    largest, estimates = _distances(dataset)
    compared = sorted(others_of(dataset), key=lambda name: largest[name])
    unsure = [name for name in compared if abs(largest[name] - SUFFICES) < estimates[name]]
    return [name for name in compared if name not in unsure and largest[name] <= SUFFICES], unsure


def _verdict(dataset: xr.Dataset) -> str:
    """Return which ICs have curves close enough to the reference's at all creepages."""
    symbol, (largest, estimates) = reference_symbol(dataset), _distances(dataset)
    compared = sorted(others_of(dataset), key=lambda name: largest[name])
    if not compared:
        return f"No other ICs than {symbol} are compared."
    enough, unsure = _sorted_out(dataset)
    near = f"within {SUFFICES:.0%} of friction times load from the creep-force curve with {symbol}"
    open_question = (
        f"whether {_list_names(unsure, largest)} {_verb('is', unsure)} within {SUFFICES:.0%}, too, estimates"
    )
    if enough:
        begun = f"{_list_names(enough, largest)} {_verb('suffices', enough)}: {near} at all creepages"
        known = max(estimates[name] for name in unsure) if unsure else 0.0
        return f"{begun}; {open_question} (± {known:.1%}) leave open." if unsure else f"{begun}."
    if unsure:
        known = max(estimates[name] for name in unsure)
        away = join_words(f"{largest[name]:.1%}" for name in unsure)
        return (
            f"Nearest to the creep-force curve with {symbol} {_verb('is', unsure)} "
            f"{join_words(map(symbol_of, unsure))}, at most {away} of friction times load away; whether "
            f"that is within {SUFFICES:.0%}, estimates (± {known:.1%}) leave open."
        )
    best = compared[0]
    return f"None is {near} at all creepages; {symbol_of(best)} is the nearest, with {largest[best]:.1%}."


def _list_names(names: Sequence[str], largest: dict[str, float]) -> str:
    """Return ICs with the largest distances of their curves."""
    return join_words(f"{symbol_of(name)} ({largest[name]:.1%})" for name in names)


def _verb(singular: str, names: Sequence[str]) -> str:
    return singular if len(names) == 1 else {"is": "are", "suffices": "suffice"}[singular]


def _further(dataset: xr.Dataset) -> str:
    """Return how far other ICs are off, and which ones tie."""
    largest, estimates = _distances(dataset)
    compared = sorted(others_of(dataset), key=lambda name: largest[name])
    if not compared:
        return ""
    enough, unsure = _sorted_out(dataset)
    shown_above = {*enough, *unsure} or {compared[0]}
    off = [name for name in compared if name not in shown_above]
    best = compared[0]
    tie = [
        name
        for name in compared
        if abs(largest[name] - largest[best]) <= max(estimates[name], estimates[best])
    ]
    clauses = [
        *([f"{_list_names(off, largest)} {_verb('is', off)} further off"] if off else []),
        *([f"{join_words(map(symbol_of, tie))} tie within their estimates"] if len(tie) > 1 else []),
    ]
    return f"{'; '.join(clauses)}." if clauses else ""


def _free_rolling(dataset: xr.Dataset) -> str:
    """Return at which creepage the wheel rolls without longitudinal force, and how far others are off."""
    zero, reference = 100 * dataset.zero_creepage, reference_of(dataset)
    at = range_text(zero.sel(ics=reference), ".2g")
    begun = f"Without longitudinal force the wheel rolls at a creepage of {at}% with {symbol_of(reference)}"
    known = 100 * float(dataset.estimate_zero_creepage.sel(ics=reference).max())
    away = {name: extreme(zero.sel(ics=name) - zero.sel(ics=reference)) for name in others_of(dataset)}
    far = [
        f"{number_text(off, '+.1g')} with {symbol_of(name)}" for name, off in away.items() if abs(off) > known
    ]
    return f"{begun} (off by up to {join_words(far)})." if far else f"{begun}."


def answer(dataset: xr.Dataset) -> Table:
    """Return the largest distances of curves at any friction, and free rolling where ICs differ most."""
    friction, symbol = worst_friction(dataset), reference_symbol(dataset)
    zero, slope = (quantity_label(dataset, name) for name in ("zero_creepage", "slope"))
    columns = [
        Column(f"largest distance from the curve with {symbol}", difference_unit(dataset)),
        Column(f"creepage without force, friction {friction:g}", zero.unit),
        Column(f"minus that with {symbol}", zero.unit),
        Column(f"slope there, friction {friction:g}", slope.unit),
        Column(f"off {symbol} by", "%"),
    ]
    largest, estimates = _distances(dataset)
    at = dataset.sel(friction=friction)
    reference = at.sel(ics=reference_of(dataset))
    rows = []
    for name in ics_of(dataset):
        curve, is_reference = at.sel(ics=name), name == reference_of(dataset)
        cells = [
            "" if is_reference else with_estimate(100 * largest[name], 100 * estimates[name]),
            _estimate_text(curve, "zero_creepage", zero.factor),
            ""
            if is_reference
            else signed_text(
                zero.factor * (curve.zero_creepage - reference.zero_creepage),
                zero.factor * reference.estimate_zero_creepage,
            ),
            _estimate_text(curve, "slope", slope.factor),
            "" if is_reference else number_text(percent_change(curve.slope, reference.slope), "+.1f"),
        ]
        rows.append(Row(symbol_of(name), cells))
    return Table("ICs", columns, rows)


def _estimate_text(curve: xr.Dataset, name: str, factor: float) -> str:
    return with_estimate(factor * curve[name], factor * curve[f"estimate_{name}"])


def creep_force(dataset: xr.Dataset) -> Chart:
    """Return creep-force curves by all ICs, and beside them their differences to the reference's."""
    force = quantity_label(dataset, "F_x")

    def panels(of_friction: xr.Dataset) -> list[Panel]:
        values, estimate = (force.factor * of_friction[name] for name in ("F_x", "estimate_F_x"))
        curves = curves_by_ics(places(dataset), values, estimate)
        cells = [Panel("longitudinal force on the wheel", ACROSS, force.title, curves)]
        if others_of(dataset):
            away, known = difference(of_friction), main_estimate(of_friction)
            title = f"minus the curve with {reference_symbol(dataset)}"
            up = f"difference [{difference_unit(dataset)}]"
            cells.append(Panel(title, ACROSS, up, curves_by_ics(places(dataset), away, known)))
        return cells

    alt = "creep-force curves by ICs, and their differences from the reference's"
    return replace(by_friction(dataset, "creep_force", panels, 2), heights=1.2, alt=alt)


def note(dataset: xr.Dataset) -> str:
    """Return what the main chart shows."""
    pressed_too = (
        "The limit of the force is larger than friction times load, since the flanks are pressed together, "
        "too. "
    )
    return (
        f"{load_text(dataset)}. {'' if dataset.attrs['friction_by_angle'] else pressed_too}"
        f"Band: estimate of {reference_symbol(dataset)}."
    )


def sections(dataset: xr.Dataset) -> list[Section]:
    """Return the tractions along the centre line."""
    text = (
        f"{contact(dataset)} Rolling is towards +x. Grey: the largest traction that friction allows with "
        f"{reference_symbol(dataset)}, friction times pressure."
    )
    return [Section("Tractions along the centre line", [text, centre_line(dataset)])]


def contact(dataset: xr.Dataset) -> str:
    """Return at which force tractions are compared."""
    share = dataset.attrs["equal_force"]
    return f"All at the same force, F_x = {share:g} friction times load, each at a creepage of its own."


def centre_line(dataset: xr.Dataset) -> Chart:
    """Return pressures and longitudinal tractions along x through the largest pressure, at equal force."""
    of_reference = dataset.p.sel(direction="n", ics=reference_of(dataset))
    strip = int(of_reference.max(["friction", "x"]).argmax("s"))
    along, factor, place = (
        dataset.p.isel(s=strip),
        float(dataset.friction_factor[strip]),
        float(dataset.s[strip]),
    )
    pressed = dataset.p.sel(direction="n").max("friction") > 0
    along = along.isel(x=covered_ranges(pressed)["x"])

    def panels(of_friction: xr.DataArray) -> list[Panel]:
        friction, reference = float(of_friction.friction), reference_of(dataset)
        pressure, traction = (of_friction.sel(direction=name) for name in ("n", "x"))
        bound = friction * factor * pressure.sel(ics=reference)
        limits = [Curve("friction times pressure", along.x, sign * bound, LIMIT) for sign in (1, -1)]
        across = "x [mm]"
        cells = [
            Panel(f"pressure at s = {place:.3g} mm", across, "p_n [MPa]", curves_by_ics(along.x, pressure)),
            Panel(
                f"traction at s = {place:.3g} mm",
                across,
                "p_x [MPa]",
                [*limits, *curves_by_ics(along.x, traction)],
            ),
        ]
        if others_of(dataset):
            away = curves_by_ics(along.x, traction - traction.sel(ics=reference))
            cells.append(Panel(f"traction minus that with {symbol_of(reference)}", across, "p_x [MPa]", away))
        return cells

    alt = "pressures and tractions along the centre line"
    chart = by_friction(dataset, "centre_line", lambda of: panels(along.sel(friction=of.friction)))
    return replace(chart, alt=alt)


def tables(dataset: xr.Dataset) -> list[Folded]:
    """Return free rolling and distances of curves at each friction."""
    meanings = "; ".join(
        f"{quantity_label(dataset, name).symbol}: {OF_CURVE[name].meaning}" for name in OF_CURVE
    )
    heading = "Free rolling, and distances of curves, at each friction"
    return [Folded(heading, [f"{meanings}.", _free_table(dataset), _distance_table(dataset)])]


def _free_table(dataset: xr.Dataset) -> Table:
    """Return the numbers of free rolling by friction and ICs."""
    named = {name: quantity_label(dataset, name) for name in OF_CURVE}
    displaced = Column("ξ_0, distance of the displaced wheel", named["zero_creepage"].unit)
    columns = [*(Column(number.symbol, number.unit) for number in named.values()), displaced]
    rows = []
    for title, curve in _by_friction_and_ics(dataset, ics_of(dataset)):
        cells = [_estimate_text(curve, key, number.factor) for key, number in named.items()]
        moved = 100 * float(curve[f"{DISPLACED}zero_creepage"])
        rows.append(Row(title, [*cells, Cell(moved, ".3g"), Cell(float(curve.seconds), ".3g")]))
    return Table("curve", [*columns, Column("contacts took", "s")], rows)


def _distance_table(dataset: xr.Dataset) -> Table:
    """Return the distances of curves from the reference's by friction and ICs."""
    rows = [
        Row(title, [_estimate_text(curve, name, 100.0) for name in ("largest", "rms")])
        for title, curve in _by_friction_and_ics(dataset, others_of(dataset))
    ]
    sizes = numbers("largest", "root mean square", unit=difference_unit(dataset))
    return Table(f"distance from the curve with {reference_symbol(dataset)}", sizes, rows)


def _by_friction_and_ics(dataset: xr.Dataset, names: list[str]) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield titles and numbers of the curves at each friction with some ICs."""
    for friction, name in product(dataset.friction.values, names):
        yield f"friction {friction:g}, {symbol_of(name)}", dataset.sel(friction=friction, ics=name)


def remarks(dataset: xr.Dataset) -> Iterator[str]:
    """Yield the effect of the distance of the displaced wheel, and which contacts are less accurate."""
    of_reference = dataset.sel(ics=reference_of(dataset))
    solved = of_reference.isel(friction=of_reference[f"{DISPLACED}zero_creepage"].notnull())
    if solved.sizes["friction"]:
        zero = 100 * (solved[f"{DISPLACED}zero_creepage"] - solved.zero_creepage)
        known = 100 * float(solved.estimate_zero_creepage.max())
        linearised = solved.p_max.sel(xi=solved[f"{DISPLACED}xi"])
        p_max = solved[f"{DISPLACED}p_max"] / linearised - 1
        yield (
            "The distance of the displaced wheel instead of the linearised one would move the creepage "
            f"without force by {signed_text(extreme(zero), known)}% and change p_max by "
            f"{number_text(extreme(p_max), '+.1%')}, with {reference_symbol(dataset)}."
        )
    for name in ics_of(dataset):
        of_ics = dataset.simplified.sel(ics=name)
        if number := int(of_ics.sum()):
            yield (
                f"{symbol_of(name)}: {number} of {of_ics.size} contacts were solved only with fewer "
                "elements that follow others at the leading edge; these are less accurate."
            )


ROLLING = MotionPage(
    summary,
    answer,
    creep_force,
    note,
    contact,
    "Minus traction times slip, per unit of rolled distance and area.",
    sections,
    tables,
    remarks,
)
