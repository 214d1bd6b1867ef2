"""Displacements and stresses inside the true body, by the harmonic engine.

All elements together are one load per wavenumber k (`section_fields`). The stress is

    half-space(all waves) + [section - half-space](waves up to the largest k)

with the half-space unrolled by the arc lengths x, s and the depth below the surface: of the short waves, which
do not reach deep, only the tangent half-space is taken, and the rest in brackets is smooth, so that it can be
continued to the surface (`near_surface`). Theory: docs/theory/stresses.md.
"""

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.cache.threads import in_threads, one_blas_thread
from femic.reference.harmonic.section import SectionMesh, section_mesh
from femic.reference.harmonic.section_size import SectionSize
from femic.reference.harmonic.waves import spectrum, synthesis_weights
from femic.reference.meshing.cell_size import Cells
from femic.reference.models import Cost, peak_memory
from femic.stresses.centred import centred
from femic.stresses.field import StressField
from femic.stresses.half_space import half_space_field, on_half_space, stress_of
from femic.stresses.near_surface import samples_of
from femic.stresses.points import InnerPoints, require_inside
from femic.stresses.section_fields import wave_solver
from femic.stresses.spectra import Spectra
from femic.stresses.tractions import SurfaceTractions
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.grids import Grid

CELLS = 32.0  # cells across the loaded width
GROWTH = 0.5  # of cells with the distance from the loaded strips
TRUSTED = 0.5  # cells on the strips deep: from there on the section is trusted


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
    require_inside(body, points)
    flat = half_space_field(body, tractions, points)
    with one_blas_thread():
        model = _Model.of(body, tractions, settings.fineness)
        u, stress, cost = model.rest(points, workers)
    return StressField(body, points, flat.u + u, flat.stress + stress, flat.stress, np.zeros(points.shape), {}, cost)


@dataclass(frozen=True, eq=False)
class _Model:
    """A section, the waves of its tractions, and the size of its cells on the loaded strips [mm]."""

    section: SectionMesh
    spectra: Spectra
    cell: float
    fineness: float
    seconds: float

    @classmethod
    def of(cls, body: Body, tractions: SurfaceTractions, fineness: float) -> "_Model":
        start = perf_counter()
        spectra = Spectra.of(body, tractions, fineness)
        blocks = strip_blocks(spectra.tractions.grid, CELLS * fineness)
        cell = float(np.max(np.ptp(blocks, axis=1)))
        size = SectionSize(Cells(cell, GROWTH, GROWTH), blocks, cell)
        section = section_mesh(body, size)
        return cls(section, spectra, cell, fineness, perf_counter() - start)

    def rest(self, points: InnerPoints, workers: int) -> tuple[Array, Array, Cost]:
        """What the section adds to the half-space: displacements (..., 3), stresses (..., 3, 3), the cost."""
        samples = samples_of(points, TRUSTED * self.cell)
        long_part = self.spectra.long_part()
        centres = centred(long_part.grid, samples.points, along_x=False)
        u, stress, cost = self.long_waves(centres.points, workers)
        flat_u, flat_stress = on_half_space(self.section.body, long_part, centres.points)
        along_n = np.arange(3) == 2
        nowhere = np.zeros(3, dtype=bool)
        return (
            samples.continued(centres.at_points(u - flat_u), nowhere),
            samples.continued(centres.at_points(stress - flat_stress), along_n | along_n[:, None]),
            cost,
        )

    def long_waves(self, points: InnerPoints, workers: int) -> tuple[Array, Array, Cost]:
        """Displacements (n, 3), stresses (n, 3, 3) along x, s, n of the waves at points (n,), and the cost."""
        body, spectra = self.section.body, self.spectra
        start = perf_counter()
        yz = body.contour.position(points.s) + body.side * points.depth * body.contour.normal(points.s)
        distinct, place = np.unique(yz, axis=1, return_inverse=True)
        solve = wave_solver(self.section, spectra, distinct)
        k = spectra.wavenumbers(1 / self.fineness)
        assembled = perf_counter()
        fields, residuals = zip(*in_threads(solve, k.tolist(), workers), strict=True)
        solved = perf_counter()
        xi = body.surface.chart_x(points.x, points.s, points.s)
        values = synthesised(spectra, k, np.stack(fields), place.ravel(), xi)
        seconds = {"mesh": self.seconds, "assembly": assembled - start, "solution": solved - assembled}
        mesh = self.section.mesh
        cost = Cost(
            3 * mesh.doflocs.shape[1], int(mesh.nelements), f"direct, {len(k)} wavenumbers", (),
            max(residuals), seconds, peak_memory(),
        )
        return *in_local_axes(body, points.s, values), cost


def strip_blocks(grid: Grid, cells: float) -> Array:
    """Ends [mm] of groups of neighbouring strips, about `cells` of them, shape (n, 2)."""
    together = max(1, round(grid.n_s / cells))
    edges = np.linspace(*grid.extent, grid.n_s + 1)
    ends = np.append(edges[:-1:together], edges[-1])
    return np.stack([ends[:-1], ends[1:]], axis=1)


def synthesised(spectra: Spectra, k: Array, fields: Array, place: Array, xi: Array) -> Array:
    """Values (n, c) at points from their waves (len(k), 2, places, c).

    `place` (n,) is the number of each point of the section, `xi` (n,) its coordinate in the chart [mm].
    """
    wavenumbers = spectrum(spectra.largest, spectra.body.rolling_radius)
    distinct, number = np.unique(xi, return_inverse=True)
    even, odd = synthesis_weights(spectra.axis, k, wavenumbers, wavenumbers.shares(0.0, distinct))
    values = np.empty((len(xi), fields.shape[-1]))
    for x in range(len(distinct)):
        here = number == x
        at = fields[:, :, place[here]]
        values[here] = np.tensordot(even[:, x], at[:, 0], 1) + np.tensordot(odd[:, x], at[:, 1], 1)
    return values


def in_local_axes(body: Body, s: Array, values: Array) -> tuple[Array, Array]:
    """Displacements (n, 3) and stresses (n, 3, 3) along x, s, n from values (n, 9) in section axes."""
    axes = np.moveaxis(body.surface.axes(np.zeros_like(s), s), 2, 0)  # (n, direction, component)
    strain = np.empty((len(s), 3, 3))
    for a in range(3):
        strain[:, a, a] = values[:, 3 + a]
    for column, (a, b) in zip((6, 7, 8), ((1, 2), (0, 2), (0, 1)), strict=True):
        strain[:, a, b] = strain[:, b, a] = values[:, column] / 2
    stress = stress_of(body.material, strain)
    return np.einsum("nic,nc->ni", axes, values[:, :3]), axes @ stress @ np.swapaxes(axes, 1, 2)
