"""Ctrl-C at a moment when Python cannot raise it."""

import os
import signal
import sys
from time import perf_counter, sleep

import pytest

from femic.cli.main import delivered_interruptions


class Interrupted:
    """Something whose destructor is running when Ctrl-C is pressed."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(autouse=True)
def _keyboard():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def work():
    Interrupted()
    sleep(60.0)


def test_interruption_in_a_destructor_ends_the_work():
    start = perf_counter()
    with pytest.raises(KeyboardInterrupt), delivered_interruptions():
        work()
    assert perf_counter() - start < 30.0  # it does not wait for the end of a blocking call


def test_other_errors_in_destructors_reach_the_previous_hook(monkeypatch):
    forwarded = []
    monkeypatch.setattr(sys, "unraisablehook", forwarded.append)

    class Failing:
        def __del__(self):
            raise ValueError

    with delivered_interruptions():
        Failing()
    assert [error.exc_type for error in forwarded] == [ValueError]
