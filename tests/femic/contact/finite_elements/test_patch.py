"""The contact patch test: two blocks, meshed differently, pass on a uniform pressure exactly.

Both blocks are confined: their sides slide, and so do bottom and top, so that any uniform strain along z is
an exact solution.
"""

import numpy as np
import pytest
from skfem import MeshTet

from femic.contact.finite_elements.bodies import Expected, prepare_body
from femic.contact.finite_elements.meshed_contact import Bodies, Meshes, solved
from femic.reference.solid.engine import SolidModel
from femic.reference.solid.linear import stiffness
from femic.reference.solid.mesh import Tetrahedra, curved
from geometries.bodies import Body, Domain
from geometries.contours import plane
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

LENGTH, WIDTH, LOAD = 2.0, 1.5, 700.0  # mm, mm, N on the modelled quarter
LOWER_BLOCK = ((4, 3, 2), 1.0, Material(210e3, 0.3), LOWER)
UPPER_BLOCK = ((3, 5, 2), 0.8, Material(70e3, 0.2), UPPER)


class Block(Body):
    """A body whose contour ends at the sides of the block."""

    @property
    def s_range(self):
        return -WIDTH, WIDTH


def block(cells, height, material, side):
    """A confined block above (side +1) or below z = 0, with an irregular mesh."""
    body = Block(side, plane(), material, Domain(100.0, LENGTH))
    sizes = LENGTH, WIDTH, height
    mesh = MeshTet.init_tensor(*(np.linspace(0, size, n + 1) for size, n in zip(sizes, cells, strict=True)))
    points = mesh.p.copy()
    shift = 0.15 * np.random.default_rng(side + 1).uniform(-1, 1, points.shape) / np.array(cells)[:, None]
    for axis, size in enumerate(sizes):
        on_side = (points[axis] == 0) | (points[axis] == size)
        points[axis] += np.where(on_side, 0.0, shift[axis])
    points[2] *= side
    facets = mesh.facets[:, np.all(points[2, mesh.facets] == 0, axis=0)]
    solid = curved(body, Tetrahedra(points, mesh.t, facets), half_section=True)
    x, y, z = solid.nodes
    held = np.stack([x == LENGTH, y == WIDTH, z == side * height], axis=1)
    return prepare_body(SolidModel(solid, stiffness(solid.mesh, material), held))


@pytest.fixture(scope="module")
def compressed():
    """The blocks under LOAD."""
    lower, upper = block(*LOWER_BLOCK), block(*UPPER_BLOCK)
    bodies = Bodies(lower.solid.body, upper.solid.body, (-WIDTH, WIDTH))
    meshes = Meshes(Expected(2 * LENGTH, (-2 * WIDTH, 2 * WIDTH)), 2.0, lower, upper, 0.0)
    return solved(bodies, meshes, 4 * LOAD)


def test_the_pressure_is_uniform(compressed):
    assert len(compressed.p) == 20  # all vertices of the lower surface
    assert compressed.p == pytest.approx(np.full(20, LOAD / LENGTH / WIDTH), rel=1e-6)


def test_displacements_are_linear_and_their_largest_are_the_approach(compressed):
    state, approach = compressed.solution.state, 0.0
    for u, (_, height, material, side) in ((state.u_lower, LOWER_BLOCK), (state.u_upper, UPPER_BLOCK)):
        body = compressed.pair.lower if side == LOWER else compressed.pair.upper
        z, strain = body.solid.nodes[2], LOAD / LENGTH / WIDTH / (material.lame + 2 * material.G)
        expected = np.zeros((len(z), 3))
        expected[:, 2] = side * (height - side * z) * strain
        assert u.reshape(-1, 3) == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())
        approach += height * strain
    assert state.approach == pytest.approx(approach, rel=1e-5)


def test_supports_and_pressures_carry_the_load(compressed):
    assert compressed.load_of_pressures == pytest.approx(4 * LOAD, rel=1e-6)
    assert compressed.reactions == pytest.approx((4 * LOAD, -4 * LOAD), rel=1e-5)
