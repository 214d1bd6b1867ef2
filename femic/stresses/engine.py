"""Displacements and stresses inside the actual body, by the harmonic engine.

All elements together are one load per wavenumber k (`femic.stresses.waves`). The stress is

    half-space(all waves) + [section - half-space](waves up to the largest k)

with the half-space unrolled by the arc lengths x, s and the depth below the surface. Short waves do not reach
deep: to them the body is its tangent half-space. The rest in brackets, what the actual body adds by its long
waves, is smooth, so that it can be continued to the surface (`near_surface`). Theory:
docs/theory/stresses.md.
"""

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.cache.workers import in_threads, one_blas_thread
from femic.reference.engine import Cost, peak_memory
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.request import FAR_REACH
from femic.reference.harmonic.section import SectionMesh, SectionSize, section_mesh
from femic.reference.meshing import Cells
from femic.stresses.field import StressField
from femic.stresses.half_space import half_space_field, on_half_space, staircase
from femic.stresses.near_surface import sample_centres, sample_points
from femic.stresses.points import InnerPoints, SurfaceTractions, merged, require_inside
from femic.stresses.resolution import Resolution
from femic.stresses.waves import COMPONENTS, Spectra, WaveSolver, in_local_axes, synthesise
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.patches import Grid

# --- field with its estimate ---

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
    """Return displacements and stresses of the tractions in the actual body, half-space stresses beside them.

    Raises WrongInput for points outside the body, NotConverged where a wavenumber cannot be solved.
    """
    require_inside(body, points)
    resolution = Resolution.at_fineness(settings.fineness)
    flat = half_space_field(body, tractions, points)
    model = SectionUnderWaves.mesh(body, tractions, resolution)
    u, rest, cost = model.body_correction(points, settings.workers)
    field = StressField(body, points, flat.u + u, flat.stress + rest, flat.stress, cost=cost)
    if not settings.estimated:
        return replace(field, estimate=np.full(points.shape, np.nan))
    coarse = SectionUnderWaves.mesh(body, tractions, resolution.coarser)
    coarser_rest = coarse.body_correction(points, settings.workers)[1]
    parts = {"section": SECTION_SHARE * _with_floor(_largest(coarser_rest - rest))}
    if body.truncated:
        parts["far arc"] = _with_floor(_largest(coarse.far_arc_change(points, settings.workers)))
    flat_of_merged = half_space_field(body, merged(tractions), points).stress
    share = np.where(tractions.beside_edge(points.x, points.s, points.depth), AT_EDGES, OF_ELEMENTS)
    parts["elements"] = share * _largest(flat_of_merged - flat.stress)
    largest = {name: float(np.max(part, initial=0.0)) for name, part in parts.items()}
    return replace(field, estimate=sum(parts.values(), np.zeros(points.shape)), estimate_parts=largest)


def _largest(change: Array) -> Array:
    """The largest component of changes (..., 3, 3), shape (...)."""
    return np.asarray(np.max(np.abs(change), axis=(-2, -1)))


def _with_floor(change: Array) -> Array:
    """The changes (...), and a share of the largest of them."""
    return np.asarray(change + FLOOR * np.max(change, initial=0.0))


# --- what the actual body adds ---

TRUSTED = 0.35  # cells on the strips deep: from there on the section is trusted
FEWEST_BESIDE, BESIDE = 3, 1 / 6  # strips beside the loaded ones with cells as fine: least number, share
NEARER = 0.5  # share of the far radius at which the far arc lies that shows the truncation error
ALONG_N = np.arange(3) == 2
TRACTIONS = ALONG_N | ALONG_N[:, None]  # components of stress that vanish at the surface of the rest


@dataclass(frozen=True, eq=False)
class SectionUnderWaves:
    """A meshed section, the waves of its tractions, and the largest cell on its loaded strips [mm]."""

    section: SectionMesh
    spectra: Spectra
    resolution: Resolution
    cell: float
    seconds: float  # of meshing

    @classmethod
    def mesh(cls, body: Body, tractions: SurfaceTractions, resolution: Resolution) -> "SectionUnderWaves":
        """Mesh the section of a body under tractions; raises Failure where Gmsh cannot mesh it."""
        start = perf_counter()
        spectra = Spectra.from_tractions(body, tractions, resolution.largest)
        blocks = strip_blocks(spectra.tractions.grid, resolution.cells)
        cell = float(np.max(np.ptp(blocks, axis=1)))
        size = SectionSize(Cells(cell, resolution.growth, resolution.growth), blocks, cell)
        section = section_mesh(body, size)
        return cls(section, spectra, resolution, cell, perf_counter() - start)

    def body_correction(self, points: InnerPoints, workers: int) -> tuple[Array, Array, Cost]:
        """Displacements (..., 3) and stresses (..., 3, 3) beyond the half-space's, and the cost."""
        samples = sample_points(points, TRUSTED * self.cell)
        long_part = self.spectra.long_part()
        centres = sample_centres(long_part.grid, samples.points, along_x=False)
        u, stress, cost = self.long_waves(centres.points, workers)
        flat_u, flat_stress = on_half_space(self.section.body, long_part, centres.points)
        flat_stress[centres.on_lattice] -= staircase(
            self.section.body, long_part, centres.lattice_points, along_x=False
        )
        return (
            samples.extend(centres.at_points(u - flat_u), np.zeros(3, dtype=bool)),
            samples.extend(centres.at_points(stress - flat_stress), TRACTIONS),
            cost,
        )

    def long_waves(self, points: InnerPoints, workers: int) -> tuple[Array, Array, Cost]:
        """Displacements (n, 3) and stresses (n, 3, 3) along x, s, n at points (n,), and the cost."""
        mesh, start = self.section.mesh, perf_counter()
        k = self.spectra.wavenumbers(self.resolution.spacing)
        places, place = np.unique(points.in_section(self.section.body), axis=1, return_inverse=True)
        solver = WaveSolver.prepare(self.section, self.spectra, places)
        assembled = perf_counter()
        fields, residual = _solve_waves(solver, k, workers)
        u, stress = self._at(points, k, fields, place.ravel())
        stages = self.seconds, assembled - start, perf_counter() - assembled
        seconds = dict(zip(("mesh", "assembly", "solution"), stages, strict=True))
        unknowns, method = 3 * mesh.doflocs.shape[1], f"direct, {len(k)} wavenumbers"
        return u, stress, Cost(unknowns, int(mesh.nelements), method, (), residual, seconds, peak_memory())

    def far_arc_change(self, points: InnerPoints, workers: int) -> Array:
        """How stresses (..., 3, 3) change with a nearer far arc, 0 beyond that."""
        k = self.spectra.wavenumbers(self.resolution.spacing)
        far = k < FAR_REACH / (NEARER * self.section.body.domain.far_radius)
        flat = points.flat
        places, place = np.unique(flat.in_section(self.section.body), axis=1, return_inverse=True)
        fields = np.zeros((len(k), 2, places.shape[1], COMPONENTS))
        for share, sign in ((NEARER, 1.0), (1.0, -1.0)):
            solver = WaveSolver.prepare(self.section, self.spectra, places, share)
            fields[far] += sign * _solve_waves(solver, k[far], workers)[0]
        inside = np.hypot(*places) < NEARER * self.section.body.domain.far_radius
        fields[:, :, ~inside] = 0.0
        return self._at(flat, k, fields, place.ravel())[1].reshape(*points.shape, 3, 3)

    def _at(self, points: InnerPoints, k: Array, fields: Array, place: Indices) -> tuple[Array, Array]:
        """Displacements (n, 3) and stresses (n, 3, 3) at points from waves (len(k), 2, places, c)."""
        body = self.section.body
        with one_blas_thread():
            values = synthesise(self.spectra, k, fields, place, points.in_chart(body))
        return in_local_axes(body, points.s, values)


def _solve_waves(solver: WaveSolver, k: Array, workers: int) -> tuple[Array, float]:
    """Waves (len(k), 2, places, c) at wavenumbers [1/mm], and the worst residual."""
    with one_blas_thread():
        parts = in_parts(k.tolist(), solver.elimination.batch_size, workers)
        fields, residuals = zip(*in_threads(solver, parts, workers), strict=True)
    return np.concatenate(fields), float(np.max(np.concatenate(residuals)))


def strip_blocks(grid: Grid, cells: float) -> Array:
    """Ends [mm] of parts of the loaded width and its margin, shape (n, 2): about `cells` on the width.

    They are groups of strips, or equal parts of strips, so that all strips lie in them alike.
    """
    together, parts = max(1, round(grid.n_s / cells)), max(1, round(cells / grid.n_s))
    beside = max(FEWEST_BESIDE, round(BESIDE * grid.n_s))
    n = together * -(-(grid.n_s + 2 * beside) // together)
    edges = grid.extent[0] - beside * grid.ds + grid.ds / parts * np.arange(n * parts + 1)
    ends = edges[::together]
    return np.stack([ends[:-1], ends[1:]], axis=1)
