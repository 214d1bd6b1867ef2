"""Wavenumbers in threads and in processes: the same solutions, kept at once, and errors that arrive."""

import os

import numpy as np
import pytest

from femic.cache.store import Store
from femic.cache.workers import Processes
from femic.reference import engine as models
from femic.reference.harmonic import engine
from femic.reference.harmonic.engine import SectionWork, build_section, solve
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.stored import StoredWaves
from femic.reference.job import NotConverged
from tests.femic.reference.small_model import TASK

REQUEST = TASK.request
K = np.geomspace(1e-3, 3.0, 11).tolist()


@pytest.fixture(name="in_processes")
def _in_processes(monkeypatch):
    """Small sections too are solved in processes."""
    monkeypatch.setattr(engine, "UNKNOWNS_FOR_PROCESSES", 0)


@pytest.fixture(scope="module")
def work():
    """Take a store, return the work that keeps its solutions there."""
    arcs = "", REQUEST.shares, REQUEST.cutoff_wavenumber
    section = build_section(REQUEST)
    return lambda store: SectionWork(
        section, REQUEST.loads, REQUEST.observed, StoredWaves(store, "key"), *arcs
    )


@pytest.fixture(scope="module")
def processes():
    with Processes(2) as two:
        yield two


def in_threads(work, store):
    """All solutions by this process."""
    return [one for solutions, _, _ in work(store).solve(K, 1) for one in solutions]


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


@pytest.mark.usefixtures("in_processes")
def test_processes_are_counted_with_their_memory():
    """The sum of at most three of them; the peak of the parent is not theirs."""
    ballast = np.ones(40_000_000)
    costs = [solve(REQUEST, workers=workers).cost for workers in (1, 2)]
    assert ballast.nbytes / 1e6 < costs[0].peak_memory < costs[1].peak_memory - 100
    assert costs[1].peak_memory < 2 * costs[0].peak_memory


@pytest.mark.parametrize("state", [None, b"Name:\t\xff\nVmRSS:\t1 kB\n"])
def test_peak_memory_is_known_where_the_system_does_not_say_it(state, tmp_path, monkeypatch):
    path = tmp_path / "status"
    if state is not None:
        path.write_bytes(state)
    said = models.peak_memory()
    monkeypatch.setattr(models, "STATE", path)
    assert 0.9 * said < models.peak_memory() < 1e5


def test_shares_are_those_that_are_felt(work):
    """From `cutoff_wavenumber` on one far arc serves both."""
    found = in_threads(work, Store())
    assert [len(responses) for responses, _ in found] == [
        2 if k < REQUEST.cutoff_wavenumber else 1 for k in K
    ]
    assert 0 < sum(len(responses) == 2 for responses, _ in found) < len(K)


def test_processes_keep_their_solutions_and_take_those_that_are_kept(work, processes, tmp_path, monkeypatch):
    store = Store(tmp_path)
    solved = list(work(store).solve(K, 2, processes))
    assert os.getpid() not in {process for _, process, _ in solved}
    assert set(store.part_names("key")) == {f"k{k!r}" for k in K}
    first = [solution for solutions, _, _ in solved for solution in solutions]
    monkeypatch.setattr(SectionSolver, "__call__", None)  # in this process nothing is solved
    for (responses, residual), (other, other_residual) in zip(first, in_threads(work, store), strict=True):
        np.testing.assert_array_equal(responses, other)
        assert residual == other_residual


def test_error_in_a_process_arrives(work, processes):
    """At a wavenumber whose square no number can hold."""
    with pytest.raises(NotConverged, match=r"k = 1e\+200 1/mm.*not solved.*Try"):
        list(work(Store()).solve([*K, 1e200], 2, processes))
