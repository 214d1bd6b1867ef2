"""All contacts of a wheelset without friction over its shifts, as datasets. Finished ones are stored."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import xarray as xr

from compare.shifts.geometry import SIDES, top_of
from femic.cache.digests import results_digest
from femic.reference.run_options import RunOptions
from femic.shifts.contact import ICsNumbers, SideContact, contact_at
from femic.shifts.patches import PatchNumbers
from femic.shifts.sides import ContactRequest, Place
from femic.shifts.specification import ShiftsFile
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.track.layout import Layout
from geometries.track.wheelset import Position, SideName, side_of

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
        k, both = SIDES.index(side), side_of(self.layout, side)
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
                    entry = _stored(study, Place(study.layout, position, side), label)
                except Failure as failure:
                    entry, refused[f"{shift:g}, {side}"] = None, str(failure)
                    study.options.watch.on_stage(f"{label} is left out: {failure}")
            solved[shift, side] = entry
            if entry is not None:
                yield (shift, side), entry


def is_mirrored(positions: Mapping[float, Position], shift: float) -> bool:
    """Whether the wheelset at the opposite shift is rolled to the other side; given rolls need not be."""
    return abs(positions[-shift].roll + positions[shift].roll) <= SAME_ROLL


def _stored(study: Study, where: Place, label: str) -> xr.Dataset:
    """Return a contact as a dataset, from the store where it is there. Raises Failure."""
    k, options = SIDES.index(where.side), study.options
    rail, wheel = study.specification.rails[k], study.specification.wheels[k]
    code = results_digest("femic.shifts.contact")
    at = where.position.given_shift, where.position.roll
    key = options.store.key("shift", code, study.facts(where.side), at, where.side)
    if (entry := options.store.get(key)) is not None:
        options.watch.on_stage(f"{label}: stored by an earlier run")
        return entry
    start = perf_counter()
    entry = _entry(contact_at(where, rail, wheel, study.request, quiet(options)))
    options.watch.on_stage(f"{label}: {_told(entry)}, {perf_counter() - start:.1f} s")
    options.store.put(key, entry)
    return entry


def quiet(options: RunOptions) -> RunOptions:
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
    most = max(len(row.patches) for row in rows)
    of_patches = {
        PATCH + name: (
            ("ics", "patch"),
            np.array([_padded([_of_patch(patch, name) for patch in row.patches], most) for row in rows]),
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


def _padded(values: list[float], length: int) -> list[float]:
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
        return _outline(replace(row, patches=tuple(_thinned(patch) for patch in row.patches)))
    return np.pad(points, ((0, 0), (0, POINTS - points.shape[1])), constant_values=np.nan)


def _thinned(patch: PatchNumbers) -> PatchNumbers:
    """Return a patch with every second point of its outline, and the ends."""
    outline = patch.outline
    inner = outline[:, 1:-1][:, ::2]
    return replace(patch, outline=np.concatenate([outline[:, :1], inner, outline[:, -1:]], axis=1))


def labelled(study: Study, solved: dict[tuple[float, SideName], xr.Dataset]) -> xr.Dataset:
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
