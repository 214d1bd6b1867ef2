"""Models of a body: what is solved, and how it combines."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.result import combine, discounted, scales
from femic.reference.run_options import MODELS, Level, factors
from tests.femic.reference.conftest import JOB, LINES


def test_models_differ_in_cells_and_domain_only_as_stated():
    fine, coarse, small = (JOB.request(Level().models(MODELS)[name]) for name in MODELS)
    assert coarse.cells == JOB.first_cells.scaled(1.5)
    assert small.cells == coarse.cells
    assert small.body.domain == JOB.body.domain.scaled(0.5)
    assert fine.body == coarse.body == JOB.body
    assert fine.loads == coarse.loads == small.loads


def test_only_the_requested_column_is_a_number(models):
    reference = combine(JOB, Level(), models)
    assert np.all(np.isfinite(reference.c.ic[:, 2]))
    assert np.all(np.isnan(reference.c.ic[:, :2]))
    assert np.all(reference.c.estimate[:, 2] >= 0)
    assert all(len(cost.iterations) == 1 for cost in reference.models.values())


ERRORS = {  # of models with cells and a domain of some sizes
    "mesh_error": lambda cells, _: cells**2,
    "truncation_error": lambda _, domain: domain**-2,
}


@pytest.mark.parametrize("part", ERRORS)
def test_estimates_are_a_quarter_above_errors_of_second_order(models, part):
    rng = np.random.default_rng(3)
    exact, error = rng.normal(size=(2, *models[Level()].u.shape))
    wrong = {
        level: replace(model, u=exact + ERRORS[part](*factors(level)) * error)
        for level, model in models.items()
    }
    c, (truth, *_) = combine(JOB, Level(), wrong).c, discounted(JOB, exact)
    np.testing.assert_allclose(getattr(c, part), 1.25 * np.abs(c.ic - truth), atol=1e-12)
    np.testing.assert_allclose(c.estimate, getattr(c, part), atol=1e-12)


def test_where_nn_was_not_solved_small_components_are_judged_by_that_of_a_point_load():
    """Boussinesq: (1 - nu) / (2 pi G r), of which the floor is a twentieth."""
    ic = np.full((3, 3, len(JOB.points.x)), np.nan)
    ic[0, 0] = 0.0
    material, r = JOB.body.material, np.hypot(JOB.points.x, JOB.points.s)
    nn = (1 - material.nu) / (2 * np.pi * material.G * r)
    for line, part in LINES.items():  # patches are small against r
        expected = 0.05 * nn[part].max()
        assert scales([JOB], ic)[line][0, 0] == pytest.approx(expected, rel=0.03)
