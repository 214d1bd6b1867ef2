"""All contacts of a wheelset without friction over its shifts, as datasets. Finished ones are stored."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import xarray as xr

from compare.shifts.geometry import SIDES, top_of
from femic.cache.digests import results_digest
from femic.reference.run_options import RunOptions
from femic.shifts.contact import contact_at
from femic.shifts.frictionless import ICsNumbers, SideContact
from femic.shifts.patches import PatchNumbers
from femic.shifts.sides import Place, Wanted
from femic.shifts.specification import ShiftsFile
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.track.layout import Layout
from geometries.track.wheelset import Position, SideName, side_of

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
    def wanted(self) -> Wanted:
        """What each contact is solved for."""
        contact = self.specification.contact
        return Wanted(contact.load, contact.ics, contact.elements, contact.c_above_deg, contact.planar)

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
            if study.alike and mirrored in solved:
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


def _stored(study: Study, where: Place, label: str) -> xr.Dataset:
    """Return a contact as a dataset, from the store where it is there. Raises Failure."""
    k, options = SIDES.index(where.side), study.options
    rail, wheel = study.specification.rails[k], study.specification.wheels[k]
    code = results_digest("femic.shifts.contact")
    key = options.store.key("shift", code, study.facts(where.side), where.position.given_shift, where.side)
    if (entry := options.store.get(key)) is not None:
        options.watch.on_stage(f"{label}: stored by an earlier run")
        return entry
    start = perf_counter()
    entry = _entry(contact_at(where, rail, wheel, study.wanted, quiet(options)))
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
            "elements": [contact.grid.n_x, contact.grid.n_s],
            "lengths": [contact.grid.dx, contact.grid.ds, contact.grid.s],
            "load": contact.load,
            "steepest": contact.steepest,
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


def labelled(study: Study, solved: dict[tuple[float, SideName], xr.Dataset]) -> xr.Dataset:
    """Return numbers and outlines of all contacts by shift, side and ICs; outlines from the rails' tops."""
    shifts = study.specification.shifts
    names = [*dict.fromkeys(str(name) for entry in solved.values() for name in entry.ics.values)]
    tops = {side: top_of(study.layout, side) for side in SIDES}
    shape = len(shifts), 2, len(names)
    values = {name: np.full(shape, np.nan) for name in (*NUMBERS, "patches", "beside")}
    outlines = {name: np.full((*shape, POINTS), np.nan) for name in ("outline_s", "outline_x")}
    grids = np.full(shape[:2], "", dtype=object)
    for (shift, side), entry in solved.items():
        k, m = shifts.index(shift), SIDES.index(side)
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
        coords={"shift": list(shifts), "side": list(SIDES), "ics": names},
    )
