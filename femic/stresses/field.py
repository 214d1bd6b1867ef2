"""Displacements and stresses at points of a body, and numbers of a stress.

Stresses are symmetric matrices, shape (..., 3, 3) [MPa]; tension is positive. Their numbers are von Mises,
Tresca, principal values, and what the largest one on a lattice may miss.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from femic.reference.engine import Cost
from femic.stresses.points import InnerPoints
from geometries.arrays import Array
from geometries.bodies import Body


@dataclass(frozen=True, eq=False)
class StressField:
    """Displacements u (..., 3) [mm] and stresses (..., 3, 3) [MPa] at points of shape (...).

    Components are along x, s, n of the surface point above each point. `half_space` are the stresses of the
    same tractions on a half-space, unrolled by arc length, None where the field is that one itself.
    `estimate` (...) [MPa] is an estimate of the error of the largest component, 0 for closed forms.
    """

    body: Body
    points: InnerPoints
    u: Array
    stress: Array
    half_space: Array | None = None
    estimate: Array = field(default_factory=lambda: np.zeros(()))
    estimate_parts: dict[str, float] | None = None  # largest of each part of the estimate [MPa]
    cost: Cost | None = None


def in_section_axes(result: StressField) -> Array:
    """Stresses along x, y, z of the section through each point, shape (..., 3, 3) [MPa].

    On a body of revolution these axes turn with x, as the section does.
    """
    axes = np.moveaxis(
        result.body.surface.axes(np.zeros_like(result.points.s), result.points.s), (0, 1), (-2, -1)
    )
    return np.asarray(np.swapaxes(axes, -1, -2) @ result.stress @ axes)


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


def rise_between(values: Array, axes: Sequence[Array]) -> float:
    """Return how far parabolas through the largest of values (n, m, ...) and its neighbours rise above it.

    `axes` are the growing coordinates along each dimension. The sum over these; at the ends of an axis there
    is no parabola. That is what a smooth function may exceed its values on a lattice by.
    """
    at, rise = list(map(int, np.unravel_index(int(np.argmax(values)), values.shape))), 0.0
    for axis, coordinates in enumerate(axes):
        line = np.moveaxis(values, axis, -1)[tuple(at[:axis] + at[axis + 1 :])]
        if 0 < (middle := at[axis]) < len(coordinates) - 1:
            near = slice(middle - 1, middle + 2)
            curvature, slope, height = np.polyfit(coordinates[near] - coordinates[middle], line[near], 2)
            if curvature < 0:
                rise += float(height - slope**2 / (4 * curvature) - line[middle])
    return rise
