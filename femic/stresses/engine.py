"""Displacements and stresses inside the true body, by the harmonic engine.

All elements together are one load per wavenumber k (`section_fields`). The stress is

    half-space(all waves) + [section - half-space](waves up to the largest k)

with the half-space unrolled by the arc lengths x, s and the depth below the surface. Short waves do not reach
deep: to them the body is its tangent half-space. The rest in brackets is smooth, so that it can be continued
to the surface (`near_surface`). Theory: docs/theory/stresses.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from femic.stresses.field import StressField
from femic.stresses.half_space import half_space_field
from femic.stresses.points import InnerPoints, require_inside
from femic.stresses.resolution import Resolution
from femic.stresses.rest import SectionUnderWaves
from femic.stresses.tractions import SurfaceTractions, merged
from geometries.arrays import Array
from geometries.bodies import Body

SECTION_SHARE = 0.5  # of the change by coarser cells and waves: these errors fall by more than 3 if halved
FLOOR = 0.25  # of the largest change among all points: at some points it vanishes by chance
SAFETY = 1.25  # Roache's factor, as for contacts (`femic.contact.estimates`)
# of the change by merged elements: their errors fall in proportion to their sides, and beside the edge of the
# tractions, which rise there like a root, in proportion to the root of these
OF_ELEMENTS, AT_EDGES = SAFETY, SAFETY / (np.sqrt(2) - 1)


@dataclass(frozen=True)
class StressSettings:
    """How finely a body is modelled: 1 is the default, 0.5 has cells and wavenumbers twice as coarse.

    The estimate costs about half as much again as the stresses. `workers` is the number of threads.
    """

    fineness: float = 1.0
    estimated: bool = True
    workers: int = 1


DEFAULT = StressSettings()


def stress_field(
    body: Body, tractions: SurfaceTractions, points: InnerPoints, settings: StressSettings = DEFAULT
) -> StressField:
    """Return displacements and stresses of the tractions in the true body, half-space stresses beside them.

    Raises WrongInput for points outside the body, NotConverged where a wavenumber cannot be solved.
    """
    require_inside(body, points)
    resolution = Resolution.of(settings.fineness)
    flat = half_space_field(body, tractions, points)
    model = SectionUnderWaves.of(body, tractions, resolution)
    u, rest, cost = model.rest(points, settings.workers)
    field = StressField(body, points, flat.u + u, flat.stress + rest, flat.stress, cost=cost)
    if not settings.estimated:
        return replace(field, estimate=np.full(points.shape, np.nan))
    parts = _changes(field, tractions, rest, settings)
    largest = {name: float(np.max(part, initial=0.0)) for name, part in parts.items()}
    return replace(field, estimate=sum(parts.values(), np.zeros(points.shape)), estimate_parts=largest)


def _changes(
    field: StressField, tractions: SurfaceTractions, rest: Array, settings: StressSettings
) -> dict[str, Array]:
    """Parts of the estimate (...) [MPa], by what changes: "section", "far arc", "elements"."""
    body, points = field.body, field.points
    coarse = SectionUnderWaves.of(body, tractions, Resolution.of(settings.fineness).coarser)
    coarser_rest = coarse.rest(points, settings.workers)[1]
    parts = {"section": SECTION_SHARE * _with_floor(_largest(coarser_rest - rest))}
    if body.truncated:
        parts["far arc"] = _with_floor(_largest(coarse.far_arc_change(points, settings.workers)))
    flat_of_merged = half_space_field(body, merged(tractions), points).stress
    assert field.half_space is not None
    share = np.where(tractions.beside_edge(points.x, points.s, points.depth), AT_EDGES, OF_ELEMENTS)
    parts["elements"] = share * _largest(flat_of_merged - field.half_space)
    return parts


def _largest(change: Array) -> Array:
    """The largest component of changes (..., 3, 3), shape (...)."""
    return np.asarray(np.max(np.abs(change), axis=(-2, -1)))


def _with_floor(change: Array) -> Array:
    """The changes (...), and a share of the largest of them."""
    return np.asarray(change + FLOOR * np.max(change, initial=0.0))
