"""The numbers of contacts, without and with friction: symbols, units, meanings, estimates of errors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from femic.contact import estimates
from femic.contact.estimates import Kind, Measured, Places, Scale
from femic.contact.patch import Extent, centre_of_pressure
from femic.lazy import lazy_imports

with lazy_imports():
    from femic.contact import frictional, normal
    from femic.contact.pairs import pair_on_grid as pairs

LEAST = 1e-300  # of scales that are divided by
Contact: TypeAlias = "normal.NormalContact | frictional.FrictionalContact"


@dataclass(frozen=True)
class Quantity:
    """A number of a contact: how its error is estimated, and how it is computed.

    `evaluate` is None for numbers of a creep-force curve as a whole.
    """

    symbol: str
    unit: str
    meaning: str
    kind: Kind
    evaluate: Callable[[pairs.PairOnGrid, Any], float] | None = None


def main_patch(contact: Contact) -> Extent:
    """Return the patch with the largest sum of pressures."""
    return max(contact.patches, key=lambda patch: float(np.sum(contact.pressures[patch.elements])))


def s_range(on_grid: pairs.PairOnGrid, contact: Contact) -> tuple[float, float]:
    """Arc lengths [mm] at the ends of the main patch."""
    low, high = main_patch(contact).s
    first, ds = on_grid.grid.strips[0], on_grid.grid.ds
    return float(first + low * ds), float(first + high * ds)


def angle(on_grid: pairs.PairOnGrid, contact: Contact) -> float:
    """Range of the inclination over the main patch [deg]."""
    inclinations = on_grid.undeformed.lower.contour.inclination(np.array(s_range(on_grid, contact)))
    return float(np.degrees(np.ptp(inclinations)))


def half_length(on_grid: pairs.PairOnGrid, contact: Contact) -> float:
    """Return half-length of the main patch along x [mm]."""
    low, high = main_patch(contact).x
    return (high - low) / 2 * on_grid.grid.dx


def half_width(on_grid: pairs.PairOnGrid, contact: Contact) -> float:
    """Return half-width of the main patch along s, on the arc [mm]."""
    low, high = s_range(on_grid, contact)
    return (high - low) / 2


def force(axis: int) -> Callable[[pairs.PairOnGrid, Contact], float]:
    """Return what computes the force on the upper body along an axis [N]."""
    return lambda on_grid, contact: float(on_grid.resultant(contact.tractions).force[axis])


def moment(axis: int) -> Callable[[pairs.PairOnGrid, Contact], float]:
    """Return what computes the moment on the upper body about an axis [N mm]."""
    return lambda on_grid, contact: float(on_grid.resultant(contact.tractions).moment[axis])


def aspect(on_grid: pairs.PairOnGrid, contact: Contact) -> float:
    """Return half-length over half-width of the main patch."""
    return half_length(on_grid, contact) / half_width(on_grid, contact)


def s_centre(on_grid: pairs.PairOnGrid, contact: Contact) -> float:
    """Return the centre of pressure along s [mm]."""
    return centre_of_pressure(contact.pressures, on_grid.grid.strips)


def work(on_grid: pairs.PairOnGrid, contact: frictional.FrictionalContact) -> float:
    """Return the work of friction [N]."""
    return float(np.sum(contact.dissipation) * on_grid.grid.area)


MOMENT_X = "moment on the upper body about the x axis through the contact centre"
MOMENT_Z = "moment on the upper body about the vertical through the contact centre"
SLOPE = "slope of the creep-force curve at zero force"
EQUAL = "creepage at the force for which tractions are compared"
WORK = "work of friction per unit of rolled distance"
ALL: Mapping[str, Quantity] = {  # c: the contact
    "angle": Quantity("Δδ", "deg", "change of inclination across the patch", estimates.WIDTH, angle),
    "a": Quantity("a", "mm", "half-length of the patch along x", estimates.LENGTH, half_length),
    "b": Quantity("b", "mm", "half-width of the patch along s, on the arc", estimates.WIDTH, half_width),
    "aspect": Quantity("a/b", "1", "aspect ratio of the patch", estimates.ASPECT, aspect),
    "p_max": Quantity(
        "p_max", "MPa", "largest pressure", estimates.PRESSURE, lambda _, c: float(np.max(c.pressures))
    ),
    "approach": Quantity("ζ", "mm", "vertical approach", estimates.GIVEN, lambda _, c: c.approach),
    "load": Quantity("N", "N", "vertical load", estimates.GIVEN, lambda _, c: c.load),
    "position": Quantity(
        "y_u",
        "mm",
        "lateral position of the upper body",
        estimates.POSITION,
        lambda at, _: at.undeformed.shift,
    ),
    "F_x": Quantity("F_x", "N", "longitudinal force on the upper body", estimates.LONGITUDINAL, force(0)),
    "F_y": Quantity("F_y", "N", "lateral force on the upper body", estimates.LATERAL, force(1)),
    "M_x": Quantity("M_x", "N mm", MOMENT_X, estimates.ABOUT_X, moment(0)),
    "M_z": Quantity("M_z", "N mm", MOMENT_Z, estimates.ABOUT_Z, moment(2)),
    "s_centre": Quantity("s_c", "mm", "centre of pressure along s", estimates.CENTRE, s_centre),
    "area": Quantity("area", "mm2", "contact area on the lower surface", estimates.AREA, lambda _, c: c.area),
    "stiffness": Quantity(
        "dN/dζ",
        "N/mm",
        "contact stiffness: derivative of load with respect to approach",
        estimates.STIFFNESS,
        lambda _, c: c.stiffness,
    ),
    "sliding_share": Quantity(
        "sliding",
        "1",
        "sliding area divided by contact area",
        estimates.SLIDING,
        lambda _, c: c.sliding_share,
    ),
    "dissipation": Quantity("work", "N", WORK, estimates.WORK, work),
    "xi": Quantity("ξ", "1", "creepage at which these numbers hold", estimates.CREEPAGE),
    "zero_creepage": Quantity("ξ_0", "1", "creepage at zero longitudinal force", estimates.CREEPAGE),
    "slope": Quantity("dF_x/dξ", "N", SLOPE, estimates.SLOPE),
    "equal_creepage": Quantity("ξ_e", "1", EQUAL, estimates.CREEPAGE),
}


def select(*names: str) -> Mapping[str, Quantity]:
    """Return some of `ALL`."""
    return {name: ALL[name] for name in names}


OF_FRICTIONLESS = select(
    *("angle", "a", "b", "aspect", "p_max", "approach", "load", "position", "F_y", "M_x", "s_centre", "area"),
    "stiffness",
)


# --- numbers of a contact, with scales and floors ---


def numbers(
    on_grid: pairs.PairOnGrid, contact: Contact, quantities: Mapping[str, Quantity] = OF_FRICTIONLESS
) -> dict[str, float]:
    """Quantities of a contact of these bodies, on its own grid."""
    own = _on_own_grid(on_grid, contact)
    return {
        name: quantity.evaluate(own, contact) for name, quantity in quantities.items() if quantity.evaluate
    }


def kinds(quantities: Mapping[str, Quantity]) -> dict[str, Kind]:
    """Return how the errors of quantities are estimated."""
    return {name: quantity.kind for name, quantity in quantities.items()}


def measured(
    on_grid: pairs.PairOnGrid,
    contact: Contact,
    quantities: Mapping[str, Quantity] = OF_FRICTIONLESS,
    prescribed: Collection[str] = (),
) -> Measured:
    """Quantities of a contact on its own grid, and the scales and floors of their errors.

    `prescribed` are the names of those that its loading fixes; others that are exact vanish by symmetry.
    """
    own, state, largest_work = _on_own_grid(on_grid, contact), contact.slip_state, contact.largest_work
    contour, strips = own.undeformed.lower.contour, own.grid.strips
    (y, z), (sin, cos) = contour.position(strips), contour.normal(strips)
    at = Places(own.x, y, z, sin, cos, own.grid.area)
    scales = estimates.scales(contact.pressures, state.friction, at) | {
        "work": Scale(largest_work, largest_work)
    }
    floors = estimates.floors(state)
    floors["peak"] += lacking(own, contact) / max(float(np.max(contact.pressures)), LEAST)
    for name, floor in estimates.floors_of_forces(state, at).items():
        floors[name] = floor / max(scales[name].changes, LEAST)
    symmetric = estimates.vanishing_by_symmetry(state.p, at)
    vanishing = {name for name, quantity in quantities.items() if quantity.kind.scale in symmetric}
    return Measured(
        numbers(own, contact, quantities),
        scales,
        floors | estimates.readings(main_patch(contact)),
        vanishing.union(prescribed),
    )


def lacking(on_grid: pairs.PairOnGrid, contact: Contact) -> float:
    """Return what p_max lacks [MPa] because the distance changes between neighbouring strips of a contact.

    Where they lack something, pressures may be as much larger; 0 for less than `RESOLVED` of it.
    """
    own, p = _on_own_grid(on_grid, contact), np.max(contact.pressures, axis=0)
    largest = float(np.max(p))
    lacking = float(np.max(np.where(p > 0, p + own.unresolved(contact.approach), 0.0))) - largest
    return lacking if lacking > pairs.RESOLVED * largest else 0.0


def _on_own_grid(on_grid: pairs.PairOnGrid, contact: Contact) -> pairs.PairOnGrid:
    grid = contact.problem.grid
    return on_grid if grid == on_grid.grid else replace(on_grid, grid=grid)
