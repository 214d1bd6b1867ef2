"""A wheelset without friction over its shifts, as datasets: its geometry, and all contacts of its wheels.

The geometry is positions, touching points, sections and conicity. Finished contacts are stored.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.cache.workers import Processes
from femic.reference.run_options import RunOptions, Watch
from femic.shifts.contact import PATCH, contact_at
from femic.shifts.sides import SIDES, Place
from femic.shifts.specification import ShiftsFile
from geometries.errors import Failure
from geometries.track.conicity import equivalent_conicity
from geometries.track.layout import Layout, SideName
from geometries.track.wheelset import Position, RollRule, over_shifts

# --- geometry -------------------------------------------------------------------------------------------


ABOUT: RollRule = "about rails"  # shifts are those at the rails: flanges of any slope are reached
BEYOND = (0.5, 2.0, 5.0)  # mm beyond the amplitude of the conicity, up to which shifts are taken for it
STEP = 0.1  # mm between these shifts: the largest step of EN 15302
DRAWN = 0.25  # mm between points of the sections that are drawn
TOUCHING = {  # of a touching point, by name: unit and meaning
    "contact_angle": ("deg", "contact angle, positive on the flange"),
    "radius": ("mm", "rolling radius"),
    "y": ("mm", "contact point: distance from the middle of the track"),
    "z": ("mm", "contact point: height above the rail tops"),
    "s_rail": ("mm", "contact point: arc length from the top of the rail, positive to the field side"),
    "curvature_rail": ("1/mm", "curvature of the rail, positive on a crown"),
    "curvature_wheel": ("1/mm", "curvature of the wheel, positive in its root"),
    "second_gap": ("mm", "gap at the second contact point; NaN if there is none within 0.5 mm"),
    "second_angle": ("deg", "contact angle at the second contact point"),
}


def wheelset(specification: ShiftsFile, positions: dict[float, Position]) -> xr.Dataset:
    """Return roll, height and rolling-radius difference over all shifts."""
    known = [positions.get(shift) for shift in specification.shifts]
    quantities: dict[str, tuple[Callable[[Position], float], str, str]] = {
        "roll": (lambda at: 1e3 * at.roll, "mrad", "roll, positive if the left wheel is higher"),
        "axle_shift": (lambda at: at.shift, "mm", "shift of the middle of the axle"),
        "height": (lambda at: at.height, "mm", "height of the axle above the rail tops"),
        "rrd": (
            lambda at: at.rolling_radius_difference,
            "mm",
            "rolling-radius difference, left minus right",
        ),
    }
    return xr.Dataset(
        {
            name: (
                "shift",
                [value(at) if at else np.nan for at in known],
                {"units": unit, "long_name": meaning},
            )
            for name, (value, unit, meaning) in quantities.items()
        },
        coords={"shift": ("shift", list(specification.shifts), {"units": "mm"})},
    )


def touching(layout: Layout, specification: ShiftsFile, positions: dict[float, Position]) -> xr.Dataset:
    """Return the touching points by shift and side."""
    values = np.full((len(TOUCHING), len(specification.shifts), 2), np.nan)
    for m, side in enumerate(SIDES):
        top = rail_top(layout, side)
        for k, shift in enumerate(specification.shifts):
            if shift in positions:
                touch, *others = positions[shift].left if side == "left" else positions[shift].right
                second = (
                    (others[0].distance, float(np.degrees(others[0].angle))) if others else (np.nan, np.nan)
                )
                values[:, k, m] = (
                    float(np.degrees(touch.angle)),
                    touch.radius,
                    float(touch.point[0]),
                    float(touch.point[1]),
                    touch.s_rail - top,
                    touch.curvature_rail,
                    touch.curvature_wheel,
                    *second,
                )
    return xr.Dataset(
        {
            name: (("shift", "side"), by_side, {"units": unit, "long_name": meaning})
            for (name, (unit, meaning)), by_side in zip(TOUCHING.items(), values, strict=True)
        },
        coords={"shift": list(specification.shifts), "side": list(SIDES)},
    )


def rail_top(layout: Layout, side: SideName) -> float:
    """Return the arc length [mm] of the highest point of a rail in its place."""
    rail = layout.side(side).rail
    t = np.linspace(*rail.limits, 20001)
    return float(t[np.argmax(rail.position(t)[1])])


def sections(layout: Layout) -> xr.Dataset:
    """Return points of rails in the axes of their sides, and of wheels in those of the axle, (2, n) each."""
    variables = {}
    for side in SIDES:
        both = layout.side(side)
        for name, curve in (("rail", both.rail), ("wheel", both.wheel)):
            t = np.linspace(*curve.limits, int(curve.limits[1] / DRAWN) + 1)
            variables[f"{name}_{side}"] = (
                ("axis", f"{name}_{side}_point"),
                curve.position(t),
                {"units": "mm"},
            )
    return xr.Dataset(variables, coords={"axis": ["y", "z"]})


def conicity(layout: Layout, specification: ShiftsFile, watch: Watch, *, alike: bool) -> xr.Dataset:
    """Return rolling-radius differences about the middle, with both values at jumps, and the conicity.

    Where both sides are `alike`, shifts to the right mirror those to the left. Wheels that are not run about
    a shift of their own: where no motion is found, more shifts are taken.
    """
    amplitude = specification.conicity_amplitude
    label, start = f"equivalent conicity at {amplitude:g} mm", perf_counter()
    watch.on_stage(f"{label}: rolling-radius differences at shifts {STEP:g} mm apart")
    at, differences = np.empty(0), np.empty(0)
    jumps: list[float] = []
    value, reason = np.nan, ""
    for beyond in BEYOND:
        end = amplitude + beyond
        count = int(np.ceil(end / STEP))
        shifts = np.linspace(0.0, end, count + 1) if alike else np.linspace(-end, end, 2 * count + 1)
        try:
            found = over_shifts(layout, shifts, roll=ABOUT)
            at, differences = found.rolling_radius_differences()
            jumps = [jump.shift for jump in found.jumps]
            if alike:
                at, differences = (np.concatenate([-part[:0:-1], part]) for part in (at, differences))
                jumps = sorted([*(-jump for jump in jumps), *jumps])
            value, reason = equivalent_conicity(at, differences, amplitude).value, ""
            break
        except Failure as failure:
            reason = reason or str(failure)
    watch.on_stage(f"{label}: {reason or f'{value:.3f}'}, {perf_counter() - start:.1f} s")
    return xr.Dataset(
        {"rrd_near": ("near", differences, {"units": "mm"})},
        coords={"near": ("near", at, {"units": "mm"})},
        attrs={
            "conicity": float(value),
            "conicity_reason": reason,
            "amplitude": amplitude,
            "jumps": [round(jump, 3) for jump in jumps],
        },
    )


# --- contacts -------------------------------------------------------------------------------------------


SAME_ROLL = 1e-8  # rad


@dataclass(frozen=True, eq=False)
class Study:
    """A wheelset over its shifts: its specification, both sides in place, and how it is computed."""

    specification: ShiftsFile
    layout: Layout
    options: RunOptions

    @property
    def alike(self) -> bool:
        """Whether both sides have the same profiles, materials and radii."""
        rails, wheels = self.specification.rails, self.specification.wheels
        left_radius, right_radius = self.layout.nominal_radius
        return rails[0] == rails[1] and wheels[0] == wheels[1] and left_radius == right_radius

    def facts(self, side: SideName) -> list[object]:
        """Return all of a side on which its contacts depend."""
        k, both = SIDES.index(side), self.layout.side(side)
        rail, wheel = self.specification.rails[k], self.specification.wheels[k]
        curves = both.rail.curve, both.wheel.curve
        points = [np.round(curve.position(np.linspace(0, curve.length, 2001)), 9) for curve in curves]
        materials = [(table.E, table.nu) for table in (rail, wheel)]
        tables = self.specification.track, self.specification.wheelset, self.specification.contact
        return [points, materials, [table.model_dump() for table in tables], wheel.flange_back]


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a study that is computed and stored by itself; `compute` raises Failure if there is none.

    `label` and what `describe` makes of the dataset are reported.
    """

    label: str
    key: str
    compute: Callable[[RunOptions], xr.Dataset]
    describe: Callable[[xr.Dataset], str]


def compute_parts(parts: Sequence[Part], options: RunOptions, workers: int) -> Iterator[xr.Dataset | Failure]:
    """Yield the datasets of parts in their order, or why there is none.

    Stored ones are taken from the store; others are computed by `workers` processes side by side, or here.
    """
    stored = [options.store.get(part.key) for part in parts]
    missing = [part for part, entry in zip(parts, stored, strict=True) if entry is None]
    with Processes(workers) as processes:
        if min(workers, len(missing)) > 1:
            computed = processes(partial(_compute, options=RunOptions(1, options.store)), missing)
        else:
            computed = map(partial(_compute, options=without_grid_reports(options)), missing)
        for part, known in zip(parts, stored, strict=True):
            entry, seconds = (known, 0.0) if known is not None else next(computed)
            if isinstance(entry, Failure):
                options.watch.on_stage(f"{part.label} is left out: {entry}")
            elif known is None:
                options.watch.on_stage(f"{part.label}: {part.describe(entry)}, {seconds:.1f} s")
            else:
                options.watch.on_stage(f"{part.label}: stored by an earlier run")
            yield entry


def _compute(part: Part, options: RunOptions) -> tuple[xr.Dataset | Failure, float]:
    """Return the dataset of a part, which is stored, or why there is none, and seconds."""
    start = perf_counter()
    try:
        entry = part.compute(options)
    except Failure as failure:
        return Failure(str(failure)), perf_counter() - start
    options.store.put(part.key, entry)
    return entry, perf_counter() - start


def contacts(
    study: Study, positions: dict[float, Position], refused: dict[str, str]
) -> Iterator[tuple[tuple[float, SideName], xr.Dataset]]:
    """Yield all contacts by shift and side; where sides are alike, one stands for both at opposite shifts.

    Contacts with C come one after the other, as their models take all workers.
    """
    parts: dict[tuple[float, SideName], Part] = {}
    same: dict[tuple[float, SideName], tuple[float, SideName]] = {}  # the one that stands for each
    for count, (shift, position) in enumerate(positions.items(), start=1):
        for side in SIDES:
            mirrored: tuple[float, SideName] = (-shift, "left" if side == "right" else "right")
            if study.alike and mirrored in parts and is_mirrored(positions, shift):
                same[shift, side] = mirrored
            else:
                same[shift, side] = shift, side
                label = f"shift {shift:g} mm ({count} of {len(positions)}), {side}"
                parts[shift, side] = _contact(study, Place(study.layout, position, side), label)
    workers = 1 if study.specification.contact.may_need_c else study.options.workers
    found = zip(parts, compute_parts(list(parts.values()), study.options, workers), strict=True)
    entries = dict[tuple[float, SideName], xr.Dataset | Failure]()
    for place, own in same.items():
        while own not in entries:
            solved, entry = next(found)
            entries[solved] = entry
        entry = entries[own]
        if isinstance(entry, Failure):
            refused[f"{place[0]:g}, {place[1]}"] = str(entry)
        else:
            yield place, entry


def _contact(study: Study, where: Place, label: str) -> Part:
    """Return a contact as a part of a study."""
    k, specification = SIDES.index(where.side), study.specification
    at = where.position.given_shift, where.position.roll
    key = study.options.store.key("shift", results_digest(), study.facts(where.side), at, where.side)
    tables = specification.rails[k], specification.wheels[k], specification.contact
    return Part(label, key, partial(contact_at, where, *tables), _largest_pressures)


def _largest_pressures(entry: xr.Dataset) -> str:
    pressures = zip(entry.ics.values, entry.p_max.values, strict=True)
    return ", ".join(f"{name} {p_max:.0f} MPa" for name, p_max in pressures)


def is_mirrored(positions: Mapping[float, Position], shift: float) -> bool:
    """Whether the wheelset at the opposite shift is rolled to the other side; given rolls need not be."""
    return abs(positions[-shift].roll + positions[shift].roll) <= SAME_ROLL


def without_grid_reports(options: RunOptions) -> RunOptions:
    """Return options without reports of grids; models of C are reported."""
    return replace(options, watch=replace(options.watch, on_stage=lambda _: None))


def join_contacts(study: Study, solved: dict[tuple[float, SideName], xr.Dataset]) -> xr.Dataset:
    """Return all contacts by shift, side and ICs, with arc lengths from the rails' tops."""
    shifts, by_side = list(study.specification.shifts), []
    grids = np.full((len(shifts), len(SIDES)), "", dtype=object)
    for m, side in enumerate(SIDES):
        entries = []
        for (shift, own), entry in solved.items():
            if own == side:
                entries.append(entry.drop_attrs(deep=False).expand_dims(shift=[shift]))
                grids[shifts.index(shift), m] = entry.attrs["grid"]
        if entries:
            joined, top = xr.concat(entries, "shift", join="outer"), rail_top(study.layout, side)
            for name in ("outline_s", *(f"{PATCH}{end}" for end in ("centre", "start", "end"))):
                joined[name] = (joined[name] - top).assign_attrs(joined[name].attrs)
            by_side.append(joined.expand_dims(side=[side]))
    names = dict.fromkeys(str(name) for entry in solved.values() for name in entry.ics.values)
    dataset = xr.concat(by_side, "side", join="outer").reindex(
        shift=shifts, side=list(SIDES), ics=list(names)
    )
    dataset["grid"] = ("shift", "side"), grids.astype(str)
    return dataset.transpose("shift", "side", "ics", ...)
