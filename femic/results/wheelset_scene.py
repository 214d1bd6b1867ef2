"""The scene of one wheel of a wheelset at a shift, which `femic contact`, `stresses` and `export` take."""

from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from femic.cache.files import write_text
from femic.results.wheelset import OF_FILES, SECOND, assumed_text, canted_rails, require_track, values_used
from femic.results.wheelset_contacts import ABOUT, SIDES
from femic.scenes.listing import as_toml
from femic.shifts.contact import C_FLANK
from femic.shifts.sides import LARGEST_LENGTH, LEAST_LENGTH, Place, doubts, layout_of, sections_of
from femic.shifts.specification import ProfileTable, RollingTable, ShiftsFile
from geometries.errors import Failure, WrongInput
from geometries.profiles.placement import STEEPEST
from geometries.profiles.profile import Kind
from geometries.track.layout import SideName
from geometries.track.wheelset import settle

INDENT = 4 * " "  # of keys in comments
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
        raise WrongInput(f"--write {shift:g}: rolls are given at the shifts {known} mm alone: name one")
    side = side or ("left" if shift >= 0 else "right")
    sections = sections_of(specification)
    layout = layout_of(specification, sections)
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
    if specification.rolling is not None:
        remarks += _rolling_lines(specification.rolling, side)
    comments = "".join(f"# {remark}\n" for remark in remarks)
    return write_text(
        f"{comments}\n{tomlkit.dumps(_scene(specification, place))}",
        folder / f"{name}_{side}_{shift:g}.toml",
    )


def _rolling_lines(rolling: RollingTable, side: SideName) -> list[str]:
    """Return the keys with which a wheel rolls, a line each; the right side is mirrored from a left one."""
    sign = 1 if side == "left" else -1
    keys = {
        "motion": "rolling",
        "friction": [rolling.friction],
        "friction_by_angle": [list(pair) for pair in rolling.by_angle],
        "lateral": sign * rolling.lateral,
        "spin": sign * rolling.spin,
    }
    given = [f"{INDENT}{key} = {as_toml(value)}" for key, value in keys.items() if value]
    return ["The specification rolls: for creep forces and wear give in [contact] instead of gap", *given]


def _scene(specification: ShiftsFile, place: Place) -> dict[str, Any]:
    """Return the keys of a scene of a wheel and its rail in a place."""
    k = SIDES.index(place.side)
    rail, wheel = specification.rails[k], specification.wheels[k]
    touch, shift = place.touch, place.position.given_shift
    steepest = C_FLANK if abs(touch.angle) + ROOM < C_FLANK else STEEPEST
    curvature = abs(touch.curvature_rail)
    length = float(np.clip(1 / max(curvature, 1 / LARGEST_LENGTH), LEAST_LENGTH, LARGEST_LENGTH))
    turn = {
        "rail_inclination": specification.track.rail_inclination,
        "turn_deg": -float(np.degrees(place.roll)),
    }
    of_both = {"steepest_deg": float(np.degrees(steepest))}
    title = specification.title or "Wheelset"
    return {
        "title": f"{title}: {place.side} wheel at a shift of {shift:g} mm",
        "reference_length": length,
        "lower": _materials(rail) | {"contour": _contour(rail, "rail", touch.s_rail) | turn | of_both},
        "upper": _materials(wheel)
        | {"contour": _contour(wheel, "wheel", touch.s_wheel) | of_both, "rolling_radius": touch.radius},
        "contact": {
            "loads": [specification.contact.load],
            "ics": list(specification.contact.ics),
            "elements": specification.contact.elements,
            "flanks": False,
            "gap": "exact",
        },
        "engine": {"tolerance": 0.03},
    }


def _materials(table: ProfileTable) -> dict[str, float]:
    return {"E": table.E, "nu": table.nu}


def _contour(table: ProfileTable, kind: Kind, centre: float) -> dict[str, Any]:
    """Return the keys of a profile whose contact centre is at an arc length [mm]."""
    place = {"kind": "profile", "s_centre": centre}
    if table.is_standard:
        return place | {"standard": table.profile}
    given = {key: value for key in OF_FILES if (value := getattr(table, key)) is not None}
    return place | {"file": str(Path(table.profile).absolute()), "profile_kind": kind} | given
