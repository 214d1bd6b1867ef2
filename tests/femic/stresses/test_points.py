"""Points of bodies: by depth and by coordinates, and those that are not inside."""

import numpy as np
import pytest

from femic.stresses.engine import stress_field
from femic.stresses.near_surface import SMOOTH_DEPTH, sample_centres
from femic.stresses.points import InnerPoints, SurfaceTractions, merged, points_at, require_inside
from femic.stresses.resolution import CELLS, COARSEST, FINEST, Resolution
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.outlines import SectionOutline
from geometries.patches import Grid
from tests.femic.stresses.samples import SIDES, STEEL, curved, flat, grid_of, section_points, unsymmetric

BLOCK = Body(
    -1,
    arc(10.0, 0.5, 0.5),
    STEEL,
    Domain(100.0, np.inf),
    outline=SectionOutline(((20.0, -10.0), (20.0, -40.0), (-20.0, -40.0), (-20.0, -10.0)), (2, 3)),
)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("rolling_radius", [np.inf, 60.0])
def test_coordinates_of_points_by_depth_give_them_back(side, rolling_radius):
    body = curved(side, rolling_radius=rolling_radius)
    points = InnerPoints(np.array([[-3.0], [5.0]]), np.array([-4.0, 0.0, 2.5]), np.array([0.0, 1.5, 4.0]))
    section = points.in_section(body).reshape(2, -1)
    xyz = body.surface.to_global(np.stack([points.in_chart(body).ravel(), *section]))
    again = points_at(body, *(values.reshape(points.shape) for values in xyz))
    for name in ("x", "s", "depth"):
        np.testing.assert_allclose(getattr(again, name), getattr(points, name), atol=1e-9)


def test_a_point_below_the_crown_of_a_revolved_body_has_the_angle_of_its_own_circle():
    body = curved(+1, rolling_radius=60.0)
    theta, depth = 0.2, 7.0
    radius = 60.0 - depth
    point = points_at(body, [radius * np.sin(theta)], [0.0], [60.0 - radius * np.cos(theta)])
    np.testing.assert_allclose([point.x[0], point.s[0], point.depth[0]], [60.0 * theta, 0, depth], atol=1e-9)


WHEEL = curved(+1, rolling_radius=60.0)


@pytest.mark.parametrize(
    ("body", "points", "reason"),
    [
        (curved(-1), InnerPoints(1.0, 2.0, [0.5, -0.1]), "x = 1, s = 2, depth = -0.1 mm: above the surface"),
        (curved(-1), InnerPoints(0.0, 0.0, [1.0, np.nan]), "finite"),
        (curved(-1), InnerPoints(0.0, 0.0, [81.0]), "ends 80 mm from the contact centre"),
        (curved(-1), InnerPoints(0.0, 0.0, [-0.01]), "above the surface"),
        (curved(-1), section_points([0.0, 5000.0], [1.0]), "s = 5000"),
        (curved(-1), InnerPoints(0.0, 9.0, [30.0]), "leaves the body before this depth"),
        (WHEEL, InnerPoints(0.0, 0.0, [49.0]), "from the axis"),
        (WHEEL, InnerPoints(190.0, 0.0, [1.0]), "half way round"),
        (BLOCK, InnerPoints(0.0, 0.0, [40.1]), "outside the outline"),
        (BLOCK, section_points([5.0], [-0.01]), "above the surface"),
    ],
)
def test_points_that_are_not_inside_are_refused_with_their_place_and_a_remedy(body, points, reason):
    with pytest.raises(WrongInput, match=reason):
        require_inside(body, points)


@pytest.mark.parametrize(
    ("body", "inside"),
    [
        (BLOCK, section_points([-5.0, 0.0, 5.0], [0.0])),
        (BLOCK, InnerPoints(0.0, 0.0, [39.9])),
        (curved(-1), InnerPoints(0.0, 0.0, [0.0, 80.0])),
    ],
)
def test_points_at_the_boundaries_are_inside(body, inside):
    require_inside(body, inside)


def test_a_point_in_the_air_is_refused_by_coordinates_and_by_fields_too():
    with pytest.raises(WrongInput, match="above the surface"):
        points_at(curved(-1), 0.0, 1.0, 3.0)
    with pytest.raises(WrongInput, match="end"):
        points_at(BLOCK, 0.0, 30.0, -30.0)
    with pytest.raises(WrongInput, match="above the surface"):
        stress_field(flat(-1), unsymmetric(grid_of(4, 3, 1.0, 1.0), 1.0, 1.0), InnerPoints(0.0, 0.0, [-1.0]))


# ---- tractions on elements


def test_elements_lie_side_by_side_about_their_centres():
    tractions = unsymmetric(grid_of(7, 10, 1.5, 2.0, s=0.3), 1.4, 1.8)
    grid = tractions.grid
    for edges, centres, side in zip(
        tractions.edges, (tractions.x, grid.strips), (grid.dx, grid.ds), strict=True
    ):
        np.testing.assert_allclose(np.diff(edges), side, rtol=1e-12)
        np.testing.assert_allclose((edges[1:] + edges[:-1]) / 2, centres, atol=1e-12)


def test_places_beside_the_edge_are_within_two_elements_of_it_and_as_deep():
    """Also where tractions reach the ends of the grid."""
    grid = Grid(12, 14, 0.5, 0.4, 0.1)
    loaded = SurfaceTractions(grid, np.ones((12, 14, 3)))
    (left, right), (low, high) = (edges[[0, -1]] for edges in loaded.edges)
    for elements, beside in (
        (-2.5, False),
        (-1.5, True),
        (-0.5, True),
        (0.5, True),
        (1.5, True),
        (2.5, False),
    ):
        places = [
            (left + elements * grid.dx, 0.1),
            (right - elements * grid.dx, 0.1),
            (0.1, low + elements * grid.ds),
            (0.1, high - elements * grid.ds),
        ]
        for x, s in places:
            assert loaded.beside_edge(np.array(x), np.array(s), np.array(0.9)) == beside
            assert not loaded.beside_edge(np.array(x), np.array(s), np.array(1.01))


@pytest.mark.parametrize("sizes", [(8, 6), (9, 6), (8, 7), (9, 7)])
def test_merged_tractions_are_means_of_four_and_carry_the_same_force(sizes):
    grid = Grid(*sizes, 0.5, 0.4, 0.1)
    p = np.random.default_rng(0).normal(size=(*sizes, 3))
    large = merged(SurfaceTractions(grid, p))
    assert (large.grid.dx, large.grid.ds) == (1.0, 0.8)
    assert large.grid.extent[0] == pytest.approx(grid.extent[0])
    force, before = (np.sum(p, axis=(0, 1)) * grid.area for p, grid in ((large.p, large.grid), (p, grid)))
    np.testing.assert_allclose(force, before, rtol=1e-12)
    if sizes[0] % 4 == 0:  # blocks begin at an edge of the grid
        blocks = p[:2, :2].mean(axis=(0, 1)), p[2:4, 2:4].mean(axis=(0, 1))
        np.testing.assert_allclose([large.p[0, 0], large.p[1, 1]], blocks, rtol=1e-12)
    one = merged(SurfaceTractions(grid, np.ones((*sizes, 3)))).p
    np.testing.assert_allclose(one[1:-1, :-1], 1.0, rtol=1e-12)


# ---- how finely


def test_fineness_counts_cells_and_waves_in_proportion():
    default = Resolution.at_fineness(1.0)
    for fineness in (COARSEST, 0.5, 2.0, FINEST):
        own = Resolution.at_fineness(fineness)
        assert own.cells == pytest.approx(CELLS * fineness)
        assert own.spacing * fineness == pytest.approx(default.spacing)
        assert own.coarser.cells == own.cells / 2
        assert own.coarser.spacing / own.spacing == pytest.approx(own.largest / own.coarser.largest)
        assert own.coarser.spacing > own.spacing
    for beyond in (0.99 * COARSEST, 1.01 * FINEST):
        with pytest.raises(WrongInput, match="fineness"):
            Resolution.at_fineness(beyond)


# ---- samples near the surface


@pytest.mark.parametrize("along_x", [True, False])
def test_points_deeper_than_an_element_are_their_own_samples(along_x):
    grid = Grid(8, 6, 0.3, 0.4, 0.1)
    x, s = np.array([0.11, -0.4]), np.array([0.2, -0.33])
    deep = sample_centres(grid, InnerPoints(x, s, 1.01 * SMOOTH_DEPTH * 0.4), along_x=along_x)
    assert not deep.on_lattice.any()
    np.testing.assert_allclose(sorted(deep.points.x), sorted(x))
    at_surface = sample_centres(grid, InnerPoints(x, s, 0.0), along_x=along_x)
    assert at_surface.on_lattice.all()
    steps = (at_surface.lattice_points.s - grid.strips[0]) / grid.ds
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)


def test_shares_of_samples_do_not_depend_on_the_unit_of_length():
    depth = np.linspace(0.0, 0.5, 7)
    shares = [
        sample_centres(
            Grid(8, 6, 0.3 * unit, 0.4 * unit, 0.1 * unit),
            InnerPoints(0.11 * unit, 0.2 * unit, depth * unit),
            along_x=False,
        ).shares
        for unit in (1.0, 100.0)
    ]
    np.testing.assert_allclose(*shares, atol=1e-9)
