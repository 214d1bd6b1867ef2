"""Threads of a program: calls that compute wait for each other, as Gmsh needs it."""

import subprocess
import sys
from threading import Thread

import pytest

import femic
from femic.interface.options import LOCK, in_turn

COMPUTE = ("compute_ics", "compute_matrix", "solve_contact", "fit_bhat_prime", "compute_shifts", "run_scene")
TWO = """
from concurrent.futures import ThreadPoolExecutor
import femic

pair, patch = femic.load_pair("geometry1"), femic.Patch(0.3, 0.2)
options = femic.Options(0.3, far_radius=60.0, workers=1)


def solved(s):
    lines, one = [femic.line_along_x(s, 3.0, 5)], {"bodies": ["lower"], "components": ["nn"]}
    return femic.compute_ics(pair, patch, lines, ["C"], options=options, **one)


with ThreadPoolExecutor(2) as threads:
    _, one = threads.map(solved, (0.0, 0.5))
print(float(abs(one.ic - solved(0.5).ic).max()))
"""


@pytest.mark.parametrize("name", COMPUTE)
def test_each_function_that_computes_holds_the_lock(name):
    """Of the layers of the function, one takes the lock."""
    layers, function = [], getattr(femic, name)
    while function is not None:
        layers.append(function.__code__)
        function = getattr(function, "__wrapped__", None)
    assert in_turn(lambda: None).__code__ in layers


def test_one_thread_at_a_time_computes_and_may_call_again_from_a_report():
    free = []

    def attempt():
        free.append(LOCK.acquire(blocking=False))
        if free[-1]:
            LOCK.release()

    def another_thread_may():
        thread = Thread(target=attempt)
        thread.start()
        thread.join()

    in_turn(in_turn(another_thread_may))()
    another_thread_may()
    assert free == [False, True]


def test_two_threads_compute_c():
    """In a process of its own: without the lock, Gmsh ends it."""
    done = subprocess.run(
        [sys.executable, "-c", TWO], capture_output=True, text=True, check=False, timeout=300
    )
    assert (done.returncode, done.stdout) == (0, "0.0\n"), done.stderr[-500:]
