"""Tractions as sums of waves along x, and displacements and strains of a section's points under them.

Tractions are known by their amplitudes at wavenumbers that resolve them, up to a largest one: their long
part. On each strip they are uniform on elements of half-length a: an element at xi_j has the amplitudes cos(k
xi_j) and sin(k xi_j) times sin(k a) / (k a) and its force. xi is the chart coordinate, in which waves on a
body of revolution have the same wavenumber on all rolling circles.

There is one solution per wavenumber. Tractions t cos(k xi) along s, n and t sin(k xi) along x cause u_x = U
sin, u_y = V cos, u_z = W cos; the other half of the waves has the sines and cosines exchanged and U and k of
the opposite sign. Both have the same stiffness K(k) but for the sign of U: so all elements together are two
columns of forces. Values and slopes at the points follow from those at the nodes of the section
(`interpolation`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.sparse import csc_matrix, csr_matrix, vstack
from skfem import ElementTriP4

from femic.reference.harmonic.elimination import Elimination
from femic.reference.harmonic.request import SCALE_LOWEST
from femic.reference.harmonic.section import SectionMesh, assemble
from femic.reference.harmonic.section_response import not_solved, require_small
from femic.reference.harmonic.waves import FEWEST_ORDERS, Axis, spectrum, synthesis_weights, taper
from femic.stresses.half_space import hooke_stress
from femic.stresses.points import SurfaceTractions
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.errors import Failure
from geometries.patches import Grid
from geometries.quadrature import on_panels

# --- waves of tractions ---

FEWEST_ELEMENTS = 32  # elements of the loaded part along x, by division of those given
FEWEST_STRIPS = 24  # and along s
LARGEST = 36.0  # largest wavenumber times the loaded half-length: the limit of Filon's panels is about 45
LOG_SPACING = 0.75  # of wavenumbers in ln k, below the inverse of the loaded half-length
SPACING = 0.5 * np.pi  # times the inverse of that length: of larger wavenumbers
FADED = 60.0  # distance times the largest k up to which the long part of a traction spreads


def loaded_part(tractions: SurfaceTractions) -> SurfaceTractions:
    """Return the tractions on the least grid about x = 0 that holds all that are not 0, in enough elements.

    One element is left where there are none.
    """
    grid, loaded = tractions.grid, np.any(tractions.p != 0, axis=2)
    strips = np.flatnonzero(np.any(loaded, axis=0))
    first, last = (int(strips[0]), int(strips[-1])) if len(strips) else (0, 0)
    rows = np.flatnonzero(np.any(loaded | loaded[::-1], axis=1))
    skipped = int(rows[0]) if len(rows) else 0
    p = tractions.p[skipped : grid.n_x - skipped, first : last + 1]
    s = float(grid.strips[first] + grid.strips[last]) / 2
    along_x, along_s = -(-FEWEST_ELEMENTS // p.shape[0]), -(-FEWEST_STRIPS // p.shape[1])
    p = np.repeat(np.repeat(p, along_x, axis=0), along_s, axis=1)
    return SurfaceTractions(Grid(p.shape[0], p.shape[1], grid.dx / along_x, grid.ds / along_s, s), p)


@dataclass(frozen=True, eq=False)
class Spectra:
    """The waves of tractions on a body; `largest` is the largest wavenumber in the chart [1/mm]."""

    body: Body
    tractions: SurfaceTractions  # their loaded part
    largest: float

    @classmethod
    def from_tractions(cls, body: Body, tractions: SurfaceTractions, largest: float) -> "Spectra":
        """The waves of tractions up to a share of `LARGEST` over their half-length."""
        part = loaded_part(tractions)
        return cls(body, part, largest * LARGEST / cls(body, part, 1.0).half_length)

    @property
    def stretch(self) -> Array:
        """Chart length over arc length on the strips, shape (n_s,)."""
        s = self.tractions.grid.strips
        return self.body.surface.chart_x(np.ones_like(s), s, s)

    @property
    def half_length(self) -> float:
        """Half-length of the loaded part in the chart [mm]."""
        grid = self.tractions.grid
        return float(grid.n_x * grid.dx / 2 * np.max(self.stretch))

    @property
    def axis(self) -> Axis:
        """The axis of wavenumbers."""
        return Axis(SCALE_LOWEST / self.body.domain.far_radius, self.largest, self.body.rolling_radius)

    def wavenumbers(self, spacing: float) -> Array:
        """Wavenumbers to be solved [1/mm], in growing order from 0 to the largest one, shape (n,).

        Their spacing is a share of k where k is small, times the root of `spacing`. Where k is large it is a
        share of the inverse half-length of the loaded part, times `spacing`: the responses swing that fast.
        Orders of a ring are integers.
        """
        low, step = self.axis.scale, spacing * SPACING / self.half_length
        k = np.linspace(0.0, self.largest, 20001)
        k = np.unique(np.append(k, low * np.sinh(np.linspace(0, np.arcsinh(self.largest / low), 2001))))
        density = 1 / (np.sqrt(spacing) * LOG_SPACING * np.hypot(k, low)) + 1 / step
        count = np.append(0.0, np.cumsum(np.diff(k) * (density[1:] + density[:-1]) / 2))
        nodes = np.interp(np.linspace(0, count[-1], int(np.ceil(count[-1])) + 1), count, k)
        radius = self.body.rolling_radius
        if np.isinf(radius):
            return nodes
        orders = np.append(np.round(nodes * radius), np.arange(FEWEST_ORDERS))
        return np.unique(np.minimum(orders, np.floor(self.largest * radius))) / radius

    def amplitudes(self, k: float) -> tuple[Array, Array]:
        """Amplitudes of cos(k xi) and sin(k xi) in the forces [N] on the body, shape (n_s, 3) each.

        They are forces per length of chart and per strip, for the weights of a `Spectrum`.
        """
        grid = self.tractions.grid
        phase = k * np.outer(self.tractions.x, self.stretch)  # (n_x, n_s)
        force = self.body.side * grid.area * self.tractions.p
        force = force * np.sinc(k * grid.dx / 2 * self.stretch / np.pi)[:, None]
        return np.sum(np.cos(phase)[..., None] * force, axis=0), np.sum(
            np.sin(phase)[..., None] * force, axis=0
        )

    def long_part(self) -> SurfaceTractions:
        """The part of the tractions whose waves the section is solved for, on a longer grid."""
        grid, p = self.tractions.grid, self.tractions.p
        added = int(np.ceil(FADED / self.largest / grid.dx))
        n_x = grid.n_x + 2 * added
        n = next_fast_len(n_x + added)
        padded = np.pad(p, ((added, added), (0, 0), (0, 0)))
        k = 2 * np.pi * rfftfreq(n, grid.dx)
        share = taper(np.minimum(k[:, None] / self.stretch / self.largest, 1.0))
        long = irfft(share[..., None] * rfft(padded, n, axis=0), n, axis=0)[:n_x]
        return SurfaceTractions(Grid(n_x, grid.n_s, grid.dx, grid.ds, grid.s), long)


# --- fields under waves ---

GAUSS_POINTS = 5  # per part of an edge
COMPONENTS = 9  # u_x, u_y, u_z, strains xx, yy, zz and shears yz, xz, xy
EXCHANGED = np.array([True, False, False, False, False, False, False, True, True])  # with sines for cosines
U_SIGNS = np.array([-1.0, 1.0, 1.0])  # signs of U, V, W in the second half of the waves


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
        """Prepare the equations with the far arc at a `share` of its radius: all nodes beyond it are held."""
        nodes, radius = section.mesh.doflocs, section.body.domain.far_radius
        beyond = (np.hypot(*nodes) > share * radius) & (share < 1)
        free = ~(section.supported | beyond[:, None])
        forces = strip_forces(section, spectra.tractions.grid)
        loaded = np.diff(csr_matrix(forces).indptr) > 0
        both = csr_matrix(np.repeat(loaded[:, None], 2, axis=1).astype(float))
        none = np.zeros(len(free), dtype=bool)
        elimination = Elimination.prepare(assemble(section), free, none, both, csr_matrix(both.T)[:0])
        ordered = csc_matrix(forces[elimination.amplitudes])
        return cls(section, spectra, points, interpolation(section, points), elimination, ordered)

    def __call__(self, k: Sequence[float]) -> tuple[Array, Array]:
        """Fields and residuals (k,) at wavenumbers [1/mm]."""
        loads = np.empty((len(k), self.forces.shape[0], 2))  # of both halves of the waves
        along_x = np.array([True, False, False])
        for one, load in zip(k, loads, strict=True):
            cos, sin = self.spectra.amplitudes(one)
            columns = np.stack([np.where(along_x, sin, cos), U_SIGNS * np.where(along_x, cos, sin)])
            load[...] = self.forces @ columns.reshape(2, -1).T
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
        return np.stack([self._read(*pair) for pair in zip(k, solution, strict=True)]), residuals

    def _read(self, k: float, solution: Array) -> Array:
        """Fields (2, n, `COMPONENTS`) at the points from amplitudes (amplitudes, 2)."""
        n_nodes, body = self.section.mesh.doflocs.shape[1], self.section.body
        fields = np.zeros((3 * n_nodes, 2))
        fields[self.elimination.amplitudes] = solution
        at = np.asarray(self.at_points @ fields.reshape(n_nodes, 6)).reshape(3, -1, 3, 2)
        at[:, :, 0, 1] *= -1
        stretch = 1 - body.side * self.points[1] / body.rolling_radius
        bend = body.side / (body.rolling_radius * stretch)
        halves = np.stack([strain(at[..., c], k * sign, stretch, bend) for c, sign in ((0, 1), (1, -1))])
        return np.where(EXCHANGED, halves[::-1], halves)


def strain(at: Array, k: float, stretch: Array, bend: Array) -> Array:
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
        (np.append(1 - share, share), (np.tile(np.arange(len(s)), 2), np.append(before, before + 1))),
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

NEWTON_STEPS = 12  # to invert the map of a cell
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
    point, cell = np.nonzero(near)
    candidates, coordinates = nodes[:, :, cell], np.full((2, len(cell)), 1 / 3)
    for _ in range(NEWTON_STEPS):
        values, slopes = _shapes(coordinates)
        jacobian = np.einsum("can,abn->ncb", candidates, slopes)
        apart = points[:, point] - np.einsum("can,an->cn", candidates, values)
        step = np.linalg.solve(jacobian, apart.T[..., None])[..., 0].T
        coordinates = np.clip(coordinates + step, -1.0, 2.0)
    inside = np.min(np.vstack([coordinates, 1 - coordinates.sum(axis=0)]), axis=0)
    order = np.lexsort((inside, point))  # the best candidate of each point comes last
    last = order[np.append(np.diff(point[order]) > 0, True)] if len(order) else order
    if len(last) < points.shape[1] or np.min(inside[last], initial=0.0) < OUTSIDE:
        raise Failure("points in no cell of the section: its mesh does not reach them; move them a little")
    return cell[last], coordinates[:, last]


def _shapes(coordinates: Array) -> tuple[Array, Array]:
    """Shape functions (15, n) at coordinates (2, n), and their slopes (15, 2, n)."""
    element = ElementTriP4()
    values, slopes = zip(*(element.lbasis(coordinates, i) for i in range(15)), strict=True)
    return np.stack(values), np.stack([np.stack(np.broadcast_arrays(*slope)) for slope in slopes])


# --- fields from their waves ---

SHEARS = ((6, 1, 2), (7, 0, 2), (8, 0, 1))  # column of values, and its place in the matrix of strains


def synthesise(spectra: Spectra, k: Array, fields: Array, place: Indices, xi: Array) -> Array:
    """Values (n, c) at points from their waves (len(k), 2, places, c).

    `place` (n,) is the number of each point's place in the section, `xi` (n,) its coordinate in the chart
    [mm].
    """
    wavenumbers = spectrum(spectra.largest, spectra.body.rolling_radius)
    distinct, number = np.unique(xi, return_inverse=True)
    even, odd = synthesis_weights(spectra.axis, k, wavenumbers, wavenumbers.shares(0.0, distinct))
    values = np.empty((len(xi), fields.shape[-1]))
    for x in range(len(distinct)):
        here = np.flatnonzero(number == x)
        at = fields[:, :, place[here]]
        values[here] = np.tensordot(even[:, x], at[:, 0], 1) + np.tensordot(odd[:, x], at[:, 1], 1)
    return values


def in_local_axes(body: Body, s: Array, values: Array) -> tuple[Array, Array]:
    """Displacements (n, 3) and stresses (n, 3, 3) along x, s, n from values (n, 9) in section axes.

    Values are displacements, strains xx, yy, zz, and shear strains yz, xz, xy.
    """
    axes = np.moveaxis(body.surface.axes(np.zeros_like(s), s), 2, 0)  # (n, direction, component)
    strain = np.empty((len(s), 3, 3))
    for a in range(3):
        strain[:, a, a] = values[:, 3 + a]
    for column, a, b in SHEARS:
        strain[:, a, b] = strain[:, b, a] = values[:, column] / 2
    stress = axes @ hooke_stress(body.material, strain) @ np.swapaxes(axes, 1, 2)
    return np.einsum("nic,nc->ni", axes, values[:, :3]), stress
