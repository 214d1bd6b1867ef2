"""The judge by CalculiX: its meshes, loads, input and reading, and the cheapest of its cases."""

import contact
import deck
import ics
import meshing
import numpy as np
import pytest

from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material

RADIUS, FAR, LENGTH = 10.0, 20.0, 30.0
PATCH = meshing.Rectangle(0.8, 2.0, 3.6)
CALCULIX_MIDDLES = {4: (0, 1), 5: (1, 2), 6: (2, 0), 7: (0, 3), 8: (1, 3), 9: (2, 3)}  # its manual, C3D10
CALCULIX_SIDES = {1: (0, 1, 2), 2: (0, 3, 1), 3: (1, 3, 2), 4: (2, 3, 0)}  # its manual, *SURFACE


def coarse(side, rolling_radius=np.inf):
    """A coarse mesh of a body."""
    domain, steel = Domain(FAR, LENGTH), Material(210e3, 0.3)
    body = Body(side, arc(RADIUS, 0.7, 0.5), steel, domain, rolling_radius=rolling_radius)
    points = body.surface.position(np.array([0.0, 0.8]), np.array([2.8, 2.8]))
    return meshing.mesh(body, meshing.Fineness(0.5, 0.6, points), PATCH)


@pytest.fixture(scope="module")
def rail():
    return coarse(-1)


@pytest.fixture(scope="module")
def wheel():
    return coarse(+1, 100.0)


def test_cells_fill_the_section_times_the_length(rail):
    """To 1e-3: facets of the far arc, of up to 8 mm, are parabolas."""
    contour = rail.body.contour.position(np.linspace(*rail.body.s_range, 20001))
    left, right = (np.arctan2(*contour[::-1, k]) % (2 * np.pi) for k in (0, -1))
    angle = np.linspace(right, left, 20001)  # clockwise, through the bottom
    y, z = np.hstack([contour, FAR * np.stack([np.cos(angle), np.sin(angle)])])
    area = abs(np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z)) / 2
    volume = np.sum(meshing.jacobians(rail.nodes[rail.cells])[:, -4:]) / 24
    assert volume == pytest.approx(area * LENGTH, rel=1e-3)


@pytest.mark.parametrize("name", ["rail", "wheel"])
def test_nodes_of_the_contact_surface_lie_on_it_and_all_cells_are_sound(name, request):
    mesh = request.getfixturevalue(name)
    on = np.unique(mesh.surface)
    expected = mesh.body.surface.position(*mesh.chart[on].T).T
    np.testing.assert_allclose(mesh.nodes[on], expected, atol=0.05 * RADIUS)  # straightened cells far away
    near = on[(mesh.chart[on, 0] < 3) & (np.abs(mesh.chart[on, 1] - 2.8) < 3)]
    expected = mesh.body.surface.position(*mesh.chart[near].T).T
    np.testing.assert_allclose(mesh.nodes[near], expected, atol=1e-9)
    assert np.all(meshing.jacobians(mesh.nodes[mesh.cells]) > 0)


def test_mid_side_nodes_have_the_order_of_calculix(rail):
    """They lie within a fifth of the edge of its middle: edges are curved by a little."""
    for middle, ends in CALCULIX_MIDDLES.items():
        start, end = (rail.nodes[rail.cells[:, k]] for k in ends)
        apart = np.linalg.norm(rail.nodes[rail.cells[:, middle]] - (start + end) / 2, axis=1)
        assert np.all(apart < 0.2 * np.linalg.norm(end - start, axis=1))


def test_patch_is_made_of_whole_faces(rail):
    corners = rail.chart[rail.faces_in(PATCH)[:, :3]]
    areas = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 2
    assert np.sum(areas) == pytest.approx(PATCH.length * (PATCH.s_end - PATCH.s_start), rel=1e-9)


def test_a_flat_face_has_a_third_of_its_load_at_each_mid_side_node(rail):
    """The consistent loads of a straight quadratic triangle; its corners have none."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.2, 0.7, 0.0]])
    nodes = np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
    chart = nodes[:, :2].copy()
    flat = meshing.Mesh(
        rail.body, nodes, np.empty((0, 10), int), np.arange(6)[None], chart, *np.zeros((2, 6))
    )
    loads = deck.face_loads(flat, flat.surface, np.array([2.0, 0.0, 0.0]))
    np.testing.assert_allclose(loads[:, 0], 2.0 * 0.35 * np.array([0, 0, 0, 1, 1, 1]) / 3, atol=1e-14)


def wrench(mesh, traction):
    """Force and moment about the origin of the consistent loads of the patch."""
    loads = deck.face_loads(mesh, mesh.faces_in(PATCH), np.array(traction, dtype=float))
    return loads.sum(axis=0), np.cross(mesh.nodes, loads).sum(axis=0)


def test_loads_have_the_wrench_of_the_tractions(rail):
    """On an arc of angles d1 to d2: the integral of n is R (cos d1 - cos d2, sin d2 - sin d1) along y, z.

    To 1e-6: faces are parabolas of 0.5 mm on a radius of 10 mm.
    """
    d1, d2 = PATCH.s_start / RADIUS, PATCH.s_end / RADIUS
    normal = RADIUS * np.array([0.0, np.cos(d1) - np.cos(d2), np.sin(d2) - np.sin(d1)])
    tangent = np.array([0.0, normal[2], -normal[1]])
    area, centre = PATCH.length * (PATCH.s_end - PATCH.s_start), np.array([PATCH.length / 2, 0.0, -RADIUS])
    force, moment = wrench(rail, [0, 0, 1])
    np.testing.assert_allclose(force, PATCH.length * normal, atol=1e-6 * area)
    np.testing.assert_allclose(moment, np.cross(centre, force), atol=1e-5 * area)  # they meet in the axis
    force, moment = wrench(rail, [0, 1, 0])
    np.testing.assert_allclose(force, PATCH.length * tangent, atol=1e-6 * area)
    about_axis = moment - np.cross(centre, force)
    np.testing.assert_allclose(about_axis, [-RADIUS * area, 0, 0], atol=1e-5 * area)
    np.testing.assert_allclose(wrench(rail, [1, 0, 0])[0], [area, 0, 0], atol=1e-6 * area)


def test_loads_turn_with_a_wheel(wheel):
    """Tractions along x have a moment about the axle: radius times force, ring by ring of the contour."""
    axle = np.array([0.0, 0.0, wheel.body.rolling_radius])
    force, moment = wrench(wheel, [1, 0, 0])
    s = np.linspace(PATCH.s_start, PATCH.s_end, 2001)
    radius = wheel.body.surface.circle_radius((s[1:] + s[:-1]) / 2)
    angle = PATCH.length / wheel.body.rolling_radius
    about_axle = (moment - np.cross(axle, force))[1]
    assert abs(about_axle) == pytest.approx(angle * np.sum(radius**2) * (s[1] - s[0]), rel=1e-5)


def test_element_faces_are_the_loaded_ones(rail):
    part = deck.Part("RAIL", rail, first_node=101, first_cell=1001)
    faces = rail.faces_in(PATCH)
    found = [line.split(",S") for line in deck.element_faces(part, faces)]
    corners = [
        tuple(sorted(rail.cells[int(cell) - 1001][list(CALCULIX_SIDES[int(side)])])) for cell, side in found
    ]
    assert sorted(corners) == sorted(tuple(sorted(face)) for face in faces[:, :3])


def test_quadratic_fields_are_read_exactly(rail):
    def field(xi, s):
        return 1 + 2 * xi - s + 0.3 * xi**2 - 0.7 * xi * s + 0.1 * s**2

    for at in ((0.0, 2.8), (0.37, 3.1), (0.8, 2.0)):
        nodes, weights = rail.interpolation(*at)
        assert weights @ field(*rail.chart.T)[nodes] == pytest.approx(field(*at), abs=1e-9)


def test_input_has_every_node_and_cell_once(rail):
    lines = list(deck.Part("RAIL", rail, first_node=11, first_cell=21).lines())
    nodes = lines[lines.index("*NODE") + 1 : lines.index("*ELEMENT,TYPE=C3D10,ELSET=ALL-RAIL")]
    read = np.array([[float(word) for word in line.split(",")] for line in nodes])
    np.testing.assert_array_equal(read[:, 0], 11 + np.arange(len(rail.nodes)))
    np.testing.assert_allclose(read[:, 1:], rail.nodes, atol=1e-11)
    cells = [line.split(",") for line in lines if line.count(",") == 10 and line[0] != "*"]
    cells = np.array(cells, dtype=int)[: len(rail.cells)]
    np.testing.assert_array_equal(cells[:, 1:] - 11, rail.cells)


def test_output_is_read(tmp_path):
    (tmp_path / "a.dat").write_text(
        "\n displacements (vx,vy,vz) for set READ and time  0.1000000E+01\n\n"
        "        12  1.0E-01 -2.0E-02  3.0E-03\n"
        "\n total force (fx,fy,fz) for set FAR-UPPER and time  0.1000000E+01\n\n"
        "       -1.5E+00  2.0E+03 -6.0E+03\n"
    )
    (tmp_path / "a.frd").write_text(
        " -4  DISP        4    1\n -1        12 1.00000E+00 2.00000E+00 3.00000E+00\n -3\n"
        " -4  CONTACT     6    1\n -5  COPEN       1    4    1    1\n"
        " -1        12-1.00000E-06-2.00000E+00 3.00000E+00 8.50000E+02-1.00000E+00 0.00000E+00\n -3\n"
    )
    output = deck.Output(tmp_path, "a")
    np.testing.assert_allclose(output.nodal()[0][12], [0.1, -0.02, 0.003])
    np.testing.assert_allclose(output.total_forces()["FAR-UPPER"], [-1.5, 2e3, -6e3])
    assert output.contact_pressures() == {12: 850.0}


def test_peak_of_a_hertzian_pressure_lies_between_points():
    x, s = (grid.ravel() for grid in np.meshgrid(np.arange(0, 2, 0.31), np.arange(-1, 1, 0.17)))
    p = 900 * np.sqrt(np.maximum(1 - (x / 1.7) ** 2 - ((s - 0.05) / 0.8) ** 2, 0))
    assert contact.peak(x, s, p) == pytest.approx(900, rel=1e-9)
    assert np.max(p) < 899.5


@pytest.mark.slow
@pytest.mark.skipif(not deck.installed(), reason="CalculiX (ccx) is not installed: apt install calculix-ccx")
def test_c_of_a_load_beside_the_crown_is_that_of_calculix(tmp_path):
    """Raw, within 2 % of each component's largest value: cells of 0.4 half-sides, which grow by 0.4.

    With a growth of 0.3 components differ by 0.03 to 1.3 %; the largest is beside the edge of the patch.
    """
    loaded = ics.rail()
    theirs, _ = ics.by_calculix(loaded, 0.4, tmp_path)
    ours = ics.by_femic(loaded)
    largest = np.max(np.abs(ours), axis=0)
    assert np.all(np.abs(theirs - ours) <= 0.02 * largest)
