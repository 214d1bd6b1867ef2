"""The numbers of a contact with friction: symbols, units and meanings, and how they are computed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from compare.contact.pair_on_grid import Placed
from compare.contact.quantities import angle, half_length, half_width, main_patch, places
from femic.contact.edges import Extent
from femic.contact.estimates import (
    ABOUT_X,
    ABOUT_Z,
    AREA,
    GIVEN,
    LATERAL,
    LENGTH,
    LONGITUDINAL,
    PRESSURE,
    SLIDING,
    WIDTH,
    WORK,
    Kind,
    Measured,
    Scale,
)
from femic.contact.frictional import FrictionalContact
from femic.contact.undecided import Tractions, floors, readings, scales
from geometries.arrays import Array
from geometries.patches import N


@dataclass(frozen=True)
class Described:
    """The unit and meaning of a number, and how its error is estimated."""

    unit: str
    meaning: str
    kind: Kind = field(kw_only=True)


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
        "F_y": Quantity("N", "lateral force on the upper body", "F_y", _force(1), kind=LATERAL),
        "M_x": Quantity(
            "N mm",
            "moment on the upper body about the x axis through the contact centre",
            "M_x",
            _moment(0),
            kind=ABOUT_X,
        ),
        "M_z": Quantity(
            "N mm",
            "moment on the upper body about the contact centre's vertical",
            "M_z",
            _moment(2),
            kind=ABOUT_Z,
        ),
        "approach": Quantity("mm", "vertical approach", "ζ", lambda _, contact: contact.approach, kind=GIVEN),
        "p_max": Quantity(
            "MPa",
            "largest pressure",
            "p_max",
            lambda _, contact: float(np.max(contact.p[..., N])),
            kind=PRESSURE,
        ),
        "a": Quantity(
            "mm",
            "half-length of the patch along x",
            "a",
            lambda placed, contact: half_length(placed, _Pressures(contact)),
            kind=LENGTH,
        ),
        "b": Quantity(
            "mm",
            "half-width of the patch along s, on the arc",
            "b",
            lambda placed, contact: half_width(placed, _Pressures(contact)),
            kind=WIDTH,
        ),
        "angle": Quantity(
            "deg",
            "range of the inclination over the patch",
            "Δδ",
            lambda placed, contact: angle(placed, _Pressures(contact)),
            kind=WIDTH,
        ),
        "area": Quantity(
            "mm2", "contact area on the lower surface", "area", lambda _, contact: contact.area, kind=AREA
        ),
        "sliding_share": Quantity(
            "1",
            "area of sliding over that of contact",
            "sliding",
            lambda _, contact: contact.sliding_share,
            kind=SLIDING,
        ),
    }
)
OF_ROLLING: Mapping[str, Quantity] = MappingProxyType(
    {
        "F_x": Quantity("N", "longitudinal force on the upper body", "F_x", _force(0), kind=LONGITUDINAL),
        "dissipation": Quantity(
            "N",
            "work of friction per unit of rolled distance",
            "work",
            lambda placed, contact: float(np.sum(contact.dissipation) * placed.grid.area),
            kind=WORK,
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


def kinds(quantities: Mapping[str, Described]) -> dict[str, Kind]:
    """How the errors of quantities are estimated."""
    return {name: quantity.kind for name, quantity in quantities.items()}


def measured(quantities: Mapping[str, Quantity], placed: Placed, contact: FrictionalContact) -> Measured:
    """Quantities of a contact, on its own grid, with what estimates of their errors need."""
    on_grid, friction = replace(placed, grid=contact.problem.grid), contact.problem.friction
    pressures = contact.p[..., N]
    of_forces = scales(pressures, friction, places(on_grid))
    tractions = Tractions(contact.p, contact.stick, contact.slip, friction)
    patch = main_patch(_Pressures(contact))
    return Measured(
        numbers(quantities, placed, contact),
        of_forces | {"work": _of_work(contact)},
        floors(tractions) | readings(patch),
    )


def _of_work(contact: FrictionalContact) -> Scale:
    """The work of friction, or, if more, that if the whole contact slid with the rigid slip."""
    rigid = contact.motion.rigid
    for free, amplitude in zip(contact.motion.free, contact.amplitudes, strict=True):
        rigid = rigid + amplitude * free.slip
    bound = contact.problem.friction * contact.p[..., N] * contact.problem.grid.area
    done = float(np.sum(contact.dissipation) * contact.problem.grid.area)
    work = max(float(np.sum(bound * np.linalg.norm(rigid, axis=-1))), done)
    return Scale(work, work)
