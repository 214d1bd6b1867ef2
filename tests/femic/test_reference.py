"""Models of a body: what is solved, and how it combines."""

import numpy as np
import pytest

from femic.reference import MODELS, Level, combine, estimated_errors, request, scales
from tests.femic.conftest import JOB, LINES


def test_models_differ_in_cells_and_domain_only_as_stated():
    fine, coarse, small = (request(JOB, Level().models()[name]) for name in MODELS)
    assert coarse.cells == JOB.cells.scaled(1.5)
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


def test_estimated_errors_are_shares_of_the_scale_of_their_line(models):
    reference = combine(JOB, Level(), models)
    c = reference.c.ic[2, 2]
    errors = estimated_errors(JOB, reference.c.estimate, scales([JOB], reference.c.ic))
    for line, part in LINES.items():
        expected = reference.c.estimate[2, 2, part].max() / np.abs(c[part]).max()
        assert errors[line][2, 2] == pytest.approx(expected)
