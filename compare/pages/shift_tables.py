"""The answer of `femic shifts`: at which shifts which ICs are good enough; and the tables of all contacts."""

import json
from collections.abc import Iterator

import numpy as np
import xarray as xr

from compare.pages.shift_figures import (
    F_X,
    F_Y,
    LIMITS,
    P_MAX,
    WORK,
    Quantity,
    compared_ics,
    compared_quantities,
    difference,
    rank_ics,
    reference_label,
    reference_names,
    reference_values,
)
from compare.report.looks import symbol_of
from compare.report.parts import join_words
from compare.report.tables import Cell, Column, Row, Table, number_text, numbers, texts
from femic.contact.pairs.planar import PLANAR
from femic.results.wheelset import value_text

# --- sentences ------------------------------------------------------------------------------------------


def summary(dataset: xr.Dataset) -> str:
    """Return where half-space ICs are good enough, the worst contact, and the geometry: three sentences.

    Of a wheelset that rolls, the second one is of the creep forces.
    """
    second = _creep_forces(dataset) if "F_x" in dataset else _worst_case(dataset)
    return " ".join([_good_enough(dataset), second, _geometry_sentence(dataset)])


def _good_enough(dataset: xr.Dataset) -> str:
    names, planar = _ics(dataset), _planar(dataset)
    if not names:
        name = symbol_of(rank_ics(dataset)[0])
        return f"Only one kind of ICs, {name}, was used, so nothing is said about half-space ICs{planar}."
    name = names[0]
    parts = [f"within {100 * limit:.0f} % {shifts_within(dataset, name, limit)}" for limit in LIMITS]
    unique = _merge(parts)
    best = reference_label(dataset)
    return f"Half-space ICs ({symbol_of(name)}) give p_max as {best} does {join_words(unique)}{planar}."


def _ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs on the curved surface that are compared with better ones."""
    return [name for name in compared_ics(dataset) if name != PLANAR]


def _planar(dataset: xr.Dataset) -> str:
    """Return the largest difference of planar contact in words; nothing where it was not solved."""
    if PLANAR not in compared_ics(dataset):
        return ""
    own = worst_of(dataset, PLANAR)
    share = _difference_at(dataset, own, PLANAR)
    return f"; planar contact is off by up to {number_text(100 * share, '+.2g')} % ({_where(own)})"


def _merge(parts: list[str]) -> list[str]:
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
    best, share = best_of(dataset, own), _difference_at(dataset, own, names[0])
    return (
        f"The worst is {_where(own)}, where the rail's inclination changes by "
        f"{float(own['angle'].sel(ics=best)):.0f} degrees across the patch: "
        f"{float(own.p_max.sel(ics=names[0])):.0f} MPa instead of {float(own.p_max.sel(ics=best)):.0f} MPa "
        f"({number_text(100 * share, '+.1f')} %)."
    )


def _difference_at(dataset: xr.Dataset, own: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> float:
    """Return a quantity of a contact with some ICs less that with the best, as a share."""
    return float(difference(dataset, ics, quantity).sel(shift=own["shift"], side=own.side))


def best_of(dataset: xr.Dataset, own: xr.Dataset, quantity: str = "p_max") -> str:
    """Return the best ICs of a contact, empty where there are none."""
    return str(reference_names(dataset, quantity).sel(shift=own["shift"], side=own.side).item())


def _creep_forces(dataset: xr.Dataset) -> str:
    names = _ics(dataset)
    if not names or not np.isfinite(difference(dataset, names[0], F_X)).any():
        peak = abs(reference_values(dataset, "F_x")).fillna(-1).argmax(["shift", "side"])
        own = dataset.isel(peak)
        return f"The largest F_x is {np.nanmax(np.abs(own.F_x)) / 1000:.1f} kN, at {_where(own)}."
    force = max((F_X, F_Y), key=lambda each: float(abs(difference(dataset, names[0], each)).max()))
    own, other = worst_of(dataset, names[0], force), worst_of(dataset, names[0], WORK)
    share = abs(_difference_at(dataset, own, names[0], force))
    of_work = abs(_difference_at(dataset, other, names[0], WORK))
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


# --- the table of the answer ----------------------------------------------------------------------------


def answer_table(dataset: xr.Dataset) -> Table:
    """Return for each ICs and quantity at which shifts they are good to 1, 5 and 10 %, and the worst."""
    quantities, rows = compared_quantities(dataset), []
    for name in compared_ics(dataset):
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
    share = _difference_at(dataset, own, name, quantity)
    within = [shifts_within(dataset, name, limit, quantity).removeprefix("at ") for limit in LIMITS]
    values = [
        Cell(quantity.per_unit * float(own[quantity.name].sel(ics=each)), quantity.form)
        for each in (name, best)
    ]
    worst = f"{float(own['shift']):g} mm, {own.side.item()}"
    worst += "; of friction × load" if quantity.of_friction else ""
    return [*within, *values, Cell(100 * share, "+.2f", worst)]


# --- all contacts and all shifts ------------------------------------------------------------------------


FORCES = (  # name, unit, format, and how many units there are in one of the dataset
    ("xi", "1e-3", ".2f", 1e3),
    ("F_x", "kN", ".2f", 1e-3),
    ("F_y", "kN", ".2f", 1e-3),
    ("M_z", "N m", ".1f", 1e-3),
    ("work", "J/m", ".1f", 1.0),
    ("sliding", "%", ".0f", 100.0),
    ("utilised", "%", ".0f", 100.0),
    ("p_max_rolling", "MPa", ".0f", 1.0),
)
AXLE = (
    ("xi_0", "1e-3", ".3f", 1e3),
    ("sum_F_y", "kN", ".2f", 1e-3),
    ("steering", "kN m", ".2f", 1e-6),
    ("axle_torque", "N m", ".2f", 1e-3),
)
OF_AREA = (
    ("angle", "deg", ".1f", 1.0),
    ("centre", "mm", "+.2f", 1.0),
    ("F_n", "kN", ".2f", 1e-3),
    ("p_max", "MPa", ".0f", 1.0),
    ("area", "mm²", ".1f", 1.0),
    ("F_x", "kN", ".2f", 1e-3),
    ("F_s", "kN", ".2f", 1e-3),
    ("slip_x", "1e-3", ".2f", 1e3),
    ("slip_s", "1e-3", ".2f", 1e3),
    ("spin", "1/m", ".3f", 1e3),
    ("work", "J/m", ".1f", 1.0),
)
AREA_TITLES = (
    "contact angle",
    "centre on the rail",
    "force along the normal",
    "p_max",
    "area",
    "F_x",
    "F_s, along the profile",
    "rigid slip along x",
    "rigid slip along the profile",
    "spin",
    "work",
)
TITLES = {
    "xi": "ξ",
    "work": "work",
    "p_max_rolling": "p_max",
    "xi_0": "ξ_0",
    "sum_F_y": "sum of F_y",
    "steering": "steering moment",
    "axle_torque": "torque",
}


def _rows(dataset: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield all contacts with their names."""
    for shift in dataset["shift"].values:
        for side in dataset.side.values:
            own = dataset.sel(shift=shift, side=side)
            if np.isfinite(own.p_max.values).any():
                yield f"{shift:g} mm, {side}", own


def pressure_table(dataset: xr.Dataset) -> Table:
    """Return p_max of all contacts by ICs, with estimates and differences to the best."""
    names = [str(name) for name in dataset.ics.values]
    rows = []
    for label, own in _rows(dataset):
        cells = [Cell(float(own.p_max.sel(ics=n)), ".1f", _estimate(own, n)) for n in names]
        shares = [Cell(100 * _difference_at(dataset, own, n), "+.2f") for n in compared_ics(dataset)]
        rows.append(Row(label, [*cells, *shares]))
    heads = [Column(f"p_max, {symbol_of(name)}", "MPa") for name in names]
    further = [Column(f"{symbol_of(name)} differs", "%") for name in compared_ics(dataset)]
    return Table("shift, wheel", [*heads, *further], rows)


def _estimate(own: xr.Dataset, ics: str) -> str:
    estimate = float(own.estimate_p_max.sel(ics=ics))
    return "" if np.isnan(estimate) else f"± {estimate:.2g}"


def patch_table(dataset: xr.Dataset) -> Table:
    """Return the patches of all contacts with the best ICs, and the forces."""
    rows = []
    for label, own in _rows(dataset):
        best = own.sel(ics=best_of(dataset, own))
        rows.append(
            Row(
                label,
                [
                    Cell(float(best["angle"]), ".1f"),
                    Cell(float(best.a), ".2f"),
                    Cell(float(best.b), ".2f"),
                    Cell(1000 * float(best.approach), ".1f"),
                    Cell(
                        float(best.patches),
                        ".0f",
                        f"{100 * float(best.beside):.1f} %" if best.patches > 1 else "",
                    ),
                    Cell(float(best.vertical) / 1000, ".2f"),
                    Cell(float(best.lateral) / 1000, ".2f"),
                ],
            )
        )
    columns = [
        Column("Δδ", "deg"),
        Column("a", "mm"),
        Column("b", "mm"),
        Column("approach", "um"),
        Column("patches"),
        Column("vertical", "kN"),
        Column("lateral", "kN"),
    ]
    return Table("shift, wheel", columns, rows)


def each_patch_table(dataset: xr.Dataset, *, several: bool) -> Table | None:
    """Return what each patch carries with the best ICs, of contacts of several patches or of all contacts.

    None where there are no such contacts.
    """
    rows = []
    for label, own in _rows(dataset):
        best = own.sel(ics=best_of(dataset, own))
        count = int(best.patches)
        if several and count < 2:
            continue
        rows += [_patch_row(label if k == 0 else "", best.isel(patch=k), k) for k in range(count)]
    columns = [
        Column("patch"),
        Column("contact angle", "deg"),
        Column("force along its normal", "kN"),
        Column("of the vertical load", "%"),
        Column("p_max", "MPa"),
        Column("centre on the rail", "mm"),
        Column("half-length", "mm"),
        Column("width", "mm"),
        Column("area", "mm²"),
    ]
    return Table("shift, wheel", columns, rows) if rows else None


def _patch_row(label: str, patch: xr.Dataset, number: int) -> Row:
    """Return the cells of a patch."""
    return Row(
        label,
        [
            Cell(number + 1, ".0f"),
            Cell(float(patch.patch_angle), ".1f"),
            Cell(float(patch.patch_normal_force) / 1000, ".2f"),
            Cell(100 * float(patch.patch_share), ".1f"),
            Cell(float(patch.patch_p_max), ".0f"),
            Cell(float(patch.patch_centre), "+.2f"),
            Cell(float(patch.patch_half_length), ".2f"),
            Cell(float(patch.patch_end - patch.patch_start), ".2f"),
            Cell(float(patch.patch_area), ".1f"),
        ],
    )


def rolling_patch_table(dataset: xr.Dataset) -> Table:
    """Return forces, slip and work of the areas that roll, with the best ICs."""
    rows = []
    for label, own in _rows(dataset):
        best = best_of(dataset, own, "F_x")
        if not best:
            continue
        with_best = own.sel(ics=best)
        for k in range(dataset.sizes["area"]):
            area = with_best.isel(area=k)
            if not np.isfinite(area.area_F_n):
                continue
            cells = [
                Cell(per_unit * float(area[f"area_{name}"]), form) for name, _, form, per_unit in OF_AREA
            ]
            rows.append(Row(label if k == 0 else "", [symbol_of(best) if k == 0 else "", *cells]))
    columns = [Column(title, unit) for (_, unit, _, _), title in zip(OF_AREA, AREA_TITLES, strict=True)]
    return Table("shift, wheel", [*texts("ICs"), *columns], rows)


def geometry_table(dataset: xr.Dataset) -> Table:
    """Return contact angles, rolling radii and roll at all shifts."""
    rows = []
    for shift in dataset["shift"].values:
        own = dataset.sel(shift=shift)
        if np.isnan(own["roll"]):
            continue
        angles = [Cell(float(own.contact_angle.sel(side=side)), ".2f") for side in dataset.side.values]
        radii = [Cell(float(own.radius.sel(side=side)), ".3f") for side in dataset.side.values]
        rows.append(
            Row(
                f"{shift:g} mm",
                [*angles, *radii, Cell(float(own.rrd), ".3f"), Cell(float(own["roll"]), ".3f")],
            )
        )
    heads = [
        *numbers("angle left", "angle right", unit="deg"),
        *numbers("radius left", "radius right", unit="mm"),
    ]
    return Table("shift", [*heads, Column("difference", "mm"), Column("roll", "mrad")], rows)


def grid_table(dataset: xr.Dataset) -> Table:
    """Return the grids of all contacts, and the time of their solutions."""
    rows = [
        Row(label, [str(own.grid.item()), Cell(float(own.seconds.sum()), ".1f")])
        for label, own in _rows(dataset)
    ]
    return Table("shift, wheel", [*texts("grid"), Column("time", "s")], rows)


def force_table(dataset: xr.Dataset) -> Table:
    """Return the creep forces of all contacts with the best ICs, with their estimated errors."""
    rows = []
    for label, own in _rows(dataset):
        best = best_of(dataset, own, "F_x")
        if not best:
            continue
        with_best = own.sel(ics=best)
        cells = [
            Cell(per_unit * float(with_best[name]), form, _error(with_best, name, per_unit, form))
            for name, _, form, per_unit in FORCES
        ]
        rows.append(Row(label, [symbol_of(best), *cells]))
    columns = [Column(TITLES.get(name, name), unit) for name, unit, _, _ in FORCES]
    return Table("shift, wheel", [*texts("ICs"), *columns], rows)


def _error(own: xr.Dataset, name: str, per_unit: float, form: str) -> str:
    error = per_unit * float(own[f"estimate_{name}"])
    return "" if np.isnan(error) else f"± {error:{form}}"


def wheelset_table(dataset: xr.Dataset) -> Table:
    """Return the numbers of the axle at all shifts with all ICs."""
    rows = []
    for shift in dataset["shift"].values:
        for k, name in enumerate(dataset.ics.values):
            own = dataset.sel(shift=shift, ics=name)
            if np.isfinite(own.xi_0):
                cells = [
                    Cell(per_unit * float(own[key]), form, _error(own, key, per_unit, form))
                    for key, _, form, per_unit in AXLE
                ]
                rows.append(Row(f"{shift:g} mm" if k == 0 else "", [symbol_of(str(name)), *cells]))
    columns = [Column(TITLES[key], unit) for key, unit, _, _ in AXLE]
    return Table("shift", [*texts("ICs"), *columns], rows)


def values_table(dataset: xr.Dataset) -> Table:
    """Return all values of a computation with their origins."""
    rows = [
        Row(key, [value_text(entry["value"]), entry["origin"], entry["meaning"]])
        for key, entry in json.loads(dataset.attrs["values"]).items()
    ]
    return Table("key", texts("value", "origin", "meaning"), rows)
