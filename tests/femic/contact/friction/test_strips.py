"""The approximate inverse of the law: exact on a single strip, and on half-spaces but for its edges."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, gmres

from femic.contact.friction.law import Law, StripInverse, Strips
from femic.contact.friction.motion import LeadingEdge, RollingStep, Shift, SteadyRolling
from geometries.patches import Grid
from tests.femic.contact.friction.laws import on_half_spaces

MOTIONS = {"shift": Shift, "first": SteadyRolling, "second": SteadyRolling, "step": RollingStep}


def motion_of(name, grid):
    rigid = np.zeros((grid.n_x, grid.n_s, 2))
    if name == "shift":
        return Shift(rigid)
    order = 1 if name == "first" else 2
    return MOTIONS[name](rigid, dx=grid.dx, order=order)


def state(name, grid, holes=(), seed=0):
    """The law at random tractions and slip, in all but the outermost elements, and its equations."""
    random, motion, operator = np.random.default_rng(seed), motion_of(name, grid), on_half_spaces(grid)
    bound = np.zeros((grid.n_x, grid.n_s))
    bound[1:-1] = random.uniform(50.0, 150.0, (grid.n_x - 2, grid.n_s))
    for hole in holes:
        bound[hole] = 0.0
    edge = LeadingEdge.find(bound, motion.depth)
    own = operator(np.ones((grid.n_x, grid.n_s, 2)) * (np.arange(grid.n_x) == 3)[:, None, None])[3, 0, 0]
    scale = 1 / own * (1 if name == "shift" else grid.dx)
    q = random.normal(size=(np.count_nonzero(edge.free), 2)) * 60
    slip = random.normal(size=(grid.n_x, grid.n_s, 2)) * 60 / scale
    slip[: grid.n_x // 2] *= 0.02  # there most elements stick
    law = Law(motion, scale, edge.free, q, bound[edge.free][:, None], slip)
    assert 2 < np.count_nonzero(law.stick) < len(law.stick) - 2

    def derivative(v):
        p = np.zeros((grid.n_x, grid.n_s, 2))
        p[edge.free] = v.reshape(-1, 2)
        return law.derivative(v.reshape(-1, 2), motion.elastic_slip(operator(edge.spread(p)))).ravel()

    return law, edge, operator, derivative


@pytest.mark.parametrize("holes", [(), ((4, 0),)], ids=["whole", "with a hole"])
@pytest.mark.parametrize("name", MOTIONS)
def test_on_one_strip_it_is_the_inverse_but_for_what_couples_x_with_s(name, holes):
    law, edge, operator, derivative = state(name, Grid(14, 1, 0.4, 0.5), holes)
    matrix = np.stack([derivative(unit) for unit in np.eye(2 * len(law.q))], axis=1)
    for i in range(2):
        matrix[i::2, 1 - i :: 2] = 0.0
    inverse = StripInverse(Strips.on_half_spaces(operator, law.motion), law, edge)
    for v in np.random.default_rng(1).normal(size=(3, 2 * len(law.q))):
        expected = np.linalg.solve(matrix, v)
        result = inverse(v.reshape(-1, 2)).ravel()
        np.testing.assert_allclose(result, expected, atol=1e-4 * np.max(np.abs(expected)))  # single precision


@pytest.mark.parametrize("name", MOTIONS)
def test_waves_over_all_strips_are_accounted_for(name):
    """Where all stick: far fewer products are needed than with each strip alone."""
    grid = Grid(16, 12, 0.4, 0.4)
    law, edge, operator, _ = state(name, grid)
    law = replace(law, sticking=True)
    size, strips = 2 * len(law.q), Strips.on_half_spaces(operator, law.motion)
    b = np.random.default_rng(2).normal(size=size)

    def products(inverse):
        count = [0]

        def counted(v):
            count[0] += 1
            p = np.zeros((grid.n_x, grid.n_s, 2))
            p[edge.free] = v.reshape(-1, 2)
            return law.derivative(v.reshape(-1, 2), law.motion.elastic_slip(operator(edge.spread(p)))).ravel()

        linear = [LinearOperator((size, size), matvec=of, dtype=float) for of in (counted, inverse)]
        x, failed = gmres(linear[0], b, M=linear[1], rtol=1e-5, restart=size)
        assert not failed
        np.testing.assert_allclose(counted(x), b, atol=1e-3 * np.max(np.abs(b)))
        return count[0]

    both = StripInverse(strips, law, edge)
    alone = StripInverse(replace(strips, alone=lambda slip: slip), law, edge)
    counts = [products(lambda v, of=of: of(v.reshape(-1, 2)).ravel()) for of in (both, alone)]
    assert counts[0] < 0.75 * counts[1]


@pytest.mark.parametrize("name", MOTIONS)
def test_a_contact_at_the_ends_of_the_grid_has_finite_tractions(name):
    """In steady rolling the last element has no slip of its own there."""
    grid = Grid(8, 3, 0.4, 0.5)
    motion, operator, bound = motion_of(name, grid), on_half_spaces(grid), np.full((8, 3), 100.0)
    edge = LeadingEdge.find(bound, 0)
    q, slip = np.zeros((24, 2)), np.ones((8, 3, 2))
    law = Law(motion, 1.0, edge.free, q, bound[edge.free][:, None], slip, sticking=True)
    result = StripInverse(Strips.on_half_spaces(operator, motion), law, edge)(np.ones((24, 2)))
    assert np.all(np.isfinite(result))
    assert np.max(np.abs(result)) > 0


def test_without_free_elements_there_is_nothing_to_invert():
    grid = Grid(4, 3, 0.4, 0.5)
    motion, bound = motion_of("shift", grid), np.zeros((4, 3))
    edge = LeadingEdge.find(bound, 0)
    law = Law(motion, 1.0, edge.free, np.zeros((0, 2)), np.zeros((0, 1)), np.zeros((4, 3, 2)))
    inverse = StripInverse(Strips.on_half_spaces(on_half_spaces(grid), motion), law, edge)
    assert inverse(np.zeros((0, 2))).shape == (0, 2)
