"""Charts of a wheelset over its shifts: pressures, angles, radii, and where wheels touch their rails.

Results are compared with those with the best ICs of each contact: C, or else B-hat.
"""

import itertools
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import INK, Look, drawing_order, ics_looks, ics_symbol
from compare.report.tables import number_text
from compare.report.thinning import thin
from compare.report.verdicts import NO, NOT_DECIDED, YES, decide
from femic.contact.datasets import CHANGE, FLOOR, LARGER, MISSED, estimate_of_difference
from femic.contact.pairs.planar import PLANAR
from geometries.arrays import Array

# --- differences to the best ICs ------------------------------------------------------------------------


ORDER = ("C", "Bhat")  # the best first; then the last of the others
LIMITS = (0.01, 0.05, 0.10)
REFERENCE, DIFFERENCE, ESTIMATE = "reference_", "difference_", "estimate_of_difference_"  # before names


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
    return _with_ics(dataset[quantity], reference_names(dataset, quantity))


def _with_ics(values: xr.DataArray, names: xr.DataArray) -> xr.DataArray:
    """Return values with the ICs that are named for each contact, NaN where there are none."""
    return values.where(values.ics == names).max("ics")


def reference_names(dataset: xr.Dataset, quantity: str = "p_max") -> xr.DataArray:
    """Return the names of the best ICs of each contact, empty where there is none."""
    if (known := dataset.get(REFERENCE + quantity)) is not None:
        return known
    result = xr.full_like(dataset[quantity].isel(ics=0, drop=True), "", dtype=object)
    for name in reversed(rank_ics(dataset)):
        result = result.where(np.isnan(dataset[quantity].sel(ics=name, drop=True)), name)
    return result


def with_differences(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with references, differences and their estimates, which a page needs often."""
    quantities = [quantity for quantity in (P_MAX, *OF_ROLLING) if quantity.name in dataset]
    found = {
        f"{prefix}{quantity.name}": find(dataset, quantity)
        for prefix, find in FOUND_ONCE.items()
        for quantity in quantities
    }
    return dataset.assign(found)


def difference(dataset: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> xr.DataArray:
    """Return a quantity with some ICs less that with the best of each contact, as a share.

    Over shift and side; NaN where these ICs are the best themselves.
    """
    known = dataset.get(DIFFERENCE + quantity.name)
    return (_differences(dataset, quantity) if known is None else known).sel(ics=ics, drop=True)


def difference_estimate(dataset: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> xr.DataArray:
    """Return the estimated error of `difference`, by how it changes with elements, states and ICs.

    Much of the error of both contacts is the same, as they have the same elements (`femic.contact.datasets`).
    Planar contact has elements of its own: there the errors of both add.
    """
    known = dataset.get(ESTIMATE + quantity.name)
    return (_difference_estimates(dataset, quantity) if known is None else known).sel(ics=ics, drop=True)


def _differences(dataset: xr.Dataset, quantity: Quantity) -> xr.DataArray:
    """Return `difference` of all ICs."""
    best = reference_names(dataset, quantity.name)
    return _less_the_best(dataset[quantity.name], best, _friction_limit(dataset, quantity))


def _difference_estimates(dataset: xr.Dataset, quantity: Quantity) -> xr.DataArray:
    """Return `difference_estimate` of all ICs."""
    name, scale = quantity.name, _friction_limit(dataset, quantity)
    best, known = reference_names(dataset, name), dataset[f"estimate_{name}"]
    varied = dataset[[prefix + name for prefix in ("", LARGER, CHANGE, FLOOR, MISSED)]]
    result = estimate_of_difference(varied, lambda contacts: _less_the_best(contacts[name], best, scale))
    both = (_with_ics(known, best) + known) / (scale or abs(reference_values(dataset, name)))
    return result.where(dataset.ics != PLANAR, both)


def _less_the_best(values: xr.DataArray, best: xr.DataArray, scale: float | None) -> xr.DataArray:
    """Return values less those with the `best` ICs, over these or over a scale."""
    reference = _with_ics(values, best)
    return ((values - reference) / (scale or reference)).where(values.ics != best)


FOUND_ONCE = {
    REFERENCE: lambda dataset, quantity: reference_names(dataset, quantity.name),
    DIFFERENCE: _differences,
    ESTIMATE: _difference_estimates,
}


def _friction_limit(dataset: xr.Dataset, quantity: Quantity) -> float | None:
    """Return friction times load where differences of a quantity are shares of it."""
    return dataset.attrs["friction"] * dataset.attrs["load"] if quantity.is_friction_share else None


def decisions(dataset: xr.Dataset, ics: str, limit: float, quantity: Quantity = P_MAX) -> xr.DataArray:
    """Return for each shift whether ICs are within a limit of the best on both wheels, as `decide` says.

    Wheels without a difference do not count; empty where nothing was compared.
    """
    off, estimate = abs(difference(dataset, ics, quantity)), difference_estimate(dataset, ics, quantity)
    each = off.copy(data=decide(off, estimate.transpose(*off.dims), limit))
    words = [
        next((word for word in (NO, NOT_DECIDED, YES) if (each.sel(shift=at) == word).any()), "")
        for at in each["shift"].values
    ]
    return xr.DataArray(np.array(words, dtype=object), coords={"shift": each["shift"]})


def compared_ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with better ones: half-spaces first, planar contact last."""
    names = [*reversed(rank_ics(dataset)), *(PLANAR for name in dataset.ics.values if name == PLANAR)]
    return [name for name in names if np.isfinite(difference(dataset, name)).any()]


def reference_label(dataset: xr.Dataset, quantity: str = "p_max", ics: str = "") -> str:
    """Return the best ICs in words: all that are a reference anywhere, or only that of some ICs."""
    names = reference_names(dataset, quantity)
    if ics:
        names = names.where(dataset[quantity].sel(ics=ics, drop=True).notnull(), "")
    used = [name for name in rank_ics(dataset) if name != ics and np.any(names.values == name)]
    first, *others = map(ics_symbol, used or rank_ics(dataset)[:1])
    return f"{first} (elsewhere {', '.join(others)})" if others else first


# --- where on the wheel a patch lies ---------------------------------------------------------------------


TREAD, ROOT, FLANGE = "tread", "flange root", "flange"
ROOT_ANGLE = 10.0  # deg from which on the wheel's profile is its flange root
FACE = 5.0  # deg below the steepest inclination from which on it is the flange
LEAST_FLANGE = 30.0  # deg: a wheel without a place as steep has no flange
FLANGE_WIDTH = 50.0  # mm from the tip of the flange within which it and its root lie
CHORD = 2  # points before and behind, between which inclinations of drawn profiles are taken


def flange_limits(dataset: xr.Dataset, side: str) -> tuple[float, float] | None:
    """Return where on a wheel its flange and its flange root end, coming from the tip: y [mm] of its axes.

    None where it has no flange.
    """
    y, z = dataset[f"wheel_{side}"].values
    tip = int(np.argmin(z))
    rise = np.full(len(y), -90.0)
    along, up = y[2 * CHORD :] - y[: -2 * CHORD], z[2 * CHORD :] - z[: -2 * CHORD]
    rise[CHORD:-CHORD] = np.degrees(np.arctan2(up, along))
    front = (np.arange(len(y)) > tip) & (y <= y[tip] + FLANGE_WIDTH)
    steepest = float(np.max(rise[front], initial=-90.0))
    if steepest < LEAST_FLANGE:
        return None
    flange, root = (
        float(y[np.flatnonzero(front & (rise >= least))[-1]]) for least in (steepest - FACE, ROOT_ANGLE)
    )
    return flange, root


def patch_zones(dataset: xr.Dataset, shift: float, side: str) -> list[str]:
    """Return where on the wheel each patch of a contact lies, with its best ICs, the gauge side first."""
    best = str(reference_names(dataset).sel(shift=shift, side=side).item())
    if not best:
        return []
    at = dataset[["patch_centre", "roll", "axle_shift", "height"]].sel(shift=shift)
    centres = at.patch_centre.sel(side=side, ics=best).dropna("patch").values
    limits = flange_limits(dataset, side)
    if limits is None:
        return [TREAD] * len(centres)
    y, z = (
        np.interp(centres, _rail_lengths(dataset, side), dataset[f"rail_{side}"].values[k]) for k in (0, 1)
    )
    sign = 1 if side == "left" else -1
    roll = sign * float(at["roll"]) / 1e3
    on_wheel = np.cos(roll) * (y - sign * float(at.axle_shift)) + np.sin(roll) * (z - float(at.height))
    return [FLANGE if at_y < limits[0] else ROOT if at_y < limits[1] else TREAD for at_y in on_wheel]


def zones(dataset: xr.Dataset, side: str) -> list[str]:
    """Return for each shift where the patch nearest to the flange lies; empty where there is no contact."""
    return [next(iter(patch_zones(dataset, shift, side)), "") for shift in dataset["shift"].values]


def _rail_lengths(dataset: xr.Dataset, side: str) -> Array:
    """Return the arc lengths of the points of a rail from its top [mm]."""
    rail = dataset[f"rail_{side}"].values
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rail, axis=1)))])
    return np.asarray(s - s[np.argmax(rail[1])])


# --- charts ---------------------------------------------------------------------------------------------


SHIFT = "shift to the left [mm]"
STEEL, TYRE, PATCH = Look(INK, width=1.8), Look("#0072b2", width=1.8), Look("#d55e00", width=5.0)
POINT = Look("#d55e00", "", "circle")
SIDE_LOOKS = {"left": Look("#0072b2", "solid", "circle"), "right": Look("#d55e00", "dash", "square")}
CONE = Look("#808080", "dot", width=1.2)
WRITTEN, FURTHER = Look(INK, ""), Look(INK, "", "circle-open")
NEAR = Look(INK, "solid", width=1.0)
ACROSS, ABOVE, BELOW = 62.0, 22.0, 46.0  # mm of the drawn sections beside the rail's top, above and below it
BESIDE = 2.0  # mm of the drawn rail beside patches
HIGH = 30.0  # mm above the rail tops up to which wheels are drawn
FINE = 0.02  # mm that drawn profiles and outlines may deviate from all of their points


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
    """Return a quantity of both sides over the shift with its estimates, and its differences with theirs."""
    sides = [str(side) for side in dataset.side.values]
    share = " of friction × load" if quantity.is_friction_share else ""
    up = f"{quantity.symbol} less that with {reference_label(dataset, quantity.name)} [%{share}]"
    panels = []
    for side in sides:
        curves = _by_ics(dataset.sel(side=side), quantity.name, quantity.per_unit)
        if quantity is P_MAX:
            curves += _further_patches(dataset, side)
        panel = Panel(f"{side} wheel", SHIFT, quantity.label, curves)
        panels.append(_with_zones(panel, dataset, side, named=True))
    for side in sides:
        curves = _difference_curves(dataset, quantity, side)
        title, levels = f"{side} wheel, difference", (-5.0, -1.0, 1.0, 5.0)
        if curves:
            panel = Panel(title, SHIFT, up, curves, levels=levels)
            panels.append(_with_zones(panel, dataset, side, named=False))
    return panels


def _difference_curves(dataset: xr.Dataset, quantity: Quantity, side: str) -> list[Curve]:
    looks, curves = ics_looks(dataset.ics.values), []
    for name in drawing_order(dataset.ics.values):
        off, estimate = (
            100 * one(dataset, name, quantity).sel(side=side).values
            for one in (difference, difference_estimate)
        )
        if np.isfinite(off).any():
            curves.append(
                Curve(ics_symbol(name), dataset["shift"].values, off, looks[name], estimate, bars=True)
            )
    return curves


def _further_patches(dataset: xr.Dataset, side: str) -> list[Curve]:
    """Return the largest pressure of each patch but that with the largest of its contact, best ICs."""
    at, values = [], []
    for shift, best in zip(
        dataset["shift"].values, reference_names(dataset).sel(side=side).values, strict=True
    ):
        if best:
            own = np.sort(dataset.patch_p_max.sel(shift=shift, side=side, ics=best).dropna("patch").values)
            at += [shift] * (len(own) - 1)
            values += own[:-1].tolist()
    return [Curve("further patches", at, values, FURTHER)] if at else []


def _with_zones(panel: Panel, dataset: xr.Dataset, side: str, *, named: bool) -> Panel:
    """Return a panel with dotted lines half way between shifts where another part of the wheel is reached.

    Where they are named, beside each line at the top stands the part that follows. Wheels without a flange
    have no parts.
    """
    known = zip(dataset["shift"].values, zones(dataset, side), strict=True)
    own = [(float(shift), zone) for shift, zone in known if zone]
    if flange_limits(dataset, side) is None or not own:
        return panel
    pairs = itertools.pairwise(own)
    changes = [((first + second) / 2, zone) for (first, before), (second, zone) in pairs if zone != before]
    places, names = zip(own[0], *changes, strict=True)
    uppermost = [curve.points[1] if curve.band is None else curve.band_edges[1] for curve in panel.curves]
    top = float(np.nanmax(np.concatenate(uppermost)))
    written = [Curve("", places, [top] * len(places), WRITTEN, names=names)] if named else []
    return replace(panel, curves=[*panel.curves, *written], marks=places[1:])


def _by_ics(dataset: xr.Dataset, name: str, per_unit: float) -> list[Curve]:
    """Return a number over the shift with all ICs, with its estimates as bars."""
    looks, curves = ics_looks(dataset.ics.values), []
    for ics in drawing_order(dataset.ics.values):
        values, estimate = (per_unit * dataset[key].sel(ics=ics).values for key in (name, f"estimate_{name}"))
        if np.isfinite(values).any():
            symbol = ics_symbol(ics)
            curves.append(Curve(symbol, dataset["shift"].values, values, looks[ics], estimate, bars=True))
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


def shift_text(shift: float | xr.DataArray) -> str:
    """Return a shift with its unit."""
    return f"{number_text(shift, 'g')} mm"


def places(dataset: xr.Dataset) -> Chart:
    """Return sections of both wheels on their rails with their patches, and the patches, a step per shift.

    The shift of the largest pressure is shown first.
    """
    steps, sides = {}, [str(side) for side in dataset.side.values]
    standing = dataset.isel(shift=dataset["roll"].notnull().values)
    for shift in standing["shift"].values:
        at = standing.sel(shift=shift)
        sections = [_section(dataset, at, side) for side in sides]
        steps[shift_text(shift)] = [*sections, *(_patches(dataset, at, side) for side in sides)]
    worst = dataset.p_max.max(["side", "ics"]).idxmax("shift")
    start = shift_text(standing["shift"].sel(shift=worst, method="nearest"))
    return Chart("touching", steps, 2, "shift", 1.15, start, alt="Where wheels touch their rails")


def _section(dataset: xr.Dataset, at: xr.Dataset, side: str) -> Panel:
    """Return the section of a side seen along the track, with its patches with the best ICs.

    The left wheel is at the left.
    """
    rail, wheel = dataset[f"rail_{side}"].values, wheel_in_place(dataset, at, side)
    top = float(rail[0, np.argmax(rail[1])])
    curves = []
    for label, points, look in (("rail", rail, STEEL), ("wheel", wheel, TYRE)):
        y, z = points
        seen = (abs(y - top) <= ACROSS + BESIDE) & (z >= -BELOW - BESIDE) & (z <= HIGH)
        drawn = thin(np.where(seen, y, np.nan), np.where(seen, z, np.nan), FINE)
        curves.append(Curve(label, *drawn, look))
    s = _rail_lengths(dataset, side)
    for start, end in patch_ranges(at, side):
        within = np.concatenate([[start], s[(s > start) & (s < end)], [end]])
        drawn = thin(np.interp(within, s, rail[0]), np.interp(within, s, rail[1]), FINE)
        curves.append(Curve("patch", *drawn, PATCH))
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
        s, x = thin(own.outline_s.sel(ics=name).values, own.outline_x.sel(ics=name).values, FINE)
        if len(s):
            curves.append(Curve(ics_symbol(name), s, x, replace(looks[name], marker="")))
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
