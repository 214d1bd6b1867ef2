"""A wheelset without friction over its shifts, as datasets: its geometry, and all contacts of its wheels.

The geometry is positions, touching points, sections and conicity. Finished contacts are stored.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.reference.run_options import RunOptions, Watch
from femic.shifts.contact import ICsNumbers, PatchNumbers, SideContact, contact_at
from femic.shifts.sides import ContactRequest, Place
from femic.shifts.specification import ShiftsFile
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import Grid
from geometries.track.conicity import equivalent_conicity
from geometries.track.layout import Layout, SideName
from geometries.track.wheelset import Position, RollRule, Touch, over_shifts

# --- geometry -------------------------------------------------------------------------------------------


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


# --- contacts -------------------------------------------------------------------------------------------


SAME_ROLL = 1e-8  # rad
POINTS = 400  # of the outlines of patches
NUMBERS = {  # of a contact, by name: unit and meaning
    "p_max": ("MPa", "largest pressure"),
    "estimate_p_max": ("MPa", "estimated error of p_max"),
    "approach": ("mm", "approach of wheel and rail"),
    "vertical": ("N", "vertical force on the wheel, perpendicular to the track"),
    "lateral": ("N", "lateral force on the wheel, positive towards the middle of the track"),
    "estimate_lateral": ("N", "estimated error of the lateral force"),
    "angle": ("deg", "change of the rail's inclination across the main patch"),
    "a": ("mm", "half-length of the main patch along the rail"),
    "b": ("mm", "half-width of the main patch, arc length"),
    "seconds": ("s", "time of the solution, without C"),
}
OF_PATCH = {  # of each patch of a contact, by growing arc length of the rail: unit, meaning
    "normal_force": ("N", "force along the normals of the patch"),
    "share": ("1", "share of the vertical load that the patch carries"),
    "p_max": ("MPa", "largest pressure of the patch"),
    "angle": ("deg", "contact angle to the track plane, mean weighted with pressures, positive on a flange"),
    "centre": ("mm", "centre of pressure of the patch, arc length on the rail from its top"),
    "start": ("mm", "end of the patch on the gauge side, arc length on the rail from its top"),
    "end": ("mm", "end of the patch on the field side, arc length on the rail from its top"),
    "half_length": ("mm", "half-length of the patch along the rail"),
    "area": ("mm2", "area of the patch"),
}
PATCH = "patch_"  # before these names


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

    @property
    def request(self) -> ContactRequest:
        """What each contact is solved for."""
        contact = self.specification.contact
        return ContactRequest(
            contact.load, contact.ics, contact.elements, contact.c_above_deg, contact.planar
        )

    def facts(self, side: SideName) -> list[object]:
        """Return all of a side on which its contacts depend."""
        k, both = SIDES.index(side), self.layout.side(side)
        rail, wheel = self.specification.rails[k], self.specification.wheels[k]
        curves = both.rail.curve, both.wheel.curve
        points = [np.round(curve.position(np.linspace(0, curve.length, 2001)), 9) for curve in curves]
        materials = [(table.E, table.nu) for table in (rail, wheel)]
        tables = self.specification.track, self.specification.wheelset, self.specification.contact
        return [points, materials, [table.model_dump() for table in tables], wheel.flange_back]


def contacts(
    study: Study, positions: dict[float, Position], refused: dict[str, str]
) -> Iterator[tuple[tuple[float, SideName], xr.Dataset]]:
    """Yield all contacts by shift and side; where sides are alike, one stands for both at opposite shifts."""
    solved = dict[tuple[float, SideName], xr.Dataset | None]()
    for count, (shift, position) in enumerate(positions.items(), start=1):
        for side in SIDES:
            mirrored: tuple[float, SideName] = (-shift, "left" if side == "right" else "right")
            if study.alike and mirrored in solved and is_mirrored(positions, shift):
                entry = solved[mirrored]
                if entry is None:
                    refused[f"{shift:g}, {side}"] = refused[f"{mirrored[0] + 0.0:g}, {mirrored[1]}"]  # no -0
            else:
                label = f"shift {shift:g} mm ({count} of {len(positions)}), {side}"
                try:
                    entry = _solve_or_load(study, Place(study.layout, position, side), label)
                except Failure as failure:
                    entry, refused[f"{shift:g}, {side}"] = None, str(failure)
                    study.options.watch.on_stage(f"{label} is left out: {failure}")
            solved[shift, side] = entry
            if entry is not None:
                yield (shift, side), entry


def is_mirrored(positions: Mapping[float, Position], shift: float) -> bool:
    """Whether the wheelset at the opposite shift is rolled to the other side; given rolls need not be."""
    return abs(positions[-shift].roll + positions[shift].roll) <= SAME_ROLL


def _solve_or_load(study: Study, where: Place, label: str) -> xr.Dataset:
    """Return a contact as a dataset, from the store where it is there. Raises Failure."""
    k, options = SIDES.index(where.side), study.options
    rail, wheel = study.specification.rails[k], study.specification.wheels[k]
    code = results_digest()
    at = where.position.given_shift, where.position.roll
    key = options.store.key("shift", code, study.facts(where.side), at, where.side)
    if (entry := options.store.get(key)) is not None:
        options.watch.on_stage(f"{label}: stored by an earlier run")
        return entry
    start = perf_counter()
    entry = _entry(contact_at(where, rail, wheel, study.request, without_grid_reports(options)))
    options.watch.on_stage(f"{label}: {_pressure_text(entry)}, {perf_counter() - start:.1f} s")
    options.store.put(key, entry)
    return entry


def without_grid_reports(options: RunOptions) -> RunOptions:
    """Return options without reports of grids; models of C are reported."""
    return replace(options, watch=replace(options.watch, on_stage=lambda _: None))


def _pressure_text(entry: xr.Dataset) -> str:
    """Return the largest pressures in words."""
    return ", ".join(
        f"{name} {value:.0f} MPa" for name, value in zip(entry.ics.values, entry.p_max.values, strict=True)
    )


def _entry(contact: SideContact) -> xr.Dataset:
    """Return a contact as a dataset over its ICs."""
    rows = contact.numbers
    numbers = {name: ("ics", [float(getattr(row, name)) for row in rows]) for name in NUMBERS}
    outlines = np.stack([_outline(row) for row in rows])
    most = max(len(row.patches) for row in rows)
    of_patches = {
        PATCH + name: (
            ("ics", "patch"),
            np.array([_pad([_of_patch(patch, name) for patch in row.patches], most) for row in rows]),
        )
        for name in OF_PATCH
    }
    return xr.Dataset(
        numbers
        | of_patches
        | {
            "patches": ("ics", [float(len(row.patches)) for row in rows]),
            "beside": ("ics", [1 - max(patch.share for patch in row.patches) for row in rows]),
            "outline_s": (("ics", "point"), outlines[:, 0]),
            "outline_x": (("ics", "point"), outlines[:, 1]),
        },
        coords={"ics": [row.ics for row in rows]},
        attrs={
            "notes": "; ".join(contact.notes),
            "grid": "; ".join(
                f"{grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm"
                for grid in contact.grids
            ),
            "grids": [
                float(value)
                for grid in contact.grids
                for value in (grid.n_x, grid.n_s, grid.dx, grid.ds, grid.s)
            ],
            "steepest": contact.steepest,
        },
    )


def grids_in(entry: xr.Dataset) -> tuple[Grid, ...]:
    """Return the grids of a stored contact."""
    rows = np.reshape(entry.attrs["grids"], (-1, 5))
    return tuple(Grid(int(n_x), int(n_s), float(dx), float(ds), float(s)) for n_x, n_s, dx, ds, s in rows)


def _of_patch(patch: PatchNumbers, name: str) -> float:
    """Return a number of a patch by its name in `OF_PATCH`, arc lengths from the start of the profile."""
    if name in {"start", "end"}:
        return patch.s[name == "end"]
    value = float(getattr(patch, name))
    return float(np.degrees(value)) if name == "angle" else value


def _pad(values: list[float], length: int) -> list[float]:
    """Return values with NaN behind them."""
    return values + [np.nan] * (length - len(values))


def _outline(row: ICsNumbers) -> Array:
    """Return the outlines of all patches, NaN between them, as arc lengths of the rail and x, (2, POINTS)."""
    gap = np.full((2, 1), np.nan)
    closed = [
        np.concatenate([patch.outline, patch.outline[:, ::-1] * [[1.0], [-1.0]], gap], axis=1)
        for patch in row.patches
    ]
    points = np.concatenate(closed, axis=1)
    if points.shape[1] > POINTS:  # every second strip
        return _outline(replace(row, patches=tuple(_thin(patch) for patch in row.patches)))
    return np.pad(points, ((0, 0), (0, POINTS - points.shape[1])), constant_values=np.nan)


def _thin(patch: PatchNumbers) -> PatchNumbers:
    """Return a patch with every second point of its outline, and the ends."""
    outline = patch.outline
    inner = outline[:, 1:-1][:, ::2]
    return replace(patch, outline=np.concatenate([outline[:, :1], inner, outline[:, -1:]], axis=1))


def label_contacts(study: Study, solved: dict[tuple[float, SideName], xr.Dataset]) -> xr.Dataset:
    """Return numbers and outlines of all contacts by shift, side and ICs; outlines from the rails' tops."""
    shifts = study.specification.shifts
    names = [*dict.fromkeys(str(name) for entry in solved.values() for name in entry.ics.values)]
    tops = {side: top_of(study.layout, side) for side in SIDES}
    shape = len(shifts), 2, len(names)
    most = max((entry.sizes["patch"] for entry in solved.values()), default=1)
    values = {name: np.full(shape, np.nan) for name in (*NUMBERS, "patches", "beside")}
    outlines = {name: np.full((*shape, POINTS), np.nan) for name in ("outline_s", "outline_x")}
    of_patches = {PATCH + name: np.full((*shape, most), np.nan) for name in OF_PATCH}
    grids = np.full(shape[:2], "", dtype=object)
    for (shift, side), entry in solved.items():
        k, m = shifts.index(shift), SIDES.index(side)
        grids[k, m] = entry.attrs["grid"]
        for n, name in enumerate(names):
            if name in entry.ics.values:
                own = entry.sel(ics=name)
                for key, array in (values | outlines).items():
                    array[k, m, n] = own[key].values
                for key, array in of_patches.items():
                    array[k, m, n, : entry.sizes["patch"]] = own[key].values
        outlines["outline_s"][k, m] -= tops[side]
        for name in ("centre", "start", "end"):
            of_patches[PATCH + name][k, m] -= tops[side]
    units = NUMBERS | {
        "patches": ("1", "number of patches"),
        "beside": ("1", "share of the load beside the main patch"),
    }
    dims = "shift", "side", "ics"
    return xr.Dataset(
        {
            name: (dims, array, {"units": units[name][0], "long_name": units[name][1]})
            for name, array in values.items()
        }
        | {
            name: ((*dims, "point"), array, {"units": "mm", "long_name": meaning})
            for (name, array), meaning in zip(
                outlines.items(),
                (
                    "outline of the patches: arc length on the rail from its top",
                    "outline of the patches: along the rail",
                ),
                strict=True,
            )
        }
        | {
            PATCH + name: ((*dims, "patch"), of_patches[PATCH + name], {"units": unit, "long_name": meaning})
            for name, (unit, meaning) in OF_PATCH.items()
        }
        | {"grid": (dims[:2], grids.astype(str))},
        coords={
            "shift": list(shifts),
            "side": list(SIDES),
            "ics": names,
            "patch": np.arange(1, most + 1),
        },
    )
