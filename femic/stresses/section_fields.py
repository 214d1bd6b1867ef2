"""Displacements and strains of a section's points under waves of traction, one solution per wavenumber.

Tractions t cos(k xi) along s, n and t sin(k xi) along x cause u_x = U sin, u_y = V cos, u_z = W cos; the
other half of the waves has the sines and cosines exchanged and U and k of the opposite sign. Both have the
same stiffness K(k) but for the sign of U: so all elements together are two columns of forces.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_matrix

from femic.reference.harmonic.equations import factors_of, require_small
from femic.reference.harmonic.section import SectionMesh
from femic.reference.harmonic.section_model import assemble
from femic.stresses.cells import interpolation
from femic.stresses.spectra import Spectra
from geometries.arrays import Array, Mask
from geometries.grids import Grid
from geometries.quadrature import on_panels

GAUSS_POINTS = 5  # per part of an edge
COMPONENTS = 9  # u_x, u_y, u_z, strains xx, yy, zz and shears yz, xz, xy
WaveSolver = Callable[[float], tuple[Array, float]]
EXCHANGED = np.array([True, False, False, False, False, False, False, True, True])  # with sines for cosines


def wave_solver(section: SectionMesh, spectra: Spectra, points: Array, share: float = 1.0) -> WaveSolver:
    """Return a function from k [1/mm] to fields at points (2, n), and the residual that proves them.

    Fields have shape (2, n, `COMPONENTS`): factors of cos(k xi), then of sin(k xi), in section axes. The far
    arc lies at a `share` of its radius. The function raises NotConverged.
    """
    model, at_points = assemble(section), interpolation(section, points)
    free = ~(section.supported | _beyond(section, share)[:, None]).ravel()[model.amplitudes]
    numbers, stiffness = model.amplitudes[free], model.stiffness.restricted(free)
    forces = strip_forces(section, spectra.tractions.grid)[numbers]
    body, n_nodes = section.body, section.mesh.doflocs.shape[1]
    stretch = 1 - body.side * points[1] / body.rolling_radius
    bend = body.side / (body.rolling_radius * stretch)
    signs = np.array([-1.0, 1.0, 1.0])  # of U in the second half of the waves

    def solve(k: float) -> tuple[Array, float]:
        cos, sin = spectra.amplitudes(k)
        along_x = np.array([True, False, False])
        columns = np.stack([np.where(along_x, sin, cos), signs * np.where(along_x, cos, sin)])
        loads = forces @ columns.reshape(2, -1).T  # (free amplitudes, 2)
        matrix = stiffness.at(k)
        solution = factors_of(matrix, k).solve(loads)
        unbalanced, load = (float(np.linalg.norm(part)) for part in (matrix @ solution - loads, loads))
        residual = unbalanced / (load or 1.0)
        require_small(residual, k, stiffness.size)
        fields = np.zeros((3 * n_nodes, 2))
        fields[numbers] = solution
        at = np.asarray(at_points @ fields.reshape(n_nodes, 6)).reshape(3, -1, 3, 2)
        at[:, :, 0, 1] *= -1
        halves = np.stack([_strained(at[..., c], k * sign, stretch, bend) for c, sign in ((0, 1), (1, -1))])
        return np.where(EXCHANGED, halves[::-1], halves), residual

    return solve


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
