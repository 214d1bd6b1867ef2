"""Wavenumbers in threads and in processes: the same solutions, kept at once, and errors that arrive."""

import os

import numpy as np
import pytest

from femic.cache.store import Store
from femic.cache.workers import Processes
from femic.reference import engine as models
from femic.reference.engine import peak_memory
from femic.reference.harmonic import engine
from femic.reference.harmonic.engine import SectionWork, build_section, solve
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.stored import StoredWaves
from femic.reference.job import NotConverged
from tests.femic.reference.small_model import TASK

REQUEST = TASK.request
K = np.geomspace(1e-3, 3.0, 11).tolist()


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


@pytest.fixture(scope="module")
def alone():
    return solve(REQUEST)


@pytest.mark.parametrize(("least", "workers"), [(np.inf, 3), (0, 2)], ids=["threads", "processes"])
def test_threads_and_processes_give_what_one_thread_gives(alone, monkeypatch, least, workers):
    """Counted one by one: all wavenumbers, then some of them with coarser cells; 0 is assembled."""
    monkeypatch.setattr(engine, "UNKNOWNS_FOR_PROCESSES", least)
    counted = []
    ballast = np.ones(40_000_000)
    parallel = solve(REQUEST, workers=workers, progress=counted.append)
    np.testing.assert_array_equal(parallel.samples.k, alone.samples.k)
    for ours, expected in (
        (parallel.samples.responses, alone.samples.responses),
        (parallel.samples.last, alone.samples.last),
        (parallel.coarser, alone.coarser),
    ):
        np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-12 * np.max(expected))
    assert parallel.cost.residual == pytest.approx(alone.cost.residual, rel=1.0)
    assert parallel.cost.unknowns == alone.cost.unknowns
    assert counted == list(range(len(counted)))
    assert len(alone.samples.k) < len(counted) - 1 < 2 * len(alone.samples.k)
    # the sum of at most three processes; the peak of the parent is not theirs
    own = peak_memory()
    assert ballast.nbytes / 1e6 < own
    if least == 0:
        assert own + 100 < parallel.cost.peak_memory < 2 * own


@pytest.mark.parametrize("state", [None, b"Name:\t\xff\nVmRSS:\t1 kB\n"])
def test_peak_memory_is_known_where_the_system_does_not_say_it(state, tmp_path, monkeypatch):
    path = tmp_path / "status"
    if state is not None:
        path.write_bytes(state)
    said = peak_memory()
    monkeypatch.setattr(models, "STATE", path)
    assert 0.9 * said < peak_memory() < 1e5


def test_processes_keep_their_solutions_and_take_those_that_are_kept(work, processes, tmp_path, monkeypatch):
    """At most wavenumbers by one far arc, which serves both from `cutoff_wavenumber` on."""
    store = Store(tmp_path)
    solved = list(work(store).solve(K, 2, processes))
    assert os.getpid() not in {process for _, process, _ in solved}
    assert set(store.part_names("key")) == {f"k{k!r}" for k in K}
    first = [solution for solutions, _, _ in solved for solution in solutions]
    arcs = [2 if k < REQUEST.cutoff_wavenumber else 1 for k in K]
    assert [len(responses) for responses, _ in first] == arcs
    assert set(arcs) == {1, 2}
    monkeypatch.setattr(SectionSolver, "__call__", None)  # in this process nothing is solved
    kept = [one for solutions, _, _ in work(store).solve(K, 1) for one in solutions]
    for (responses, residual), (other, other_residual) in zip(first, kept, strict=True):
        np.testing.assert_array_equal(responses, other)
        assert residual == other_residual
    # whose square no number can hold
    with pytest.raises(NotConverged, match=r"k = 1e\+200 1/mm.*not solved.*Try"):
        list(work(store).solve([*K, 1e200], 2, processes))
