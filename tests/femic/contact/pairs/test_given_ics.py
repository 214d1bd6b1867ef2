"""ICs that the caller gives: nn of them, operators with and without their errors, and what is refused."""

import numpy as np
import pytest

from approx.pair import matrix
from femic.contact.pairs.ics import GivenICs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from geometries.errors import WrongInput
from geometries.patches import Grid
from tests.femic.contact.pairs.problems import problem

GRID = Grid(6, 5, 0.5, 0.3)


@pytest.fixture(scope="module")
def full():
    """B-hat of a pair in all directions, with errors of a tenth of each entry."""
    ics = matrix("Bhat", problem(10.2).pair, GRID)
    return GivenICs(GRID, ics, 0.1 * np.abs(ics))


def test_contact_without_friction_takes_nn(full):
    on_grid = pair_on_grid(problem(10.2), GRID)
    alone = GivenICs(GRID, full.ics[..., 2, 2], full.estimate[..., 2, 2])
    for of_all, of_nn in zip(full.at(on_grid), alone.at(on_grid), strict=True):
        np.testing.assert_array_equal(of_all, of_nn)


def test_operators_act_as_the_ics_and_as_the_ics_with_their_errors(full):
    """A unit traction on one element displaces itself by the IC at lag 0 of its strip."""
    tractions = np.zeros((GRID.n_x, GRID.n_s, 3))
    tractions[2, 1] = 1.0, 2.0, 3.0
    for operator, ics in ((full.operator, full.ics), (full.perturbed, full.ics + full.estimate)):
        np.testing.assert_allclose(operator(tractions)[2, 1], ics[0, 1, 1] @ [1, 2, 3], rtol=1e-12)


def test_ics_without_errors_have_no_perturbed_operator(full):
    assert GivenICs(GRID, full.ics).perturbed is None


def test_ics_of_nn_alone_are_refused_with_friction(full):
    nn = GivenICs(GRID, full.ics[..., 2, 2])
    with pytest.raises(WrongInput, match=r"ICs of shape \(6, 5, 5\): .*\(n_x, n_s, n_s, 3, 3\)"):
        _ = nn.operator
