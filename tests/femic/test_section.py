"""Section meshes: on the true contour, with vertices at the ends of the strips, and their trace."""

import numpy as np
import pytest
from skfem import Basis, ElementTriP2

from femic.cell_size import Cells
from femic.section import section_mesh
from femic.section_model import assemble
from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse, plane
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

STEEL = Material(210e3, 0.28)
STRIPS = np.array([[-0.2, 0.3], [3.0, 3.4]])
CELLS = Cells(0.1, 0.3, 0.3)
DOMAIN = Domain(60.0, 60.0)
BODIES = {
    "rail": Body(LOWER, arc(10.0, 0.45, 1.1), STEEL, DOMAIN),
    "wheel": Body(UPPER, ellipse(8.0, 11.0, 0.7, 1.0), STEEL, DOMAIN, 90.0),
    "hub": Body(UPPER, plane(), STEEL, DOMAIN, 40.0, hub_radius=15.0),
}
each = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)


@each
def test_nodes_of_the_contour_lie_on_it_in_order_and_at_the_ends_of_strips(body):
    section = section_mesh(body, CELLS, STRIPS)
    knots = section.knots
    assert np.all(np.diff(knots) > 0)
    assert knots[[0, -1]] == pytest.approx(body.s_range, abs=1e-6)
    for end in STRIPS.ravel():
        assert np.min(np.abs(knots - end)) < 1e-6
    middles = (knots[1:] + knots[:-1]) / 2
    s = np.append(np.stack([knots[:-1], middles]).T.ravel(), knots[-1])
    on_contour = section.mesh.doflocs[:, section.contour_nodes]
    np.testing.assert_allclose(on_contour, body.contour.position(s), atol=1e-9)


@each
def test_the_trace_reads_quadratics_of_s_exactly(body):
    section = section_mesh(body, CELLS, STRIPS)
    middles = (section.knots[1:] + section.knots[:-1]) / 2
    s = np.append(np.stack([section.knots[:-1], middles]).T.ravel(), section.knots[-1])
    nodal = np.zeros(section.mesh.doflocs.shape[1])
    nodal[section.contour_nodes] = 3 * s**2 - 2 * s + 1
    at = np.linspace(-5.0, 7.0, 50)
    np.testing.assert_allclose(
        section.interpolation(at) @ nodal, 3 * at**2 - 2 * at + 1, rtol=1e-12, atol=1e-10
    )


@pytest.mark.parametrize("name", ["rail", "wheel"])
def test_the_mesh_fills_what_contour_and_far_arc_enclose(name):
    body = BODIES[name]
    section = section_mesh(body, Cells(0.1, 0.1, 0.1), STRIPS)
    contour = body.contour.position(np.linspace(*body.s_range, 20_001))
    left, right = np.arctan2(*contour[::-1, [0, -1]])
    left += 2 * np.pi * ((left < right) - 1) if body.side < 0 else 2 * np.pi * (left < right)
    left -= 2 * np.pi * (body.side < 0) * (left > right)
    around = np.linspace(right, left, 20_001)
    y, z = np.hstack([contour, 60.0 * np.stack([np.cos(around), np.sin(around)])])
    enclosed = abs(np.sum(y * np.roll(z, -1) - z * np.roll(y, -1))) / 2
    filled = Basis(section.mesh, ElementTriP2()).dx.sum()
    assert filled == pytest.approx(enclosed, rel=3e-3)  # the cells' far edges are chords: h^2 / 6 R^2


@each
def test_every_node_of_the_far_arc_and_the_hub_is_held_and_no_other(body):
    section = section_mesh(body, CELLS, STRIPS)
    model = assemble(section)
    held = np.setdiff1d(np.arange(model.unknowns), model.free)
    y, z = section.mesh.doflocs
    vertex = np.arange(len(y)) < section.mesh.nvertices
    far = (np.hypot(y, z) > 60.0 - 1e-6) | (body.side * z > body.depth - 1e-6)
    of_vertices = held[vertex[held // 3]]
    expected = 3 * np.flatnonzero(far & vertex)[:, None] + np.arange(3)
    np.testing.assert_array_equal(of_vertices, expected.ravel())
