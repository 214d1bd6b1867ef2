"""Displacements and stresses at points of a body."""

from dataclasses import dataclass, field

import numpy as np

from femic.reference.models import Cost
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
