"""Models of a body: what is solved, and kept for the next run."""

import numpy as np
import pytest
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.cache.store import Store
from femic.reference.refinement import solve_models
from femic.reference.run_options import MODELS, Level, RunOptions
from femic.reference.solid import engine as solid
from femic.reference.solid import engine as tasks
from geometries.errors import Failure
from tests.femic.reference.conftest import TASKS, solve_all


def test_a_second_run_opens_no_mesh_and_an_interrupted_one_resumes(tmp_path, monkeypatch):
    meshed = []
    build = solid.build_mesh

    def counting(asked):
        if len(meshed) == 2 and not interrupted:
            interrupted.append(1)
            raise KeyboardInterrupt
        meshed.append(1)
        return build(asked)

    interrupted = []
    monkeypatch.setattr(solid, "build_mesh", counting)
    store = Store(tmp_path)
    try:
        solve_all(store)
    except KeyboardInterrupt:
        assert len(meshed) == 2
    first = solve_all(store)
    assert interrupted
    assert len(meshed) == len(MODELS)  # two before the interruption, the third after it
    again = list(solve_models(TASKS, RunOptions(1, store)))
    assert all(solved.cached for solved in again)
    assert len(meshed) == len(MODELS)
    np.testing.assert_array_equal(first[Level()].u, again[0].model.u)


def test_a_dead_worker_is_reported_with_both_causes_and_what_to_try(monkeypatch):
    def dead(*_):
        raise TerminatedWorkerError

    monkeypatch.setattr(tasks, "in_processes", dead)
    with pytest.raises(Failure, match=r"memory: use fewer.*mesher crashed.*change the cells.*are kept"):
        list(solve_models(TASKS, RunOptions(2)))
