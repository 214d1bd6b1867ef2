"""The registry of approximations: one name, one formula, one symbol."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from approx.halfspace import halfspace_ics
from approx.orientation import load_rotated, observer_rotated, split_rotation
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.materials import HalfSpaces
from geometries.patches import Patch

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Variant:
    """An approximation made of the half-space ICs `a` and the orientation difference `alpha`."""

    symbol: str
    meaning: str
    formula: Callable[[Array, Array], Array]
    reciprocal: bool  # ns = -sn, nx = -xn, sx = xs on any contour


def _unchanged(a: Array, _alpha: Array) -> Array:
    return a


VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {
        "A": Variant("A", "flat half-space", _unchanged, True),
        "B": Variant("B", "load turned", load_rotated, False),
        "Bbar": Variant("B̄", "displacement turned", observer_rotated, False),
        "Bhat": Variant("B̂", "half of the turn each", split_rotation, True),
    }
)


def approximate(
    variant: str,
    constants: HalfSpaces,
    contour: Contour,
    patch: Patch,
    points: tuple[ArrayLike, ArrayLike],
) -> Array:
    """ICs per unit pressure [mm/MPa] at surface points (x, s) [mm], shape (3, 3, *x.shape).

    `constants` are those of one body or of both; `contour` gives the inclination of load and
    observer. Index order: displacement, traction; directions x, s, n.
    """
    if variant not in VARIANTS:
        raise WrongInput(f"variant = {variant!r}: one of {', '.join(VARIANTS)}")
    x, s = np.broadcast_arrays(*(np.asarray(p, dtype=float) for p in points))
    a = halfspace_ics(constants, patch, x, s - patch.s)
    alpha = contour.inclination(s) - contour.inclination(patch.s)
    return VARIANTS[variant].formula(a, alpha)
