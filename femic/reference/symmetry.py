"""Planes of symmetry: they halve a body, and even and odd fields follow on its other half; and supports.

Every body is symmetric in x. Patches lie at x = 0, so the field of each load is even or odd in x. Where the
section is symmetric in y, half of it is enough: a load at s = 0 is even or odd in y, any other load is the
sum of an even and an odd part.
"""

from dataclasses import dataclass

import numpy as np
from skfem import Mesh

from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.patches import Load, S, X

Y = S


@dataclass(frozen=True)
class Parity:
    """Parity of a field in x and in y: +1 if it is its own mirror image, -1 if it is the opposite of it.

    y = 0 means that the symmetry in y is not used.
    """

    x: int
    y: int

    def signs(self, mirrored: int) -> Array:
        """Parities of the components in the mirrored coordinate, shape (3,): +1 even, -1 odd."""
        parity = self.x if mirrored == X else self.y
        return parity * np.where(np.arange(3) == mirrored, -1.0, 1.0)


def parities(load: Load, *, half_section: bool) -> tuple[Parity, ...]:
    """Parities of the parts that add up to the field of a load."""
    in_x = -1 if load.direction == X else +1
    if not half_section:
        return (Parity(in_x, 0),)
    if load.patch.s == 0:
        return (Parity(in_x, -1 if load.direction == S else +1),)
    return Parity(in_x, +1), Parity(in_x, -1)


def held_by_symmetry(nodes: Array, parity: Parity) -> Mask:
    """Whether components vanish because a node is on a plane of symmetry and they are odd, (n_nodes, 3)."""
    held = np.zeros((nodes.shape[1], 3), dtype=bool)
    for mirrored in (X, Y) if parity.y else (X,):
        held |= on_plane(nodes, mirrored)[:, None] & (parity.signs(mirrored) < 0)
    return held


def held_by_supports(body: Body, mesh: Mesh, y: Array, z: Array, *further: Mask) -> Mask:
    """Whether the supports of a body, or a further one, hold the components of nodes, shape (n_nodes, 3).

    y, z [mm] are section coordinates of the vertices, (n_vertices,) each; `further` supports are marked among
    the vertices. A node is held on boundary facets all of whose vertices lie on one support.
    """
    held = np.zeros((mesh.doflocs.shape[1], 3), dtype=bool)
    for vertices in (*body.on_supports(y, z), *further):
        held[mesh.dofs.get_facet_dofs(boundary_facets_on(mesh, vertices)).flatten()] = True
    return held


def boundary_facets_on(mesh: Mesh, vertices: Mask) -> Indices:
    """Numbers of the boundary facets all of whose vertices are marked; `vertices` has shape (n_vertices,)."""
    facets = mesh.boundary_facets()
    return np.asarray(facets[np.all(vertices[mesh.facets[:, facets]], axis=0)])


def on_plane(nodes: Array, mirrored: int) -> Mask:
    """Whether nodes (3, n) lie on the plane of symmetry x = 0 (y = 0), shape (n,)."""
    return np.asarray(np.abs(nodes[mirrored]) < 1e-9 * np.ptp(nodes, axis=1).max())
