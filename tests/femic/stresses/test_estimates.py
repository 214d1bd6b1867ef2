"""Estimates of what elements do to stresses: tractions that rise like a root at their edge, as in contact."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from femic.stresses import engine
from femic.stresses.engine import AT_EDGES, OF_ELEMENTS
from femic.stresses.half_space import half_space_field
from femic.stresses.points import InnerPoints, SurfaceTractions, merged
from geometries.patches import Grid
from tests.femic.stresses.samples import curved, grid_of, tractions_of

HALF_LENGTH, HALF_WIDTH, MIDDLE = 1.4, 1.9, 0.7


def hertzian(n_x, n_s):
    """Hertz's pressure with unsymmetric friction, on elements that cover a little more than its ellipse."""
    grid = grid_of(n_x, n_s, 1.6, 2.2, s=MIDDLE)

    def tractions(x, s):
        p = np.sqrt(np.maximum(1 - (x / HALF_LENGTH) ** 2 - ((s - MIDDLE) / HALF_WIDTH) ** 2, 0))
        return 0.3 * p * (1 + 0.5 * x / HALF_LENGTH), -0.2 * p * (1 - 0.3 * s / HALF_WIDTH), p

    return tractions_of(grid, tractions)


def scattered(n):
    """Points below the tractions and beside them, a fifth of them at the surface, most of them near it."""
    random = np.random.default_rng(4)
    x, s = 1.7 * random.uniform(-1, 1, n), MIDDLE + 2.3 * random.uniform(-1, 1, n)
    depth = HALF_WIDTH * random.uniform(0, 1, n) ** 3 * (random.random(n) > 0.2)
    return InnerPoints(x, s, depth)


@pytest.mark.parametrize(
    ("n", "n_x", "n_s", "finer"),
    [(300, 16, 20, 4), pytest.param(2000, 24, 31, 8, marks=pytest.mark.slow)],
)
def test_errors_of_elements_are_within_their_estimates_in_95_of_100_points(n, n_x, n_s, finer):
    """Beside the edge and elsewhere."""
    body, points, tractions = curved(+1), scattered(n), hertzian(n_x, n_s)
    stress, coarse, exact = (
        half_space_field(body, of, points).stress
        for of in (tractions, merged(tractions), hertzian(finer * n_x + 1, finer * n_s + 1))
    )
    error, change = (np.max(np.abs(other - stress), axis=(-2, -1)) for other in (exact, coarse))
    edge = tractions.beside_edge(points.x, points.s, points.depth)
    assert 0.2 < np.mean(edge) < 0.8
    for of, share in ((edge, AT_EDGES), (~edge, OF_ELEMENTS)):
        assert np.mean(error[of] <= share * change[of]) >= 0.95


@dataclass(frozen=True)
class Model:
    """A model of the rest whose changes by coarser cells, and by a nearer far arc, are given."""

    change: np.ndarray

    def body_correction(self, points, _workers):
        return np.zeros((*points.shape, 3)), self.change, None

    def far_arc_change(self, _points, _workers):
        return 3 * self.change


@pytest.mark.parametrize("given", [False, True])
def test_the_estimate_is_the_sum_of_changes_with_a_share_of_the_largest(given, monkeypatch):
    """Half by section and all by far arc, unless it is given; a quarter of the largest, as one may vanish."""
    body, tractions, points = curved(+1), hertzian(16, 20), scattered(12)
    body = replace(body, domain=replace(body.domain, radius_given=given))
    change = np.zeros((12, 3, 3))
    change[:, 1, 2] = np.linspace(-2.0, 1.0, 12)
    models = iter([Model(np.zeros_like(change)), Model(change)])
    monkeypatch.setattr(engine.SectionUnderWaves, "mesh", lambda *_: next(models))
    field = engine.stress_field(body, tractions, points)
    flat, coarse = (half_space_field(body, of, points).stress for of in (tractions, merged(tractions)))
    edge = tractions.beside_edge(points.x, points.s, points.depth)
    elements = np.where(edge, AT_EDGES, OF_ELEMENTS) * np.max(np.abs(coarse - flat), axis=(1, 2))
    floored = np.abs(change[:, 1, 2]) + 2.0 / 4
    expected = (1 / 2 + (0.0 if given else 3.0)) * floored + elements
    np.testing.assert_allclose(field.estimate, expected, rtol=1e-12)
    assert ("far arc" in field.estimate_parts) == (not given)


def test_places_beside_the_edge():
    """Two elements to either side of where tractions end, and as deep."""
    p = np.zeros((11, 9, 3))
    p[3:8, :, 2] = 1.0
    tractions = SurfaceTractions(Grid(11, 9, 1.0, 1.0, 0.0), p)
    x = np.array([-4.6, -4.4, -2.6, -0.6, -0.4, 0.4, 0.6, 4.4, 4.6, 20.0])
    beside = tractions.beside_edge(x, np.zeros(10), np.zeros(10))
    assert beside.tolist() == [False, True, True, True, False, False, True, True, False, False]
    assert tractions.beside_edge(np.zeros(3), np.array([0.0, 3.0, 6.0]), np.zeros(3)).tolist() == [
        False,
        True,
        True,
    ]
    assert not tractions.beside_edge(x, np.zeros(10), np.full(10, 2.1)).any()


def test_beyond_a_grid_that_is_full_places_are_beside_the_edge_for_two_elements_more():
    """Whether they lie before its first element or behind its last one; the middle of the grid is not."""
    tractions = SurfaceTractions(Grid(7, 7, 1.0, 1.0, 0.0), np.ones((7, 7, 3)))
    along = np.array([-6.1, -5.9, -5.4, -3.6, -1.4, 0.0, 1.4, 3.6, 5.4, 5.9, 6.1, 90.0])
    beside = (np.abs(along) > 1.5) & (np.abs(along) < 5.5)  # the grid ends at 3.5
    zeros = np.zeros_like(along)
    np.testing.assert_array_equal(tractions.beside_edge(along, zeros, zeros), beside)
    np.testing.assert_array_equal(tractions.beside_edge(zeros, along, zeros), beside)
