"""The tables of all contacts and all shifts."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.tables import Cell, Column, Row, Table, numbers, texts
from compare.shifts.answers import best_of
from compare.shifts.differences import compared, difference, reference_names
from compare.shifts.values import value_text, values_of

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
        shares = [
            Cell(100 * float(difference(dataset, n).sel(shift=own["shift"], side=own.side)), "+.2f")
            for n in compared(dataset)
        ]
        rows.append(Row(label, [*cells, *shares]))
    heads = [Column(f"p_max, {symbol_of(name)}", "MPa") for name in names]
    further = [Column(f"{symbol_of(name)} differs", "%") for name in compared(dataset)]
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
        best = str(reference_names(dataset, "F_x").sel(shift=own["shift"], side=own.side).item())
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
        best = str(reference_names(dataset, "F_x").sel(shift=own["shift"], side=own.side).item())
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
        for key, entry in values_of(dataset).items()
    ]
    return Table("key", texts("value", "origin", "meaning"), rows)
