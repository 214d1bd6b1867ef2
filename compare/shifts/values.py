"""All values of a wheelset's computation: given by its specification, assumed, or taken from a profile."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xarray as xr

from femic.scenes.scene_table import SceneTable
from femic.shifts.specification import ProfileTable, ShiftsFile
from geometries.errors import WrongInput
from geometries.profiles.text import read_source
from geometries.track.layout import Layout

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
    "contact.c_above_deg": "none: no contact with C",
    "rolling": "none: contacts without friction",
    "rolling.by_angle": "the same at all contact angles",
}


def require_track(specification: ShiftsFile) -> None:
    """Raise WrongInput where a rail is a file and the specification leaves out where it lies.

    Rails of the package lie as in their standard; what is assumed of a wheel is said (`assumed_text`).
    """
    rails = [(name, table) for name, table in _profiles(specification) if "rail" in name]
    of_files = [name for name, table in rails if not table.is_standard]
    missing = [
        f"{table}.{key} = {value_text(getattr(getattr(specification, table), key))}"
        for table, key in NEEDED
        if key not in getattr(specification, table).model_fields_set
    ]
    if of_files and missing:
        raise WrongInput(
            f"{of_files[0]}.profile is a file, and the specification does not say on which track it "
            f"runs: give {', '.join(missing)}, or what they are there (rail_inclination = 0 where the "
            "points of the rail are inclined already)"
        )


def canted_rails(specification: ShiftsFile) -> tuple[str, ...]:
    """Return a sentence for each rail that its file calls canted and that the track inclines once more."""
    slope = specification.track.rail_inclination
    if slope == 0:
        return ()
    sentences = []
    for name, table in _profiles(specification):
        if "rail" not in name or table.is_standard:
            continue
        lines = read_source(Path(table.profile)).lines
        if said := next((line for line in lines if CANTED.search(line)), None):
            sentences.append(
                f'{name}, {Path(table.profile).name}: its file says "{" ".join(said.split())}", and '
                f"track.rail_inclination = {slope:g} turns it once more: give 0 if its points are inclined"
            )
    return tuple(sentences)


def values_used(specification: ShiftsFile, layout: Layout) -> dict[str, dict[str, Any]]:
    """Return value, origin and meaning of each key; of profiles of the package none of files."""
    used = dict(_of_table("", specification))
    for name in TABLES:
        if isinstance(table := getattr(specification, name), SceneTable):
            used |= _of_table(f"{name}.", table)
    half = specification.wheelset.flange_back_distance / 2
    for name, side in (("wheel", layout.left), ("right_wheel", layout.right)):
        if (back := used.get(f"{name}.flange_back")) and back["value"] is None:
            back |= {"value": half - side.wheel.offset[0], "origin": OF_PROFILE}
    return {key: entry for key, entry in used.items() if entry["value"] is not None}


def _of_table(prefix: str, table: SceneTable) -> Iterator[tuple[str, dict[str, Any]]]:
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


def _profiles(specification: ShiftsFile) -> Iterator[tuple[str, ProfileTable]]:
    """Yield the profiles that the specification names."""
    for name in TABLES:
        if isinstance(table := getattr(specification, name), ProfileTable):
            yield name, table


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
    return f"Assumed, because the specification does not say: {', '.join(parts)}." if parts else ""


def values_of(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Return value, origin and meaning of each key with which a dataset was computed."""
    used: dict[str, dict[str, Any]] = json.loads(dataset.attrs["values"])
    return used
