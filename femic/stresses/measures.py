"""Numbers of a stress: von Mises, Tresca, principal values; the largest of values and its place.

Stresses are symmetric matrices, shape (..., 3, 3) [MPa]; tension is positive.
"""

from dataclasses import dataclass

import numpy as np

from femic.stresses.points import InnerPoints
from geometries.arrays import Array
from geometries.errors import WrongInput


def von_mises(stress: Array) -> Array:
    """Return sqrt(3/2) times the norm of the deviator, shape (...) [MPa]."""
    deviator = stress - mean_stress(stress)[..., None, None] * np.eye(3)
    return np.asarray(np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1))))


def mean_stress(stress: Array) -> Array:
    """Return a third of the trace, shape (...) [MPa]; negative under pressure."""
    return np.asarray(np.einsum("...aa->...", stress) / 3)


def principal_values(stress: Array) -> Array:
    """Return the principal stresses in growing order, shape (..., 3) [MPa]."""
    return np.asarray(np.linalg.eigvalsh(stress), dtype=float)


def tresca(stress: Array) -> Array:
    """Return the difference of the largest and the smallest principal stress, shape (...) [MPa]."""
    values = principal_values(stress)
    return np.asarray(values[..., 2] - values[..., 0])


def largest_shear(stress: Array) -> Array:
    """Return the largest shear stress on any plane, half of `tresca`, shape (...) [MPa]."""
    return tresca(stress) / 2


@dataclass(frozen=True)
class Largest:
    """The largest of some values, and where it lies: x, s, depth [mm]."""

    value: float
    x: float
    s: float
    depth: float


def largest(values: Array, points: InnerPoints) -> Largest:
    """Return the largest of values at points, both of one shape; raises WrongInput where shapes differ."""
    if values.shape != points.shape:
        raise WrongInput(f"values of shape {values.shape} at points of shape {points.shape}: must be alike")
    place = np.unravel_index(int(np.argmax(values)), values.shape)
    return Largest(*(float(array[place]) for array in (values, points.x, points.s, points.depth)))
