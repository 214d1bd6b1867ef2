"""A wheelset of unequal cones on rails, with contacts that are known and not solved: datasets in a moment."""

from contextlib import contextmanager
from functools import cache

import numpy as np
import pytest
import xarray as xr

from femic.reference.run_options import RunOptions
from femic.results import wheelset
from femic.results import wheelset_contacts as contacts
from femic.shifts.axle import OF_PATCH, OF_WHEEL, OF_WHEELSET, WheelNumbers
from femic.shifts.contact import label_contact
from femic.shifts.position import concat_ics, label_wheelset
from femic.shifts.specification import ContactTable, ProfileTable, RollingTable, ShiftsFile, WheelTable
from geometries.patches import Grid

SHIFTS = (-2.0, -1.0, 0.0, 1.0, 2.0)
ALONE = RunOptions(1)  # in this process, which knows the functions below
FILE = ShiftsFile(
    shifts=SHIFTS,
    conicity_amplitude=0.5,
    rail=ProfileTable(profile="60E1"),
    wheel=WheelTable(profile="cone-1-20"),
    right_wheel=WheelTable(profile="cone-1-20", nu=0.3),
    contact=ContactTable(ics=("A", "Bhat"), c_above_deg=20.0),
)
SHARES = {-2.0: 0.005, -1.0: 0.0, 0.0: 0.02, 1.0: -0.07, 2.0: 0.2}  # of A, left; the right wheel: half of it


def changed(file=FILE, **keys):
    """A specification with other keys."""
    return file.model_copy(update=keys)


ROLLING = changed(
    shifts=(-2.0, 0.0, 1.0, 2.0),
    contact=ContactTable(ics=("A", "Bhat")),
    rolling=RollingTable(friction=0.4, by_angle=((20.0, 1.0), (40.0, 0.3))),
)


def numbers(where, ics):
    """Numbers of a contact; at 2 mm the flange touches as well."""
    shift = where.position.given_shift
    share = SHARES[shift] * (1.0 if where.side == "left" else 0.5) if ics == "A" else 0.0
    s = np.linspace(-5, 5, 31)
    outline = np.stack([where.touch.s_rail + s, 6 * np.sqrt(1 - (s / 5) ** 2)])
    largest = 1000 * (1 + share)
    patch = {
        "normal_force": 9e4 / np.cos(0.05),
        "share": 1.0,
        "p_max": largest,
        "angle": np.degrees(0.05),
        "centre": where.touch.s_rail,
        "start": outline[0, 0],
        "end": outline[0, -1],
        "half_length": 6.0,
        "area": 94.0,
        "outline": outline,
    }
    patches = (patch,)
    if shift == 2.0:
        places = {name: patch[name] - 30.0 for name in ("centre", "start", "end")}
        flange = {"normal_force": 1e4, "share": 0.033, "angle": np.degrees(1.2)}
        patches = patch | flange | places, patch | {"share": 0.967}
    forces = {"vertical": 9e4, "lateral": 4e3, "estimate_lateral": 50.0}
    sizes = {"angle": 20 + shift, "a": 6.0, "b": 5.0, "seconds": 0.5, "patches": patches}
    varied = {"larger_p_max": largest, "change_p_max": 0.0, "floor_p_max": 3.0 if ics != "A" else 0.0}
    varied |= {"missed_p_max": 0.05}
    return {"p_max": largest, "estimate_p_max": 3.0, "approach": 0.1} | varied | forces | sizes


def fake_contact(where, *_):
    """In the place of `contact_at`: C is known at 2 mm, left."""
    ics = ["A", "Bhat"] + (["C"] if where.position.given_shift == 2.0 and where.side == "left" else [])
    rows = {name: numbers(where, name) for name in ics}
    return label_contact(rows, (Grid(40, 40, 0.5, 0.4),), notes=("a remark",))


def rolling_wheel(shift, side, ics):
    """Numbers of a wheel: A is off by 3 % of friction times load of F_x at 2 mm, left, and less elsewhere."""
    sign = 1 if side == "left" else -1
    off = 0.03 * (shift == 2.0 and side == "left") if ics == "A" else 0.0
    own = dict.fromkeys(OF_WHEEL, 1.0) | {
        "F_x": sign * 5000 * shift + off * 0.4 * 9e4,
        "F_y": 3000 - 100.0 * sign * shift,
        "work": 10.0 * (1 + off),
        "resistance": 7.0,
    }
    patch = dict.fromkeys(OF_PATCH, 1.0) | {"F_n": 9e4, "centre": 70.0}
    patches = (patch, patch) if shift == 2.0 else (patch,)
    summed, floor = ("F_x", "F_y", "M_z", "work"), 50.0 if ics != "A" else 0.0
    variations = {
        "larger_": own,
        "change_": dict.fromkeys(summed, 0.0),
        "floor_": dict.fromkeys(summed, floor),
        "missed_": dict.fromkeys(summed, 0.05),
    }
    return WheelNumbers(own, dict.fromkeys(summed, 50.0), patches, variations)


def fake_roll(sides, load, table, ics, _):
    """In the place of `roll`: nothing rolls at 1 mm."""
    assert load == 9e4
    assert table.friction == 0.4
    shift = sides[0].place.position.given_shift
    if shift == 1.0:
        return label_wheelset("A", {}, reasons={"left": "not today", "right": "not today"})
    solved = []
    for name in [*ics, *(["C"] if any(side.with_c for side in sides) else [])]:
        own = [side.place.side for side in sides if name != "C" or side.with_c]
        wheels = {side: rolling_wheel(shift, side, name) for side in own}
        axle = dict.fromkeys(OF_WHEELSET, 1.0) | {"steering": 1e6 * shift, "xi_0": -1e-4 * shift**2}
        solved.append(label_wheelset(name, wheels, (axle, {"xi_0": 1e-6})))
    return concat_ics(solved)


@contextmanager
def faked(contact=fake_contact, roll=fake_roll, *, conicity=False):
    """Contacts and rolling are those of functions; the conicity is left out, which takes longest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contacts, "contact_at", contact)
        patch.setattr(wheelset, "roll", roll)
        if not conicity:
            patch.setattr(contacts, "conicity", lambda *_, **__: xr.Dataset())
        yield


@cache
def known_dataset(file=FILE):
    """The dataset of `FILE` or `ROLLING`."""
    with faked(conicity=True):
        return wheelset.compute_shifts(file, "text of the file", ALONE)
