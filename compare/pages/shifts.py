"""File and report of `femic shifts`: at which shifts half-space ICs are good enough, and all contacts."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages import shift_figures as figures
from compare.pages.shift_figures import LIMITS, OF_ROLLING, P_MAX, Quantity, compared_ics, difference
from compare.report.looks import ics_symbol
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Column, Row, Table, numbers, texts
from femic.contact.finite_strain import finite_strain_shares
from femic.results.wheelset import value_text

# --- the page -------------------------------------------------------------------------------------------


ELASTIC = (
    "The contacts are elastic and frictionless; plastic flow is not included. Both wheels carry the same "
    "vertical load. The lateral forces result from the contact; they are not the forces that a vehicle "
    "needs."
)
READING = (
    "C is the reference where it was computed (contact.c_above_deg). Elsewhere B̂ is the reference, and "
    "B̂ itself is an approximation. For C the bodies have flanks of 60 degrees beside the contact; its "
    "estimated error includes the effect of nearer supports. Planar contact puts the elements of each "
    "patch in one plane with the mean inclination where the profiles overlap, and uses ICs A; patches do "
    "not displace each other. If both sides have the same profiles, the right contact at one shift is the "
    "left contact at the opposite shift. Distances are those of the displaced profiles. Bands: estimated "
    "error of p_max from the size of the elements, which all ICs of a contact share, and from the "
    "rounding of the points in the profile files."
)
PATCHES = (
    "Values with the best ICs of each contact, patches ordered from the gauge side to the field side. The "
    "contact angle is measured from the track plane and is positive on a flange. On a steep patch the "
    "force along the normal is much larger than its vertical part. The centre is given as arc length from "
    "the top of the rail, positive to the field side."
)
AREAS = (
    "Patches that are close together share a grid and a row. The creepages of a patch are the rigid slip "
    "and the spin at its centre of pressure; spin is the rotation about the normal per rolled distance. "
    "F_s and the slip along the profile are positive to the field side."
)
CREEP_FORCES = (
    "Values with the best ICs of each contact. M_z is the moment about the vertical through the contact "
    "point, positive if it turns the front of the wheel outwards. Utilised friction is the tangential "
    "force divided by the sum of friction coefficient times pressure. p_max includes the effect of "
    "friction."
)
ROLLING = (
    "Steady rolling, coefficient of friction {friction:g}{factor}. Creepage at the nominal radius: "
    "{longitudinal} (free: no torque acts on the axle); lateral velocity of the wheelset: {lateral:g} V "
    "to the left; yaw rate: {spin:g} V per mm to the left. F_x is positive in the rolling direction. F_y "
    "is positive towards the middle of the track and includes the lateral part of the pressures. "
    "Differences of forces are given relative to friction times load, {unit:.3g} kN; differences of the "
    "work of friction (T-gamma, per rolled distance) are relative to the reference work. Bands: estimated "
    "error from the size of the elements, which all ICs of a contact share."
)
OF_AXLE = (
    "The creepage refers to the nominal radius. The steering moment comes from the longitudinal forces. "
    "It is positive if it turns the wheelset to the right; after a shift to the left this steers the "
    "wheelset back to the middle. The torque about the axle uses the radius at which each traction acts. "
    "Divided by the rolling radius, it differs from F_x by up to {:.0f} N."
)
CONICITY = "Equivalent conicity {} (EN 15302). {} The contact points jump at these shifts [mm]: {}."
CONVENTION = (
    "A shift is the movement of the wheelset to the left at rail level. The roll follows because both "
    "wheels touch their rails. Contact points and rolling radii refer to the undeformed profiles."
)
PLACES = (
    "Sections seen along the track, with the left rail on the left. Orange: patches with the best ICs, "
    "and the contact point of the undeformed profiles. Below: outlines of the patches on the unrolled "
    "rail. Arc lengths are positive to the field side, which lies to the left of the left rail."
)


def write_shifts(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `shifts.nc`, the figures and `shifts.html`; returns the path of the page."""
    title = f"Wheelset at lateral shifts: {dataset.attrs['title']}"
    page = Page(title, summary(dataset), _sections(dataset), answer_table(dataset))
    return write_results(page, folder, "shifts", dataset)


def summary(dataset: xr.Dataset) -> str:
    """Return the largest pressure with the best ICs and where it is, and the equivalent conicity."""
    at = figures.reference_values(dataset, "p_max").fillna(-1).argmax(["shift", "side"])
    own, conicity = dataset.isel(at), Cell(float(dataset.attrs["conicity"]), ".3f")
    best = best_ics(dataset, own)
    contact = own.sel(ics=best)
    return (
        f"The largest pressure is {float(contact.p_max):.0f} MPa with {ics_symbol(best)}, at a shift of "
        f"{float(own['shift']):g} mm on the {own.side.item()} wheel. The inclination of the rail changes "
        f"by {float(contact['angle']):.0f} degrees across that patch. The equivalent conicity at an "
        f"amplitude of {dataset.attrs['amplitude']:g} mm is {conicity.text}."
    )


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    rolls = "F_x" in dataset
    if doubts := json.loads(dataset.attrs["doubts"]):
        yield Section("", [Items(doubts)])
    yield Section("", [figures.pressures(dataset), Note(f"{_load_note(dataset)} {READING} {ELASTIC}")])
    if unusual := json.loads(dataset.attrs["unusual"]):
        yield Section("Unusual contacts", [Items([f"{at} mm: {note}" for at, note in unusual.items()])])
    if (several := each_patch_table(dataset, several=True)) is not None:
        yield Section("Load of each patch", [several, Note(PATCHES)])
    if rolls:
        pairs = json.loads(dataset.attrs["by_angle"])
        factors = ", ".join(f"{factor:g} at {angle:g} degrees" for angle, factor in pairs)
        unit = dataset.attrs["friction"] * dataset.attrs["load"] / 1000
        factor = f" times a factor that depends on the contact angle: {factors}" if pairs else ""
        note = ROLLING.format(**dataset.attrs, factor=factor, unit=unit)
        yield Section("Creep forces", [figures.forces(dataset), Note(note)])
    yield Section("Where they touch", [figures.places(dataset), Note(PLACES)])
    if rolls:
        torque = float(np.nanmax(np.abs(dataset.resistance)))
        yield Section("The axle", [figures.rolling(dataset), Note(OF_AXLE.format(torque))])
    yield Section("Angles and radii", [figures.geometry(dataset), Note(CONVENTION)])
    left_out = [f"{place} mm: {reason}" for place, reason in json.loads(dataset.attrs["refused"]).items()]
    not_rolling = json.loads(dataset.attrs.get("not_rolling", "{}"))
    left_out += [f"{place}: {reason}" for place, reason in not_rolling.items()]
    if left_out:
        yield Folded("Not solved", [Items(left_out)])
    yield Folded("All contacts: pressures", [pressure_table(dataset), Note(ELASTIC)])
    yield Folded("All contacts: patches and forces", [patch_table(dataset)])
    if (patches := each_patch_table(dataset, several=False)) is not None:
        yield Folded("All contacts: each patch", [patches, Note(PATCHES)])
    if rolls:
        yield Folded("All contacts: creep forces", [rolling_table(dataset), Note(CREEP_FORCES)])
        yield Folded(
            "All contacts: creep forces of each patch", [rolling_table(dataset, by_area=True), Note(AREAS)]
        )
        yield Folded("All shifts: axle", [wheelset_table(dataset)])
    conicity = Cell(float(dataset.attrs["conicity"]), ".4f").text
    jumps = ", ".join(f"{jump:g}" for jump in np.atleast_1d(dataset.attrs["jumps"])) or "–"
    note = CONICITY.format(conicity, dataset.attrs["conicity_reason"], jumps)
    yield Folded("All shifts: geometry", [geometry_table(dataset), Note(note)])
    yield Folded("How the profiles were read", [Items(json.loads(dataset.attrs["notes"]))])
    yield Folded("All values, given and assumed", [values_table(dataset)])
    time = (
        "Patches that are far apart have separate grids. Below the number of patches stands the fraction "
        f"of the load that the other patches carry. The whole run took {dataset.attrs['seconds']:.0f} s, "
        "not counting stored contacts."
    )
    yield Folded("Grids", [grid_table(dataset), Note(time)])
    yield Folded("Specification", [Verbatim(dataset.attrs["specification"])])


def _load_note(dataset: xr.Dataset) -> str:
    largest = float(dataset.p_max.max())
    strain = largest * finite_strain_shares(largest, float(dataset.attrs["E"]))[0]
    return (
        f"Vertical load {dataset.attrs['load'] / 1000:g} kN on each wheel. Strains are assumed small: "
        f"finite strains may change the largest p_max by {strain:.0f} MPa."
    )


# --- the answer -----------------------------------------------------------------------------------------


def answer_table(dataset: xr.Dataset) -> Table:
    """Return for each ICs and quantity at which shifts they are good to 1, 5 and 10 %, and the worst."""
    quantities, rows = (P_MAX, *OF_ROLLING) if "F_x" in dataset else (P_MAX,), []
    for name in compared_ics(dataset):
        for quantity in quantities:
            off = difference(dataset, name, quantity)
            if not np.isfinite(off).any():
                continue
            label = f"{ics_symbol(name)}: {quantity.label}" if len(quantities) > 1 else ics_symbol(name)
            within = [shifts_within(dataset, name, limit, quantity) for limit in LIMITS]
            own = dataset.isel(abs(off).fillna(-1).argmax(["shift", "side"]))
            values = [
                Cell(quantity.per_unit * float(own[quantity.name].sel(ics=each)), quantity.form)
                for each in (name, best_ics(dataset, own, quantity.name))
            ]
            share = 100 * float(off.sel(shift=own["shift"], side=own.side))
            worst = f"{float(own['shift']):g} mm, {own.side.item()}"
            worst += "; of friction × load" if quantity.is_friction_share else ""
            rows.append(Row(label, [*within, *values, Cell(share, "+.2f", worst)]))
    heads = texts(*(f"within {100 * limit:.0f} %" for limit in LIMITS))
    unit = "MPa" if len(quantities) == 1 else ""
    columns = [*heads, Column("p_max" if unit else "value", unit), Column("reference", unit)]
    caption = "p_max by" if unit else "with"
    return Table(caption, [*columns, Column("largest difference", "%")], rows)


def shifts_within(dataset: xr.Dataset, ics: str, limit: float, quantity: Quantity = P_MAX) -> str:
    """Return the ranges of neighbouring shifts at which both contacts agree with the reference to a limit."""
    worst = abs(difference(dataset, ics, quantity)).max("side").dropna("shift")
    shifts, good = worst["shift"].values, worst.values <= limit
    if np.all(good):
        return "all shifts"
    starts = np.flatnonzero(good & ~np.append(False, good[:-1]))
    ends = np.flatnonzero(good & ~np.append(good[1:], False))
    parts = [
        f"{shifts[a]:g} mm" if a == b else f"{shifts[a]:g} to {shifts[b]:g} mm"
        for a, b in zip(starts, ends, strict=True)
    ]
    return join_words(parts) or "no shift"


def best_ics(dataset: xr.Dataset, own: xr.Dataset, quantity: str = "p_max") -> str:
    """Return the best ICs of a contact, empty where there are none."""
    return str(figures.reference_names(dataset, quantity).sel(shift=own["shift"], side=own.side).item())


# --- all contacts and all shifts ------------------------------------------------------------------------


Shown = tuple[str, str, str, str, float]  # name, head, unit, format, how many units are in one of the dataset
PATCH: tuple[Shown, ...] = (
    ("angle", "Δδ", "deg", ".1f", 1.0),
    ("a", "a", "mm", ".2f", 1.0),
    ("b", "b", "mm", ".2f", 1.0),
    ("approach", "approach", "um", ".1f", 1e3),
    ("patches", "patches", "", ".0f", 1.0),
    ("vertical", "vertical", "kN", ".2f", 1e-3),
    ("lateral", "lateral", "kN", ".2f", 1e-3),
)
EACH_PATCH: tuple[Shown, ...] = (
    ("patch_angle", "contact angle", "deg", ".1f", 1.0),
    ("patch_normal_force", "force along its normal", "kN", ".2f", 1e-3),
    ("patch_share", "of the vertical load", "%", ".1f", 100.0),
    ("patch_p_max", "p_max", "MPa", ".0f", 1.0),
    ("patch_centre", "centre on the rail", "mm", "+.2f", 1.0),
    ("patch_half_length", "half-length", "mm", ".2f", 1.0),
    ("patch_width", "width", "mm", ".2f", 1.0),
    ("patch_area", "area", "mm²", ".1f", 1.0),
)
FORCES: tuple[Shown, ...] = (
    ("xi", "ξ", "1e-3", ".2f", 1e3),
    ("F_x", "F_x", "kN", ".2f", 1e-3),
    ("F_y", "F_y", "kN", ".2f", 1e-3),
    ("M_z", "M_z", "N m", ".1f", 1e-3),
    ("work", "work", "J/m", ".1f", 1.0),
    ("sliding", "sliding", "%", ".0f", 100.0),
    ("utilised", "utilised", "%", ".0f", 100.0),
    ("p_max_rolling", "p_max", "MPa", ".0f", 1.0),
)
AXLE: tuple[Shown, ...] = (
    ("xi_0", "ξ_0", "1e-3", ".3f", 1e3),
    ("sum_F_y", "sum of F_y", "kN", ".2f", 1e-3),
    ("steering", "steering moment", "kN m", ".2f", 1e-6),
    ("axle_torque", "torque", "N m", ".2f", 1e-3),
)
AREA: tuple[Shown, ...] = (
    ("area_angle", "contact angle", "deg", ".1f", 1.0),
    ("area_centre", "centre on the rail", "mm", "+.2f", 1.0),
    ("area_F_n", "force along the normal", "kN", ".2f", 1e-3),
    ("area_p_max", "p_max", "MPa", ".0f", 1.0),
    ("area_area", "area", "mm²", ".1f", 1.0),
    ("area_F_x", "F_x", "kN", ".2f", 1e-3),
    ("area_F_s", "F_s, along the profile", "kN", ".2f", 1e-3),
    ("area_slip_x", "rigid slip along x", "1e-3", ".2f", 1e3),
    ("area_slip_s", "rigid slip along the profile", "1e-3", ".2f", 1e3),
    ("area_spin", "spin", "1/m", ".3f", 1e3),
    ("area_work", "work", "J/m", ".1f", 1.0),
)
CONTACT = "shift, wheel"


def _columns(shown: Sequence[Shown]) -> list[Column]:
    return [Column(head, unit) for _, head, unit, _, _ in shown]


def _cells(own: xr.Dataset, shown: Sequence[Shown], *, estimates: bool = False) -> list[Cell | str]:
    """Return numbers, with `estimates` their estimated errors below them."""
    cells: list[Cell | str] = []
    for name, _, _, form, per_unit in shown:
        error = per_unit * float(own[f"estimate_{name}"]) if estimates else np.nan
        below = "" if np.isnan(error) else f"± {error:{form}}"
        cells.append(Cell(per_unit * float(own[name]), form, below))
    return cells


def _contacts(dataset: xr.Dataset, quantity: str = "") -> Iterator[tuple[str, xr.Dataset]]:
    """Yield all contacts with their names; of a quantity with their best ICs, where there are any."""
    for shift in dataset["shift"].values:
        for side in dataset.side.values:
            own, label = dataset.sel(shift=shift, side=side), f"{shift:g} mm, {side}"
            if not quantity:
                if np.isfinite(own.p_max.values).any():
                    yield label, own
            elif best := best_ics(dataset, own, quantity):
                yield label, own.sel(ics=best)


def pressure_table(dataset: xr.Dataset) -> Table:
    """Return p_max of all contacts by ICs, with estimates and differences to the best."""
    names, compared, rows = [str(name) for name in dataset.ics.values], compared_ics(dataset), []
    off = {name: 100 * difference(dataset, name) for name in compared}
    for label, own in _contacts(dataset):
        estimates = {name: float(own.estimate_p_max.sel(ics=name)) for name in names}
        below = {name: "" if np.isnan(one) else f"± {one:.2g}" for name, one in estimates.items()}
        cells = [Cell(float(own.p_max.sel(ics=name)), ".1f", below[name]) for name in names]
        shares = [Cell(float(each.sel(shift=own["shift"], side=own.side)), "+.2f") for each in off.values()]
        rows.append(Row(label, [*cells, *shares]))
    heads = [Column(f"p_max, {ics_symbol(name)}", "MPa") for name in names]
    further = [Column(f"{ics_symbol(name)} differs", "%") for name in compared]
    return Table(CONTACT, [*heads, *further], rows)


def patch_table(dataset: xr.Dataset) -> Table:
    """Return the patches of all contacts with the best ICs, and the forces."""
    rows = []
    for label, best in _contacts(dataset, "p_max"):
        cells = _cells(best, PATCH)
        beside = f"{100 * float(best.beside):.1f} %" if best.patches > 1 else ""
        cells[4] = Cell(float(best.patches), ".0f", beside)
        rows.append(Row(label, cells))
    return Table(CONTACT, _columns(PATCH), rows)


def each_patch_table(dataset: xr.Dataset, *, several: bool) -> Table | None:
    """Return what each patch carries with the best ICs, of contacts of several patches or of all contacts.

    None where there are no such contacts.
    """
    rows = []
    with_widths = dataset.assign(patch_width=dataset.patch_end - dataset.patch_start)
    for label, best in _contacts(with_widths, "p_max"):
        count = int(best.patches)
        if count > several:
            rows += [
                Row("" if k else label, [Cell(k + 1, ".0f"), *_cells(best.isel(patch=k), EACH_PATCH)])
                for k in range(count)
            ]
    return Table(CONTACT, [Column("patch"), *_columns(EACH_PATCH)], rows) if rows else None


def rolling_table(dataset: xr.Dataset, *, by_area: bool = False) -> Table:
    """Return forces, slip and work of all contacts that roll, with the best ICs and estimated errors.

    By area: those of each area that rolls, without errors.
    """
    shown, rows = AREA if by_area else FORCES, []
    for label, best in _contacts(dataset, "F_x"):
        parts = [best.isel(area=k) for k in np.flatnonzero(np.isfinite(best.area_F_n))] if by_area else [best]
        for k, part in enumerate(parts):
            ics = "" if k else ics_symbol(best.ics.item())
            cells = _cells(part, shown, estimates=not by_area)
            rows.append(Row("" if k else label, [ics, *cells]))
    return Table(CONTACT, [*texts("ICs"), *_columns(shown)], rows)


def wheelset_table(dataset: xr.Dataset) -> Table:
    """Return the numbers of the axle at all shifts with all ICs."""
    rows = []
    for shift in dataset["shift"].values:
        for k, name in enumerate(dataset.ics.values):
            own = dataset.sel(shift=shift, ics=name)
            if np.isfinite(own.xi_0):
                cells = [ics_symbol(str(name)), *_cells(own, AXLE, estimates=True)]
                rows.append(Row("" if k else f"{shift:g} mm", cells))
    return Table("shift", [*texts("ICs"), *_columns(AXLE)], rows)


def geometry_table(dataset: xr.Dataset) -> Table:
    """Return contact angles, rolling radii and roll at all shifts."""
    standing = dataset.isel(shift=dataset["roll"].notnull().values)
    rows = []
    for shift in standing["shift"].values:
        own = standing.sel(shift=shift)
        angles = [Cell(float(angle), ".2f") for angle in own.contact_angle]
        lengths = [Cell(float(length), ".3f") for length in (*own.radius, own.rrd, own["roll"])]
        rows.append(Row(f"{shift:g} mm", [*angles, *lengths]))
    heads = [
        *numbers("angle left", "angle right", unit="deg"),
        *numbers("radius left", "radius right", "difference", unit="mm"),
        Column("roll", "mrad"),
    ]
    return Table("shift", heads, rows)


def grid_table(dataset: xr.Dataset) -> Table:
    """Return the grids of all contacts, and the time of their solutions."""
    rows = [
        Row(label, [str(own.grid.item()), Cell(float(own.seconds.sum()), ".1f")])
        for label, own in _contacts(dataset)
    ]
    return Table(CONTACT, [*texts("grid"), Column("time", "s")], rows)


def values_table(dataset: xr.Dataset) -> Table:
    """Return all values of a computation with their origins."""
    rows = [
        Row(key, [value_text(entry["value"]), entry["origin"], entry["meaning"]])
        for key, entry in json.loads(dataset.attrs["values"]).items()
    ]
    return Table("key", texts("value", "origin", "meaning"), rows)
