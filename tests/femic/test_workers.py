"""Models of a body: what is solved, and kept for the next run."""

import numpy as np
import pytest
from joblib import Memory
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic import workers
from femic.provenance import code_digest
from femic.reference import MODELS, Level
from femic.solid import engine as solid
from femic.workers import memory_in, solve_models
from geometries.errors import Failure
from tests.femic.conftest import FIRST, JOB, solve_all


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
    memory = Memory(tmp_path, verbose=0)
    try:
        solve_all(memory)
    except KeyboardInterrupt:
        assert len(meshed) == 2
    first = solve_all(memory)
    assert interrupted
    assert len(meshed) == len(MODELS["solid"])  # two before the interruption, the third after it
    todo = [("lower", level) for level in FIRST]
    again = list(solve_models({"lower": JOB}, todo, workers=1, memory=memory, on_step=str))
    assert all(solved.kept for solved in again)
    assert len(meshed) == len(MODELS["solid"])
    np.testing.assert_array_equal(first[Level()].u, again[0].raw.u)


def test_a_dead_worker_is_reported_with_both_causes_and_what_to_try(monkeypatch):
    def dead(**_):
        def run(_):
            raise TerminatedWorkerError

        return run

    monkeypatch.setattr(workers, "Parallel", dead)
    todo = [("lower", level) for level in FIRST]
    with pytest.raises(Failure, match=r"memory: use fewer.*mesher crashed.*change the cells.*are kept"):
        list(solve_models({"lower": JOB}, todo, workers=2, memory=Memory(None), on_step=str))


def test_models_of_other_code_are_deleted_and_nothing_else(tmp_path):
    for name in ("0123456789ab", "0123456789abc", "mine"):
        (tmp_path / name).mkdir()
    memory_in(tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"0123456789abc", "mine", code_digest()}
    memory_in(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == names
