"""Charts of a wheelset over its shifts: pressures, angles, radii, and where wheels touch their rails.

Results are compared with those with the best ICs of each contact: C, or else B-hat.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import INK, Look, drawing_order, ics_looks, ics_symbol
from femic.contact.pairs.planar import PLANAR
from geometries.arrays import Array

# --- differences to the best ICs ------------------------------------------------------------------------


ORDER = ("C", "Bhat")  # the best first; then the last of the others
LIMITS = (0.01, 0.05, 0.10)


@dataclass(frozen=True)
class Quantity:
    """A result that is compared: its name in the dataset, symbol, and unit, of which it has `per_unit`.

    `is_friction_share`: whether its differences are shares of friction times load; else of itself.
    """

    name: str
    symbol: str
    unit: str
    form: str
    per_unit: float = 1.0
    is_friction_share: bool = False

    @property
    def label(self) -> str:
        """Symbol and unit."""
        return f"{self.symbol} [{self.unit}]"


P_MAX = Quantity("p_max", "p_max", "MPa", ".0f")
F_X, F_Y = (Quantity(name, name, "kN", ".2f", 1e-3, is_friction_share=True) for name in ("F_x", "F_y"))
WORK = Quantity("work", "work of friction", "J/m", ".1f")
OF_ROLLING = (F_X, F_Y, WORK)


def rank_ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs from the best to the least good as a reference; planar contact is never one."""
    names = [str(name) for name in dataset.ics.values if name != PLANAR]
    best = [name for name in ORDER if name in names]
    return [*best, *(name for name in reversed(names) if name not in best)]


def reference_values(dataset: xr.Dataset, quantity: str) -> xr.DataArray:
    """Return a quantity with the best ICs of each contact, over shift and side."""
    first, *others = rank_ics(dataset)
    values = dataset[quantity].sel(ics=first, drop=True)
    for name in others:
        values = values.fillna(dataset[quantity].sel(ics=name, drop=True))
    return values


def reference_names(dataset: xr.Dataset, quantity: str = "p_max") -> xr.DataArray:
    """Return the names of the best ICs of each contact, empty where there is none."""
    result = xr.full_like(dataset[quantity].isel(ics=0, drop=True), "", dtype=object)
    for name in reversed(rank_ics(dataset)):
        result = result.where(np.isnan(dataset[quantity].sel(ics=name, drop=True)), name)
    return result


def difference(dataset: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> xr.DataArray:
    """Return a quantity with some ICs less that with the best of each contact, as a share.

    Over shift and side; NaN where these ICs are the best themselves.
    """
    own = dataset[quantity.name].sel(ics=ics, drop=True)
    best = reference_values(dataset, quantity.name)
    scale = dataset.attrs["friction"] * dataset.attrs["load"] if quantity.is_friction_share else best
    return ((own - best) / scale).where(reference_names(dataset, quantity.name) != ics)


def compared_ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with better ones: half-spaces first, planar contact last."""
    names = [*reversed(rank_ics(dataset)), *(PLANAR for name in dataset.ics.values if name == PLANAR)]
    return [name for name in names if np.isfinite(difference(dataset, name)).any()]


def reference_label(dataset: xr.Dataset, quantity: str = "p_max") -> str:
    """Return the best ICs in words: all that are a reference anywhere."""
    names = reference_names(dataset, quantity).values
    used = [name for name in rank_ics(dataset) if np.any(names == name)]
    return " or ".join(ics_symbol(name) for name in used)


# --- charts ---------------------------------------------------------------------------------------------


SHIFT = "shift to the left [mm]"
STEEL, TYRE, PATCH = Look(INK, width=1.8), Look("#0072b2", width=1.8), Look("#d55e00", width=5.0)
POINT = Look("#d55e00", "", "circle")
SIDE_LOOKS = {"left": Look("#0072b2", "solid", "circle"), "right": Look("#d55e00", "dash", "square")}
CONE = Look("#808080", "dot", width=1.2)
NEAR = Look(INK, "solid", width=1.0)
ACROSS, ABOVE, BELOW = 62.0, 22.0, 46.0  # mm of the drawn sections beside the rail's top, above and below it
BESIDE = 2.0  # mm of the drawn rail beside patches
HIGH = 30.0  # mm above the rail tops up to which wheels are drawn


def pressures(dataset: xr.Dataset) -> Chart:
    """Return p_max over the shift by side, and below it differences to the best ICs."""
    alt = "Largest pressure against shift, and its differences from the reference"
    return Chart("pressures", {"": _quantity_panels(dataset, P_MAX)}, 2, alt=alt)


def forces(dataset: xr.Dataset) -> Chart:
    """Return creep forces and work of friction over the shift by side, and their differences."""
    steps = {quantity.symbol: _quantity_panels(dataset, quantity) for quantity in OF_ROLLING}
    alt = "Creep forces against shift, and their differences from the reference"
    return Chart("forces", steps, 2, "quantity", start=OF_ROLLING[0].symbol, alt=alt)


def _quantity_panels(dataset: xr.Dataset, quantity: Quantity) -> list[Panel]:
    """Return a quantity of both sides over the shift, and its differences."""
    looks, shift, sides = ics_looks(dataset.ics.values), dataset["shift"].values, dataset.side.values
    off = {name: 100 * difference(dataset, name, quantity) for name in drawing_order(dataset.ics.values)}
    share = " of friction × load" if quantity.is_friction_share else ""
    up = f"{quantity.symbol} less that of {reference_label(dataset, quantity.name)} [%{share}]"
    values = [_by_ics(dataset.sel(side=side), quantity.name, quantity.per_unit) for side in sides]
    differences = [
        [
            Curve(ics_symbol(name), shift, each.sel(side=side).values, looks[name])
            for name, each in off.items()
            if np.isfinite(each.values).any()
        ]
        for side in sides
    ]
    return [
        *(
            Panel(f"{side} wheel", SHIFT, quantity.label, curves)
            for side, curves in zip(sides, values, strict=True)
        ),
        *(
            Panel(f"{side} wheel, difference", SHIFT, up, curves, levels=(-5.0, -1.0, 1.0, 5.0))
            for side, curves in zip(sides, differences, strict=True)
        ),
    ]


def _by_ics(dataset: xr.Dataset, name: str, per_unit: float) -> list[Curve]:
    """Return a number over the shift with all ICs, with its estimates."""
    looks, curves = ics_looks(dataset.ics.values), []
    for ics in drawing_order(dataset.ics.values):
        values, estimate = (per_unit * dataset[key].sel(ics=ics).values for key in (name, f"estimate_{name}"))
        curves.append(Curve(ics_symbol(ics), dataset["shift"].values, values, looks[ics], estimate))
    return curves


def rolling(dataset: xr.Dataset) -> Chart:
    """Return the creepage of the wheelset and its steering moment over the shift."""
    creepage, moment = _by_ics(dataset, "xi_0", 1e3), _by_ics(dataset, "steering", 1e-6)
    panels = [
        Panel("creepage at the nominal radius", SHIFT, "ξ_0 [10⁻³]", creepage),
        Panel("steering moment", SHIFT, "steering moment [kN m]", moment),
    ]
    return Chart("axle", {"": panels}, 2, alt="Creepage and steering moment of the wheelset against shift")


def geometry(dataset: xr.Dataset) -> Chart:
    """Return contact angles, changes of inclination across patches, rolling radii and their difference.

    Differences are left minus right, with those of the equivalent cone.
    """
    shift, panels = dataset["shift"].values, []
    for title, up, values in (
        ("contact angle", "contact angle [deg]", dataset.contact_angle),
        ("inclination change across the patch", "Δδ [deg]", reference_values(dataset, "angle")),
        ("rolling radii", "rolling radius [mm]", dataset.radius),
    ):
        curves = [
            Curve(f"{side} wheel", shift, values.sel(side=side).values, look)
            for side, look in SIDE_LOOKS.items()
        ]
        panels.append(Panel(title, SHIFT, up, curves))
    curves = [Curve("solved shifts", shift, dataset.rrd.values, Look("#009e73", "solid", "diamond"))]
    if dataset.sizes["near"]:
        curves.append(Curve("jumps included", dataset.near.values, dataset.rrd_near.values, NEAR))
    conicity, amplitude = dataset.attrs["conicity"], dataset.attrs["amplitude"]
    if np.isfinite(conicity):
        ends = np.array([-amplitude, amplitude])
        curves.append(Curve(f"cone of {conicity:.3f}", ends, 2 * conicity * ends, CONE))
    panels.append(Panel("rolling-radius difference", SHIFT, "left minus right [mm]", curves))
    return Chart("geometry", {"": panels}, 2, alt="Contact angles and rolling radii over the shift")


def places(dataset: xr.Dataset) -> Chart:
    """Return sections of both wheels on their rails with their patches, and the patches, a step per shift.

    The shift of the largest pressure is shown first.
    """
    steps, sides = {}, [str(side) for side in dataset.side.values]
    standing = dataset.isel(shift=dataset["roll"].notnull().values)
    for shift in standing["shift"].values:
        at = standing.sel(shift=shift)
        sections = [_section(dataset, at, side) for side in sides]
        steps[f"{shift:g} mm"] = [*sections, *(_patches(dataset, at, side) for side in sides)]
    worst = float(dataset.p_max.max(["side", "ics"]).idxmax("shift"))
    start = min(steps, key=lambda label: abs(float(label.split()[0]) - worst))
    return Chart("touching", steps, 2, "shift", 1.15, start, alt="Where wheels touch their rails")


def _section(dataset: xr.Dataset, at: xr.Dataset, side: str) -> Panel:
    """Return the section of a side seen along the track, with its patches with the best ICs.

    The left wheel is at the left.
    """
    rail, wheel = dataset[f"rail_{side}"].values, wheel_in_place(dataset, at, side)
    low = wheel[:, wheel[1] < HIGH]
    top = float(rail[0, np.argmax(rail[1])])
    curves = [Curve("rail", rail[0], rail[1], STEEL), Curve("wheel", low[0], low[1], TYRE)]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rail, axis=1)))])
    s = s - s[np.argmax(rail[1])]
    for start, end in patch_ranges(at, side):
        within = np.concatenate([[start], s[(s > start) & (s < end)], [end]])
        curves.append(Curve("patch", np.interp(within, s, rail[0]), np.interp(within, s, rail[1]), PATCH))
    touching = [float(at.y.sel(side=side))], [float(at.z.sel(side=side))]
    curves.append(Curve("contact point", *touching, POINT))
    angle, radius = (float(at[name].sel(side=side)) for name in ("contact_angle", "radius"))
    return Panel(
        f"{side} wheel: {angle:.1f}°, r = {radius:.2f} mm",
        "distance from the middle of the track [mm]",
        "height [mm]",
        curves,
        to_scale=True,
        limits_x=_from_left(side, top - ACROSS, top + ACROSS),
        limits_y=(-BELOW, ABOVE),
    )


def _from_left(side: str, inner: float, outer: float) -> tuple[float, float]:
    """Return the limits of an axis that grows to the field side, which is at the left of a left rail."""
    return (outer, inner) if side == "left" else (inner, outer)


def wheel_in_place(dataset: xr.Dataset, at: xr.Dataset, side: str) -> Array:
    """Return points of a wheel at a shift in the axes of its side, (2, n) [mm]."""
    sign = 1 if side == "left" else -1
    y, z = dataset[f"wheel_{side}"].values
    roll = sign * float(at["roll"]) / 1e3
    cos, sin = np.cos(roll), np.sin(roll)
    return np.array([cos * y - sin * z + sign * float(at.axle_shift), sin * y + cos * z + float(at.height)])


def patch_ranges(at: xr.Dataset, side: str) -> list[tuple[float, float]]:
    """Return the ranges of the patches of a side with the best ICs: arc lengths from the rail's top [mm]."""
    own = at.sel(side=side)
    known = [name for name in own.ics.values if np.isfinite(own.p_max.sel(ics=name))]
    if not known:
        return []
    s = own.outline_s.sel(ics="C" if "C" in known else known[-1]).values
    parts = np.split(s, np.flatnonzero(np.isnan(s)))
    parts = [part[np.isfinite(part)] for part in parts]
    return [(float(np.min(part)), float(np.max(part))) for part in parts if len(part)]


def _patches(dataset: xr.Dataset, at: xr.Dataset, side: str) -> Panel:
    """Return the outlines of the patches of a side with all ICs; a left rail's field side is at the left."""
    looks = ics_looks(dataset.ics.values)
    own = at.sel(side=side)
    curves = []
    for name in drawing_order(dataset.ics.values):
        s, x = own.outline_s.sel(ics=name).values, own.outline_x.sel(ics=name).values
        last = np.flatnonzero(np.isfinite(s))
        if len(last):
            until = last[-1] + 1
            curves.append(Curve(ics_symbol(name), s[:until], x[:until], replace(looks[name], marker="")))
    span = float(np.nanmax(np.abs(dataset.outline_x.values), initial=10.0))
    known = own.outline_s.values[np.isfinite(own.outline_s.values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (-span, span)
    middle, half = (low + high) / 2, max(span, (high - low) / 2 + BESIDE)
    return Panel(
        f"{side} patch",
        "arc length on the rail from its top [mm]",
        "along the track [mm]",
        curves,
        to_scale=True,
        limits_x=_from_left(side, middle - half, middle + half),
        limits_y=(-span, span),
    )
