"""The scene of one wheel of a wheelset at a shift, which `femic contact`, `stresses` and `export` take."""

from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from femic.cache.files import write_text
from femic.results.wheelset import OF_FILES, SECOND, assumed_text, canted_rails, require_track, values_used
from femic.results.wheelset_contacts import ABOUT
from femic.scenes.listing import as_toml
from femic.shifts.contact import C_FLANK
from femic.shifts.sides import (
    SIDES,
    Place,
    doubts,
    lay_out_wheelset,
    prepare_sections,
    reference_length,
)
from femic.shifts.specification import ProfileTable, ShiftsFile
from geometries.errors import Failure, WrongInput
from geometries.profiles.placement import STEEPEST
from geometries.profiles.profile import Kind
from geometries.track.layout import SideName
from geometries.track.wheelset import settle

INDENT = 4 * " "  # of keys in comments
DIGITS = 7  # decimals of lengths [mm] and angles [deg]
ROOM = float(np.radians(10.0))  # from the contact angle to the flanks of the bodies at least


def write_scene(
    specification: ShiftsFile, shift: float, folder: Path, name: str, side: SideName | None = None
) -> Path:
    """Write the scene of a wheel at a shift [mm] to the left, NAME_SIDE_SHIFT.toml; return its path.

    Without a side it is the wheel that is moved towards its rail. Bodies end in flanks of 60 degrees, as
    those of shifts with C do, or of 85 where the touching point is steeper than 50. The load is the
    vertical one of the wheel, perpendicular to the axle. Raises WrongInput, and Failure where the wheelset
    cannot stand.
    """
    require_track(specification)
    if specification.rolls and shift not in specification.shifts:
        known = ", ".join(f"{each:g}" for each in specification.shifts)
        raise WrongInput(
            f"--write {shift:g}: rolls are only given at the shifts {known} mm; choose one of them"
        )
    side = side or ("left" if shift >= 0 else "right")
    sections = prepare_sections(specification)
    layout = lay_out_wheelset(specification, sections)
    given = specification.roll_at(shift) if specification.rolls else None
    try:
        position = settle(layout, shift, roll=ABOUT if given is None else given, within=SECOND)
    except Failure as failure:
        raise Failure(f"--write {shift:g}: {failure}") from failure
    place = Place(layout, position, side)
    remarks = [
        f"Touching point at {np.degrees(place.touch.angle):.2f} degrees to the track; the wheelset rolls by "
        f"{np.degrees(position.roll):.4f} degrees, its left wheel higher where positive",
        *position.notes,
        *filter(None, [assumed_text(values_used(specification, layout))]),
        *canted_rails(specification),
        *doubts(sections),
    ]
    if (rolling := specification.rolling) is not None:
        sign = 1 if side == "left" else -1  # the right side is mirrored from a left one
        keys = {
            "motion": "rolling",
            "friction": [rolling.friction],
            "friction_by_angle": [list(pair) for pair in rolling.by_angle],
            "lateral": sign * rolling.lateral,
            "spin": sign * rolling.spin,
        }
        remarks.append(
            "The specification has [rolling]. For creep forces and wear, give in [contact] instead of gap"
        )
        remarks += [f"{INDENT}{key} = {as_toml(value)}" for key, value in keys.items() if value]
    comments = "".join(f"# {remark}\n" for remark in remarks)
    k, touch = SIDES.index(side), place.touch
    rail, wheel = specification.rails[k], specification.wheels[k]
    steepest = C_FLANK if abs(touch.angle) + ROOM < C_FLANK else STEEPEST
    turn = {
        "rail_inclination": specification.track.rail_inclination,
        "turn_deg": round(-float(np.degrees(place.roll)), DIGITS),
    }
    both = {"steepest_deg": round(float(np.degrees(steepest)), DIGITS)}
    title = specification.title or "Wheelset"
    scene = {
        "title": f"{title}: {side} wheel at a shift of {position.given_shift:g} mm",
        "reference_length": round(reference_length(touch.curvature_rail), DIGITS),
        "lower": {
            "E": rail.E,
            "nu": rail.nu,
            "contour": _contour(rail, "rail", touch.s_rail) | turn | both,
        },
        "upper": {
            "E": wheel.E,
            "nu": wheel.nu,
            "contour": _contour(wheel, "wheel", touch.s_wheel) | both,
            "rolling_radius": round(touch.radius, DIGITS),
        },
        "contact": {
            "loads": [specification.contact.load],
            "ics": list(specification.contact.ics),
            "elements": specification.contact.elements,
            "flanks": False,
            "gap": "exact",
        },
        "engine": {"tolerance": 0.03},
    }
    return write_text(f"{comments}\n{tomlkit.dumps(scene)}", folder / f"{name}_{side}_{shift:g}.toml")


def _contour(table: ProfileTable, kind: Kind, centre: float) -> dict[str, Any]:
    """Return the keys of a profile whose contact centre is at an arc length [mm]."""
    place = {"kind": "profile", "s_centre": round(centre, DIGITS)}
    if table.is_standard:
        return place | {"standard": table.profile}
    given = {key: value for key in OF_FILES if (value := getattr(table, key)) is not None}
    return place | {"file": str(Path(table.profile).absolute()), "profile_kind": kind} | given
