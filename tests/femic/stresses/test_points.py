"""Points of bodies: by depth and by coordinates, and those that are not inside."""

import numpy as np
import pytest

from femic.stresses.engine import stress_field
from femic.stresses.near_surface import sample_centres, sample_points
from femic.stresses.points import InnerPoints, SurfaceTractions, merged, points_at, require_inside
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


# ---- samples near the surface


def test_parabolas_are_continued_to_the_surface_and_cubics_that_vanish_there_between():
    """Exactly, below and above the trusted depth, where points are their own samples."""
    depth = np.array([[0.0, 0.02, 0.3], [0.69, 0.7, 5.0]])
    samples = sample_points(InnerPoints(1.5, -2.0, depth), 0.7)

    def fields(z):
        parabola, cubic = 3 - z + 0.4 * z**2, z * (2 + z - 0.3 * z**2)
        return np.stack([parabola, cubic], axis=-1)

    extended = samples.extend(fields(samples.points.depth), np.array([False, True]))
    np.testing.assert_allclose(extended, fields(depth), rtol=1e-13, atol=1e-13)
    assert np.min(samples.points.depth) == 0.7


@pytest.mark.parametrize("along_x", [True, False])
def test_between_centres_of_elements_bilinear_fields_are_themselves(along_x):
    """At all depths, on the grid and beyond it; without `along_x`, any field of x."""
    random = np.random.default_rng(3)
    x, s = random.uniform(-3, 3, 40), random.uniform(-3, 3, 40)
    depth = np.repeat([0.0, 0.2, 0.3, 0.5, 2.0], 8)
    samples = sample_centres(Grid(5, 6, 0.4, 0.3, 0.7), InnerPoints(x, s, depth), along_x=along_x)

    def field(x, s, depth):
        return (2 + (x if along_x else np.sin(9 * x))) * (3 - s) * np.cos(depth)

    points = samples.points
    values = samples.at_points(field(points.x, points.s, points.depth))
    np.testing.assert_allclose(values, field(x, s, depth), rtol=1e-9)


@pytest.mark.parametrize("along_x", [True, False])
def test_samples_lie_below_centres_near_the_surface_and_at_the_points_deeper(along_x):
    """As deep as half of an element, and as deep as an element: 0.4 along x, 0.3 along s; in any unit."""
    side = 0.4 if along_x else 0.3
    for unit in (1.0, 1e-3, 1e3):
        grid = Grid(5, 6, unit * 0.4, unit * 0.3, unit * 0.7)

        def samples(depth, unit=unit, grid=grid):
            points = InnerPoints(unit * 0.13, unit * 0.77, unit * np.array([depth]))
            return sample_centres(grid, points, along_x=along_x)

        for depth in (0.0, 0.1, 0.5 * side):
            near = samples(depth)
            assert np.all(near.on_lattice)
            x, s = np.unique(near.points.x / unit), np.unique(near.points.s / unit)
            np.testing.assert_allclose(x, [0.0, 0.4] if along_x else [0.13], atol=1e-9)
            np.testing.assert_allclose(s, [0.55, 0.85])
            assert near.shares[0, -1] == pytest.approx(0.0, abs=1e-12)
        half = samples(0.75 * side)  # of the values by the smooth step
        assert half.shares[0, -1] == pytest.approx(0.5)
        for depth in (1.0001 * side, 3.0):
            deep = samples(depth)
            assert not np.any(deep.on_lattice)
            np.testing.assert_array_equal(deep.shares[0], [0, 0, 0, 0, 1])
            np.testing.assert_allclose([deep.points.x[0], deep.points.s[0]], [unit * 0.13, unit * 0.77])


# ---- tractions on elements


def test_elements_lie_side_by_side_about_their_centres():
    tractions = unsymmetric(grid_of(7, 10, 1.5, 2.0, s=0.3), 1.4, 1.8)
    grid = tractions.grid
    for edges, centres, side in zip(
        tractions.edges, (tractions.x, grid.strips), (grid.dx, grid.ds), strict=True
    ):
        np.testing.assert_allclose(np.diff(edges), side, rtol=1e-12)
        np.testing.assert_allclose((edges[1:] + edges[:-1]) / 2, centres, atol=1e-12)


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
