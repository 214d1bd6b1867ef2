"""One of the two bodies: mesh, stiffness, supports and multigrid, built once and used for all loads."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_matrix
from scipy.sparse.linalg import LinearOperator

from femic.reference.meshing import Cells
from femic.reference.solid.engine import SolidModel, assemble, from_vertices
from femic.reference.solid.linear import System, multigrid, rigid_body_modes
from femic.reference.solid.mesh import Focus, SolidMesh, solid_mesh
from femic.reference.symmetry import Parity, held_by_symmetry
from geometries.arrays import Array, Mask
from geometries.bodies import Body
from geometries.errors import Failure

GROWTH = 3.0  # growth of the cells with the distance from the patch, times the cells per half-length
ALONG = 0.27  # growth along the crown beyond the patch, as a share of that: a section curves where x does not
SPACING = 4.0  # of points at which cells are smallest, in cells
STRETCH = 1.1  # ratio of the distances of neighbouring points along the crown
OTHER_SIZES = (1.0, 0.96, 1.04, 0.92)  # of cells, tried one after the other where a mesh fails


@dataclass(frozen=True)
class Expected:
    """The patch for which meshes are made: half-length a along x, range of arc lengths s [mm]."""

    a: float
    s: tuple[float, float]

    @property
    def b(self) -> float:
        """Half-width along s [mm]."""
        return (self.s[1] - self.s[0]) / 2

    def radius(self, x: Array, s: Array) -> Array:
        """Return the distance of points from the middle over that of the edge in their direction."""
        return np.asarray(np.hypot(x / self.a, (s - sum(self.s) / 2) / self.b))


@dataclass(frozen=True, eq=False)
class Elastic:
    """A body that can be solved: its matrix has unit rows (scaled) where components are held."""

    solid: SolidMesh
    stiffness: bsr_matrix  # [N/mm], with no component held
    held: Mask  # (n_nodes, 3), by supports or by symmetry
    supported: Mask  # (n_nodes, 3), by supports alone
    matrix: bsr_matrix
    preconditioner: LinearOperator

    @property
    def unknowns(self) -> int:
        """Number of displacement components, held ones included."""
        return int(self.matrix.shape[0])

    def reaction(self, u: Array) -> Array:
        """Resultant [N] of the forces of the supports on the model, shape (3,), at displacements u [mm]."""
        force = (self.stiffness @ u).reshape(-1, 3)
        return np.asarray(np.sum(np.where(self.supported, force, 0.0), axis=0))


def prepare_body(model: SolidModel) -> Elastic:
    """Prepare a model, symmetric in x (and in y where half of the section is meshed), for its solution."""
    solid = model.solid
    parity = Parity(+1, +1 if solid.half_section else 0)
    held = model.supported | held_by_symmetry(solid.nodes, parity)
    system = System(model.stiffness, held, rigid_body_modes(solid.nodes), from_vertices(solid))
    return Elastic(solid, model.stiffness, held, model.supported, *multigrid(system))


def mesh_body(body: Body, expected: Expected, cells: float, *, half_section: bool) -> Elastic:
    """Mesh a body with `cells` cells along the shorter half-length of a patch on it, and prepare it.

    Cells are equal in the patch and grow in proportion to the distance from it. Far from it, where they may
    be larger than the radius of the contour, those that would fold stay straight. Raises Failure where Gmsh
    cannot mesh it.
    """
    smallest = min(expected.a, expected.b) / cells
    patch = _covering(expected, SPACING * smallest, half_section)
    end = body.xi_end
    x = np.geomspace(expected.a, end, max(2, round(np.log(end / expected.a) / np.log(STRETCH))))
    crown = np.stack([x, np.full_like(x, 0.0 if half_section else sum(expected.s) / 2)])  # to the body's end
    focus = Focus(body.surface.position(*patch), body.surface.position(*np.hstack([patch, crown])))
    size = Cells(smallest, GROWTH / cells, ALONG * GROWTH / cells)
    for factor in OTHER_SIZES:
        try:
            solid = solid_mesh(
                body, size.scaled(factor), focus, half_section=half_section, curved_within=SPACING * smallest
            )
        except Failure:
            if factor == OTHER_SIZES[-1]:
                raise
        else:
            break
    return prepare_body(assemble(solid))


def _covering(expected: Expected, spacing: float, half_section: bool) -> Array:
    """Return points (x, s) [mm] of the modelled part of a patch, up to its edge, shape (2, n)."""
    low, high = (0.0 if half_section else expected.s[0]), expected.s[1]
    x, s = (
        np.linspace(start, end, 1 + round(np.ceil((end - start) / spacing)))
        for start, end in ((0.0, expected.a), (low, high))
    )
    x, s = (grid.ravel() for grid in np.meshgrid(x, s, indexing="ij"))
    inside = expected.radius(x, s) <= 1
    n_edge = 5 + round(np.ceil(np.pi * max(expected.a, expected.b) / spacing))
    phi = np.linspace(-np.pi / 2, np.pi / 2, n_edge)
    edge = np.stack([expected.a * np.cos(phi), sum(expected.s) / 2 + expected.b * np.sin(phi)])
    return np.hstack([np.stack([x, s])[:, inside], edge[:, edge[1] >= low - 1e-9 * expected.b]])
