"""The numbers of contacts, without and with friction: symbols, units, meanings, estimates of errors.

Of steady rolling the work of friction is known to what the slip misses, besides.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from femic.contact import estimates
from femic.contact.estimates import (
    Kind,
    Measured,
    Places,
    Scale,
    floors,
    floors_of_forces,
    readings,
    scales,
    vanishing_by_symmetry,
)
from femic.contact.normal import NormalContact
from femic.contact.pairs.pair_on_grid import RESOLVED, PairOnGrid
from femic.contact.patch import Extent, centre_of_pressure
from femic.contact.rolling import RollingContact, RollingProblem

if TYPE_CHECKING:
    from femic.contact.frictional import FrictionalContact


# --- quantities ---

LEAST = 1e-300  # of scales that are divided by
Contact: TypeAlias = "NormalContact | FrictionalContact"


@dataclass(frozen=True)
class Quantity:
    """A number of a contact: how its error is estimated, and how it is computed.

    `evaluate` is None for numbers of a creep-force curve as a whole.
    """

    symbol: str
    unit: str
    meaning: str
    kind: Kind
    evaluate: Callable[[PairOnGrid, Any], float] | None = None


def main_patch(contact: Contact) -> Extent:
    """Return the patch with the largest sum of pressures."""
    return max(contact.patches, key=lambda patch: float(np.sum(contact.pressures[patch.elements])))


def s_range(on_grid: PairOnGrid, contact: Contact) -> tuple[float, float]:
    """Arc lengths [mm] at the ends of the main patch."""
    low, high = main_patch(contact).s
    first, ds = on_grid.grid.strips[0], on_grid.grid.ds
    return float(first + low * ds), float(first + high * ds)


def angle(on_grid: PairOnGrid, contact: Contact) -> float:
    """Range of the inclination over the main patch [deg]."""
    inclinations = on_grid.undeformed.lower.contour.inclination(np.array(s_range(on_grid, contact)))
    return float(np.degrees(np.ptp(inclinations)))


def half_length(on_grid: PairOnGrid, contact: Contact) -> float:
    """Return half-length of the main patch along x [mm]."""
    low, high = main_patch(contact).x
    return (high - low) / 2 * on_grid.grid.dx


def half_width(on_grid: PairOnGrid, contact: Contact) -> float:
    """Return half-width of the main patch along s, on the arc [mm]."""
    low, high = s_range(on_grid, contact)
    return (high - low) / 2


def _largest_pressure(_: PairOnGrid, contact: Contact) -> float:
    return float(np.max(contact.pressures))


def _aspect(on_grid: PairOnGrid, contact: Contact) -> float:
    return half_length(on_grid, contact) / half_width(on_grid, contact)


def _centre(on_grid: PairOnGrid, contact: Contact) -> float:
    return centre_of_pressure(contact.pressures, on_grid.grid.strips)


def _dissipation(on_grid: PairOnGrid, contact: Any) -> float:
    return float(np.sum(contact.dissipation) * on_grid.grid.area)


def _force(axis: int) -> Callable[[PairOnGrid, Contact], float]:
    """Return the force [N] on the upper body along a global axis."""
    return lambda on_grid, contact: float(on_grid.resultant(contact.tractions).force[axis])


def _moment(axis: int) -> Callable[[PairOnGrid, Contact], float]:
    """Return the moment [N mm] on the upper body about a global axis through the contact centre."""
    return lambda on_grid, contact: float(on_grid.resultant(contact.tractions).moment[axis])


def _attribute(name: str) -> Callable[[PairOnGrid, Any], float]:
    """Return a number that contacts have as an attribute."""
    return lambda _, contact: getattr(contact, name)


ALL: Mapping[str, Quantity] = {
    "angle": Quantity("Δδ", "deg", "range of the inclination over the patch", estimates.WIDTH, angle),
    "a": Quantity("a", "mm", "half-length of the patch along x", estimates.LENGTH, half_length),
    "b": Quantity("b", "mm", "half-width of the patch along s, on the arc", estimates.WIDTH, half_width),
    "aspect": Quantity("a/b", "1", "aspect of the patch", estimates.ASPECT, _aspect),
    "p_max": Quantity("p_max", "MPa", "largest pressure", estimates.PRESSURE, _largest_pressure),
    "approach": Quantity("ζ", "mm", "vertical approach", estimates.GIVEN, _attribute("approach")),
    "load": Quantity("N", "N", "vertical load", estimates.GIVEN, _attribute("load")),
    "position": Quantity(
        "y_u",
        "mm",
        "lateral position of the upper body",
        estimates.POSITION,
        lambda on_grid, _: on_grid.undeformed.shift,
    ),
    "F_x": Quantity("F_x", "N", "longitudinal force on the upper body", estimates.LONGITUDINAL, _force(0)),
    "F_y": Quantity("F_y", "N", "lateral force on the upper body", estimates.LATERAL, _force(1)),
    "M_x": Quantity(
        "M_x",
        "N mm",
        "moment on the upper body about the x axis through the contact centre",
        estimates.ABOUT_X,
        _moment(0),
    ),
    "M_z": Quantity(
        "M_z",
        "N mm",
        "moment on the upper body about the contact centre's vertical",
        estimates.ABOUT_Z,
        _moment(2),
    ),
    "s_centre": Quantity("s_c", "mm", "centre of pressure along s", estimates.CENTRE, _centre),
    "area": Quantity("area", "mm2", "contact area on the lower surface", estimates.AREA, _attribute("area")),
    "stiffness": Quantity(
        "dN/dζ",
        "N/mm",
        "derivative of the load by the approach",
        estimates.STIFFNESS,
        _attribute("stiffness"),
    ),
    "sliding_share": Quantity(
        "sliding", "1", "area of sliding over that of contact", estimates.SLIDING, _attribute("sliding_share")
    ),
    "dissipation": Quantity(
        "work", "N", "work of friction per unit of rolled distance", estimates.WORK, _dissipation
    ),
}


def _chosen(*names: str) -> Mapping[str, Quantity]:
    return {name: ALL[name] for name in names}


OF_FRICTIONLESS = _chosen(
    *("angle", "a", "b", "aspect", "p_max", "approach", "load", "position", "F_y", "M_x", "s_centre", "area"),
    "stiffness",
)
OF_COMPRESSION = _chosen(
    *("F_y", "M_x", "M_z", "approach", "p_max", "a", "b", "angle", "area", "sliding_share")
)
OF_ROLLING = _chosen("F_x", "dissipation", *OF_COMPRESSION)  # steady or transient
OF_CURVE: Mapping[str, Quantity] = {  # of a creep-force curve, besides its points
    "zero_creepage": Quantity("ξ_0", "1", "creepage without longitudinal force", estimates.CREEPAGE),
    "slope": Quantity(
        "dF_x/dξ", "N", "derivative of the longitudinal force by the creepage there", estimates.SLOPE
    ),
    "equal_creepage": Quantity(
        "ξ_e", "1", "creepage at the force at which tractions are compared", estimates.CREEPAGE
    ),
}


# --- numbers of a contact, with scales and floors ---


def numbers(
    on_grid: PairOnGrid, contact: Contact, quantities: Mapping[str, Quantity] = OF_FRICTIONLESS
) -> dict[str, float]:
    """Quantities of a contact of these bodies, on its own grid."""
    own = _on_grid_of(contact, on_grid)
    return {
        name: quantity.evaluate(own, contact) for name, quantity in quantities.items() if quantity.evaluate
    }


def kinds(quantities: Mapping[str, Quantity]) -> dict[str, Kind]:
    """Return how the errors of quantities are estimated."""
    return {name: quantity.kind for name, quantity in quantities.items()}


def measured(
    on_grid: PairOnGrid,
    contact: Contact,
    quantities: Mapping[str, Quantity] = OF_FRICTIONLESS,
    prescribed: Collection[str] = (),
) -> Measured:
    """Quantities of a contact on its own grid, and the scales and floors of their errors.

    `prescribed` are the names of those that its loading fixes; others that are exact vanish by symmetry.
    """
    own, state, work = _on_grid_of(contact, on_grid), contact.slip_state, contact.largest_work
    at = _places(own)
    of_all = scales(contact.pressures, state.friction, at) | {"work": Scale(work, work)}
    of_state, largest = floors(state), max(float(np.max(contact.pressures)), LEAST)
    of_state["peak"] += lacking(own, contact) / largest
    of_forces = {
        name: floor / max(of_all[name].changes, LEAST) for name, floor in floors_of_forces(state, at).items()
    }
    symmetric = vanishing_by_symmetry(state.p, at)
    vanishing = {name for name, quantity in quantities.items() if quantity.kind.scale in symmetric}
    return Measured(
        numbers(own, contact, quantities),
        of_all,
        of_state | of_forces | readings(main_patch(contact)),
        vanishing.union(prescribed),
    )


def lacking(on_grid: PairOnGrid, contact: Contact) -> float:
    """Return what p_max lacks [MPa] because the distance changes between neighbouring strips of a contact.

    Where they lack something, pressures may be as much larger; 0 for less than `RESOLVED` of it.
    """
    own, p = _on_grid_of(contact, on_grid), np.max(contact.pressures, axis=0)
    largest = float(np.max(p))
    lacking = float(np.max(np.where(p > 0, p + own.unresolved(contact.approach), 0.0))) - largest
    return lacking if lacking > RESOLVED * largest else 0.0


def _on_grid_of(contact: Contact, on_grid: PairOnGrid) -> PairOnGrid:
    grid = contact.problem.grid
    return on_grid if grid == on_grid.grid else replace(on_grid, grid=grid)


def _places(on_grid: PairOnGrid) -> Places:
    """Return where the elements are."""
    contour, strips = on_grid.undeformed.lower.contour, on_grid.grid.strips
    (y, z), (sin, cos) = contour.position(strips), contour.normal(strips)
    return Places(on_grid.x, y, z, sin, cos, on_grid.grid.area)


# --- steady rolling ---

OF_EDGE = 0.015  # part of the work on elements at the edge
FORCES = {"longitudinal": "F_x", "lateral": "F_y", "spin": "M_z"}  # that creepages bring about


def measured_rolling(on_grid: PairOnGrid, problem: RollingProblem, rolling: RollingContact) -> Measured:
    """Return the numbers of `OF_ROLLING`; the floor of work is that which the slip misses, and of the edge.

    Where little of a contact slides, grids miss much of the slip, and changes from grid to grid do not show
    that. Forces that creepages follow from are exact.
    """
    prescribed = [FORCES[name] for name in rolling.prescribed]
    known = measured(on_grid, rolling.contact, OF_ROLLING, prescribed)
    largest = known.scales["work"].changes
    if largest == 0.0:
        return known
    at_edge = float(np.sum(rolling.contact.dissipation[rolling.contact.slip_state.at_edge]))
    missed = problem.missed_work(rolling) + OF_EDGE * at_edge * problem.problem.grid.area
    return replace(known, floors={**known.floors, "work": missed / largest})
