"""The numbers of a contact with friction: symbols, units and meanings, and how they are computed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from compare.results.contact.pairing import Placed
from compare.results.contact.quantities import angle, half_length, half_width
from contact.edges import Extent
from contact.frictional import FrictionalContact
from geometries.arrays import Array
from geometries.patches import N


@dataclass(frozen=True)
class Described:
    """The unit and meaning of a number."""

    unit: str
    meaning: str


@dataclass(frozen=True)
class Quantity(Described):
    """A number of a contact with friction, and its symbol."""

    symbol: str
    of: Callable[[Placed, FrictionalContact], float]


@dataclass(frozen=True, eq=False)
class _Pressures:
    """The pressures of a contact and its patches."""

    contact: FrictionalContact

    @property
    def p(self) -> Array:
        """Pressures [MPa], shape (n_x, n_s)."""
        return np.asarray(self.contact.p[..., N])

    @property
    def patches(self) -> list[Extent]:
        """The contact patches."""
        return self.contact.patches


def _force(axis: int) -> Callable[[Placed, FrictionalContact], float]:
    """The force [N] on the upper body along a global axis."""
    return lambda placed, contact: float(placed.resultant(contact.p).force[axis])


def _moment(axis: int) -> Callable[[Placed, FrictionalContact], float]:
    """The moment [N mm] on the upper body about a global axis through the contact centre."""
    return lambda placed, contact: float(placed.resultant(contact.p).moment[axis])


OF_PATCH: Mapping[str, Quantity] = MappingProxyType(
    {
        "F_y": Quantity("N", "lateral force on the upper body", "F_y", _force(1)),
        "M_x": Quantity(
            "N mm", "moment on the upper body about the x axis through the contact centre", "M_x", _moment(0)
        ),
        "M_z": Quantity(
            "N mm", "moment on the upper body about the contact centre's vertical", "M_z", _moment(2)
        ),
        "approach": Quantity("mm", "vertical approach", "ζ", lambda _, contact: contact.approach),
        "p_max": Quantity(
            "MPa", "largest pressure", "p_max", lambda _, contact: float(np.max(contact.p[..., N]))
        ),
        "a": Quantity(
            "mm",
            "half-length of the patch along x",
            "a",
            lambda placed, contact: half_length(placed, _Pressures(contact)),
        ),
        "b": Quantity(
            "mm",
            "half-width of the patch along s, on the arc",
            "b",
            lambda placed, contact: half_width(placed, _Pressures(contact)),
        ),
        "angle": Quantity(
            "deg",
            "range of the inclination over the patch",
            "Δδ",
            lambda placed, contact: angle(placed, _Pressures(contact)),
        ),
        "area": Quantity("mm2", "contact area on the lower surface", "area", lambda _, contact: contact.area),
        "sliding_share": Quantity(
            "1", "area of sliding over that of contact", "sliding", lambda _, contact: contact.sliding_share
        ),
    }
)
OF_ROLLING: Mapping[str, Quantity] = MappingProxyType(
    {
        "F_x": Quantity("N", "longitudinal force on the upper body", "F_x", _force(0)),
        "dissipation": Quantity(
            "N",
            "work of friction per unit of rolled distance",
            "work",
            lambda placed, contact: float(np.sum(contact.dissipation) * placed.grid.area),
        ),
        **OF_PATCH,
    }
)


def numbers(
    quantities: Mapping[str, Quantity], placed: Placed, contact: FrictionalContact
) -> dict[str, float]:
    """Quantities of a contact, on its own grid."""
    on_grid = replace(placed, grid=contact.problem.grid)
    return {name: quantity.of(on_grid, contact) for name, quantity in quantities.items()}
