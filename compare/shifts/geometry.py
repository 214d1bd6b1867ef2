"""Positions, touching points, sections and conicity of a wheelset over its shifts, as datasets."""

from collections.abc import Callable
from time import perf_counter

import numpy as np
import xarray as xr

from femic.reference.run_options import Watch
from femic.shifts.specification import ShiftsFile
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.track.conicity import equivalent_conicity
from geometries.track.layout import Layout
from geometries.track.shifts import over_shifts
from geometries.track.wheelset import Position, RollRule, SideName, Touch, side_of

SIDES: tuple[SideName, SideName] = ("left", "right")
ABOUT: RollRule = "about rails"  # shifts are those at the rails: flanges of any slope are reached
BEYOND = (0.5, 2.0, 5.0)  # mm beyond the amplitude of the conicity, up to which shifts are taken for it
STEP = 0.1  # mm between these shifts: the largest step of EN 15302
DRAWN = 0.25  # mm between points of the sections that are drawn
TOUCHING = {  # of a touching point, by name: unit and meaning
    "contact_angle": ("deg", "contact angle, positive on the flange"),
    "radius": ("mm", "rolling radius"),
    "y": ("mm", "touching point: distance from the middle of the track"),
    "z": ("mm", "touching point: height over the rail tops"),
    "s_rail": ("mm", "touching point: arc length on the rail from its top, positive to the field side"),
    "curvature_rail": ("1/mm", "curvature of the rail, positive on a crown"),
    "curvature_wheel": ("1/mm", "curvature of the wheel, positive in its root"),
    "second_gap": ("mm", "distance of the next touching point; none within 0.5 mm: NaN"),
    "second_angle": ("deg", "contact angle of the next touching point"),
}


def wheelset(specification: ShiftsFile, positions: dict[float, Position]) -> xr.Dataset:
    """Return roll, height and rolling-radius difference over all shifts."""

    def over(value: Callable[[Position], float]) -> tuple[str, list[float]]:
        return "shift", [value(positions[s]) if s in positions else np.nan for s in specification.shifts]

    return xr.Dataset(
        {
            "roll": (
                *over(lambda position: 1e3 * position.roll),
                {"units": "mrad", "long_name": "roll, positive where the left wheel is higher"},
            ),
            "axle_shift": (
                *over(lambda position: position.shift),
                {"units": "mm", "long_name": "shift of the middle of the axle"},
            ),
            "height": (
                *over(lambda position: position.height),
                {"units": "mm", "long_name": "height of the axle over the rail tops"},
            ),
            "rrd": (
                *over(lambda position: position.rolling_radius_difference),
                {"units": "mm", "long_name": "rolling-radius difference, left minus right"},
            ),
        },
        coords={"shift": ("shift", list(specification.shifts), {"units": "mm"})},
    )


def touching(layout: Layout, specification: ShiftsFile, positions: dict[float, Position]) -> xr.Dataset:
    """Return the touching points by shift and side."""
    tops = [top_of(layout, side) for side in SIDES]
    rows = [
        [
            _touch_numbers(_touches(positions[shift], side), top)
            if shift in positions
            else dict.fromkeys(TOUCHING, np.nan)
            for side, top in zip(SIDES, tops, strict=True)
        ]
        for shift in specification.shifts
    ]
    return xr.Dataset(
        {
            name: (
                ("shift", "side"),
                [[row[name] for row in both] for both in rows],
                {"units": unit, "long_name": meaning},
            )
            for name, (unit, meaning) in TOUCHING.items()
        },
        coords={"shift": list(specification.shifts), "side": list(SIDES)},
    )


def _touches(position: Position, side: SideName) -> tuple[Touch, ...]:
    return position.left if side == "left" else position.right


def _touch_numbers(touches: tuple[Touch, ...], top: float) -> dict[str, float]:
    touch, second = touches[0], touches[1] if len(touches) > 1 else None
    return {
        "contact_angle": float(np.degrees(touch.angle)),
        "radius": touch.radius,
        "y": float(touch.point[0]),
        "z": float(touch.point[1]),
        "s_rail": touch.s_rail - top,
        "curvature_rail": touch.curvature_rail,
        "curvature_wheel": touch.curvature_wheel,
        "second_gap": second.distance if second else np.nan,
        "second_angle": float(np.degrees(second.angle)) if second else np.nan,
    }


def top_of(layout: Layout, side: SideName) -> float:
    """Return the arc length [mm] of the highest point of a rail in its place."""
    rail = side_of(layout, side).rail
    t = np.linspace(*rail.limits, 20001)
    return float(t[np.argmax(rail.position(t)[1])])


def sections(layout: Layout) -> xr.Dataset:
    """Return points of rails in the axes of their sides, and of wheels in those of the axle, (2, n) each."""
    variables = {}
    for side in SIDES:
        both = side_of(layout, side)
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
        try:
            at, differences, jumps = _near(layout, amplitude + beyond, from_middle=alike)
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


def _near(layout: Layout, end: float, *, from_middle: bool) -> tuple[Array, Array, list[float]]:
    """Return shifts up to +-`end`, their rolling-radius differences [mm], and the jumps.

    `from_middle`: those to the right mirror those to the left.
    """
    count = int(np.ceil(end / STEP))
    shifts = np.linspace(0.0, end, count + 1) if from_middle else np.linspace(-end, end, 2 * count + 1)
    found = over_shifts(layout, shifts, roll=ABOUT)
    at, differences = found.rolling_radius_differences()
    jumps = [jump.shift for jump in found.jumps]
    if from_middle:
        at, differences = (np.concatenate([-part[:0:-1], part]) for part in (at, differences))
        jumps = sorted([*(-jump for jump in jumps), *jumps])
    return at, differences, jumps
