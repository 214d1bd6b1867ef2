"""Displacements and strains of a section's points under waves of traction, one solution per wavenumber.

Tractions t cos(k xi) along s, n and t sin(k xi) along x cause u_x = U sin, u_y = V cos, u_z = W cos; the
other half of the waves has the sines and cosines exchanged and U and k of the opposite sign. Both have the
same stiffness K(k) but for the sign of U: so all elements together are two columns of forces.

Values and slopes at the points follow from those at the nodes of the section (`interpolation`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, vstack
from skfem import ElementTriP4

from femic.reference.harmonic.elimination import Elimination, Equations
from femic.reference.harmonic.section import SectionMesh
from femic.reference.harmonic.section_model import assemble
from femic.reference.harmonic.section_response import not_solved, require_small
from femic.stresses.waves import Spectra
from geometries.arrays import Array, Indices, Mask
from geometries.errors import Failure
from geometries.patches import Grid
from geometries.quadrature import on_panels

# --- fields under waves ---

GAUSS_POINTS = 5  # per part of an edge
COMPONENTS = 9  # u_x, u_y, u_z, strains xx, yy, zz and shears yz, xz, xy
EXCHANGED = np.array([True, False, False, False, False, False, False, True, True])  # with sines for cosines
OF_U = np.array([-1.0, 1.0, 1.0])  # signs of U, V, W in the second half of the waves


@dataclass(frozen=True, eq=False)
class WaveSolver:
    """A function from wavenumbers k [1/mm] to fields at points (2, n), and the residuals that prove them.

    Fields have shape (k, 2, n, `COMPONENTS`): factors of cos(k xi), then of sin(k xi), in section axes. The
    function raises NotConverged.
    """

    section: SectionMesh
    spectra: Spectra
    points: Array
    at_points: csr_matrix
    elimination: Elimination
    forces: csc_matrix  # (amplitudes, 3 n_s) of unit line loads on strips, in the order of elimination

    @classmethod
    def prepare(
        cls, section: SectionMesh, spectra: Spectra, points: Array, share: float = 1.0
    ) -> "WaveSolver":
        """Prepare the equations with the far arc at a `share` of its radius."""
        free = ~(section.supported | _beyond(section, share)[:, None])
        forces = strip_forces(section, spectra.tractions.grid)
        loaded = np.diff(csr_matrix(forces).indptr) > 0
        both = csr_matrix(np.repeat(loaded[:, None], 2, axis=1).astype(float))
        none = np.zeros(len(free), dtype=bool)
        elimination = Elimination.prepare(
            Equations(assemble(section), free, none, both, csr_matrix(both.T)[:0])
        )
        ordered = csc_matrix(forces[elimination.amplitudes])
        return cls(section, spectra, points, interpolation(section, points), elimination, ordered)

    def __call__(self, k: Sequence[float]) -> tuple[Array, Array]:
        """Fields and residuals (k,) at wavenumbers [1/mm]."""
        loads = np.stack([self._forces(one) for one in k])  # (k, amplitudes, 2)
        loaded = np.diff(self.elimination.forces.indptr) > 0
        try:
            eliminated = self.elimination.at(k, loads[:, loaded].reshape(len(k), -1))
        except np.linalg.LinAlgError as error:
            raise not_solved(max(k), loads.shape[1], str(error)) from error
        solution = eliminated.fields(np.zeros((len(k), 0, 2)), np.eye(2))
        unbalanced, load = (
            np.linalg.norm(part, axis=(1, 2)) for part in (eliminated.forces(solution) - loads, loads)
        )
        residuals = unbalanced / np.where(load > 0, load, 1.0)
        for one, residual in zip(k, residuals, strict=True):
            require_small(float(residual), one, loads.shape[1])
        return np.stack([self._strained(*pair) for pair in zip(k, solution, strict=True)]), residuals

    def _forces(self, k: float) -> Array:
        """Forces (amplitudes, 2) of both halves of the waves."""
        cos, sin = self.spectra.amplitudes(k)
        along_x = np.array([True, False, False])
        columns = np.stack([np.where(along_x, sin, cos), OF_U * np.where(along_x, cos, sin)])
        return np.asarray(self.forces @ columns.reshape(2, -1).T)

    def _strained(self, k: float, solution: Array) -> Array:
        """Fields (2, n, `COMPONENTS`) at the points from amplitudes (amplitudes, 2)."""
        n_nodes, body = self.section.mesh.doflocs.shape[1], self.section.body
        fields = np.zeros((3 * n_nodes, 2))
        fields[self.elimination.amplitudes] = solution
        at = np.asarray(self.at_points @ fields.reshape(n_nodes, 6)).reshape(3, -1, 3, 2)
        at[:, :, 0, 1] *= -1
        stretch = 1 - body.side * self.points[1] / body.rolling_radius
        bend = body.side / (body.rolling_radius * stretch)
        halves = np.stack([_strained(at[..., c], k * sign, stretch, bend) for c, sign in ((0, 1), (1, -1))])
        return np.where(EXCHANGED, halves[::-1], halves)


def _beyond(section: SectionMesh, share: float) -> Mask:
    """Nodes beyond a share of the far radius, which are held, (n_nodes,); none for a share of 1."""
    return np.asarray(
        (np.hypot(*section.mesh.doflocs) > share * section.body.domain.far_radius) & (share < 1)
    )


def _strained(at: Array, k: float, stretch: Array, bend: Array) -> Array:
    """Displacements and strains (n, `COMPONENTS`) from values and slopes along y, z (3, n, 3) of U, V, W."""
    (U, V, W), (Uy, Vy, Wy), (Uz, Vz, Wz) = np.moveaxis(at, 2, 1)
    wave = k / stretch
    strains = (wave * U - bend * W, Vy, Wz, Vz + Wy, Uz + bend * U - wave * W, Uy - wave * V)
    return np.stack([U, V, W, *strains], axis=-1)


def strip_forces(section: SectionMesh, grid: Grid) -> csc_matrix:
    """Consistent forces (3 n_nodes, 3 n_s) of unit line loads on the strips of a grid.

    Column 3 l + d belongs to the local direction d on strip l. A load falls linearly from the middle of its
    strip to the middles of the next ones: so tractions are continuous along s.
    """
    low, ds = grid.extent[0] - grid.ds / 2, grid.ds  # the middle of a strip before the first one
    middles = low + ds * np.arange(grid.n_s + 2)
    inner = section.knots[(section.knots > low) & (section.knots < middles[-1])]
    ends = np.unique(np.append(middles, inner))
    nodes, weights = on_panels(ends[:-1], ends[1:], GAUSS_POINTS)
    s = nodes.ravel()
    before = np.clip(np.floor((s - low) / ds).astype(int), 0, grid.n_s)  # the middle before each node
    share = (s - middles[before]) / ds
    hats = csc_matrix(
        (
            np.append(1 - share, share),
            (np.tile(np.arange(len(s)), 2), np.append(before, before + 1)),
        ),
        shape=(len(s), grid.n_s + 2),
    )[:, 1:-1]
    trace = section.interpolation(s).T.tocsr()  # (n_nodes, n)
    axes = section.body.surface.axes(np.zeros_like(s), s) * weights.ravel() / ds  # (d, c, n)
    blocks = {
        (c, d): (trace @ hats.multiply(axes[d, c][:, None])).tocoo() for c in range(3) for d in range(3)
    }
    data, rows, columns = (
        np.concatenate(parts)
        for parts in zip(
            *((block.data, 3 * block.row + c, 3 * block.col + d) for (c, d), block in blocks.items()),
            strict=True,
        )
    )
    return csc_matrix((data, (rows, columns)), shape=(3 * trace.shape[0], 3 * grid.n_s))


# --- values and slopes at points ---

NEWTON_STEPS = 12
MARGIN = 0.1  # of its size, by which a cell may bulge over the box of its nodes
OUTSIDE = -0.02  # barycentric coordinate below which a point is not in a cell


def interpolation(section: SectionMesh, points: Array) -> csr_matrix:
    """Matrix (3 n, n_nodes): values at points (2, n) [mm], then slopes along y, then along z.

    Raises Failure where a point is in no cell.
    """
    cells, coordinates = locate(section, points)
    nodes = section.mesh.dofs.element_dofs[:, cells]  # (15, n)
    values, slopes = _shapes(coordinates)  # (15, n), (15, 2, n)
    jacobian = np.einsum("can,abn->cbn", section.mesh.doflocs[:, nodes], slopes)
    slopes = np.einsum("abn,nbc->acn", slopes, np.linalg.inv(np.moveaxis(jacobian, 2, 0)))
    n = points.shape[1]
    rows = np.broadcast_to(np.arange(n), nodes.shape).ravel()
    shape = (n, section.mesh.doflocs.shape[1])
    return vstack(
        [
            csr_matrix((part.ravel(), (rows, nodes.ravel())), shape=shape)
            for part in (values, slopes[:, 0], slopes[:, 1])
        ],
        format="csr",
    )


def locate(section: SectionMesh, points: Array) -> tuple[Indices, Array]:
    """Return the cells (n,) of points (2, n) [mm], and their coordinates in the reference cell (2, n).

    Raises Failure where a point is in none.
    """
    nodes = section.mesh.doflocs[:, section.mesh.dofs.element_dofs]  # (2, 15, n_cells)
    low, high = nodes.min(axis=1), nodes.max(axis=1)
    margin = MARGIN * (high - low).max(axis=0)
    near = np.all(
        (points[:, :, None] >= (low - margin)[:, None]) & (points[:, :, None] <= (high + margin)[:, None]),
        axis=0,
    )
    of_point, cell = np.nonzero(near)
    coordinates = _inverted(nodes[:, :, cell], points[:, of_point])
    inside = np.min(np.vstack([coordinates, 1 - coordinates.sum(axis=0)]), axis=0)
    order = np.lexsort((inside, of_point))  # the best candidate of each point comes last
    last = order[np.append(np.diff(of_point[order]) > 0, True)] if len(order) else order
    if len(last) < points.shape[1] or np.min(inside[last], initial=0.0) < OUTSIDE:
        raise Failure("points in no cell of the section: its mesh does not reach them; move them a little")
    return cell[last], coordinates[:, last]


def _inverted(nodes: Array, points: Array) -> Array:
    """Coordinates (2, n) in the reference cell of points (2, n) in cells with nodes (2, 15, n), by Newton."""
    coordinates = np.full(points.shape, 1 / 3)
    for _ in range(NEWTON_STEPS):
        values, slopes = _shapes(coordinates)
        jacobian = np.einsum("can,abn->ncb", nodes, slopes)
        apart = points - np.einsum("can,an->cn", nodes, values)
        step = np.linalg.solve(jacobian, apart.T[..., None])[..., 0].T
        coordinates = np.clip(coordinates + step, -1.0, 2.0)
    return coordinates


def _shapes(coordinates: Array) -> tuple[Array, Array]:
    """Shape functions (15, n) at coordinates (2, n), and their slopes (15, 2, n)."""
    element = ElementTriP4()
    values, slopes = zip(*(element.lbasis(coordinates, i) for i in range(15)), strict=True)
    return np.stack(values), np.stack([np.stack(np.broadcast_arrays(*slope)) for slope in slopes])
