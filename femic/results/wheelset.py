"""`femic shifts`: a wheelset over its lateral shifts as one labelled dataset, `shifts.nc`.

Each value of the computation is given by its specification, assumed, or taken from a profile. Finished
contacts and rolling wheelsets are stored: an interrupted run goes on with the next one.
"""

import json
import re
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import xarray as xr

from femic.cache.digests import results_digest, versions
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results import wheelset_contacts as geometry
from femic.results.wheelset_contacts import (
    ABOUT,
    Part,
    Study,
    compute_parts,
    contacts,
    is_mirrored,
    join_contacts,
    rail_top,
)
from femic.scenes.scene_table import SceneTable
from femic.shifts.contact import read_grids
from femic.shifts.position import GRID, RollingSide, roll
from femic.shifts.sides import (
    SIDES,
    Place,
    bodies_at,
    contact_problem,
    doubts,
    lay_out_wheelset,
    prepare_sections,
    understood,
)
from femic.shifts.specification import C, ProfileTable, RollingTable, ShiftsFile
from geometries.errors import Failure, WrongInput
from geometries.profiles.text import read_source
from geometries.track.layout import Layout, SideName
from geometries.track.wheelset import Position, settle

# --- all shifts -----------------------------------------------------------------------------------------


SECOND = 0.5  # mm: touching points with a distance below this are stated


def compute_shifts(specification: ShiftsFile, text: str = "", options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return positions and contacts at all shifts of a specification; raises WrongInput before any contact.

    Shifts at which the wheelset cannot stand, and contacts that are not found, are NaN, with the reasons in
    the attribute `refused`; `values` has all values that were used, given or assumed.
    """
    start = perf_counter()
    require_track(specification)
    sections = prepare_sections(specification)
    layout = lay_out_wheelset(specification, sections)
    used = values_used(specification, layout)
    doubtful = [*filter(None, [assumed_text(used)]), *canted_rails(specification), *doubts(sections)]
    for doubt in doubtful:
        options.watch.on_stage(doubt)
    study = Study(specification, layout, options)
    positions, refused = _positions(layout, specification)
    for shift, reason in refused.items():
        options.watch.on_stage(f"shift {shift} mm was skipped: {reason}")
    solved = dict(contacts(study, positions, refused))
    if not solved:
        raise Failure(f"shifts: no contact was found: {next(iter(refused.values()))}")
    parts = [
        geometry.wheelset(specification, positions),
        geometry.touching(layout, specification, positions),
        join_contacts(study, solved),
        geometry.sections(layout),
        geometry.conicity(layout, specification, options.watch, alike=study.alike),
    ]
    if specification.rolling is not None:
        parts.append(join_rolling(study, dict(rolling_wheelsets(study, positions, solved))))
    dataset = xr.merge(parts, compat="no_conflicts", join="outer", combine_attrs="no_conflicts")
    unusual = {f"{shift:g}": "; ".join(at.notes) for shift, at in positions.items() if at.notes} | {
        f"{shift:g}, {side}": entry.attrs["notes"]
        for (shift, side), entry in solved.items()
        if entry.attrs["notes"]
    }
    return dataset.assign_attrs(
        title=specification.title or f"{sections[2].name} on {sections[0].name}",
        load=specification.contact.load,
        alike=int(study.alike),
        refused=json.dumps(refused),
        notes=json.dumps(understood(sections, layout)),
        doubts=json.dumps(doubtful),
        values=json.dumps(used),
        unusual=json.dumps(unusual),
        E=min(table.E for table in (*specification.rails, *specification.wheels)),
        specification=text,
        seconds=perf_counter() - start,
        code=results_digest(),
        versions=json.dumps(versions()),
    )


def _positions(layout: Layout, specification: ShiftsFile) -> tuple[dict[float, Position], dict[str, str]]:
    """Return the positions at shifts [mm] at which the wheelset stands, and the reasons for the others."""
    positions, refused = {}, {}
    for shift in specification.shifts:
        try:
            given = specification.roll_at(shift)
            positions[shift] = settle(layout, shift, roll=ABOUT if given is None else given, within=SECOND)
        except Failure as failure:
            refused[f"{shift:g}"] = str(failure)
    if not positions:
        raise Failure(f"shifts: none of the shifts is possible: {next(iter(refused.values()))}")
    return positions, refused


# --- the values of the computation ----------------------------------------------------------------------


GIVEN, ASSUMED, OF_PROFILE = "given", "assumed", "from the profile"  # origins of a value
NEEDED = (  # of rails that are files: what decides where a wheel stands on its rail
    ("track", "gauge"),
    ("track", "rail_inclination"),
    ("wheelset", "flange_back_distance"),
    ("wheelset", "nominal_radius"),
)
TABLES = ("rail", "right_rail", "wheel", "right_wheel", "track", "wheelset", "contact", "rolling")
OF_FILES = ("axes", "unit", "surface", "section", "section_at", "tolerance")
UNIT = re.compile(r"\[([^\]\s]+)\]")
FIRST = re.compile(r"[;:] ")  # ends the first part of the description of a key
CANTED = re.compile(r"\b(cant|canted|inclined)\b", re.IGNORECASE)
ABSENT = {  # what holds where there is no value
    "rolls": "follow: both wheels touch",
    "right_rail": "as the left one",
    "right_wheel": "as the left one",
    "contact.c_above_deg": "none: C is not used",
    "rolling": "none: the contacts are frictionless",
    "rolling.by_angle": "constant over the contact angle",
}


def require_track(specification: ShiftsFile) -> None:
    """Raise WrongInput where a rail is a file and the specification leaves out where it lies.

    Rails of the package lie as in their standard; what is assumed of a wheel is said (`assumed_text`).
    """
    profiles = specification.profiles.items()
    rail_files = [name for name, table in profiles if "rail" in name and not table.is_standard]
    missing = [
        f"{table}.{key} = {value_text(getattr(getattr(specification, table), key))}"
        for table, key in NEEDED
        if key not in getattr(specification, table).model_fields_set
    ]
    if rail_files and missing:
        raise WrongInput(
            f"{rail_files[0]}.profile is a file, and the specification does not describe the track: give "
            f"{', '.join(missing)}, or the actual values (rail_inclination = 0 if the points of the rail are "
            "already inclined)"
        )


def canted_rails(specification: ShiftsFile) -> tuple[str, ...]:
    """Return a sentence for each rail that its file calls canted and that the track inclines once more."""
    slope = specification.track.rail_inclination
    if slope == 0:
        return ()
    sentences = []
    for name, table in specification.profiles.items():
        if "rail" not in name or table.is_standard:
            continue
        lines = read_source(Path(table.profile)).lines
        if said := next((line for line in lines if CANTED.search(line)), None):
            quoted = " ".join(said.split()).lstrip("#; ").replace('"', "'")
            sentences.append(
                f"The file {Path(table.profile).name} (key {name}) says “{quoted}”, but "
                f"track.rail_inclination = {slope:g} inclines its points once more. Give 0 if they are "
                "inclined already."
            )
    return tuple(sentences)


def values_used(specification: ShiftsFile, layout: Layout) -> dict[str, dict[str, Any]]:
    """Return value, origin and meaning of each key; of profiles of the package none of files."""
    used = dict(_table_values("", specification))
    for name in TABLES:
        if isinstance(table := getattr(specification, name), SceneTable):
            used |= _table_values(f"{name}.", table)
    half = specification.wheelset.flange_back_distance / 2
    for name, side in (("wheel", layout.left), ("right_wheel", layout.right)):
        if (back := used.get(f"{name}.flange_back")) and back["value"] is None:
            back |= {"value": half - side.wheel.offset[0], "origin": OF_PROFILE}
    return {key: entry for key, entry in used.items() if entry["value"] is not None}


def _table_values(prefix: str, table: SceneTable) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the keys of a table that are no tables."""
    for key, field in type(table).model_fields.items():
        value = getattr(table, key)
        if isinstance(value, SceneTable) or key == "title":
            continue
        if key in OF_FILES and isinstance(table, ProfileTable) and table.is_standard:
            continue
        if value is None or value == ():
            value = ABSENT.get(prefix + key)
        origin = GIVEN if key in table.model_fields_set else ASSUMED
        meaning = FIRST.split(field.description or "")[0]
        yield prefix + key, {"value": value, "origin": origin, "meaning": meaning}


def value_text(value: Any) -> str:
    """Return a value as text; equal ones of both sides once."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(dict.fromkeys(value_text(each) for each in value)) or "none"
    return f"{value:.10g}" if isinstance(value, int | float) else str(value)


def assumed_text(used: dict[str, dict[str, Any]]) -> str:
    """Return which numbers of track, wheelset, materials, load and friction were assumed; empty if none."""
    parts = []
    for key, entry in used.items():
        unit = UNIT.search(entry["meaning"])
        is_number = isinstance(entry["value"], float | tuple) and "." in key
        if entry["origin"] == ASSUMED and is_number and key != "contact.ics":
            parts.append(f"{key} = {value_text(entry['value'])}{f' {unit[1]}' if unit else ''}")
    return f"Assumed values that the specification does not give: {', '.join(parts)}." if parts else ""


# --- the rolling wheelset -------------------------------------------------------------------------------


Contacts = Mapping[tuple[float, SideName], xr.Dataset]
MIRRORED = ("sum_F_y", "steering")  # numbers of a wheelset that change their sign


def rolling_wheelsets(
    study: Study, positions: Mapping[float, Position], contacts: Contacts
) -> Iterator[tuple[float, xr.Dataset]]:
    """Yield the wheelset by shift; where sides are alike, the mirrored one stands for the opposite shift."""
    rolling = study.specification.rolling
    assert rolling is not None
    may_mirror = study.alike and rolling.lateral == 0 == rolling.spin
    parts: dict[float, Part] = {}
    mirrored: dict[float, bool] = {}
    for count, (shift, position) in enumerate(positions.items(), start=1):
        sides = []  # on the grids of their contacts without friction
        for k, side in enumerate(SIDES):
            if (contact := contacts.get((shift, side))) is None:
                continue
            place, grids = Place(study.layout, position, side), read_grids(contact)
            rail, wheel = study.specification.rails[k], study.specification.wheels[k]
            bodies = bodies_at(place, rail, wheel, float(contact.attrs["steepest"]))
            problem = contact_problem(bodies, study.specification.contact, grids[0])
            approach = float(contact.approach.isel(ics=0))
            sides.append(RollingSide(place, problem, grids, approach, C in contact.ics.values))
        if not sides:
            continue
        mirrored[shift] = may_mirror and -shift in parts and shift != 0 and is_mirrored(positions, shift)
        if not mirrored[shift]:
            label = f"shift {shift:g} mm ({count} of {len(positions)}), rolling"
            parts[shift] = _rolling(study, rolling, sides, label)
    workers = 1 if study.specification.contact.may_need_c else study.options.workers
    found = zip(parts, compute_parts(list(parts.values()), study.options, workers), strict=True)
    solved: dict[float, xr.Dataset] = {}
    for shift, is_mirror in mirrored.items():
        if is_mirror:
            yield shift, mirror(solved[-shift])
            continue
        _, entry = next(found)
        if isinstance(entry, Failure):
            raise entry
        solved[shift] = entry
        yield shift, entry


def mirror(entry: xr.Dataset) -> xr.Dataset:
    """Return the wheelset at the opposite shift: its sides change places."""
    swapped = entry.sel(side=entry.side.values[::-1]).assign_coords(side=entry.side.values)
    swapped = swapped.assign({name: -swapped[name] for name in MIRRORED})
    names = dict(zip(SIDES, SIDES[::-1], strict=True))
    reasons = {names[side]: text for side, text in json.loads(entry.attrs["reasons"]).items()}
    return swapped.assign_attrs(reasons=json.dumps(reasons))


def _rolling(study: Study, rolling: RollingTable, sides: list[RollingSide], label: str) -> Part:
    """Return the wheelset in a position as a part of a study."""
    position, contact = sides[0].place.position, study.specification.contact
    key = study.options.store.key(
        "rolling",
        results_digest(),
        [study.facts(side) for side in SIDES],
        [(side.place.side, side.grids, side.approach, side.with_c) for side in sides],
        (position.given_shift, position.roll),
        rolling.model_dump(),
    )
    return Part(label, key, partial(roll, sides, contact.load, rolling, contact.ics), _creepages)


def _creepages(entry: xr.Dataset) -> str:
    known = entry.xi_0.dropna("ics")
    creepages = ", ".join(f"{name} {float(known.sel(ics=name)):.3g}" for name in known.ics.values)
    return f"creepage {creepages}" if creepages else "not found"


def join_rolling(study: Study, solved: Mapping[float, xr.Dataset]) -> xr.Dataset:
    """Return the numbers of all wheelsets by shift, side and ICs, and the reasons for missing ones.

    C of a wheel is left out where only the other one has it. Arc lengths are from the rails' tops.
    """
    rolling, shifts = study.specification.rolling, list(study.specification.shifts)
    assert rolling is not None
    entries = [entry.drop_attrs(deep=False).expand_dims(shift=[shift]) for shift, entry in solved.items()]
    dataset = xr.concat(entries, "shift", join="outer").reindex(shift=shifts)
    tops = xr.DataArray([rail_top(study.layout, side) for side in SIDES], coords={"side": list(SIDES)})
    centre = dataset[f"{GRID}centre"]
    meaning = "centre of pressure of the area, arc length on the rail from its top"
    dataset[f"{GRID}centre"] = (
        (centre - tops).transpose(*centre.dims).assign_attrs(centre.attrs | {"long_name": meaning})
    )
    reasons = {
        f"{shift:g}, {side}, rolling": text
        for shift, entry in solved.items()
        for side, text in json.loads(entry.attrs["reasons"]).items()
    }
    return dataset.assign_attrs(
        friction=rolling.friction,
        longitudinal=str(rolling.longitudinal),
        by_angle=json.dumps(rolling.by_angle),
        lateral=rolling.lateral,
        spin=rolling.spin,
        not_rolling=json.dumps(reasons),
    )
