"""Values and slopes of a section's field at points of it: matrices from those at the nodes."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, vstack
from skfem import ElementTriP4

from femic.reference.harmonic.section import SectionMesh
from geometries.arrays import Array, Indices
from geometries.errors import Failure

NEWTON_STEPS = 12
MARGIN = 0.1  # of its size, by which a cell may bulge over the box of its nodes
OUTSIDE = -0.02  # barycentric coordinate below which a point is not in a cell


@dataclass(frozen=True, eq=False)
class Located:
    """The cells in which points lie (n,), and their coordinates in the reference cell (2, n)."""

    cells: Indices
    coordinates: Array


def interpolation(section: SectionMesh, points: Array) -> csr_matrix:
    """Matrix (3 n, n_nodes): values at points (2, n) [mm], then slopes along y, then along z.

    Raises Failure where a point is in no cell.
    """
    located = locate(section, points)
    nodes = section.mesh.dofs.element_dofs[:, located.cells]  # (15, n)
    values, slopes = _shapes(located.coordinates)  # (15, n), (15, 2, n)
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


def locate(section: SectionMesh, points: Array) -> Located:
    """Return the cells of points (2, n) [mm]; raises Failure where a point is in none."""
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
    return Located(cell[last], coordinates[:, last])


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
