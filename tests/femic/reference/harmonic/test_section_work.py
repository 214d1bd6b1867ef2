"""Wavenumbers in threads and in processes: the same solutions, kept at once, and errors that arrive."""

import numpy as np
import pytest

from femic.cache.processes import end_processes
from femic.cache.store import Store
from femic.reference.accuracy import NotConverged
from femic.reference.harmonic import section_work
from femic.reference.harmonic.engine import build_section, solve
from femic.reference.harmonic.entry import StoredWaves
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.section_work import SectionWork
from tests.femic.reference.small_model import TASK

REQUEST = TASK.request
K = np.geomspace(1e-3, 3.0, 11).tolist()


@pytest.fixture(name="in_processes")
def _in_processes(monkeypatch):
    """Small sections too are solved in processes."""
    monkeypatch.setattr(section_work, "UNKNOWNS_FOR_PROCESSES", 0)
    yield
    end_processes()


@pytest.fixture(scope="module")
def work():
    section = build_section(REQUEST)
    return SectionWork(section, REQUEST.loads, REQUEST.observed, REQUEST.shares, REQUEST.felt)


def solutions(work, workers, store):
    """All solutions, and the peak memory of the process of each part."""
    parts = list(work.solver(workers, StoredWaves(store, "key"))(K))
    return [solution for of_part, _ in parts for solution in of_part], [memory for _, memory in parts]


@pytest.mark.usefixtures("in_processes")
def test_processes_give_what_this_process_gives():
    alone, parallel = (solve(REQUEST, workers=workers) for workers in (1, 2))
    np.testing.assert_array_equal(parallel.samples.k, alone.samples.k)
    for name in ("responses", "last"):
        expected = getattr(alone.samples, name)
        np.testing.assert_allclose(
            getattr(parallel.samples, name), expected, rtol=0, atol=1e-12 * np.max(expected)
        )
    np.testing.assert_allclose(parallel.coarser, alone.coarser, rtol=0, atol=1e-12 * np.max(alone.coarser))
    assert parallel.cost.residual == pytest.approx(alone.cost.residual, rel=1.0)
    assert parallel.cost.unknowns == alone.cost.unknowns


def test_shares_are_those_that_are_felt(work):
    """From `felt` on one far arc serves both."""
    found, _ = solutions(work, 1, Store())
    assert [len(responses) for responses, _ in found] == [2 if k < REQUEST.felt else 1 for k in K]
    assert 0 < sum(len(responses) == 2 for responses, _ in found) < len(K)


@pytest.mark.usefixtures("in_processes")
def test_processes_keep_their_solutions_and_take_those_that_are_kept(work, tmp_path, monkeypatch):
    store = Store(tmp_path)
    first, memory = solutions(work, 2, store)
    assert min(memory) > 50
    assert set(store.part_names("key")) == {f"k{k!r}" for k in K}
    monkeypatch.setattr(SectionSolver, "__call__", None)  # in this process nothing is solved
    again, _ = solutions(work, 1, store)
    for (responses, residual), (other, other_residual) in zip(first, again, strict=True):
        np.testing.assert_array_equal(responses, other)
        assert residual == other_residual


@pytest.mark.usefixtures("in_processes")
def test_error_in_a_process_arrives(work):
    """At a wavenumber whose square no number can hold."""
    with pytest.raises(NotConverged, match=r"k = 1e\+200 1/mm.*not solved.*Try"):
        list(work.solver(2, StoredWaves(Store(), "key"))([*K, 1e200]))
