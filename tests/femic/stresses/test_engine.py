"""Stresses in true bodies: the half-space, free surfaces, equilibrium, symmetry, waves of tractions."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from femic.stresses.engine import (
    BESIDE,
    FEWEST_BESIDE,
    SectionUnderWaves,
    StressSettings,
    stress_field,
    strip_blocks,
)
from femic.stresses.field import in_section_axes
from femic.stresses.points import InnerPoints, SurfaceTractions, merged, points_at
from femic.stresses.resolution import Resolution
from femic.stresses.waves import Spectra, strain
from geometries.errors import WrongInput
from tests.femic.stresses.samples import (
    SIDES,
    curved,
    flat,
    grid_of,
    section_points,
    tractions_of,
    unsymmetric,
)

QUICK = StressSettings(0.4, estimated=False)


@pytest.mark.parametrize("side", [-1, pytest.param(+1, marks=pytest.mark.slow)])
def test_a_flat_body_is_a_half_space_within_the_estimate(side):
    """All components, under the contact and beside it, at the surface and below: to 1e-2 of the largest."""
    grid = grid_of(15, 20, 1.5, 2.0, s=0.3)  # as of a contact: on 11 x 14 elements it is 1.1e-2
    tractions = unsymmetric(grid, 1.4, 1.8)
    points = section_points([-3.0, -1.71, -0.9, 0.35, 1.2, 2.2], [0.0, 0.1, 0.4, 1.0, 3.0], x=0.25)
    field = stress_field(flat(side), tractions, points, StressSettings(0.7))
    error = np.max(np.abs(field.stress - field.half_space), axis=(-2, -1))
    assert np.all(error <= field.estimate)
    assert np.max(error) < 1e-2 * np.max(np.abs(field.half_space))


@pytest.mark.parametrize("side", SIDES)
def test_tractions_of_the_surface_are_those_given_and_0_beside_the_contact(side):
    grid = grid_of(9, 12, 1.5, 4.0)
    tractions = unsymmetric(grid, 1.4, 3.9)
    x = np.append(np.repeat(tractions.x[3:5], grid.n_s), [0.0, 3.0, -2.2])
    s = np.concatenate([grid.strips, grid.strips, [6.0, 1.0, -5.0]])
    field = stress_field(curved(side), tractions, InnerPoints(x, s, 0 * x), QUICK)
    expected = np.concatenate([tractions.p[3], tractions.p[4], np.zeros((3, 3))])
    np.testing.assert_allclose(field.stress[..., 2], -expected, atol=1e-12)


def test_a_plane_through_the_body_carries_the_force():
    """Below the contact z = const. cuts the crown off: forces along x, y, z, by Gauss and trapezoids."""
    body, grid = curved(-1), grid_of(10, 13, 1.5, 4.0, s=-0.5)
    tractions = unsymmetric(grid, 1.4, 3.5)
    depth, y_end = 4.0, 8.0  # on the circle of radius 10
    nodes, weights = np.polynomial.legendre.leggauss(12)
    t = np.linspace(-5.5, 5.5, 41)
    x, w_x = np.sinh(t), np.cosh(t) * (t[1] - t[0])
    points = points_at(body, x[:, None], y_end * nodes, -depth)
    field = stress_field(body, tractions, points, StressSettings(0.5, estimated=False))
    stress = in_section_axes(field)
    below = -np.einsum("xyc,x,y->c", stress[..., 2], w_x, y_end * weights)  # on what lies above the plane
    delta = body.contour.inclination(grid.strips)
    p_x, p_s, p_n = (grid.area * np.sum(tractions.p[..., d], axis=0) for d in range(3))
    applied = -np.array(
        [
            np.sum(p_x),
            np.sum(p_s * np.cos(delta) + p_n * np.sin(delta)),
            np.sum(p_n * np.cos(delta) - p_s * np.sin(delta)),
        ]
    )
    np.testing.assert_allclose(below, -applied, atol=5e-3 * np.max(np.abs(applied)))


@pytest.mark.slow
@pytest.mark.parametrize("rolling_radius", [np.inf, 80.0])
def test_what_is_symmetric_stays_so(rolling_radius):
    """Mirrored in x and in s: components with one index of the mirrored direction change their sign."""
    body = replace(curved(+1, rolling_radius=rolling_radius), contour=curved(+1).contour)
    grid = grid_of(9, 12, 1.5, 4.0)
    tractions = tractions_of(grid, lambda x, s: (0, 0, (1 - (x / 1.5) ** 2) * (1 - (s / 4.0) ** 2)))
    x = np.array([0.4, -0.4, 2.0, -2.0])
    field = stress_field(
        body, tractions, InnerPoints(x[:, None], np.array([1.0, 2.0]), np.array([0.2, 1.5])), QUICK
    )
    mirror = np.outer([-1, 1, 1], [-1, 1, 1])
    np.testing.assert_allclose(field.stress[1::2], mirror * field.stress[::2], atol=1e-9)


@pytest.mark.slow
def test_mirrored_bodies_have_mirrored_stresses():
    """Of an unsymmetric section and its mirror image: meshes differ, so within the errors of the mesh."""
    from_left, from_right = (
        replace(curved(-1), contour=replace(curved(-1).contour, limits=limits))
        for limits in ((-12.0, 10.0), (-10.0, 12.0))
    )
    grid, other = grid_of(9, 12, 1.5, 4.0, s=0.5), grid_of(9, 12, 1.5, 4.0, s=-0.5)
    tractions = unsymmetric(grid, 1.4, 3.5)
    mirrored = SurfaceTractions(other, tractions.p[:, ::-1] * [1, -1, 1])
    s, depth = np.array([-2.0, 1.0, 4.5]), np.array([0.0, 0.6, 2.0])
    fields = [
        stress_field(body, loads, section_points(sign * s, depth, x=0.3), QUICK).stress
        for body, loads, sign in ((from_left, tractions, 1), (from_right, mirrored, -1))
    ]
    mirror = np.outer([1, -1, 1], [1, -1, 1])
    np.testing.assert_allclose(fields[1], mirror * fields[0], atol=1e-2)


@pytest.mark.slow
def test_a_large_wheel_is_prismatic():
    """With a difference in proportion to 1 / R: halves with twice the radius, within a tenth."""
    grid = grid_of(9, 12, 1.5, 4.0)
    tractions = unsymmetric(grid, 1.4, 3.9)
    points = section_points([-2.0, 1.0], [0.0, 0.5, 2.0], x=0.3)
    fields = [
        stress_field(curved(+1, far_radius=100.0, rolling_radius=R), tractions, points, QUICK).stress
        for R in (1000.0, 2000.0, np.inf)
    ]
    first, second = (np.max(np.abs(stress - fields[2])) for stress in fields[:2])
    assert 0.5 * first == pytest.approx(second, rel=0.15)
    assert first < 0.02


@pytest.mark.slow
def test_depth_does_not_make_a_step_where_samples_begin():
    """Between depths 2e-6 apart stresses change by less than 2e-3 of p_max, a fifth of what is aimed at."""
    grid = grid_of(9, 12, 1.5, 4.0)
    depth = np.array([0.5, 1.0]) * 2 * grid.ds / 2
    around = np.sort(np.concatenate([depth - 1e-6, depth + 1e-6]))
    field = stress_field(
        curved(+1),
        unsymmetric(grid, 1.4, 3.9),
        section_points([1.0], around),
        StressSettings(1.0, estimated=False),
    )
    assert np.max(np.abs(np.diff(field.stress[0], axis=0)[::2])) < 2e-3


def test_merged_elements_carry_the_same_force():
    for n_x, n_s in ((9, 12), (8, 7), (5, 3)):
        grid = grid_of(n_x, n_s, 1.5, 4.0, s=0.7)
        tractions = unsymmetric(grid, 1.4, 3.5)
        coarse = merged(tractions)
        assert coarse.grid.dx == 2 * grid.dx
        assert coarse.grid.ds == 2 * grid.ds
        force = coarse.grid.area * np.sum(coarse.p, axis=(0, 1))
        np.testing.assert_allclose(force, grid.area * np.sum(tractions.p, axis=(0, 1)), rtol=1e-12)
        assert coarse.grid.extent[0] == pytest.approx(grid.extent[0])


def test_tractions_of_another_shape_or_that_are_no_numbers_are_refused():
    grid = grid_of(4, 3, 1.0, 1.0)
    with pytest.raises(WrongInput, match=r"\(4, 3, 3\)"):
        SurfaceTractions(grid, np.zeros((3, 4, 3)))
    with pytest.raises(WrongInput, match="finite"):
        SurfaceTractions(grid, np.full((4, 3, 3), np.nan))


def test_no_tractions_cause_no_stresses():
    grid = grid_of(4, 3, 1.0, 1.0)
    field = stress_field(
        flat(-1), SurfaceTractions(grid, np.zeros((4, 3, 3))), section_points([0.0], [0.0, 1.0]), QUICK
    )
    assert np.all(field.stress == 0)


# ---- how finely a body is modelled


@pytest.mark.parametrize("fineness", [0.1, 0.5, 2.0, 10.0])
def test_cells_and_waves_follow_the_fineness(fineness):
    """As many cells, and as small a spacing of waves, as it says; coarser where the largest wave is, too."""
    default, resolution = Resolution.at_fineness(1.0), Resolution.at_fineness(fineness)
    assert resolution.cells == pytest.approx(fineness * default.cells)
    assert resolution.spacing == pytest.approx(default.spacing / fineness)
    assert resolution.largest == pytest.approx(min(1.0, fineness) * default.largest)


def test_cells_that_are_four_times_as_fine_grow_half_as_fast_and_coarser_ones_no_faster():
    tenth, whole, four = (Resolution.at_fineness(fineness).growth for fineness in (0.1, 1.0, 4.0))
    assert tenth == whole == pytest.approx(2 * four)


@pytest.mark.parametrize("fineness", [0.5, 1.0, 2.0])
def test_a_coarser_resolution_has_cells_twice_as_large_and_fewer_waves(fineness):
    """By the same factor in their spacing and in the largest one."""
    resolution = Resolution.at_fineness(fineness)
    coarser = resolution.coarser
    assert coarser.cells == resolution.cells / 2
    assert coarser.spacing / resolution.spacing == pytest.approx(resolution.largest / coarser.largest)
    assert coarser.spacing > resolution.spacing
    assert coarser.growth == resolution.growth


@pytest.mark.parametrize("fineness", [0.0999, 10.001, np.nan])
def test_a_fineness_out_of_range_is_refused(fineness):
    with pytest.raises(WrongInput, match=r"fineness = .*: must lie in 0\.1 \.\.\. 10;"):
        Resolution.at_fineness(fineness)


@pytest.mark.parametrize("n_s", [1, 3, 7, 24, 100])
@pytest.mark.parametrize("cells", [3.2, 16.0, 32.0, 320.0])
def test_blocks_are_equal_groups_or_parts_of_strips_over_the_loaded_width_and_beside_it(n_s, cells):
    grid = grid_of(4, n_s, 1.0, 1.5, s=0.4)
    blocks = strip_blocks(grid, cells)
    size, (low, high) = blocks[0, 1] - blocks[0, 0], grid.extent
    np.testing.assert_allclose(np.ptp(blocks, axis=1), size)
    np.testing.assert_array_equal(blocks[1:, 0], blocks[:-1, 1])
    together = size / grid.ds
    assert max(together, 1 / together) == pytest.approx(round(max(together, 1 / together)))
    beside = max(FEWEST_BESIDE, round(BESIDE * n_s)) * grid.ds
    assert blocks[0, 0] == pytest.approx(low - beside)
    assert high + beside - 1e-9 < blocks[-1, 1] < high + beside + max(size, grid.ds)
    assert 2 / 3 <= (high - low) / size / cells <= 3 / 2


def test_a_nearer_far_arc_is_a_smaller_body_and_beyond_it_nothing_changes():
    """Within half the radius as a body of that radius, meshed anew, to a quarter of the largest change."""
    tractions = unsymmetric(grid_of(5, 6, 1.5, 2.0), 1.4, 1.8)
    points = InnerPoints(0.25, np.array([0.5, -3.0, 0.5, 0.5]), np.array([10.0, 6.0, 14.9, 15.1]))
    inner = InnerPoints(points.x[:2], points.s[:2], points.depth[:2])
    whole, near = (
        SectionUnderWaves.mesh(flat(-1, far_radius=radius), tractions, Resolution.at_fineness(0.4))
        for radius in (30.0, 15.0)
    )
    change = whole.far_arc_change(points, 1)
    expected = near.long_waves(inner, 1)[1] - whole.long_waves(inner, 1)[1]
    np.testing.assert_allclose(change[:2], expected, atol=0.25 * np.max(np.abs(expected)))
    assert np.any(change[2] != 0)
    assert np.all(change[3] == 0)


# ---- waves of tractions and strains of sections


R = 60.0


@pytest.mark.parametrize("k", [0.0, 0.4, 3.0])
@pytest.mark.parametrize("side", SIDES)
def test_amplitudes_are_integrals_over_elements(side, k):
    """Of uniform tractions times cos(k x) and sin(k x), by quadrature over each element of a strip."""
    grid = grid_of(32, 24, 1.4, 1.0)  # as many as the loaded part has at least
    tractions = unsymmetric(grid, 1.5, 1.3)
    spectra = Spectra.from_tractions(flat(side), tractions, 1.0)
    assert spectra.tractions.grid == grid
    edges = tractions.edges[0]
    for wave, found in zip((np.cos, np.sin), spectra.amplitudes(k), strict=True):
        parts = [quad(lambda x, w=wave: w(k * x), *ends)[0] for ends in pairwise(edges)]
        expected = side * grid.ds * np.einsum("x,xsd->sd", parts, tractions.p)
        np.testing.assert_allclose(found, expected, atol=1e-12)


def strains(side, values, k):
    """Strains xx, yy, zz, yz, xz, xy at heights z of a wheel's section from steady U, V, W."""
    z = np.array([-3.0, 0.0, 8.0])
    stretch = 1 - side * z / R
    at = np.zeros((3, 3, 3))  # value and slopes along y, z; point; U, V, W
    at[0] = values
    return strain(at, k, stretch, side / (R * stretch))[:, 3:]


@pytest.mark.parametrize("side", SIDES)
def test_a_translation_of_a_wheel_has_no_strains(side):
    """Along z: at the angle x / R its parts along x and z are side sin(x / R) and cos(x / R)."""
    assert np.max(np.abs(strains(side, [side, 0.0, 1.0], 1 / R))) < 1e-15


@pytest.mark.parametrize("side", SIDES)
def test_a_ring_that_grows_has_the_hoop_strain_of_its_radius(side):
    """Displacements of 1 away from the axis: hoop strain 1 / r, r the distance from the axis."""
    found = strains(side, [0.0, 0.0, -side], 0.0)
    radius = R - side * np.array([-3.0, 0.0, 8.0])
    np.testing.assert_allclose(found[:, 0], 1 / radius)
    assert np.all(found[:, 1:] == 0)


def test_stresses_of_wheels_take_the_length_of_their_circles():
    """The chart's length over the arc length is that of the crown's circle over the strip's own."""
    body = curved(+1, rolling_radius=R)
    grid = grid_of(32, 24, 1.4, 4.0)
    spectra = Spectra.from_tractions(body, unsymmetric(grid, 1.4, 4.0), 1.0)
    circles = body.surface.circle_radius(spectra.tractions.grid.strips)
    np.testing.assert_allclose(spectra.stretch, R / circles)
