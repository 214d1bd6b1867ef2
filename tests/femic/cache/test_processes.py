"""Parallel processes and threads: what they give, and that nothing outlives what started it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event, current_thread, main_thread

import pytest
from threadpoolctl import threadpool_info

from femic.cache import workers as processes
from femic.cache.workers import AHEAD, Prepared, Processes, in_processes, in_threads, one_blas_thread
from geometries.errors import Failure

IDLE, BUSY = "time.sleep(300)", "sum(range(10**11))"  # the latter never gives other threads a turn
ANY = "list(in_processes(task, [sys.argv[1]] * 2, workers=2))"
OWN = "with Processes(2) as processes: list(processes(task, [sys.argv[1]] * 2))"
PARENT = """
import os, sys, time
from femic.cache.workers import Processes, in_processes

def task(folder):
    open(os.path.join(folder, str(os.getpid())), "w").close()
    {work}

if __name__ == "__main__":
    {run}
"""


def until(condition, seconds):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


def alive(pid):
    """Whether a process is there and not only waiting to be buried."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False


@pytest.fixture
def started(tmp_path):
    """Starts a process that works in two others; gives it and their ids."""
    begun = []

    def start(work, run):
        script, notes = tmp_path / "parent.py", tmp_path / "pids"
        script.write_text(PARENT.format(work=work, run=run))
        notes.mkdir()
        path = os.pathsep.join(path for path in sys.path if path)
        command = [sys.executable, str(script), str(notes)]
        begun.append(subprocess.Popen(command, env={**os.environ, "PYTHONPATH": path}))
        assert until(lambda: len(list(notes.iterdir())) == 2, 30)
        begun.extend(int(one.name) for one in notes.iterdir())
        return begun[0], begun[1:]

    yield start
    for pid in begun[1:]:
        if alive(pid):
            os.kill(pid, signal.SIGKILL)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("work", [IDLE, BUSY])
@pytest.mark.parametrize("run", [ANY, OWN])
def test_workers_end_with_a_parent_that_is_killed(started, work, run):
    parent, workers = started(work, run)
    assert all(alive(pid) for pid in workers)
    parent.kill()
    parent.wait()
    assert until(lambda: not any(alive(pid) for pid in workers), 2.0)


def test_each_result_is_yielded_once_and_a_single_worker_is_this_process():
    assert sorted(in_processes(abs, range(-3, 3), workers=2)) == [0, 1, 1, 2, 2, 3]
    assert set(in_processes(_process, range(3), workers=1)) == {os.getpid()}
    assert os.getpid() not in set(in_processes(_process, range(3), workers=2))


def _process(_):
    return os.getpid()


def test_thread_watches_the_parent_where_there_is_no_signal(monkeypatch):
    """On other systems: with the parent there it goes on, without it the process ends."""
    ended, parents = [], iter([7, 7, 1])
    monkeypatch.setattr(processes.os, "_exit", ended.append)
    monkeypatch.setattr(processes.os, "getppid", lambda: next(parents))
    monkeypatch.setattr(processes, "sleep", lambda _: None)
    processes._watch(7)
    assert ended == [1]
    assert not list(parents)


# --- for one piece of work -----------------------------------------------------------------------------


@pytest.fixture
def two():
    with Processes(2) as processes:
        yield processes


def test_results_come_in_the_order_of_arguments(two):
    later_first = [0.3, 0.2, 0.1, 0.0, 0.0, 0.1]
    assert list(two(_waited, later_first)) == later_first
    assert os.getpid() not in set(two(_process, range(3)))


def _waited(seconds):
    time.sleep(seconds)
    return seconds


def test_each_process_prepares_a_function_once(two):
    one, other = Prepared(_prepared), Prepared(_prepared)
    prepared = [*two(one, range(8)), *two(one, range(8))]
    assert len(set(prepared)) == len({pid for pid, _ in prepared}) == 2
    assert not set(two(other, range(8))) & set(prepared)


def _prepared():
    made = (os.getpid(), time.monotonic_ns())

    def function(_):
        time.sleep(0.05)
        return made

    return function


@pytest.mark.parametrize("work", [300.0, 0.0])
def test_processes_end_with_their_work_also_in_the_middle_of_it(work):
    with Processes(2) as processes:
        pids = set(processes(_process_after, [0.2] * 4))
        results = processes(_waited, [0.0, 0.0, *[work] * 8])
        assert next(results) == 0.0
    assert len(pids) == 2
    assert until(lambda: not any(alive(pid) for pid in pids), 2.0)


def _process_after(seconds):
    time.sleep(seconds)
    return os.getpid()


def test_no_process_is_begun_without_work():
    with Processes(2) as processes:
        assert processes._pool is None


def test_two_pieces_of_work_do_not_share_processes(two):
    results = two(_waited, [0.1] * 6)
    assert next(results) == 0.1
    with Processes(2) as others:
        assert list(others(abs, [-1, -2])) == [1, 2]
    assert list(results) == [0.1] * 5


def test_a_dead_process_is_reported_with_its_cause_and_what_to_try(two):
    with pytest.raises(
        Failure, match=r"one of 2 .* ended .*memory .*Use fewer workers \(`workers` = 1\).*are kept"
    ):
        list(two(_killed, range(4)))


def _killed(_):
    os.kill(os.getpid(), signal.SIGKILL)


# --- threads -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("workers", [1, 3])
def test_results_of_threads_come_in_the_order_of_arguments(workers):
    def late(n):
        time.sleep(0.01 * (4 - n % 5))
        return n, current_thread() is main_thread()

    result = list(in_threads(late, range(15), workers))
    assert [n for n, _ in result] == list(range(15))
    assert {in_main for _, in_main in result} == {workers == 1}


def test_results_that_nobody_takes_do_not_pile_up():
    begun = []
    results = in_threads(begun.append, range(50), 2)
    next(results)
    time.sleep(0.1)
    assert len(begun) == AHEAD * 2


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_early_end_waits_for_running_calls_and_starts_no_others(error):
    begun, ended, go_on = [], [], Event()

    def work(n):
        begun.append(n)
        if n == 0:
            return n
        go_on.wait(5)
        time.sleep(0.5)
        ended.append(n)
        return n

    def run():
        for _ in in_threads(work, range(50), 2):
            while len(begun) < 3:
                time.sleep(0.001)
            go_on.set()
            raise error

    with pytest.raises(error):
        run()
    assert sorted(ended) == sorted(begun)[1:]
    assert len(begun) == 3


def test_one_blas_thread_is_one():
    with one_blas_thread():
        assert {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"} == {1}


@pytest.mark.parametrize("workers", [1, 2])
def test_errors_of_the_function_are_raised(workers):
    with pytest.raises(ZeroDivisionError):
        list(in_threads(lambda n: 1 // n, [1, 0, 2], workers))
