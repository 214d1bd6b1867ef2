"""Parallel threads: results in order, and nothing goes on behind an early end."""

import time
from threading import Event, current_thread, main_thread

import pytest

from femic.cache.workers import AHEAD, in_threads


@pytest.mark.parametrize("workers", [1, 3])
def test_results_come_in_the_order_of_arguments(workers):
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
        time.sleep(0.05)
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
    assert len(begun) < 6


@pytest.mark.parametrize("workers", [1, 2])
def test_errors_of_the_function_are_raised(workers):
    with pytest.raises(ZeroDivisionError):
        list(in_threads(lambda n: 1 // n, [1, 0, 2], workers))
