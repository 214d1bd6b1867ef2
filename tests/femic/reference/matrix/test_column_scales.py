"""How errors of an IC matrix are measured: scales of a column, shares of them, the worst of all."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.harmonic.synthesis import chebyshev_points
from femic.reference.job import Settings, Shares
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import assess_matrices, column_scale, column_shares
from femic.reference.refinement import worst_shares
from femic.reference.result import EstimatedICs
from geometries.bodies import Body, Domain
from geometries.contours import plane
from geometries.errors import WrongInput
from geometries.materials import Material, one_body
from geometries.patches import Grid, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL

GRID = Grid(7, 6, 0.4, 0.5)
SOFT = Material(70e3, 0.33)
STRIP = 4


def job(material=STEEL, side=LOWER, **settings):
    body = Body(side, plane(), material, Domain(1000.0, np.inf))
    return MatrixJob(body, GRID, Settings(HARMONIC, **settings))


def a_nn(material, side):
    half_space = HalfSpace(one_body(material, side))
    s = GRID.strips - GRID.strips[STRIP]
    return half_space.ics(Patch(0.2, 0.25), GRID.lags[:, None], s)[2, 2] / (0.4 * 0.5)


def test_a_matrix_by_another_engine_is_refused():
    body = Body(LOWER, plane(), STEEL, Domain(1000.0, np.inf))
    with pytest.raises(WrongInput, match=r"`engine`: the solid engine has no .*engine\.kind = 'harmonic'"):
        MatrixJob(body, GRID, Settings(SOLID))


LAG, APART = np.meshgrid(np.arange(7), np.arange(6) - STRIP, indexing="ij")
FAR = LAG**2 + APART**2 >= 16


def test_within_four_elements_errors_are_shares_of_five_times_a_nn_there():
    """Of several bodies the half-spaces add up."""
    c, jobs, a = np.full((3, 3, 7, 6), 1e9), [job(), job(SOFT, UPPER)], a_nn(STEEL, LOWER)
    for n, expected in ((1, 5 * a), (2, 5 * (a + a_nn(SOFT, UPPER)))):
        result = column_scale(STRIP, c, jobs[:n])
        np.testing.assert_allclose(result[..., ~FAR], np.broadcast_to(expected, c.shape)[..., ~FAR])
    assert np.sum(FAR) not in (0, FAR.size)


def test_scale_far_from_the_load_is_the_largest_c_ij_over_the_lags_of_two_strips():
    c = 10 * np.random.default_rng(1).normal(size=(3, 3, 7, 6))  # far above the floor
    c[..., ~FAR] = 1e9  # what is near does not count
    result = column_scale(STRIP, c, [job()])
    for i, j, strip in np.ndindex(3, 3, 6):
        far = FAR[:, strip]
        np.testing.assert_allclose(result[i, j, far, strip], np.max(np.abs(c[i, j, far, strip])))


def test_scale_of_a_vanishing_component_is_a_twentieth_of_the_largest_a_nn():
    a = a_nn(STEEL, LOWER)
    result = column_scale(STRIP, np.zeros((3, 3, 7, 6)), [job()])
    for strip in range(6):
        far = FAR[:, strip]
        np.testing.assert_allclose(result[0, 2, far, strip], np.max(a[far, strip]) / 20)


def column(**parts):
    """Estimates that are 0 but for single entries: {part: {(i, j, lag, strip): value}}."""
    arrays = {name: np.zeros((3, 3, 7, 6)) for name in ("mesh_error", "truncation_error", "waves_error")}
    for name, entries in parts.items():
        for place, value in entries.items():
            arrays[name][place] = value
    return EstimatedICs(np.zeros((3, 3, 7, 6)), **arrays)


def test_shares_of_a_column_are_the_worst_of_each_part_and_of_their_sum():
    scale = np.full((3, 3, 7, 6), 2.0)
    scale[0, 2] = 0.5
    c = column(
        mesh_error={(2, 2, 1, 3): 0.4, (0, 2, 5, 1): 0.2},  # 0.2, 0.4
        truncation_error={(0, 2, 5, 1): 0.1, (1, 1, 0, 0): 0.6},  # 0.2, 0.3
        waves_error={(1, 2, 6, 5): 0.7},  # 0.35
    )
    result = column_shares(3, c, scale)
    assert (result.mesh, result.truncation, result.waves) == pytest.approx((0.4, 0.3, 0.35))
    assert result.total == pytest.approx(0.6)
    assert (result.component, result.line) == ("xn", "of strip 1 under strip 3 (worst at lag 5)")
    result = column_shares(0, column(mesh_error={(2, 1, 1, 3): np.nan}), scale)
    assert (result.mesh, result.truncation, result.total, result.component) == (np.inf, 0, np.inf, "ns")


def test_the_worst_of_several_has_the_worst_of_each_part():
    first, second = Shares(0.1, 0.9, 0.2, 1.0, "nn", "one"), Shares(0.3, 0.4, 0.5, 1.2, "sn", "other")
    for order in ([first, second], [second, first]):
        assert worst_shares(order) == Shares(0.3, 0.9, 0.5, 1.2, "sn", "other")


class Column:
    """A body whose matrix is made up."""

    def __init__(self, columns):
        self.columns = columns

    def column(self, strip):
        return self.columns[strip]


def columns(error_of):
    """ICs of 1, with some error of the mesh, strip by strip."""
    one, zero = np.ones((3, 3, 7, 6)), np.zeros((3, 3, 7, 6))
    return Column([EstimatedICs(one, e + zero, zero, zero) for e in error_of])


def test_all_strips_are_assessed_and_the_sum_of_bodies_on_its_own_scale():
    """ICs of 1 are far above the floor, and near the load 5 A_nn is far below: the worst is near."""
    jobs = {"lower": job(), "upper": job(SOFT, UPPER)}
    result = {"lower": columns([1, 1, 3, 1, 1, 1]), "upper": columns([2, 2, 2, 2, 5, 2])}
    assessed = assess_matrices(jobs, result, combined=True)
    least = {name: 5 * np.min(a_nn(of.body.material, of.body.side)[~FAR]) for name, of in jobs.items()}
    together = sum(least.values())
    assert assessed.own["lower"].line.split(" (")[0].endswith("under strip 2")
    assert assessed.combined.line.split(" (")[0].endswith("under strip 4")
    assert assessed.in_combined["upper"].total == pytest.approx(
        assessed.own["upper"].total * least["upper"] / together, rel=1e-6
    )
    assert assessed.combined.total == pytest.approx(assessed.in_combined["upper"].total * 6 / 5)
    alone = assess_matrices(jobs, result, combined=False)
    assert alone.own == assessed.own
    assert alone.combined is None


class Recorded:
    """A consumer of columns that records what it gets."""

    def __init__(self):
        self.begun, self.added, self.discarded = 0, [], 0

    def begin(self, references):
        self.begun += 1
        self.references = references

    def made(self, strip, columns):
        assert columns == {name: one.column(strip) for name, one in self.references.items()}
        return strip

    def add(self, made):
        self.added.append(made)

    def discard(self):
        self.discarded += 1


@pytest.fixture(name="in_threads")
def _in_threads(monkeypatch):
    monkeypatch.setattr("femic.reference.matrix.reference.ELEMENTS_FOR_THREADS", 1)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize(
    ("lower", "upper", "combined", "used"),
    [
        (1.01, 5.01, False, 6),
        (0.99, 5.01, False, 0),
        (1.01, 4.99, False, 4),
        (1.01, 5.01, True, 4),  # the error of the sum is the mean of both, and must meet the first tolerance
        (3.01, 5.01, True, 6),
    ],
)
@pytest.mark.usefixtures("in_threads")
def test_columns_are_used_in_order_until_one_is_not_accurate_enough(workers, lower, upper, combined, used):
    """The tolerances are multiples of the error of the first column."""
    result = {"lower": columns([1, 1, 1, 1, 1, 1]), "upper": columns([1, 1, 1, 1, 5, 1])}
    one = assess_matrices({"lower": job()}, {"lower": result["lower"]}, combined=False).own["lower"].total
    jobs, taken = {"lower": job(tolerance=lower * one), "upper": job(tolerance=upper * one)}, Recorded()
    assess_matrices(jobs, result, combined=combined, consumer=taken, workers=workers)
    assert taken.begun == 1
    assert taken.added == list(range(used))
    assert taken.discarded == (used < 6)


def test_first_cells_and_domains_follow_tolerance_and_grid():
    tuned = job(tolerance=1e-3).first_cells
    assert tuned.smallest == pytest.approx(GRID.ds / 4)
    assert job(tolerance=1e-3 / 8).first_cells == tuned.scaled(0.5)
    assert job(tolerance=1.0).first_cells == tuned.scaled(1.25)
    wide = Grid(7, 60, 0.4, 0.5)
    assert HARMONIC.far_radius(1e-3, GRID) == HARMONIC.far_radius(0.1, GRID) == 1280.0
    assert HARMONIC.far_radius(1e-3, wide) == pytest.approx(600 * 15)
    assert HARMONIC.far_radius(1e-3 / 4, wide) == pytest.approx(2 * 600 * 15)


def test_chebyshev_points_are_zeros_of_a_chebyshev_polynomial():
    points = chebyshev_points(np.array([0.3, -0.1, 0.2]), 7)
    np.testing.assert_allclose(np.cos(7 * np.arccos((points - 0.1) / 0.2)), 0, atol=1e-12)


def test_wavenumbers_are_as_dense_as_the_least_scale_of_each_pair_of_strips_needs():
    """At lag 0, where A_nn is largest: 0.05 A_nn of the strips' distance."""
    of_strips, strips = job(), GRID.strips
    loads = of_strips.strip_loads[3 * STRIP : 3 * STRIP + 3]
    no_fit_points = strips[~np.isin(strips, of_strips.fit_points("approach").s)]
    result = of_strips._least_scales(loads, no_fit_points)
    near = np.isin(strips, no_fit_points)
    expected = 0.05 * a_nn(STEEL, LOWER)[0, near]
    assert result.shape == (3, 1, np.sum(near))
    for of_load in result:
        np.testing.assert_allclose(of_load[0], expected, rtol=1e-12)


def test_where_conditions_of_m_read_wavenumbers_are_as_dense_as_the_least_a_nn_there_needs():
    of_strips = job()
    loads = [*of_strips.strip_loads[-1:], *of_strips.fit_loads]
    s = np.append(GRID.strips, of_strips.fit_points("approach").s)
    distances = s - np.array([load.patch.s for load in loads])[:, None]
    least = np.min(of_strips.half_space_nn(0.0, distances))
    np.testing.assert_allclose(of_strips._least_scales(loads, s)[1:, 0, -1], least, rtol=1e-12)
    assert of_strips.half_space_nn(0.0, 0.0) > 2 * least
