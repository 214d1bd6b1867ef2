"""Closed forms of line contacts, in plane strain: a cylinder on a block, and a pin that fits its hole.

The pin is the closed form of conforming contact: its pressures are not those of half-planes.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.sparse import bsr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, splu
from skfem import MeshTet, MeshTet2

from femic.contact.exact.hertz import LineContact, combined_modulus
from femic.contact.finite_elements.bodies import Elastic, Expected
from femic.contact.finite_elements.meshed_contact import Bodies, Meshes, solved
from femic.reference.solid.linear import stiffness
from femic.reference.solid.mesh import Tetrahedra, curved
from femic.reference.symmetry import Parity, held_by_symmetry
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.exact.pin import PinInHole
from tests.femic.contact.problems import BRASS, STEEL

# ---- slices of long bodies between two planes that hold them along x
# Meshes are tensor grids in x, in arc length s from the middle of the contact, and in depth d below the
# surface; half of each, s >= 0, is modelled. Slices are thin: their stiffness is factorised.

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


# ---- contacts

SIMILAR = Material(500e3, 0.0), Material(50e3 * 1.45, 0.45)  # of Dundurs' beta 0, though not equal
HUB = 0.03  # radius at which pins are held, as a share of their own
FAR = 40.0  # half-widths or radii to the ends of blocks and plates: errors of 1 / 1600
INSIDE = 0.8  # of the half-width: there pressures are smooth


def difference(level, truth, half_width):
    """Root mean square over the inside of the patch, over the largest pressure.

    Pressures are means over the slice: they differ from side to side, as the cells do.
    """
    s, of = np.unique(np.round(level.pair.s, 9), return_inverse=True)
    p = np.bincount(of, level.p) / np.bincount(of)
    inside = s < INSIDE * half_width
    return np.sqrt(np.mean((p - truth(s))[inside] ** 2)) / truth(0.0)


def check_numbers(level, truth, half_width):
    """The largest pressure within 0.4 %, the edge within 0.3 spacings: few vertices are left beyond it."""
    assert level.p.max() == pytest.approx(truth(0.0), rel=0.004)
    assert level.s_range[1] == pytest.approx(half_width, abs=0.3 * level.spacing)
    assert level.reactions == pytest.approx((level.load, -level.load), rel=1e-5)


def test_a_cylinder_on_a_block_converges_to_hertz():
    """Its patch is so narrow, a 30th of the radius, that half-planes are right within 0.1 %."""
    half_width, radius = 1.0, 30.0
    line = LineContact(1 / radius, combined_modulus(STEEL, BRASS))
    load = np.pi * line.modulus * half_width**2 / (4 * radius)
    errors = []
    for count in (4.0, 8.0):
        cells = Cells(half_width / count, count)
        mesh = {"cells": cells, "equal_to": 1.4 * half_width + 2 * cells.smallest}
        lower = block(STEEL, depth=FAR * half_width, **mesh)
        upper = round_section(UPPER, BRASS, radius, depth=(1 - HUB) * radius, **mesh)
        level = pressed(lower, upper, cells, load)
        check_numbers(level, lambda s: line.pressure(load, s), half_width)
        errors.append(difference(level, lambda s: line.pressure(load, s), half_width))
    assert errors[1] < 0.004
    assert errors[1] < errors[0] / 2  # first order, or better


@pytest.mark.parametrize(
    ("materials", "half_angle", "count"),
    [((STEEL, STEEL), 45.0, 8.0), (SIMILAR, 45.0, 8.0), ((STEEL, STEEL), 60.0, 11.0)],
    ids=["equal", "similar", "equal, 120 degrees"],
)
def test_pin_in_a_fitting_hole_agrees_with_persson(materials, half_angle, count):
    """Pressures over 90 and 120 degrees. Hertz's are at least a fifth too small."""
    radius, clearance, angle = 12.0, 0.012, np.radians(half_angle)
    pin = PinInHole(*materials, radius, clearance)
    load, half_width = pin.load(angle), radius * angle
    cells = Cells(half_width / count, count)

    def truth(s):
        return pin.pressure(load, np.minimum(s / (radius + clearance), angle))

    mesh = {"cells": cells, "equal_to": OVERHANG * radius - cells.smallest}
    hole = round_section(LOWER, pin.hole, radius + clearance, depth=FAR * radius, **mesh)
    shaft = round_section(UPPER, pin.pin, radius, depth=(1 - HUB) * radius, **mesh)
    level = pressed(hole, shaft, cells, load)
    check_numbers(level, truth, half_width)
    assert difference(level, truth, half_width) < 0.004
    hertz = LineContact(1 / radius - 1 / (radius + clearance), pin.modulus)
    assert hertz.p_max(load) < 0.8 * truth(0.0)
