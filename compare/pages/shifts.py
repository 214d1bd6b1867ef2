"""File and report of `femic shifts`: at which shifts half-space ICs are good enough."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.shift_figures import forces, geometry, places, pressures, reference_values, rolling
from compare.pages.shift_tables import (
    answer_table,
    best_ics,
    each_patch_table,
    geometry_table,
    grid_table,
    patch_table,
    pressure_table,
    rolling_table,
    values_table,
    wheelset_table,
)
from compare.report.looks import ics_symbol
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Cell
from femic.contact.finite_strain import finite_strain_shares

ELASTIC = (
    "Pressures are those of elastic contacts without friction; there is no plastic flow. Each wheel "
    "carries the same vertical load; the lateral forces follow from the contact, whatever a vehicle needs."
)
READING = (
    "C is the reference where it was computed (contact.c_above_deg), else B̂, which is itself an "
    "approximation. C is of bodies with flanks of 60 degrees beside the contact; its estimate has the change "
    "by nearer supports in it. Planar contact has the elements of each patch in one plane, of the mean "
    "inclination where the profiles overlap, and ICs A; patches do not act on each other. Where both sides "
    "are alike, the right contact at a shift is the left one at the opposite shift. Distances are those of "
    "the displaced profiles. Bands: estimated errors of p_max by the size of the elements, which all ICs of "
    "a contact share, and by the last decimals of the profiles' files."
)
PATCHES = (
    "With the best ICs of each contact, from the gauge side to the field side. The contact angle is to the "
    "track plane, positive on a flange; the force along the normal of a steep patch is much larger than its "
    "vertical part. The centre is an arc length from the rail's top, positive to the field side."
)
AREAS = (
    "Patches near each other share a grid and stand in one row. Creepages of a patch are the rigid slip and "
    "the spin, the turning about its normal per rolled distance, in its centre of pressure. F_s and the slip "
    "along the profile are positive to the field side."
)
FORCES = (
    "With the best ICs of each contact. M_z is about the vertical of the touching point, positive where it "
    "turns the front of the wheel outwards; utilised is the tangential force over the sum of friction times "
    "pressures; p_max is that with friction."
)
ROLLING = (
    "Steady rolling, coefficient of friction {friction:g}{factor}. Creepage at the nominal radius: "
    "{longitudinal} (free: no torque acts on the axle); lateral velocity of the wheelset: {lateral:g} V to "
    "the left; yaw rate: {spin:g} V per mm to the left. F_x is positive in the rolling direction, F_y "
    "towards the middle of the track, with the part of the inclined pressures. Differences of forces are "
    "shares of friction times load, {unit:.3g} kN, those of the work of friction (T-gamma, per rolled "
    "distance) shares of itself. Bands: estimated errors by the size of elements, which all ICs of a contact "
    "share."
)
AXLE = (
    "The creepage is that at the nominal radius; the steering moment is that of the longitudinal forces, "
    "positive where it turns the wheelset to the right, which is back to the middle for a shift to the left. "
    "The torque about the axle takes each traction on its own circle: over the rolling radius it differs "
    "from F_x by up to {:.0f} N."
)
CONICITY = "Equivalent conicity {} (EN 15302). {} Touching points jump at [mm]: {}."
CONVENTION = (
    "Shifts are those of the wheelset at the rails, to the left; the roll follows from both wheels touching. "
    "Touching points and rolling radii are those of the undeformed profiles."
)
PLACES = (
    "Sections seen along the track, the left rail at the left; orange: patches with the best ICs, and "
    "the touching point of the undeformed profiles. Below: outlines of the patches, on the unrolled "
    "rail; arc lengths are positive to the field side, which is at the left of the left rail."
)


def write_shifts(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `shifts.nc`, the figures and `shifts.html`; returns the path of the page."""
    title = f"Wheelset at lateral shifts: {dataset.attrs['title']}"
    page = Page(title, summary(dataset), _sections(dataset), answer_table(dataset))
    return write_results(page, folder, "shifts", dataset)


def summary(dataset: xr.Dataset) -> str:
    """Return the largest pressure with the best ICs and where it is, and the equivalent conicity."""
    at = reference_values(dataset, "p_max").fillna(-1).argmax(["shift", "side"])
    own, conicity = dataset.isel(at), Cell(float(dataset.attrs["conicity"]), ".3f")
    best = best_ics(dataset, own)
    contact = own.sel(ics=best)
    return (
        f"The largest pressure is {float(contact.p_max):.0f} MPa with {ics_symbol(best)}, at "
        f"{float(own['shift']):g} mm, {own.side.item()} wheel, where the rail's inclination changes by "
        f"{float(contact['angle']):.0f} degrees across the patch. The equivalent conicity at "
        f"{dataset.attrs['amplitude']:g} mm is {conicity.text}."
    )


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    rolls = "F_x" in dataset
    if doubts := json.loads(dataset.attrs["doubts"]):
        yield Section("", [Items(doubts)])
    yield Section("", [pressures(dataset), Note(f"{_load_note(dataset)} {READING} {ELASTIC}")])
    if unusual := json.loads(dataset.attrs["unusual"]):
        yield Section("Unusual contacts", [Items([f"{at} mm: {note}" for at, note in unusual.items()])])
    if (several := each_patch_table(dataset, several=True)) is not None:
        yield Section("What each patch carries", [several, Note(PATCHES)])
    if rolls:
        pairs = json.loads(dataset.attrs["by_angle"])
        factors = ", ".join(f"{factor:g} at {angle:g} degrees" for angle, factor in pairs)
        unit = dataset.attrs["friction"] * dataset.attrs["load"] / 1000
        factor = f" times a factor by the contact angle, {factors}" if pairs else ""
        note = ROLLING.format(**dataset.attrs, factor=factor, unit=unit)
        yield Section("Creep forces", [forces(dataset), Note(note)])
    yield Section("Where they touch", [places(dataset), Note(PLACES)])
    if rolls:
        torque = float(np.nanmax(np.abs(dataset.resistance)))
        yield Section("The axle", [rolling(dataset), Note(AXLE.format(torque))])
    yield Section("Angles and radii", [geometry(dataset), Note(CONVENTION)])
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
        yield Folded("All contacts: creep forces", [rolling_table(dataset), Note(FORCES)])
        yield Folded("All contacts: patches that roll", [rolling_table(dataset, by_area=True), Note(AREAS)])
        yield Folded("All shifts: axle", [wheelset_table(dataset)])
    conicity = Cell(float(dataset.attrs["conicity"]), ".4f").text
    jumps = ", ".join(f"{jump:g}" for jump in np.atleast_1d(dataset.attrs["jumps"])) or "–"
    note = CONICITY.format(conicity, dataset.attrs["conicity_reason"], jumps)
    yield Folded("All shifts: geometry", [geometry_table(dataset), Note(note)])
    yield Folded("How the profiles were understood", [Items(json.loads(dataset.attrs["notes"]))])
    yield Folded("All values, given and assumed", [values_table(dataset)])
    time = (
        "Patches far from each other have a grid each; the share of the load beside the main patch stands "
        f"below their number. The whole run took {dataset.attrs['seconds']:.0f} s; stored contacts count "
        "nothing."
    )
    yield Folded("Grids", [grid_table(dataset), Note(time)])
    yield Folded("Specification", [Verbatim(dataset.attrs["specification"])])


def _load_note(dataset: xr.Dataset) -> str:
    largest = float(dataset.p_max.max())
    strain = largest * finite_strain_shares(largest, float(dataset.attrs["E"]))[0]
    return (
        f"Vertical load {dataset.attrs['load'] / 1000:g} kN on each wheel. Strains are taken as small: "
        f"finite ones may change p_max by {strain:.0f} MPa where it is largest."
    )
