"""File and report of `femic shifts`: at which shifts half-space ICs are good enough, and all contacts."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from compare.pages import shift_figures as figures
from compare.pages.shift_figures import (
    F_X,
    F_Y,
    LIMITS,
    OF_ROLLING,
    P_MAX,
    Quantity,
    compared_ics,
    decisions,
    difference,
    difference_estimate,
    shift_text,
)
from compare.report.looks import ics_symbol
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Column, Row, Table, number_text, numbers, texts, with_estimate
from compare.report.verdicts import NO, NOT_DECIDED, YES
from femic.contact.finite_strain import finite_strain_shares
from femic.contact.pairs.planar import PLANAR
from femic.results.wheelset import value_text
from femic.shifts.sides import SIDES

# --- the page -------------------------------------------------------------------------------------------


ELASTIC = (
    "Both wheels carry a vertical load of {load:g} kN. All contacts are elastic, without plastic flow. These "
    "pressures are without friction{friction}. Strains are assumed small; finite strains may change the "
    "largest p_max by {strain:.0f} MPa."
)
WITH_FRICTION = " (those with friction: “Creep forces” below)"
REFERENCE = (
    "ICs: A is the half-space, B̂ an approximation for curved surfaces, C the reference by finite elements. "
    "Differences are relative to C where it was computed (contact.c_above_deg), else to B̂, else to the last "
    "ICs of contact.ics."
)
BARS = (
    "Bars are estimated errors from the size of the elements and from rounded points of the profile files. "
    "The estimated error of a difference is smaller: all ICs of a contact use the same elements and the same "
    "points of the profiles, and these errors nearly cancel; the error of C is included whole. Level dotted "
    "lines are limits of 1 and 5 %. The answer is yes or no only where the difference is further from the "
    "limit than its estimated error."
)
ZONES = (
    "Upright dotted lines: there the patch nearest to the flange reaches another part of the wheel, "
    "somewhere between the two solved shifts beside the line. The flange root begins where the profile of "
    f"the wheel is steeper than {figures.ROOT_ANGLE:g} degrees, the flange where it is within "
    f"{figures.FACE:g} degrees of its steepest place."
)
FURTHER = "Circles are the largest pressures of the other patches of a contact."
WITH_PLANAR = (
    "Planar contact puts each patch into one plane, with the mean inclination where the profiles overlap, "
    "and uses A. Its patches do not displace each other. It has elements of its own, so for its differences "
    "the estimated errors of both contacts are added."
)
WITH_C = (
    "With C both contours go on in straight flanks of 60 degrees beside the contact, up to a clamped edge. "
    "Its estimated error includes the effect of an edge at half the distance."
)
ALIKE = "Both sides have the same profiles: each right contact is the left one at the opposite shift."
PATCHES = (
    "Values with the best ICs of each contact: C, else B̂. Patches are ordered from the gauge side to the "
    "field side. The contact angle is measured from the track plane and is positive on a flange. The centre "
    "is the arc length from the top of the rail, positive to the field side."
)
CREEP_FORCES = (
    "Values with the best ICs of each contact. F_x is positive in the rolling direction. F_y is positive "
    "towards the middle of the track and includes the lateral part of the pressures. M_z is the moment about "
    "the vertical through the contact point, positive if it turns the front of the wheel outwards. Work is "
    "the work of friction per rolled distance; forces times creepages (T-gamma) leave out that slip varies "
    "over a curved patch. Utilised friction is the tangential force divided by the sum of friction "
    "coefficient times pressure; with spin, tractions point in several directions, and a patch that slides "
    "everywhere utilises less than 100 %. p_max includes the effect of friction. Patches that are close "
    "together share a grid and a row. The creepages of a patch are the rigid slip, wheel minus rail and thus "
    "of the other sign than ξ, and the spin at its centre of pressure. F_s and the slip along the profile "
    "are positive to the field side."
)
ROLLING = (
    "Steady rolling with a coefficient of friction of {friction:g}{factor}. The creepage at the nominal "
    "radius is {longitudinal} (free: no torque acts on the axle). {moved} Differences of forces are "
    "relative to friction times load, {unit:.3g} kN, those of the work to the work with the reference."
)
STRAIGHT = "The wheelset neither moves along its axle nor yaws."
MOVED = (
    "The wheelset moves to the left at {lateral:g} times the speed V and yaws to the left by {spin:g} rad "
    "per mm of track."
)
OF_AXLE = (
    "The creepage refers to the nominal radius. The steering moment comes from the longitudinal forces. It "
    "is positive if it turns the wheelset to the right; after a shift to the left this steers the wheelset "
    "back to the middle. The torque of a wheel uses the radius at which each traction acts; divided by the "
    "rolling radius it differs from F_x by up to {:.0f} N. The lateral forces follow from the given shift; "
    "the vehicle is not in equilibrium with them."
)
CONVENTION = (
    "A shift is the movement of the wheelset to the left at rail level. The roll follows because both wheels "
    "touch their rails. Contact points and rolling radii refer to the undeformed profiles. The equivalent "
    "conicity follows EN 15302. "
)
PLACES = (
    "Sections seen along the track, with the left rail on the left. Orange: patches with the best ICs, and "
    "the contact point of the undeformed profiles. Below: outlines of the patches on the unrolled rail."
)


def write_shifts(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `shifts.nc`, the figures and `shifts.html`; returns the path of the page."""
    title = f"Wheelset at lateral shifts: {dataset.attrs['title']}"
    known = figures.with_differences(dataset)
    page = Page(title, summary(known), _sections(known), answer_table(known), doubts(known))
    return write_results(page, folder, "shifts", dataset)


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    rolls, several = "F_x" in dataset, bool((dataset.patches > 1).any())
    largest = float(dataset.p_max.max())
    strain = largest * finite_strain_shares(largest, float(dataset.attrs["E"]))[0]
    has_flange = any(figures.flange_limits(dataset, side) for side in SIDES)
    chart = [BARS, FURTHER if several else "", ZONES if has_flange else ""]
    assumed = [
        ELASTIC.format(
            load=dataset.attrs["load"] / 1000, friction=WITH_FRICTION if rolls else "", strain=strain
        ),
        ALIKE if dataset.attrs["alike"] else "",
        REFERENCE if compared_ics(dataset) else "",
        WITH_PLANAR if PLANAR in dataset.ics else "",
        WITH_C if "C" in dataset.ics else "",
    ]
    notes = [Note(" ".join(filter(None, sentences))) for sentences in (chart, assumed)]
    yield Section("", [figures.pressures(dataset), *notes])
    yield Section("Where they touch", [figures.places(dataset), Note(PLACES)])
    yield Folded("p_max and patch of each contact", [pressure_table(dataset), patch_table(dataset)])
    yield Folded("Load of each patch", [each_patch_table(dataset), Note(PATCHES)])
    if rolls:
        pairs = json.loads(dataset.attrs["by_angle"])
        factors = ", ".join(f"{factor:g} at {angle:g} degrees" for angle, factor in pairs)
        factor = f" times a factor that depends on the contact angle: {factors}" if pairs else ""
        unit = dataset.attrs["friction"] * dataset.attrs["load"] / 1000
        moved = (STRAIGHT if not dataset.attrs["lateral"] and not dataset.attrs["spin"] else MOVED).format(
            **dataset.attrs
        )
        note = ROLLING.format(**dataset.attrs, factor=factor, moved=moved, unit=unit)
        tables = rolling_table(dataset), rolling_table(dataset, by_area=True)
        yield Folded("Creep forces", [figures.forces(dataset), Note(note), *tables, Note(CREEP_FORCES)])
        note = OF_AXLE.format(float(np.nanmax(np.abs(dataset.resistance))))
        yield Folded("The axle", [figures.rolling(dataset), wheelset_table(dataset), Note(note)])
    jumps = join_words(f"{jump:g}" for jump in np.atleast_1d(dataset.attrs["jumps"]))
    note = CONVENTION + (f"The contact points jump at shifts of {jumps} mm." if jumps else "")
    heading = "Contact angles, rolling radii and conicity"
    yield Folded(heading, [figures.geometry(dataset), geometry_table(dataset), Note(note)])
    yield Folded("How the profiles were read", [Items(json.loads(dataset.attrs["notes"]))])
    yield Folded("All values, given and assumed", [values_table(dataset)])
    time = (
        "Patches that are far apart have separate grids. The whole run took "
        f"{dataset.attrs['seconds']:.0f} s, not counting stored contacts."
    )
    yield Folded("Grids and times", [grid_table(dataset), Note(time)])
    yield Folded("Specification", [Verbatim(dataset.attrs["specification"])])


# --- doubts ---------------------------------------------------------------------------------------------


NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


def doubts(dataset: xr.Dataset) -> list[str]:
    """Return what may be wrong: assumed values, the reference, missing and unusual contacts."""
    refused, idle, unusual = (
        json.loads(dataset.attrs.get(name, "{}")) for name in ("refused", "not_rolling", "unusual")
    )
    missing, most = (
        int(dataset.p_max.isnull().all("ics").sum()),
        dataset.sizes["shift"] * dataset.sizes["side"],
    )
    references = [str(name) for name in np.unique(figures.reference_names(dataset, "p_max")) if name]
    approximate = (
        "C was not computed (contact.c_above_deg). The reference is "
        f"{join_words(map(ics_symbol, references))}, an approximation."
    )
    gaps = f"The curves have gaps. Contacts without a solution: {missing} of {most}."
    return [
        *json.loads(dataset.attrs["doubts"]),
        *([] if "C" in references else [approximate]),
        *([gaps] if missing else []),
        *_by_text("Not solved at ", refused),
        *_by_text("Not solved with friction at ", idle),
        *_by_text("At ", unusual),
    ]


def _by_text(before: str, texts: Mapping[str, str]) -> Iterator[str]:
    """Yield a sentence per text; texts that differ by numbers alone are said once, with all their places."""
    places: dict[str, list[str]] = {}
    for place, text in texts.items():
        shift, *side = place.removesuffix(", rolling").split(", ")
        label = f"{number_text(float(shift), 'g')} mm{f' ({side[0]} wheel)' if side else ''}"
        places.setdefault(NUMBER.sub("", text), []).append(label)
        if len(places[NUMBER.sub("", text)]) == 1:
            places[NUMBER.sub("", text)].append(text)
    for first, text, *others in places.values():
        end = text if text.endswith(".") else f"{text}."
        yield f"{before}{first}: {end}" + (f" The same holds at {join_words(others)}." if others else "")


# --- the summary ----------------------------------------------------------------------------------------


LIMIT = 0.05  # of the verdict in the summary
WHERE = {
    figures.TREAD: "on the tread",
    figures.ROOT: "in the flange root",
    figures.FLANGE: "on the flange",
}
VERDICTS = {  # by what was decided at some shifts
    (YES,): "With {ics}, p_max is within {limit} of {reference} at {yes}.",
    (NO,): "With {ics}, p_max differs from {reference} by more than {limit} at {no}.",
    (YES, NO): "With {ics}, p_max is within {limit} of {reference} at {yes}, but not at {no}.",
    (NOT_DECIDED,): "With {ics}, it is not decided whether p_max is within {limit} of {reference}.",
    (YES, NOT_DECIDED): (
        "With {ics}, p_max is within {limit} of {reference} at {yes}; at {open} this is not decided."
    ),
    (NO, NOT_DECIDED): (
        "With {ics}, p_max differs from {reference} by more than {limit} at {no}; at {open} this is not "
        "decided."
    ),
    (YES, NO, NOT_DECIDED): (
        "With {ics}, p_max is within {limit} of {reference} at {yes}, but not at {no}; at {open} this is not "
        "decided."
    ),
}
NO_CONICITY = (
    "The equivalent conicity at an amplitude of {} cannot be given: {}. Give a smaller conicity_amplitude, "
    "or check the profiles and the radii of both sides."
)
FIRST_OF_REASON = re.compile(r"^(equivalent conicity|amplitude = [^:]*): ")


def summary(dataset: xr.Dataset) -> str:
    """Return the largest pressure and where it is, which ICs are good enough for it, and the conicity."""
    at = figures.reference_values(dataset, "p_max").fillna(-1).argmax(["shift", "side"])
    own = dataset.isel(at)
    name = best_ics(dataset, own)
    best, side = own.sel(ics=name), str(own.side.item())
    zones = figures.patch_zones(dataset, float(own["shift"]), side)
    where = WHERE[zones[int(np.nanargmax(best.patch_p_max.values))]]
    sentences = [
        f"The largest pressure is {with_estimate(best.p_max, best.estimate_p_max)} MPa (± is the "
        f"estimated error) with {ics_symbol(name)}, at {_place(own)}, {where}."
    ]
    groups: dict[tuple[str, ...], list[str]] = {}
    for ics in compared_ics(dataset):
        groups.setdefault(tuple(decisions(dataset, ics, LIMIT).values), []).append(ics)
    sentences += [_verdict(dataset, names, decided) for decided, names in groups.items()]
    if groups:
        sentences.append(f"Largest difference of p_max: {_largest_difference(dataset, (P_MAX,))}.")
    else:
        sentences.append("No other ICs were used, so nothing was compared.")
    if "F_x" in dataset and any(
        np.isfinite(difference(dataset, ics, F_X)).any() for ics in compared_ics(dataset)
    ):
        sentences.append(f"Largest difference of creep forces: {_largest_difference(dataset, (F_X, F_Y))}.")
    amplitude, value = f"{dataset.attrs['amplitude']:g} mm", float(dataset.attrs["conicity"])
    if np.isfinite(value):
        sentences.append(f"The equivalent conicity at an amplitude of {amplitude} is {value:.3f}.")
    else:
        reason = FIRST_OF_REASON.sub("", dataset.attrs["conicity_reason"])
        sentences.append(NO_CONICITY.format(amplitude, reason.removesuffix(".")))
    return " ".join(sentences)


def _place(own: xr.Dataset) -> str:
    return f"{shift_text(own['shift'])} on the {own.side.item()} wheel"


def _ics_text(name: str) -> str:
    return "planar contact" if name == PLANAR else ics_symbol(name)


def _verdict(dataset: xr.Dataset, names: Sequence[str], decided: Sequence[str]) -> str:
    """Return at which shifts p_max with some ICs, decided alike, is within the limit."""
    shifts = dataset["shift"].values
    found = {word: shift_ranges(shifts, [one == word for one in decided]) for word in (YES, NO, NOT_DECIDED)}
    text = VERDICTS[tuple(word for word in found if word in decided)].format(
        ics=join_words(map(_ics_text, names)),
        limit=f"{100 * LIMIT:g} %",
        reference=figures.reference_label(dataset, ics=names[0]),
        yes=found[YES],
        no=found[NO],
        open=found[NOT_DECIDED],
    )
    if not any(_is_reference(dataset, name) for name in names):
        return text
    itself = "is the reference itself" if len(names) == 1 else "are the references themselves"
    return f"{text.removesuffix('.')}; elsewhere {join_words(map(_ics_text, names))} {itself}."


def _is_reference(dataset: xr.Dataset, ics: str, quantity: str = "p_max") -> bool:
    """Return whether others are compared with some ICs at some shifts."""
    return bool((figures.reference_names(dataset, quantity) == ics).any())


# --- the answer -----------------------------------------------------------------------------------------


MOST_RANGES = 3  # in a text
PERCENT_SHARE = "% of friction × load"


def answer_table(dataset: xr.Dataset) -> Table:
    """Return for each ICs and quantity at which shifts they are good to 1, 5 and 10 %, and the worst.

    Where nothing was compared, the largest pressures by the part of the wheel.
    """
    quantities, rows = (P_MAX, *OF_ROLLING) if "F_x" in dataset else (P_MAX,), []
    for name in compared_ics(dataset):
        for quantity in quantities:
            if not np.isfinite(difference(dataset, name, quantity)).any():
                continue
            reference = figures.reference_label(dataset, quantity.name, ics=name)
            where = f", against {reference}" if _is_reference(dataset, name, quantity.name) else ""
            label = f"{ics_symbol(name)}{where}{f': {quantity.symbol}' * (len(quantities) > 1)}"
            within = [decision_cell(dataset, name, limit, quantity) for limit in LIMITS]
            own, text = worst_difference(dataset, name, quantity)
            unit = PERCENT_SHARE if quantity.is_friction_share else "%"
            rows.append(Row(label, [*within, Cell(f"{text} {unit}", below=_place(own))]))
    if not rows:
        return _largest_pressures(dataset)
    heads = texts(*(f"within {100 * limit:.0f} %" for limit in LIMITS), "largest difference")
    return Table("p_max with" if len(quantities) == 1 else "ICs: number", heads, rows)


def decision_cell(dataset: xr.Dataset, ics: str, limit: float, quantity: Quantity = P_MAX) -> Cell:
    """Return at which shifts ICs are within a limit, at which they are not, and what is open."""
    decided = decisions(dataset, ics, limit, quantity).values
    parts = [
        f"{word}: {shift_ranges(dataset['shift'].values, decided == word)}"
        for word in (YES, NOT_DECIDED, NO)
        if word in decided
    ]
    return Cell(parts[0], below="; ".join(parts[1:]))


def shift_ranges(shifts: ArrayLike, chosen: ArrayLike) -> str:
    """Return the ranges of neighbouring shifts that are chosen; of many ranges how many shifts there are."""
    at, good = np.asarray(shifts, dtype=float), np.asarray(chosen, dtype=bool)
    if np.all(good):
        return "all shifts"
    starts = np.flatnonzero(good & ~np.append(False, good[:-1]))
    ends = np.flatnonzero(good & ~np.append(good[1:], False))
    if len(starts) > MOST_RANGES:
        return f"{np.count_nonzero(good)} of {len(at)} shifts"
    first, last = ([number_text(at[k], "g") for k in edges] for edges in (starts, ends))
    return join_words(f"{a} mm" if a == b else f"{a} to {b} mm" for a, b in zip(first, last, strict=True))


def worst_difference(dataset: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> tuple[xr.Dataset, str]:
    """Return the contact with the largest difference of ICs from the best, and it with its estimate [%]."""
    off = 100 * difference(dataset, ics, quantity)
    at = abs(off).fillna(-1).argmax(["shift", "side"])
    estimate = 100 * difference_estimate(dataset, ics, quantity).isel(at)
    return dataset.isel(at), with_estimate(off.isel(at), estimate, signed=True)


def _largest_difference(dataset: xr.Dataset, quantities: Sequence[Quantity]) -> str:
    """Return the largest difference of several quantities and all ICs, with its estimate and its place."""
    pairs = [(ics, quantity) for ics in compared_ics(dataset) for quantity in quantities]
    known = [pair for pair in pairs if np.isfinite(difference(dataset, *pair)).any()]
    ics, quantity = max(known, key=lambda pair: float(abs(difference(dataset, *pair)).max()))
    own, text = worst_difference(dataset, ics, quantity)
    unit = PERCENT_SHARE if quantity.is_friction_share else "%"
    symbol = f"{quantity.symbol} " if len(quantities) > 1 else ""
    return f"{text} {unit}, {symbol}with {_ics_text(ics)} at {_place(own)}"


def _largest_pressures(dataset: xr.Dataset) -> Table:
    """Return the largest pressure on each part of the wheel, by the patch nearest to the flange."""
    best = figures.reference_values(dataset, "p_max")
    zones = xr.DataArray(
        [figures.zones(dataset, str(side)) for side in dataset.side.values], dims=("side", "shift")
    ).transpose("shift", "side")
    rows = []
    for zone, where in WHERE.items():
        own = best.where(zones == zone)
        if own.notnull().any():
            at = dataset.isel(own.fillna(-1).argmax(["shift", "side"]))
            contact = at.sel(ics=best_ics(dataset, at))
            text = with_estimate(contact.p_max, contact.estimate_p_max)
            rows.append(Row(where, [Cell(text, below=_place(at))]))
    return Table("largest pressure", [Column("p_max", "MPa")], rows)


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
    ("patch_angle", "angle of the patch", "deg", ".1f", 1.0),
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
    ("area_angle", "mean angle", "deg", ".1f", 1.0),
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
            own, label = dataset.sel(shift=shift, side=side), f"{shift_text(shift)}, {side}"
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
    return Table(f"{CONTACT}; small: share of the load outside the main patch", _columns(PATCH), rows)


def each_patch_table(dataset: xr.Dataset) -> Table:
    """Return what each patch of all contacts carries with the best ICs."""
    rows = []
    with_widths = dataset.assign(patch_width=dataset.patch_end - dataset.patch_start)
    for label, best in _contacts(with_widths, "p_max"):
        shift, side = float(best["shift"]), str(best.side.item())
        rows += [
            Row("" if k else label, [Cell(k + 1, ".0f"), zone, *_cells(best.isel(patch=k), EACH_PATCH)])
            for k, zone in enumerate(figures.patch_zones(dataset, shift, side))
        ]
    return Table(CONTACT, [Column("patch"), *texts("on the wheel"), *_columns(EACH_PATCH)], rows)


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
                rows.append(Row("" if k else shift_text(shift), cells))
    return Table("shift", [*texts("ICs"), *_columns(AXLE)], rows)


def geometry_table(dataset: xr.Dataset) -> Table:
    """Return contact angles, rolling radii and roll at all shifts."""
    standing = dataset.isel(shift=dataset["roll"].notnull().values)
    rows = []
    for shift in standing["shift"].values:
        own = standing.sel(shift=shift)
        angles = [Cell(float(angle), ".2f") for angle in own.contact_angle]
        lengths = [Cell(float(length), ".3f") for length in (*own.radius, own.rrd, own["roll"])]
        rows.append(Row(shift_text(shift), [*angles, *lengths]))
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
