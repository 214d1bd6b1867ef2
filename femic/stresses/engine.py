"""Stub."""

from dataclasses import dataclass

import numpy as np

from femic.stresses.field import StressField
from femic.stresses.points import InnerPoints
from femic.stresses.tractions import SurfaceTractions
from geometries.bodies import Body


@dataclass(frozen=True)
class StressSettings:
    """How finely a body is modelled: 1 is the default, 0.5 has cells and wavenumbers twice as coarse."""

    fineness: float = 1.0
    estimated: bool = True  # whether the error is estimated: it costs about half as much again


def stress_field(
    body: Body,
    tractions: SurfaceTractions,
    points: InnerPoints,
    settings: StressSettings = StressSettings(),
    workers: int = 1,
) -> StressField:
    """Return displacements and stresses of the tractions in the true body, half-space stresses beside them.

    Raises WrongInput for points outside the body, NotConverged where a wavenumber cannot be solved.
    """
    shape = points.shape
    nan = np.full((*shape, 3, 3), np.nan)
    return StressField(body, points, nan[..., 0], nan, nan, np.full(shape, np.nan), {}, None)
