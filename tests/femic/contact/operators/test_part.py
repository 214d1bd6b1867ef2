"""Operators on a part of the grid: they move its elements as the whole one does under tractions there."""

import numpy as np
import pytest

from approx.pair import Pair, Solid, matrix
from femic.contact.operators import dense as part
from femic.contact.operators.approximations import approximate_operator
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.dense import GridOperator, Part, coarsened, restrict_to
from femic.contact.patch import Box
from geometries.contours import arc
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.problems import BRASS, STEEL

GRID = Grid(12, 10, 0.3, 0.4, 0.6)
SHAPE = 12, 10
PAIR = Pair(
    Solid(BRASS, Surface(UPPER, arc(10.3, 0.9, 0.9))), Solid(STEEL, Surface(LOWER, arc(10.0, 0.9, 0.9)))
)
BOXES = [Box((2, 8), (4, 10)), Box((0, 12), (3, 7)), Box((4, 10), (0, 10))]


class Unknown:
    """An operator of which only products are known."""

    def __init__(self, operator):
        self.operator = operator

    def __call__(self, p):
        return self.operator(p)

    def restricted(self, directions):
        return Unknown(self.operator.restricted(directions))

    def coarsened(self):
        return Unknown(self.operator.coarsened())


def operators():
    fast = approximate_operator("Bhat", PAIR, GRID)
    return {
        "convolution": fast,
        "flat": approximate_operator("A", PAIR, GRID),
        "dense": GridOperator.from_ics(matrix("Bhat", PAIR, GRID)),
        "unknown": Unknown(fast),
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
    u = operator(p.repeat(2, axis=0).repeat(2, axis=1))
    expected = u.reshape(6, 2, 5, 2, 3).mean(axis=(1, 3))
    atol = (1e-2 if name == "unknown" else 1e-13) * np.max(np.abs(expected))  # it has mean factors
    np.testing.assert_allclose(coarsened(operator)(p), expected, atol=atol)


def test_the_form_is_the_fastest_one(monkeypatch):
    """Many convolutions become a matrix between strips, few do not, and no matrix of very many strips."""
    box, of = Box((2, 8), (4, 10)), operators()
    assert isinstance(restrict_to(of["convolution"], box, SHAPE), GridOperator)
    assert isinstance(restrict_to(of["flat"], box, SHAPE), Convolution)
    assert isinstance(restrict_to(of["dense"], box, SHAPE), GridOperator)
    assert isinstance(restrict_to(of["unknown"], box, SHAPE), Part)
    monkeypatch.setattr(part, "MOST_DENSE", 5)
    assert isinstance(restrict_to(of["convolution"], box, SHAPE), Convolution)


def test_a_matrix_is_its_own_part_on_the_whole_grid():
    dense = operators()["dense"]
    assert restrict_to(dense, Box.whole(SHAPE), SHAPE) is dense
