"""Slices of long bodies in plane strain: closed forms of line contacts hold in them.

A slice lies between two planes that hold it along x. Its mesh is a tensor grid in x, in arc length s from
the middle of the contact, and in depth d below the surface; half of it, s >= 0, is modelled. Slices are
thin: their stiffness is factorised.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, splu
from skfem import MeshTet, MeshTet2

from femic.contact.finite_elements.bodies import Elastic, Expected
from femic.contact.finite_elements.meshed_contact import Bodies, Meshes, solved
from femic.reference.solid.linear import stiffness
from femic.reference.solid.mesh import Tetrahedra, curved
from femic.reference.symmetry import Parity, held_by_symmetry
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.surfaces import LOWER

OVERHANG = 1.53  # rad, up to which a surface is one for contact: no contour overhangs
GROWTH = 3.0  # of cells away from the contact, over their number along its half-width
SOUGHT = 0.9  # share of the lower surface on which contact is sought
ENDLESS = 1e6  # mm, half-length of the patch along x


@dataclass(frozen=True)
class Section(Body):
    """A body whose contour ends at the arc length `end` [mm]."""

    end: float = np.inf

    @property
    def s_range(self):
        return -self.end, self.end


@dataclass(frozen=True)
class Cells:
    """Cells of `smallest` size [mm] at the contact, `count` along its half-width, and growing ones beyond.

    More of them are smaller everywhere: they grow by exp(GROWTH / count) from one to the next.
    """

    smallest: float
    count: float

    @property
    def thickness(self):
        """Of the slice [mm]."""
        return 2 * self.smallest

    def along(self, equal_to, end):
        """Coordinates from 0 to `end` [mm], equally spaced up to `equal_to` at least."""
        near = np.arange(0, equal_to + self.smallest, self.smallest)
        grown = near[-1] + self.smallest * np.cumsum(np.exp(GROWTH / self.count * np.arange(1, 200)))
        points = np.concatenate([near, grown])
        n = max(1, int(np.searchsorted(points, end)))
        return np.append(points[:n] * end / points[n], end)


def round_section(side, material, radius, *, cells, equal_to, depth):
    """A cylinder (side +1), or the plate around a hole (-1), from its surface to a depth where it is held."""
    s = cells.along(equal_to, np.pi * radius)
    end = float(s[s < OVERHANG * radius].max())
    body = Section(
        side, arc(-radius, OVERHANG, OVERHANG), material, Domain(10 * depth, cells.thickness), end=end
    )

    def position(x, s, d):
        theta, rho = s / radius, radius - side * d
        y = np.where(s < np.pi * radius, rho * np.sin(theta), 0.0)
        return np.stack([x, y, radius - rho * np.cos(theta)])

    return _slice(body, position, s, cells.along(cells.smallest, depth), cells.thickness)


def block(material, *, cells, equal_to, depth):
    """A lower block as wide on each side as it is deep, held below and at its sides."""
    s = cells.along(equal_to, depth)
    body = Section(LOWER, plane(), material, Domain(10 * depth, cells.thickness), end=depth)
    d = cells.along(cells.smallest, depth)
    return _slice(body, lambda x, s, d: np.stack([x, s, -d]), s, d, cells.thickness, side_held=True)


def _slice(body, position, s, d, thickness, *, side_held=False):
    """The prepared slice, held at its largest depth; where s is largest, it is held or in the plane y = 0."""
    tensor = MeshTet.init_tensor(np.array([0, thickness]), s, d)
    on_surface = np.all(tensor.p[2, tensor.facets] == 0, axis=0)
    on_surface &= tensor.p[1, tensor.facets].max(axis=0) <= body.end
    linear = Tetrahedra(position(*tensor.p), tensor.t, tensor.facets[:, on_surface])
    solid = curved(body, linear, half_section=True)
    x, along, below = MeshTet2.from_mesh(tensor).doflocs
    far = (below == d[-1]) | ((along == s[-1]) & side_held)
    return _factorised(solid, np.stack([far | (x == thickness), far, far], axis=1))


def _factorised(solid, supported):
    """The body, solved directly instead of by multigrid."""
    held = supported | held_by_symmetry(solid.nodes, Parity(+1, +1))
    whole = stiffness(solid.mesh, solid.body.material)
    free = diags_array((~held).ravel().astype(float))
    matrix = free @ whole @ free + diags_array(held.ravel().astype(float))
    solve = LinearOperator(matrix.shape, matvec=splu(matrix.tocsc()).solve)
    return Elastic(solid, whole, held, supported, bsr_matrix(matrix), solve)


def pressed(lower, upper, cells, load):
    """The contact of slices under a load per length [N/mm]."""
    half_width = cells.smallest * cells.count
    s_range = tuple(SOUGHT * s for s in lower.solid.body.s_range)
    bodies = Bodies(lower.solid.body, upper.solid.body, s_range)
    expected = Expected(ENDLESS, (-half_width, half_width))
    return solved(bodies, Meshes(expected, cells.count, lower, upper, 0.0), 2 * cells.thickness * load)
