"""Calls that compute wait for each other where a program has several threads.

Gmsh has one model per process, which the sections and solids of C are meshed in, and ends the process where
two threads change it. Processes compute side by side.
"""

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

LOCK = RLock()  # a report may call the function again


def in_turn(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Return a public function that one thread at a time runs."""

    @wraps(function)
    def call(*arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        with LOCK:
            return function(*arguments, **named)

    return call
