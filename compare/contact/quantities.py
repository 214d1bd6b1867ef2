"""The numbers of a contact that are compared: symbols, units and meanings, and how they are computed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

import numpy as np

from compare.contact.pair_on_grid import Placed
from femic.contact.edges import Extent
from femic.contact.estimates import (
    ABOUT_X,
    AREA,
    ASPECT,
    CENTRE,
    GIVEN,
    LATERAL,
    LENGTH,
    POSITION,
    PRESSURE,
    STIFFNESS,
    WIDTH,
    Kind,
    Measured,
)
from femic.contact.normal import NormalContact
from femic.contact.resultants import Resultant, centre_of_pressure
from femic.contact.undecided import Places, Tractions, floors, readings, scales
from geometries.arrays import Array


@dataclass(frozen=True)
class Quantity:
    """A number of a contact, and how its error is estimated."""

    symbol: str
    unit: str
    meaning: str
    of: Callable[[Placed, NormalContact], float]
    kind: Kind = field(kw_only=True)


class Pressed(Protocol):
    """A contact as far as its patches are concerned."""

    @property
    def p(self) -> Array:
        """Pressures [MPa], shape (n_x, n_s)."""
        ...

    @property
    def patches(self) -> list[Extent]:
        """The contact patches."""
        ...


def main_patch(contact: Pressed) -> Extent:
    """The patch with the largest sum of pressures."""
    return max(contact.patches, key=lambda patch: float(np.sum(contact.p[patch.elements])))


def s_range(placed: Placed, contact: Pressed) -> tuple[float, float]:
    """Arc lengths [mm] at the ends of the main patch."""
    low, high = main_patch(contact).s
    first, ds = placed.grid.strips[0], placed.grid.ds
    return float(first + low * ds), float(first + high * ds)


def angle(placed: Placed, contact: Pressed) -> float:
    """Range of the inclination over the main patch [deg]."""
    inclinations = placed.undeformed.lower.contour.inclination(np.array(s_range(placed, contact)))
    return float(np.degrees(np.ptp(inclinations)))


def half_length(placed: Placed, contact: Pressed) -> float:
    """Half-length of the main patch along x [mm]."""
    low, high = main_patch(contact).x
    return (high - low) / 2 * placed.grid.dx


def half_width(placed: Placed, contact: Pressed) -> float:
    """Half-width of the main patch along s, on the arc [mm]."""
    low, high = s_range(placed, contact)
    return (high - low) / 2


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        "angle": Quantity("Δδ", "deg", "range of the inclination over the patch", angle, kind=WIDTH),
        "a": Quantity("a", "mm", "half-length of the patch along x", half_length, kind=LENGTH),
        "b": Quantity("b", "mm", "half-width of the patch along s, on the arc", half_width, kind=WIDTH),
        "aspect": Quantity(
            "a/b",
            "1",
            "aspect of the patch",
            lambda *of: half_length(*of) / half_width(*of),
            kind=ASPECT,
        ),
        "p_max": Quantity(
            "p_max", "MPa", "largest pressure", lambda _, contact: float(np.max(contact.p)), kind=PRESSURE
        ),
        "approach": Quantity("ζ", "mm", "vertical approach", lambda _, contact: contact.approach, kind=GIVEN),
        "load": Quantity("N", "N", "vertical load", lambda _, contact: contact.load, kind=GIVEN),
        "position": Quantity(
            "y_u",
            "mm",
            "lateral position of the upper body",
            lambda placed, _: placed.undeformed.shift,
            kind=POSITION,
        ),
        "F_y": Quantity(
            "F_y",
            "N",
            "lateral force on the upper body",
            lambda *of: float(_resultant(*of).force[1]),
            kind=LATERAL,
        ),
        "M_x": Quantity(
            "M_x",
            "N mm",
            "moment on the upper body about the x axis through the contact centre",
            lambda *of: float(_resultant(*of).moment[0]),
            kind=ABOUT_X,
        ),
        "s_centre": Quantity(
            "s_c",
            "mm",
            "centre of pressure along s",
            lambda placed, contact: centre_of_pressure(contact.p, placed.grid.strips),
            kind=CENTRE,
        ),
        "area": Quantity(
            "area", "mm2", "contact area on the lower surface", lambda _, contact: contact.area, kind=AREA
        ),
        "stiffness": Quantity(
            "dN/dζ",
            "N/mm",
            "derivative of the load by the approach",
            lambda _, contact: contact.stiffness,
            kind=STIFFNESS,
        ),
    }
)


def _resultant(placed: Placed, contact: NormalContact) -> Resultant:
    return placed.resultant(contact.p[..., None] * [0.0, 0.0, 1.0])


def numbers(placed: Placed, contact: NormalContact) -> dict[str, float]:
    """All quantities of a contact."""
    return {name: quantity.of(placed, contact) for name, quantity in QUANTITIES.items()}


def kinds(quantities: Mapping[str, Quantity] = QUANTITIES) -> dict[str, Kind]:
    """How the errors of quantities are estimated."""
    return {name: quantity.kind for name, quantity in quantities.items()}


def measured(
    placed: Placed, contact: NormalContact, quantities: Mapping[str, Quantity] = QUANTITIES
) -> Measured:
    """Quantities of a contact on the grid of `placed`, with what estimates of their errors need."""
    none = np.zeros((*contact.p.shape, 2))
    tractions = Tractions(np.concatenate([none, contact.p[..., None]], axis=-1), none[..., 0] > 0, none, 0.0)
    return Measured(
        {name: quantity.of(placed, contact) for name, quantity in quantities.items()},
        scales(contact.p, 0.0, places(placed)),
        floors(tractions) | readings(main_patch(contact)),
    )


def places(placed: Placed) -> Places:
    """Where the elements are."""
    contour, strips = placed.undeformed.lower.contour, placed.grid.strips
    (y, z), (sin, cos) = contour.position(strips), contour.normal(strips)
    return Places(placed.x, y, z, sin, cos, placed.grid.area)
