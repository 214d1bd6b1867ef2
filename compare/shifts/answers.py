"""The answer of `femic shifts`: at which shifts which ICs are good enough, in sentences and a table."""

import json

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import join_words
from compare.report.tables import Cell, Column, Row, Table, number_text, texts
from compare.shifts.differences import (
    F_X,
    F_Y,
    LIMITS,
    P_MAX,
    WORK,
    Quantity,
    compared,
    compared_quantities,
    difference,
    ranked,
    reference_label,
    reference_names,
    reference_values,
)
from femic.contact.pairs.planar import PLANAR


def summary(dataset: xr.Dataset) -> str:
    """Return where half-space ICs are good enough, the worst contact, and the geometry: three sentences.

    Of a wheelset that rolls, the second one is of the creep forces.
    """
    second = _creep_forces(dataset) if "F_x" in dataset else _worst_case(dataset)
    return " ".join([_good_enough(dataset), second, _geometry_sentence(dataset)])


def _good_enough(dataset: xr.Dataset) -> str:
    names, planar = _ics(dataset), _planar(dataset)
    if not names:
        name = symbol_of(ranked(dataset)[0])
        return f"Only one kind of ICs, {name}, was used, so nothing is said about half-space ICs{planar}."
    name = names[0]
    parts = [f"within {100 * limit:.0f} % {shifts_within(dataset, name, limit)}" for limit in LIMITS]
    unique = _merged(parts)
    best = reference_label(dataset)
    return f"Half-space ICs ({symbol_of(name)}) give p_max as {best} does {join_words(unique)}{planar}."


def _ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs on the curved surface that are compared with better ones."""
    return [name for name in compared(dataset) if name != PLANAR]


def _planar(dataset: xr.Dataset) -> str:
    """Return the largest difference of planar contact in words; nothing where it was not solved."""
    if PLANAR not in compared(dataset):
        return ""
    own = worst_of(dataset, PLANAR)
    share = float(difference(dataset, PLANAR).sel(shift=own["shift"], side=own.side))
    return f"; planar contact is off by up to {number_text(100 * share, '+.2g')} % ({_where(own)})"


def _merged(parts: list[str]) -> list[str]:
    """Return the limits and shifts; from the first limit that holds at all shifts on, no more."""
    complete = [k for k, part in enumerate(parts) if part.endswith("at all shifts")]
    return parts[: complete[0] + 1] if complete else parts


def shifts_within(dataset: xr.Dataset, ics: str, limit: float, quantity: Quantity = P_MAX) -> str:
    """Return at which shifts both contacts agree with the reference to a limit, in words."""
    worst = abs(difference(dataset, ics, quantity)).max("side")
    known = np.isfinite(worst.values)
    good = known & (worst.values <= limit)
    if np.all(good[known]):
        return "at all shifts"
    return f"at {ranges(dataset['shift'].values[known], good[known])}" if good.any() else "at no shift"


def ranges(shifts: np.ndarray, good: np.ndarray) -> str:
    """Return the ranges of neighbouring shifts where something holds, in words."""
    starts = np.flatnonzero(good & ~np.append(False, good[:-1]))
    ends = np.flatnonzero(good & ~np.append(good[1:], False))
    parts = [
        f"{shifts[a]:g} mm" if a == b else f"{shifts[a]:g} to {shifts[b]:g} mm"
        for a, b in zip(starts, ends, strict=True)
    ]
    return join_words(parts)


def worst_of(dataset: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> xr.Dataset:
    """Return the contact in which some ICs differ most from the best."""
    at = abs(difference(dataset, ics, quantity)).fillna(-1).argmax(["shift", "side"])
    return dataset.isel(at)


def _worst_case(dataset: xr.Dataset) -> str:
    names = _ics(dataset)
    if not names:
        peak = reference_values(dataset, "p_max").fillna(-1).argmax(["shift", "side"])
        own = dataset.isel(peak)
        return f"The largest pressure is {float(own.p_max.max()):.0f} MPa, at {_where(own)}."
    own = worst_of(dataset, names[0])
    best, share = (
        best_of(dataset, own),
        float(difference(dataset, names[0]).sel(shift=own["shift"], side=own.side)),
    )
    return (
        f"The worst is {_where(own)}, where the rail's inclination changes by "
        f"{float(own['angle'].sel(ics=best)):.0f} degrees across the patch: "
        f"{float(own.p_max.sel(ics=names[0])):.0f} MPa instead of {float(own.p_max.sel(ics=best)):.0f} MPa "
        f"({number_text(100 * share, '+.1f')} %)."
    )


def best_of(dataset: xr.Dataset, own: xr.Dataset, quantity: str = "p_max") -> str:
    """Return the best ICs of a contact."""
    return str(reference_names(dataset, quantity).sel(shift=own["shift"], side=own.side).item())


def _creep_forces(dataset: xr.Dataset) -> str:
    names = _ics(dataset)
    if not names or not np.isfinite(difference(dataset, names[0], F_X)).any():
        peak = abs(reference_values(dataset, "F_x")).fillna(-1).argmax(["shift", "side"])
        own = dataset.isel(peak)
        return f"The largest F_x is {np.nanmax(np.abs(own.F_x)) / 1000:.1f} kN, at {_where(own)}."
    force = max((F_X, F_Y), key=lambda each: float(abs(difference(dataset, names[0], each)).max()))
    own, other = worst_of(dataset, names[0], force), worst_of(dataset, names[0], WORK)
    share = abs(float(difference(dataset, names[0], force).sel(shift=own["shift"], side=own.side)))
    of_work = abs(float(difference(dataset, names[0], WORK).sel(shift=other["shift"], side=other.side)))
    return (
        f"Creep forces differ by {100 * share:.2g} % of friction times load at most ({_where(own)}: "
        f"{force.symbol} {_pair(dataset, own, names[0], force)}), the work of friction by "
        f"{100 * of_work:.2g} % ({_where(other)}: {_pair(dataset, other, names[0], WORK)})."
    )


def _pair(dataset: xr.Dataset, own: xr.Dataset, ics: str, quantity: Quantity) -> str:
    """Return a quantity of a contact with some ICs and with the best ones in words."""
    best = best_of(dataset, own, quantity.name)
    one, other = (quantity.per_unit * float(own[quantity.name].sel(ics=name)) for name in (ics, best))
    return f"{one:{quantity.form}} instead of {other:{quantity.form}} {quantity.unit}"


def _where(own: xr.Dataset) -> str:
    return f"{float(own['shift']):g} mm, {own.side.item()} wheel"


def _geometry_sentence(dataset: xr.Dataset) -> str:
    conicity, refused = dataset.attrs["conicity"], whole_shifts_refused(dataset)
    parts = []
    if np.isfinite(conicity):
        parts.append(f"the equivalent conicity at {dataset.attrs['amplitude']:g} mm is {conicity:.3f}")
    else:
        parts.append(f"there is no equivalent conicity at {dataset.attrs['amplitude']:g} mm")
    if refused:
        parts.append(f"at {', '.join(refused)} mm the wheelset cannot stand")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def whole_shifts_refused(dataset: xr.Dataset) -> list[str]:
    """Return the shifts [mm] at which no position was found."""
    return [place for place in json.loads(dataset.attrs["refused"]) if "," not in place]


def answer_table(dataset: xr.Dataset) -> Table:
    """Return for each ICs and quantity at which shifts they are good to 1, 5 and 10 %, and the worst."""
    quantities, rows = compared_quantities(dataset), []
    for name in compared(dataset):
        for quantity in quantities:
            if np.isfinite(difference(dataset, name, quantity)).any():
                label = f"{symbol_of(name)}: {quantity.label}" if len(quantities) > 1 else symbol_of(name)
                rows.append(Row(label, _answer(dataset, name, quantity)))
    heads = texts(*(f"within {100 * limit:.0f} %" for limit in LIMITS))
    unit = "MPa" if len(quantities) == 1 else ""
    columns = [*heads, Column("p_max" if unit else "value", unit), Column("reference", unit)]
    caption = "p_max by" if unit else "with"
    return Table(caption, [*columns, Column("differs at most by", "%")], rows)


def _answer(dataset: xr.Dataset, name: str, quantity: Quantity) -> list[Cell | str]:
    """Return the cells of some ICs and a quantity."""
    own = worst_of(dataset, name, quantity)
    best = best_of(dataset, own, quantity.name)
    share = float(difference(dataset, name, quantity).sel(shift=own["shift"], side=own.side))
    within = [shifts_within(dataset, name, limit, quantity).removeprefix("at ") for limit in LIMITS]
    values = [
        Cell(quantity.per_unit * float(own[quantity.name].sel(ics=each)), quantity.form)
        for each in (name, best)
    ]
    worst = f"{float(own['shift']):g} mm, {own.side.item()}"
    worst += "; of friction × load" if quantity.of_friction else ""
    return [*within, *values, Cell(100 * share, "+.2f", worst)]
