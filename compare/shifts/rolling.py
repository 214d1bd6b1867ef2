"""The rolling wheelset over its shifts, as datasets. Finished positions are stored."""

import json
from collections.abc import Iterator, Mapping
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from compare.shifts.contacts import Study, grids_in, is_mirrored, quiet
from compare.shifts.geometry import SIDES, top_of
from femic.cache.digests import results_digest
from femic.shifts.rolling.numbers import OF_PATCH, OF_WHEEL, OF_WHEELSET
from femic.shifts.rolling.position import RolledICs, RollingSide, roll
from femic.shifts.sides import Place, bodies_at, problem_of
from femic.shifts.specification import C, RollingTable
from geometries.track.wheelset import Position, SideName

Contacts = Mapping[tuple[float, SideName], xr.Dataset]
MIRRORED = ("sum_F_y", "steering")  # numbers of a wheelset that change their sign
ESTIMATE = "estimate_"  # before the name of a number
GRID = "area_"  # before the names of numbers of each contact area that rolls


def rolling_wheelsets(
    study: Study, positions: Mapping[float, Position], contacts: Contacts
) -> Iterator[tuple[float, xr.Dataset]]:
    """Yield the wheelset by shift; where sides are alike, the mirrored one stands for the opposite shift."""
    rolling = study.specification.rolling
    assert rolling is not None
    may_mirror = study.alike and rolling.lateral == 0 == rolling.spin
    solved: dict[float, xr.Dataset] = {}
    for count, (shift, position) in enumerate(positions.items(), start=1):
        sides = [
            _side(study, Place(study.layout, position, side), contacts[shift, side])
            for side in SIDES
            if (shift, side) in contacts
        ]
        if not sides:
            continue
        if may_mirror and -shift in solved and shift != 0 and is_mirrored(positions, shift):
            solved[shift] = mirrored(solved[-shift])
        else:
            label = f"shift {shift:g} mm ({count} of {len(positions)}), rolling"
            solved[shift] = _stored(study, rolling, sides, label)
        yield shift, solved[shift]


def mirrored(entry: xr.Dataset) -> xr.Dataset:
    """Return the wheelset at the opposite shift: its sides change places."""
    swapped = entry.sel(side=entry.side.values[::-1]).assign_coords(side=entry.side.values)
    swapped = swapped.assign({name: -swapped[name] for name in MIRRORED})
    names = dict(zip(SIDES, SIDES[::-1], strict=True))
    reasons = {names[side]: text for side, text in json.loads(entry.attrs["reasons"]).items()}
    return swapped.assign_attrs(reasons=json.dumps(reasons))


def _side(study: Study, where: Place, contact: xr.Dataset) -> RollingSide:
    """Return a side on the grid of its contact without friction."""
    k, grids = SIDES.index(where.side), grids_in(contact)
    rail, wheel = study.specification.rails[k], study.specification.wheels[k]
    bodies = bodies_at(where, rail, wheel, float(contact.attrs["steepest"]))
    problem = problem_of(bodies, study.request, study.request.load, grids[0])
    approach = float(contact.approach.isel(ics=0))
    return RollingSide(where, problem, grids, approach, C in contact.ics.values)


def _stored(study: Study, rolling: RollingTable, sides: list[RollingSide], label: str) -> xr.Dataset:
    """Return the wheelset in a position as a dataset, from the store where it is there."""
    options = study.options
    key = options.store.key(
        "rolling",
        results_digest("femic.shifts.rolling.position"),
        [study.facts(side) for side in SIDES],
        [(side.place.side, side.grids, side.approach, side.with_c) for side in sides],
        (sides[0].place.position.given_shift, sides[0].place.position.roll),
        rolling.model_dump(),
    )
    if (entry := options.store.get(key)) is not None:
        options.watch.on_stage(f"{label}: stored by an earlier run")
        return entry
    start = perf_counter()
    contact = study.specification.contact
    entry = _entry(roll(sides, contact.load, rolling, contact.ics, quiet(options)))
    options.watch.on_stage(f"{label}: {_told(entry)}, {perf_counter() - start:.1f} s")
    options.store.put(key, entry)
    return entry


def _told(entry: xr.Dataset) -> str:
    """Return the creepages of the wheelset in words."""
    known = entry.xi_0.dropna("ics")
    if not known.size:
        return "not found"
    return "creepage " + ", ".join(f"{name} {float(known.sel(ics=name)):.3g}" for name in known.ics.values)


def _entry(solved: list[RolledICs]) -> xr.Dataset:
    """Return a wheelset as a dataset over sides and ICs."""
    shape, variables = (len(SIDES), len(solved)), dict[str, tuple[Any, Any]]()
    for name in OF_WHEEL:
        both = np.full(shape, np.nan), np.full(shape, np.nan)
        for n, of_ics in enumerate(solved):
            for side, wheel in of_ics.wheels.items():
                if wheel.ics != of_ics.ics:
                    continue  # beside a wheel with C
                both[0][SIDES.index(side), n] = wheel.numbers[name]
                both[1][SIDES.index(side), n] = wheel.errors.get(name, np.nan)
        for key, array in zip((name, ESTIMATE + name), both, strict=True):
            variables[key] = (("side", "ics"), array)
    most = max((len(wheel.patches) for of_ics in solved for wheel in of_ics.wheels.values()), default=1)
    for name in OF_PATCH:
        array = np.full((*shape, most), np.nan)
        for n, of_ics in enumerate(solved):
            for side, wheel in of_ics.wheels.items():
                if wheel.ics == of_ics.ics:
                    values = [patch[name] for patch in wheel.patches]
                    array[SIDES.index(side), n, : len(values)] = values
        variables[GRID + name] = (("side", "ics", "area"), array)
    for name in OF_WHEELSET:
        known = [of_ics.axle for of_ics in solved]
        variables[name] = ("ics", [axle.numbers[name] if axle else np.nan for axle in known])
        errors = [axle.errors.get(name, np.nan) if axle else np.nan for axle in known]
        variables[ESTIMATE + name] = ("ics", errors)
    reasons: dict[str, str] = {}
    for of_ics in solved:
        for side, reason in of_ics.reasons.items():
            reasons[side] = "; ".join(filter(None, [reasons.get(side), f"{of_ics.ics}: {reason}"]))
    variables["seconds_rolling"] = ("ics", [of_ics.seconds for of_ics in solved])
    return xr.Dataset(
        variables,
        coords={"side": list(SIDES), "ics": [of_ics.ics for of_ics in solved]},
        attrs={"reasons": json.dumps(reasons)},
    )


def labelled_rolling(study: Study, solved: Mapping[float, xr.Dataset]) -> xr.Dataset:
    """Return the numbers of all wheelsets by shift, side and ICs, and the reasons for missing ones.

    C of a wheel is left out where only the other one has it.
    """
    rolling, shifts = study.specification.rolling, list(study.specification.shifts)
    assert rolling is not None
    entries = [entry.drop_attrs().expand_dims(shift=[shift]) for shift, entry in solved.items()]
    dataset = xr.concat(entries, "shift", join="outer") if entries else xr.Dataset()
    dataset = dataset.reindex(shift=shifts)
    for table in (OF_WHEEL, OF_WHEELSET):
        for name, (unit, meaning) in table.items():
            dataset[name].attrs = {"units": unit, "long_name": meaning}
            dataset[ESTIMATE + name].attrs = {"units": unit, "long_name": f"estimated error of {name}"}
    for name, (unit, meaning) in OF_PATCH.items():
        dataset[GRID + name].attrs = {"units": unit, "long_name": meaning}
    tops = xr.DataArray([top_of(study.layout, side) for side in SIDES], coords={"side": list(SIDES)})
    centre = dataset[GRID + "centre"]
    dataset[GRID + "centre"] = (
        (centre - tops)
        .transpose(*centre.dims)
        .assign_attrs(
            units="mm", long_name="centre of pressure of the area, arc length on the rail from its top"
        )
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
