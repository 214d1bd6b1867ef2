"""Matrices of ICs as operators: against the matrix itself, on parts of the grid; how reciprocal they are."""

import json
import warnings
from dataclasses import asdict
from itertools import product

import numpy as np
import pytest

from approx.pair import Pair, Solid, matrix
from compare.pages.matrix import reciprocity_text
from femic.contact.operators import dense
from femic.contact.operators.approximations import approximate_operator
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.dense import (
    PARITY,
    Asymmetry,
    GridOperator,
    Part,
    coarsened,
    reciprocity,
    reciprocity_defects,
    restrict_to,
)
from femic.contact.patch import Box, block_mean
from geometries.contours import arc, plane
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.problems import BRASS, STEEL, Products

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


def smallest(whole):
    """The smallest eigenvalue of the symmetric part, and the smallest entry of the diagonal."""
    return np.linalg.eigvalsh((whole + whole.T) / 2)[0], np.min(np.abs(np.diagonal(whole)))


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
def test_smallest_eigenvalue_is_that_of_the_symmetric_part(variant):
    result = GridOperator.from_ics(matrix(variant, RAIL, GRID)).smallest_eigenvalue()
    assert result == pytest.approx(smallest(whole_matrix(variant))[0], rel=0.03)


def test_search_goes_on_from_where_it_has_ended(monkeypatch):
    monkeypatch.setattr(dense, "MOST_ITERATIONS", 4)
    monkeypatch.setattr(dense, "eigsh", lambda *_, **__: pytest.fail("another method was begun"))
    monkeypatch.setattr(dense, "RESTARTS", 20)
    ics, (exact, least) = matrix("Bhat", RAIL, GRID), smallest(whole_matrix("Bhat"))
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


def test_single_precision_stays_single_and_changes_by_1e_7_of_the_largest():
    ics, tractions = matrix("Bhat", RAIL, GRID), np.ones((GRID.n_x, GRID.n_s, 3))
    exact, single = (GridOperator.from_ics(values)(tractions) for values in (ics, ics.astype(np.float32)))
    assert 0 < np.max(np.abs(single - exact)) < 2e-7 * np.sum(np.abs(ics[:, 2, :]))
    defects = [reciprocity_defects(values) for values in (ics, ics.astype(np.float32))]
    assert np.max(np.abs(defects[1] - defects[0])) < 2e-7
    ics = matrix("B", RAIL, Grid(6, 8, 0.4, 0.3)).astype(np.float32)
    for directions in ((2,), (0, 1, 2)):
        operator = GridOperator.from_ics(ics[..., directions, :][..., directions], directions)
        assert operator.transformed.dtype == operator.coarsened().transformed.dtype == np.float32


@pytest.mark.parametrize(
    ("grid", "iterations", "share"),
    [
        *product([GRID], [1, 100], [0.0, 0.3, 3.0]),
        *product([Grid(40, 3, 0.4, 0.3)], [dense.MOST_ITERATIONS], [0.0, 0.3]),  # some frequencies will do
    ],
)
def test_smallest_eigenvalue_is_found_with_a_rigid_compliance_subtracted_or_an_endless_search(
    grid, iterations, share, monkeypatch
):
    """Of a share of the element's own IC: such matrices are not definite. Another search may follow."""
    monkeypatch.setattr(dense, "MOST_ITERATIONS", iterations)
    ics, whole = matrix("Bhat", RAIL, grid), whole_matrix("Bhat", grid)
    middle = grid.n_s // 2
    subtracted = share * ics[0, middle, middle, 2, 2]
    ics[..., 2, 2] -= subtracted
    whole[2::3, 2::3] -= subtracted
    exact, least = smallest(whole)
    assert (exact < 0) == (share > 0)
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
    ics = matrix("B", RAIL, GRID)
    part = GridOperator.from_ics(ics[..., directions, :][..., directions], directions)
    whole = whole_matrix("B").reshape(GRID.n_x * GRID.n_s, 3, -1, 3)[:, directions][..., directions]
    expected = whole.reshape(tractions.size, tractions.size) @ tractions.ravel()
    for operator in (part, GridOperator.from_ics(ics).restricted(directions)):
        np.testing.assert_allclose(operator(tractions).ravel(), expected, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("directions", [(0, 1, 2), (2,), (0, 2)])
def test_coarsened_operator_is_the_mean_over_four_elements(directions):
    ics = matrix("B", RAIL, Grid(6, 8, 0.4, 0.3))[..., directions, :][..., directions]
    operator = GridOperator.from_ics(ics, directions)
    tractions = np.random.default_rng(1).normal(size=(3, 4, len(directions)))
    mean = block_mean(operator(tractions.repeat(2, axis=0).repeat(2, axis=1)))
    u = operator.coarsened()(tractions)
    np.testing.assert_allclose(u, mean, rtol=0, atol=1e-13 * np.max(np.abs(mean)))


# ---- parts of the grid: elements move as the whole one does under tractions there

PART_GRID = Grid(12, 10, 0.3, 0.4, 0.6)
SHAPE = 12, 10
PAIR = Pair(
    Solid(BRASS, Surface(UPPER, arc(10.3, 0.9, 0.9))), Solid(STEEL, Surface(LOWER, arc(10.0, 0.9, 0.9)))
)
BOXES = [Box((2, 8), (4, 10)), Box((0, 12), (3, 7)), Box((4, 10), (0, 10))]


def operators():
    fast = approximate_operator("Bhat", PAIR, PART_GRID)
    return {
        "convolution": fast,
        "flat": approximate_operator("A", PAIR, PART_GRID),
        "dense": GridOperator.from_ics(matrix("Bhat", PAIR, PART_GRID)),
        "unknown": Products(fast),
    }


@pytest.mark.parametrize("box", BOXES, ids=str)
@pytest.mark.parametrize("name", operators())
@pytest.mark.parametrize("directions", [(X, S, N), (S, N)])
def test_part_moves_elements_as_the_whole_does(name, box, directions):
    operator, m = operators()[name].restricted(directions), len(directions)
    p = np.random.default_rng(0).normal(size=(*box.shape, m))
    expected = box.crop(operator(box.embed(p, SHAPE)))
    result = restrict_to(operator, box, SHAPE)
    np.testing.assert_allclose(result(p), expected, atol=1e-13 * np.max(np.abs(expected)))
    fewer = result.restricted(directions[-1:])(p[..., -1:])
    alone = operator.restricted(directions[-1:])(box.embed(p[..., -1:], SHAPE))
    np.testing.assert_allclose(fewer, box.crop(alone), atol=1e-13 * np.max(np.abs(alone)))


@pytest.mark.parametrize("name", ["flat", "dense", "unknown"])  # other convolutions: with mean factors
def test_part_on_larger_elements_is_the_part_of_the_coarsened_operator(name):
    box, operator = Box((2, 8), (4, 10)), operators()[name]
    p = np.random.default_rng(1).normal(size=(3, 3, 3))
    expected = restrict_to(operator.coarsened(), box.coarsened, (6, 5))(p)
    result = restrict_to(operator, box, SHAPE).coarsened()(p)
    np.testing.assert_allclose(result, expected, atol=1e-12 * np.max(np.abs(expected)))


@pytest.mark.parametrize("name", operators())
def test_larger_elements_have_mean_displacements_due_to_equal_tractions(name):
    """Exactly, and so for estimates: B-hat's factors vary within elements."""
    operator = operators()[name]
    p = np.random.default_rng(2).normal(size=(6, 5, 3))
    expected = block_mean(operator(p.repeat(2, axis=0).repeat(2, axis=1)))
    atol = (1e-2 if name == "unknown" else 1e-13) * np.max(np.abs(expected))  # it has mean factors
    np.testing.assert_allclose(coarsened(operator)(p), expected, atol=atol)


def test_the_form_is_the_fastest_one(monkeypatch):
    """Many convolutions become a matrix between strips, few do not, and no matrix of very many strips."""
    box, of = Box((2, 8), (4, 10)), operators()
    assert isinstance(restrict_to(of["convolution"], box, SHAPE), GridOperator)
    assert isinstance(restrict_to(of["flat"], box, SHAPE), Convolution)
    assert isinstance(restrict_to(of["dense"], box, SHAPE), GridOperator)
    assert isinstance(restrict_to(of["unknown"], box, SHAPE), Part)
    assert restrict_to(of["dense"], Box.whole(SHAPE), SHAPE) is of["dense"]
    monkeypatch.setattr(dense, "MOST_DENSE", 5)
    assert isinstance(restrict_to(of["convolution"], box, SHAPE), Convolution)


# ---- how reciprocal a matrix is, and where: matrices with one known defect

JOINTED_GRID = Grid(4, 6, 0.5, 0.4, s=0.1)  # strips from -1.1 to 1.3 mm
JOINTED = arc(2.0, 0.5, 0.31)  # joints at -1.0 (strip 0) and 0.62 mm (strip 4)


def reciprocal_matrix():
    rng = np.random.default_rng(3)
    half = rng.normal(size=(4, 6, 6, 3, 3))
    ics = half + PARITY * np.swapaxes(np.swapaxes(half, 1, 2), 3, 4)
    ics[..., 2, 2] /= np.max(np.abs(ics[..., 2, 2])) / 5.0  # largest C_nn: 5
    return ics


def size_of(component):
    """The largest value of a component of `reciprocal_matrix`, the same of its transpose."""
    i, j = ("xsn".index(direction) for direction in component)
    return np.max(np.abs(reciprocal_matrix()[..., i, j]))


def with_defects(*, joint, elsewhere):
    ics = reciprocal_matrix()
    ics[2, 1, 4, 0, 1] += joint  # strip 4 has a joint
    ics[1, 3, 2, 1, 2] += elsewhere
    return ics


def test_the_worst_pair_and_the_worst_without_joints():
    result = reciprocity(with_defects(joint=0.01, elsewhere=0.002), JOINTED, JOINTED_GRID)
    xs, sn = size_of("xs"), size_of("sn")
    assert result.worst == pytest.approx(0.01 / xs)
    assert result.component == "xs"
    assert sorted(result.strips) == [1, 4]
    assert result.at_joints == (0, 4)
    assert result.elsewhere == pytest.approx(0.002 / sn)
    assert json.loads(json.dumps(asdict(result)))["at_joints"] == [0, 4]
    assert reciprocity_text(result, JOINTED_GRID) == (
        f"{0.01 / xs:.1e} of xs (strips 1 and 4, s = -0.5, 0.7 mm); joints in strips 0, 4; "
        f"{0.002 / sn:.1e} without these"
    )


def test_defects_of_small_components_are_relative_to_their_own_size():
    """The same defect, in the component that is a hundred times smaller than the others."""
    small = np.ones((3, 3))
    small[1, 2] = small[2, 1] = 0.01
    ics = with_defects(joint=0.01, elsewhere=0.0) * small
    ics[1, 3, 2, 1, 2] += 0.002
    result = reciprocity(ics, JOINTED, JOINTED_GRID)
    assert (result.component, sorted(result.strips)) == ("sn", [2, 3])
    assert result.worst == pytest.approx(0.2 / size_of("sn"))


def test_a_component_that_is_zero_has_no_defect():
    ics = with_defects(joint=0.01, elsewhere=0.0)
    ics[..., [1, 2], [2, 1]] *= 1e-12
    ics[1, 3, 2, 1, 2] += 1e-12
    assert reciprocity(ics, JOINTED, JOINTED_GRID).component == "xs"


def test_contour_without_joints_has_equal_worst_and_elsewhere():
    result = reciprocity(with_defects(joint=0.001, elsewhere=0.02), plane(), JOINTED_GRID)
    assert (sorted(result.strips), result.at_joints) == ([2, 3], ())
    assert result.worst == result.elsewhere == pytest.approx(0.02 / size_of("sn"))
    assert (
        reciprocity_text(result, JOINTED_GRID)
        == f"{result.worst:.1e} of sn (strips 2 and 3, s = -0.1, 0.3 mm)"
    )


def test_a_joint_on_an_edge_belongs_to_both_strips():
    on_edge = reciprocity(reciprocal_matrix(), arc(2.0, 0.25, 0.45), JOINTED_GRID)  # -0.5: centre; 0.9: edge
    assert on_edge.at_joints == (1, 4, 5)


def test_grid_of_joints_only_has_no_defect_elsewhere():
    grid = Grid(4, 2, 0.5, 0.4)
    result = reciprocity(reciprocal_matrix()[:, :2, :2], arc(2.0, 0.1, 0.1), grid)
    assert (result.at_joints, result.elsewhere) == ((0, 1), None)
    assert "without" not in reciprocity_text(result, grid)
