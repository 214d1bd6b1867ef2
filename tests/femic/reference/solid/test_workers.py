"""Models of a body in other processes: what is kept for the next run, dead workers, sessions of Gmsh."""

import subprocess
import sys

import numpy as np
import pytest
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.cache.store import Store
from femic.reference.refinement import solve_models
from femic.reference.run_options import MODELS, Level, RunOptions
from femic.reference.solid import engine as solid
from geometries.errors import Failure
from tests.femic.reference.conftest import TASKS, solve_all


def test_a_second_run_opens_no_mesh_and_an_interrupted_one_resumes(tmp_path, monkeypatch):
    meshed, build, store = [], solid.build_mesh, Store(tmp_path)

    def interrupting(asked):
        if len(meshed) == 2:
            raise KeyboardInterrupt
        return counting(asked)

    def counting(asked):
        meshed.append(asked)
        return build(asked)

    monkeypatch.setattr(solid, "build_mesh", interrupting)
    with pytest.raises(KeyboardInterrupt):
        solve_all(store)
    monkeypatch.setattr(solid, "build_mesh", counting)
    first = solve_all(store)
    assert len(meshed) == len(MODELS)  # two before the interruption, the third after it
    again = list(solve_models(TASKS, RunOptions(1, store)))
    assert all(solved.cached for solved in again)
    assert len(meshed) == len(MODELS)
    np.testing.assert_array_equal(first[Level()].u, again[0].model.u)


def test_a_dead_worker_is_reported_with_both_causes_and_what_to_try(monkeypatch):
    def dead(*_):
        raise TerminatedWorkerError

    monkeypatch.setattr(solid, "in_processes", dead)
    with pytest.raises(Failure, match=r"memory: use fewer.*mesher crashed.*change the cells.*are kept"):
        list(solve_models(TASKS, RunOptions(2)))


WRITES = """
import os
from threading import Thread
from femic.reference.meshing import gmsh_session

def meshes():
    with gmsh_session():
        pass

{call}
reads, writes = os.pipe()
os.close(reads)
try:
    os.write(writes, b"to nobody")
except BrokenPipeError:
    print("raised")
"""


@pytest.mark.parametrize("call", ["meshes()", "one = Thread(target=meshes); one.start(); one.join()"])
def test_write_to_a_closed_connection_does_not_end_a_process_after_meshing(call):
    """Such as a campaign, when a worker is killed; also where a thread has meshed, as in workers."""
    ended = subprocess.run(
        [sys.executable, "-c", WRITES.format(call=call)], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout) == (0, "raised\n"), ended.stderr
