"""Models of a body: what is solved, kept and combined."""

import numpy as np
from joblib import Memory

from femic import solid
from femic.reference import MODELS, Job, combine, requests, solve_models
from tests.femic.conftest import COARSE, PATCH, SYMMETRIC, request_for

BODY = request_for(SYMMETRIC).body
JOB = Job(BODY, PATCH, (2,), request_for(SYMMETRIC).points, COARSE, 9.0)


def solve_all(memory):
    return {solved.model: solved.raw for solved in solve_models({"lower": JOB}, workers=1, memory=memory)}


def test_models_differ_in_cells_and_domain_only_as_stated():
    models = requests(JOB)
    assert models["coarse"].cells == JOB.cells.scaled(1.5)
    assert models["small"].cells == models["coarse"].cells
    assert models["small"].body.domain == BODY.domain.scaled(0.5)
    assert models["fine"].body == models["coarse"].body


def test_a_second_run_opens_no_mesh_and_an_interrupted_one_resumes(tmp_path, monkeypatch):
    meshed = []
    build = solid.build_mesh

    def counting(request):
        if len(meshed) == 2 and not interrupted:
            interrupted.append(1)
            raise KeyboardInterrupt
        meshed.append(1)
        return build(request)

    interrupted = []
    monkeypatch.setattr(solid, "build_mesh", counting)
    memory = Memory(tmp_path, verbose=0)
    try:
        solve_all(memory)
    except KeyboardInterrupt:
        assert len(meshed) == 2
    first = solve_all(memory)
    assert interrupted
    assert len(meshed) == len(MODELS)  # two before the interruption, the third after it
    again = list(solve_models({"lower": JOB}, workers=1, memory=memory))
    assert all(solved.kept for solved in again)
    assert len(meshed) == len(MODELS)
    np.testing.assert_array_equal(first["fine"].ic, again[0].raw.ic)


def test_only_the_requested_column_is_a_number():
    reference = combine(JOB, solve_all(Memory(None)))
    assert np.all(np.isfinite(reference.ic[:, 2]))
    assert np.all(np.isnan(reference.ic[:, :2]))
    assert np.all(reference.estimate[:, 2] >= 0)
    assert all(len(cost.iterations) == 1 for cost in reference.models.values())
