"""Dense matrices, rigid motions, and the numbers that compare two contacts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from approx.pair import Pair, Solid, matrix
from compare.validation.statements.changed_operators import DenseMatrix, MovedICs, TwoContacts, prismatic
from compare.validation.statements.components_and_moduli import exchanged_alone
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.operators.approximations import approximate_matrix, approximate_operator
from femic.scenes.load import load_scene
from geometries.contours import arc
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.friction_problems import groove, wheel_on
from tests.femic.contact.problems import BRASS, STEEL

GRID = Grid(6, 4, 0.9, 1.3, 0.4)
PAIR = Pair(
    Solid(STEEL, Surface(UPPER, arc(10.2, 1.3, 1.1), 500.0)),
    Solid(BRASS, Surface(LOWER, arc(10.0, 1.3, 1.1))),
)


@pytest.mark.parametrize("name", ["A", "B", "Bhat"])
def test_dense_matrices_and_operators_have_the_same_displacements(name):
    """All directions, some of them, and elements twice as large; unlike materials, so nothing vanishes."""
    dense = DenseMatrix.from_lags(matrix(name, prismatic(PAIR), GRID))
    fast = approximate_operator(name, PAIR, GRID)
    p = np.random.default_rng(1).standard_normal((6, 4, 3))
    scale = np.max(np.abs(dense(p)))
    np.testing.assert_allclose(fast(p), dense(p), atol=1e-12 * scale)
    for directions in ((N,), (X, S)):
        some = p[..., directions]
        expected = fast.restricted(directions)(some)
        np.testing.assert_allclose(dense.restricted(directions)(some), expected, atol=1e-12 * scale)
    coarse = p[::2, ::2]
    if name == "A":  # factors are averaged, not their products
        np.testing.assert_allclose(dense.coarsened()(coarse), fast.coarsened()(coarse), atol=1e-12 * scale)


def test_a_dense_matrix_of_larger_elements_has_means_due_to_equal_tractions():
    dense = DenseMatrix.from_lags(matrix("Bhat", prismatic(PAIR), GRID))
    coarse = np.random.default_rng(2).standard_normal((3, 2, 3))
    fine = np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)
    means = dense(fine).reshape(3, 2, 2, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(dense.coarsened()(coarse), means, atol=1e-14)


def contact(p=1.0, approach=1.0, force=0.0):
    """A contact with two tractions."""
    return SimpleNamespace(
        p=np.array([[[0.0, 0.0, 4.0], [p, 0.0, 2.0]]]),
        pressures=np.array([[4.0, 2.0]]),
        approach=approach,
        force=np.array([0.0, force, 1e5]),
        area=2.0,
    )


def test_before_and_after_count_what_is_beyond_the_motion():
    both = TwoContacts(contact(), replace_area(contact(1.2, 2.3, 1e4), 3.0), expected=1.0)
    assert both.tractions == pytest.approx(0.2 / 4)
    assert both.forces == pytest.approx(0.1)
    assert both.approach == pytest.approx(0.3)
    assert both.area == pytest.approx(0.5)


def replace_area(made, area):
    return SimpleNamespace(**(vars(made) | {"area": area}))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_motion_is_along_its_axis_and_does_work_with_the_force_along_it(axis):
    """Displacements times tractions are the square of the force times the motion per force."""
    problem = groove()
    moved = MovedICs(lambda p: 0 * p, problem.inclination, problem.grid.area, axis, 2e-6)
    p = np.random.default_rng(3).standard_normal((*problem.distance.shape, 3))
    sin, cos = np.sin(problem.inclination), np.cos(problem.inclination)
    along = {
        "x": p[..., X],
        "y": p[..., S] * cos + p[..., N] * sin,
        "z": p[..., N] * cos - p[..., S] * sin,
    }[axis]
    force = np.sum(along) * problem.grid.area
    assert np.sum(moved(p) * p) * problem.grid.area == pytest.approx(2e-6 * force**2)


def test_only_admissible_motions_leave_rolling_as_it_is():
    """Beside the crown: along z and x they do, along y they do not."""
    problem = groove(16, 16)
    before = wheel_on(problem).contact(Creepages(1e-3), Loading(3000.0)).contact
    for axis, changes in (("z", False), ("x", False), ("y", True)):
        moved = MovedICs(problem.operator, problem.inclination, problem.grid.area, axis, 5e-6)
        after = wheel_on(replace(problem, operator=moved)).contact(Creepages(1e-3), Loading(3000.0)).contact
        expected = 5e-6 * 3000.0 if axis == "z" else 0.0
        both = TwoContacts(before, after, expected)
        assert (both.tractions > 1e-3) == changes
        assert (both.approach < 1e-5) != changes


def test_one_component_is_exchanged_and_nothing_else():
    pair, grid = load_scene("rolling").pair, Grid(3, 4, 0.7, 0.9)
    base, other = (approximate_matrix(name, pair, grid) for name in ("Bhat", "Bhat_prime"))
    given = exchanged_alone(grid)
    ns = given["Bhat+ns:Bhat_prime"].ics
    np.testing.assert_array_equal(ns[..., N, S], other[..., N, S])
    ns = ns.copy()
    assert np.any(ns[..., N, S] != base[..., N, S])
    ns[..., N, S] = base[..., N, S]
    np.testing.assert_array_equal(ns, base)
