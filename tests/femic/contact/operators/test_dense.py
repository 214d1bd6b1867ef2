"""The operator of an IC matrix against the matrix itself, element by element."""

import warnings

import numpy as np
import pytest

from approx.pair import Solid, matrix
from femic.contact.operators import dense
from femic.contact.operators.dense import Asymmetry, GridOperator, reciprocity_defects
from geometries.contours import arc
from geometries.patches import Grid
from geometries.surfaces import LOWER, Surface
from tests.femic.reference.conftest import STEEL

GRID = Grid(6, 5, 0.4, 0.3)
RAIL = Solid(STEEL, Surface(LOWER, arc(10.0, 0.5, 0.5)))


def whole_matrix(variant, grid=GRID):
    """ICs of all pairs of elements by the approximation at the true, signed distances."""
    n_x, n_s = grid.n_x, grid.n_s
    x = grid.dx * np.arange(n_x)
    out = np.empty((n_x, n_s, 3, n_x, n_s, 3))
    for m, n in np.ndindex(n_x, n_s):
        points = ((x - x[m])[:, None], grid.strips)
        out[..., m, n, :] = np.moveaxis(RAIL.approximate(variant, grid.patch(n), points), (0, 1), (2, 3))
    return out.reshape(3 * n_x * n_s, -1)


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
def test_operator_agrees_with_the_dense_matrix(variant):
    tractions = np.random.default_rng(0).normal(size=(GRID.n_x, GRID.n_s, 3))
    u = GridOperator.from_ics(matrix(variant, RAIL, GRID))(tractions)
    np.testing.assert_allclose(u.ravel(), whole_matrix(variant) @ tractions.ravel(), rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
def test_smallest_eigenvalue_is_that_of_the_symmetric_part(variant):
    whole = whole_matrix(variant)
    exact = np.linalg.eigvalsh((whole + whole.T) / 2)[0]
    result = GridOperator.from_ics(matrix(variant, RAIL, GRID)).smallest_eigenvalue()
    assert result == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_smallest_eigenvalue_of_a_long_grid_is_found_with_some_frequencies(share):
    """A rigid compliance of this share of the element's own IC is subtracted: no other search follows."""
    grid = Grid(40, 3, 0.4, 0.3)
    ics, whole = matrix("Bhat", RAIL, grid), whole_matrix("Bhat", grid)
    subtracted = share * ics[0, 1, 1, 2, 2]
    ics[..., 2, 2] -= subtracted
    whole[2::3, 2::3] -= subtracted
    exact = np.linalg.eigvalsh((whole + whole.T) / 2)[0]
    least = np.min(np.abs(np.diagonal(whole)))
    assert GridOperator.from_ics(ics).smallest_eigenvalue() == pytest.approx(exact, abs=0.03 * least)


def test_search_goes_on_from_where_it_has_ended(monkeypatch):
    monkeypatch.setattr(dense, "MOST_ITERATIONS", 4)
    monkeypatch.setattr(dense, "eigsh", lambda *_, **__: pytest.fail("another method was begun"))
    ics, whole = matrix("Bhat", RAIL, GRID), whole_matrix("Bhat")
    least = np.min(np.abs(np.diagonal(whole)))
    monkeypatch.setattr(dense, "RESTARTS", 20)
    exact = np.linalg.eigvalsh((whole + whole.T) / 2)[0]
    assert GridOperator.from_ics(ics).smallest_eigenvalue() == pytest.approx(exact, abs=0.03 * least)
    monkeypatch.setattr(dense, "RESTARTS", 1)
    with pytest.raises(pytest.fail.Exception, match="another method"):
        GridOperator.from_ics(ics).smallest_eigenvalue()


@pytest.mark.parametrize("workers", [1, 2])
def test_smallest_eigenvalues_of_matrices_are_shares_and_leave_warnings_alone(workers, monkeypatch):
    """Slow searches warn."""
    monkeypatch.setattr(dense, "MOST_ITERATIONS", 2)
    ics = [matrix(variant, RAIL, GRID) for variant in ("A", "B", "Bhat")]
    filters = list(warnings.filters)
    found = dense.smallest_eigenvalues(ics, workers)
    assert warnings.filters == filters
    for one, share in zip(ics, found, strict=True):
        own = min(one[0, s, s, i, i] for s in range(GRID.n_s) for i in range(3))
        assert share * own == pytest.approx(GridOperator.from_ics(one).smallest_eigenvalue())


def test_single_precision_changes_by_1e_7_of_the_largest():
    ics, tractions = matrix("Bhat", RAIL, GRID), np.ones((GRID.n_x, GRID.n_s, 3))
    exact, single = (GridOperator.from_ics(values)(tractions) for values in (ics, ics.astype(np.float32)))
    assert 0 < np.max(np.abs(single - exact)) < 2e-7 * np.sum(np.abs(ics[:, 2, :]))
    defects = [reciprocity_defects(values) for values in (ics, ics.astype(np.float32))]
    assert np.max(np.abs(defects[1] - defects[0])) < 2e-7


@pytest.mark.parametrize("iterations", [1, 100])
@pytest.mark.parametrize("share", [0.0, 0.3, 3.0])
def test_smallest_eigenvalue_is_found_with_a_rigid_compliance_subtracted_or_an_endless_search(
    monkeypatch, share, iterations
):
    """Such matrices are not definite. A search that is stopped is followed by another one."""
    monkeypatch.setattr(dense, "MOST_ITERATIONS", iterations)
    ics, whole = matrix("Bhat", RAIL, GRID), whole_matrix("Bhat")
    subtracted = share * ics[0, 2, 2, 2, 2]
    ics[..., 2, 2] -= subtracted
    whole[2::3, 2::3] -= subtracted
    exact = np.linalg.eigvalsh((whole + whole.T) / 2)[0]
    assert (exact < 0) == (share > 0)
    least = np.min(np.abs(np.diagonal(whole)))
    assert GridOperator.from_ics(ics).smallest_eigenvalue() == pytest.approx(exact, abs=0.03 * least)


@pytest.mark.parametrize(("variant", "reciprocal"), [("A", True), ("Bhat", True), ("B", False)])
def test_the_reciprocity_defect_is_that_of_the_dense_matrix(variant, reciprocal):
    whole = whole_matrix(variant)
    exact = {}
    for i, j in np.ndindex(3, 3):
        sizes = np.max(np.abs(whole[i::3, j::3])), np.max(np.abs(whole[j::3, i::3]))
        exact["xsn"[i] + "xsn"[j]] = np.max(np.abs(whole - whole.T)[i::3, j::3]) / max(sizes)
    result = reciprocity_defects(matrix(variant, RAIL, GRID)).max(axis=(0, 1))
    assert result.ravel() == pytest.approx(list(exact.values()), rel=1e-9, abs=1e-12)
    assert (result.max() < 1e-12) == reciprocal
    worst = Asymmetry.find(matrix(variant, RAIL, GRID))
    assert worst.share == result.max()
    if not reciprocal:
        assert exact[worst.component] == max(exact.values())


@pytest.mark.parametrize("directions", [(2,), (0,), (1, 2), (2, 0), (0, 1)])
def test_restricted_operator_is_the_part_of_the_matrix(directions):
    tractions = np.random.default_rng(0).normal(size=(GRID.n_x, GRID.n_s, len(directions)))
    part = np.ix_(directions, directions)
    operator = GridOperator.from_ics(matrix("B", RAIL, GRID)[..., part[0], part[1]], directions)
    whole = whole_matrix("B").reshape(GRID.n_x * GRID.n_s, 3, -1, 3)[:, directions][..., directions]
    expected = whole.reshape(tractions.size, tractions.size) @ tractions.ravel()
    np.testing.assert_allclose(operator(tractions).ravel(), expected, rtol=1e-12, atol=1e-18)
    restricted = GridOperator.from_ics(matrix("B", RAIL, GRID)).restricted(directions)
    np.testing.assert_allclose(restricted(tractions).ravel(), expected, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("directions", [(0, 1, 2), (2,), (0, 2)])
def test_coarsened_operator_is_the_mean_over_four_elements(directions):
    grid, coarse = Grid(6, 8, 0.4, 0.3), (3, 4)
    part = np.ix_(directions, directions)
    operator = GridOperator.from_ics(matrix("B", RAIL, grid)[..., part[0], part[1]], directions)
    tractions = np.random.default_rng(1).normal(size=(*coarse, len(directions)))
    fine = operator(tractions.repeat(2, axis=0).repeat(2, axis=1))
    mean = fine.reshape(3, 2, 4, 2, len(directions)).mean(axis=(1, 3))
    u = operator.coarsened()(tractions)
    np.testing.assert_allclose(u, mean, rtol=0, atol=1e-13 * np.max(np.abs(mean)))


def test_single_precision_stays_single():
    ics = matrix("B", RAIL, Grid(6, 8, 0.4, 0.3)).astype(np.float32)
    for directions in ((2,), (0, 1, 2)):
        operator = GridOperator.from_ics(ics[..., directions, :][..., directions], directions)
        assert operator.transformed.dtype == np.float32
        assert operator.coarsened().transformed.dtype == np.float32
