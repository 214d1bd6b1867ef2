"""All contacts of a wheelset over its lateral shifts, as one labelled dataset, `shifts.nc`.

Finished contacts are stored: an interrupted run goes on with the next one.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest, versions
from femic.reference.run_options import DEFAULT, RunOptions
from femic.shifts.contact import contact_at
from femic.shifts.frictionless import ICsNumbers, SideContact
from femic.shifts.patches import PatchNumbers
from femic.shifts.placement import layout_of, sections_of, understood
from femic.shifts.sides import Place, Wanted
from femic.shifts.specification import ShiftsFile
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.track.conicity import equivalent_conicity
from geometries.track.layout import Layout
from geometries.track.shifts import Shifts, over_shifts
from geometries.track.wheelset import Position, RollRule, SideName, Touch, settle, side_of

SIDES: tuple[SideName, SideName] = ("left", "right")
ABOUT: RollRule = "about rails"  # shifts are those at the rails: flanges of any slope are reached
SECOND = 0.5  # mm: touching points with a distance below this are stated
BEYOND = 0.5  # mm beyond the amplitude of the conicity, up to which shifts are taken for it
STEP = 0.5  # mm between these shifts
DRAWN = 0.25  # mm between points of the sections that are drawn
POINTS = 400  # of the outlines of patches
NUMBERS = {  # of a contact, by name: unit and meaning
    "p_max": ("MPa", "largest pressure"),
    "estimate_p_max": ("MPa", "estimated error of p_max by the size of elements"),
    "approach": ("mm", "approach of wheel and rail"),
    "vertical": ("N", "vertical force on the wheel, perpendicular to the track"),
    "lateral": ("N", "lateral force on the wheel, positive towards the middle of the track"),
    "angle": ("deg", "change of the rail's inclination across the main patch"),
    "a": ("mm", "half-length of the main patch along the rail"),
    "b": ("mm", "half-width of the main patch, arc length"),
    "seconds": ("s", "time of the solution, without C"),
}
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


def compute_shifts(specification: ShiftsFile, text: str = "", options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return positions and contacts at all shifts of a specification; raises WrongInput before any contact.

    Shifts at which the wheelset cannot stand, and contacts that are not found, are NaN, with the reasons in
    the attribute `refused`.
    """
    start = perf_counter()
    sections = sections_of(specification)
    layout = layout_of(specification, sections)
    positions, refused = _positions(layout, specification)
    contacts = dict(_contacts(layout, specification, positions, refused, options))
    dataset = xr.merge(
        [
            _wheelset(specification, positions),
            _touching(layout, specification, positions),
            _labelled(layout, specification, contacts),
            _sections(layout),
            _conicity(layout, specification, options),
        ],
        compat="no_conflicts",
        join="outer",
        combine_attrs="no_conflicts",
    )
    return dataset.assign_attrs(
        title=specification.title or f"{sections[2].name} on {sections[0].name}",
        load=specification.contact.load,
        alike=int(_alike(specification)),
        refused=json.dumps(refused),
        notes=json.dumps(understood(sections, layout)),
        neglected=json.dumps(
            {
                f"{shift:g}, {side}": contact.attrs["notes"]
                for (shift, side), contact in contacts.items()
                if contact.attrs["notes"]
            }
        ),
        specification=text,
        seconds=perf_counter() - start,
        code=results_digest(__name__),
        versions=json.dumps(versions()),
    )


def _positions(layout: Layout, specification: ShiftsFile) -> tuple[dict[float, Position], dict[str, str]]:
    """Return the positions at shifts [mm] at which the wheelset stands, and the reasons for the others."""
    positions, refused = {}, {}
    for shift in specification.shifts:
        try:
            positions[shift] = settle(layout, shift, roll=ABOUT, within=SECOND)
        except Failure as failure:
            refused[f"{shift:g}"] = str(failure)
    if not positions:
        raise Failure(f"shifts: none is possible: {next(iter(refused.values()))}")
    return positions, refused


def _contacts(
    layout: Layout,
    specification: ShiftsFile,
    positions: dict[float, Position],
    refused: dict[str, str],
    options: RunOptions,
) -> Iterator[tuple[tuple[float, SideName], xr.Dataset]]:
    """Yield all contacts by shift and side; where sides are alike, one stands for both at opposite shifts."""
    alike, solved = _alike(specification), dict[tuple[float, SideName], xr.Dataset | None]()
    for count, (shift, position) in enumerate(positions.items(), start=1):
        for side in SIDES:
            mirrored: tuple[float, SideName] = (-shift, "left" if side == "right" else "right")
            if alike and mirrored in solved:
                entry = solved[mirrored]
                if entry is None:
                    refused[f"{shift:g}, {side}"] = refused[f"{mirrored[0]:g}, {mirrored[1]}"]
            else:
                label = f"shift {shift:g} mm ({count} of {len(positions)}), {side}"
                try:
                    entry = _stored(Place(layout, position, side), layout, specification, label, options)
                except Failure as failure:
                    entry, refused[f"{shift:g}, {side}"] = None, str(failure)
            solved[shift, side] = entry
            if entry is not None:
                yield (shift, side), entry


def _stored(
    where: Place, layout: Layout, specification: ShiftsFile, label: str, options: RunOptions
) -> xr.Dataset:
    """Return a contact as a dataset, from the store where it is there. Raises Failure."""
    k = SIDES.index(where.side)
    rail, wheel, contact = specification.rails[k], specification.wheels[k], specification.contact
    side = side_of(layout, where.side)
    curves = side.rail.curve, side.wheel.curve
    facts = [np.round(curve.position(np.linspace(0, curve.length, 2001)), 9) for curve in curves]
    materials = [(table.E, table.nu) for table in (rail, wheel)]
    code = results_digest("femic.shifts.contact")
    dimensions = specification.track.model_dump(), specification.wheelset.model_dump(), contact.model_dump()
    key = options.store.key(
        "shift", code, facts, materials, dimensions, wheel.flange_back, where.position.given_shift, where.side
    )
    if (entry := options.store.get(key)) is not None:
        options.watch.on_stage(f"{label}: stored by an earlier run")
        return entry
    start = perf_counter()
    wanted = Wanted(contact.load, contact.ics, contact.elements, contact.c_above_deg)
    entry = _entry(contact_at(where, rail, wheel, wanted, _quiet(options)))
    options.watch.on_stage(f"{label}: {_told(entry)}, {perf_counter() - start:.1f} s")
    options.store.put(key, entry)
    return entry


def _quiet(options: RunOptions) -> RunOptions:
    """Return options without reports of grids; models of C are reported."""
    return replace(options, watch=replace(options.watch, on_stage=lambda _: None))


def _told(entry: xr.Dataset) -> str:
    """Return the largest pressures in words."""
    return ", ".join(
        f"{name} {value:.0f} MPa" for name, value in zip(entry.ics.values, entry.p_max.values, strict=True)
    )


def _entry(contact: SideContact) -> xr.Dataset:
    """Return a contact as a dataset over its ICs."""
    rows = contact.numbers
    numbers = {name: ("ics", [float(getattr(row, name)) for row in rows]) for name in NUMBERS}
    outlines = np.stack([_outline(row) for row in rows])
    return xr.Dataset(
        numbers
        | {
            "patches": ("ics", [float(len(row.patches)) for row in rows]),
            "beside": ("ics", [1 - max(patch.share for patch in row.patches) for row in rows]),
            "outline_s": (("ics", "point"), outlines[:, 0]),
            "outline_x": (("ics", "point"), outlines[:, 1]),
        },
        coords={"ics": [row.ics for row in rows]},
        attrs={
            "notes": "; ".join(contact.notes),
            "grid": f"{contact.grid.n_x} x {contact.grid.n_s} elements of {contact.grid.dx:.3g} x "
            f"{contact.grid.ds:.3g} mm",
        },
    )


def _outline(row: ICsNumbers) -> Array:
    """Return the outlines of all patches, NaN between them, as arc lengths of the rail and x, (2, POINTS)."""
    gap = np.full((2, 1), np.nan)
    closed = [
        np.concatenate([patch.outline, patch.outline[:, ::-1] * [[1.0], [-1.0]], gap], axis=1)
        for patch in row.patches
    ]
    points = np.concatenate(closed, axis=1)
    if points.shape[1] > POINTS:  # every second strip
        return _outline(replace(row, patches=tuple(_thinned(patch) for patch in row.patches)))
    return np.pad(points, ((0, 0), (0, POINTS - points.shape[1])), constant_values=np.nan)


def _thinned(patch: PatchNumbers) -> PatchNumbers:
    """Return a patch with every second point of its outline, and the ends."""
    outline = patch.outline
    inner = outline[:, 1:-1][:, ::2]
    return replace(patch, outline=np.concatenate([outline[:, :1], inner, outline[:, -1:]], axis=1))


def _wheelset(specification: ShiftsFile, positions: dict[float, Position]) -> xr.Dataset:
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


def _touching(layout: Layout, specification: ShiftsFile, positions: dict[float, Position]) -> xr.Dataset:
    """Return the touching points by shift and side."""
    tops = [_top(layout, side) for side in SIDES]
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


def _top(layout: Layout, side: SideName) -> float:
    """Return the arc length [mm] of the highest point of a rail in its place."""
    rail = side_of(layout, side).rail
    t = np.linspace(*rail.limits, 20001)
    return float(t[np.argmax(rail.position(t)[1])])


def _labelled(
    layout: Layout, specification: ShiftsFile, contacts: dict[tuple[float, SideName], xr.Dataset]
) -> xr.Dataset:
    """Return numbers and outlines of all contacts by shift, side and ICs; outlines from the rails' tops."""
    names = [*dict.fromkeys(str(name) for entry in contacts.values() for name in entry.ics.values)]
    tops = {side: _top(layout, side) for side in SIDES}
    shape = len(specification.shifts), 2, len(names)
    values = {name: np.full(shape, np.nan) for name in (*NUMBERS, "patches", "beside")}
    outlines = {name: np.full((*shape, POINTS), np.nan) for name in ("outline_s", "outline_x")}
    grids = np.full(shape[:2], "", dtype=object)
    for (shift, side), entry in contacts.items():
        k, m = specification.shifts.index(shift), SIDES.index(side)
        grids[k, m] = entry.attrs["grid"]
        for n, name in enumerate(names):
            if name in entry.ics.values:
                own = entry.sel(ics=name)
                for key, array in (values | outlines).items():
                    array[k, m, n] = own[key].values
        outlines["outline_s"][k, m] -= tops[side]
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
        | {"grid": (dims[:2], grids.astype(str))},
        coords={"shift": list(specification.shifts), "side": list(SIDES), "ics": names},
    )


def _sections(layout: Layout) -> xr.Dataset:
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


def _conicity(layout: Layout, specification: ShiftsFile, options: RunOptions) -> xr.Dataset:
    """Return rolling-radius differences about the middle, with both values at jumps, and the conicity."""
    amplitude = specification.conicity_amplitude
    options.watch.on_stage(f"equivalent conicity at {amplitude:g} mm")
    end = amplitude + BEYOND
    try:
        shifts = over_shifts(layout, np.linspace(-end, end, 2 * int(np.ceil(end / STEP)) + 1), roll=ABOUT)
        at, differences = shifts.rolling_radius_differences()
        conicity, reason = equivalent_conicity(at, differences, amplitude).value, ""
    except Failure as failure:
        at, differences, conicity, reason = np.empty(0), np.empty(0), np.nan, str(failure)
        shifts = Shifts((), ())
    return xr.Dataset(
        {"rrd_near": ("near", differences, {"units": "mm"})},
        coords={"near": ("near", at, {"units": "mm"})},
        attrs={
            "conicity": float(conicity),
            "conicity_reason": reason,
            "amplitude": amplitude,
            "jumps": [round(jump.shift, 3) for jump in shifts.jumps],
        },
    )


def _alike(specification: ShiftsFile) -> bool:
    """Whether both sides have the same profiles and materials."""
    return (
        specification.rails[0] == specification.rails[1]
        and specification.wheels[0] == specification.wheels[1]
    )
