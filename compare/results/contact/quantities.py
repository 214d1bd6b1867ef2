"""The numbers of a contact that are compared: symbols, units and meanings, and how they are computed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from compare.results.contact.pairing import Placed
from contact.edges import Extent
from contact.normal import NormalContact
from contact.resultants import Resultant, centre_of_pressure
from geometries.arrays import Array


@dataclass(frozen=True)
class Quantity:
    """A number of a contact."""

    symbol: str
    unit: str
    meaning: str
    of: Callable[[Placed, NormalContact], float]


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
        "angle": Quantity("Δδ", "deg", "range of the inclination over the patch", angle),
        "a": Quantity("a", "mm", "half-length of the patch along x", half_length),
        "b": Quantity("b", "mm", "half-width of the patch along s, on the arc", half_width),
        "aspect": Quantity("a/b", "1", "aspect of the patch", lambda *of: half_length(*of) / half_width(*of)),
        "p_max": Quantity("p_max", "MPa", "largest pressure", lambda _, contact: float(np.max(contact.p))),
        "approach": Quantity("ζ", "mm", "vertical approach", lambda _, contact: contact.approach),
        "load": Quantity("N", "N", "vertical load", lambda _, contact: contact.load),
        "position": Quantity(
            "y_u",
            "mm",
            "lateral position of the upper body",
            lambda placed, _: placed.undeformed.shift,
        ),
        "F_y": Quantity(
            "F_y", "N", "lateral force on the upper body", lambda *of: float(_resultant(*of).force[1])
        ),
        "M_x": Quantity(
            "M_x",
            "N mm",
            "moment on the upper body about the x axis through the contact centre",
            lambda *of: float(_resultant(*of).moment[0]),
        ),
        "s_centre": Quantity(
            "s_c",
            "mm",
            "centre of pressure along s",
            lambda placed, contact: centre_of_pressure(contact.p, placed.grid.strips),
        ),
        "area": Quantity("area", "mm2", "contact area on the lower surface", lambda _, contact: contact.area),
        "stiffness": Quantity(
            "dN/dζ", "N/mm", "derivative of the load by the approach", lambda _, contact: contact.stiffness
        ),
    }
)


def _resultant(placed: Placed, contact: NormalContact) -> Resultant:
    return placed.resultant(contact.p[..., None] * [0.0, 0.0, 1.0])


def numbers(placed: Placed, contact: NormalContact) -> dict[str, float]:
    """All quantities of a contact."""
    return {name: quantity.of(placed, contact) for name, quantity in QUANTITIES.items()}
