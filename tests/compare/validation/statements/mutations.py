"""Statements hold as the program is, and miss criteria where something in it is wrong."""

from dataclasses import replace
from functools import cached_property
from inspect import getattr_static
from types import SimpleNamespace

import pytest

from compare.validation.statements.page import STATEMENTS

CRITERIA = {(number, each.name): each for number, one in STATEMENTS.items() for each in one.criteria}


def remembering():
    """Runs that remember what statements solve, and have nothing else."""
    memory = {}

    def once(name, compute):
        if name not in memory:
            memory[name] = compute()
        return memory[name]

    return SimpleNamespace(once=once)


def missed(keys, runs=None):
    """Those of some criteria, by number and name, that are missed in some case."""
    runs = runs or remembering()
    return {key for key in keys if not all(map(CRITERIA[key].met, CRITERIA[key].measure(runs).values()))}


def cases_met(runs, key):
    """Whether a criterion is met, by case."""
    return {case: CRITERIA[key].met(value) for case, value in CRITERIA[key].measure(runs).items()}


def quick_and_slow(mutations, quick):
    """The names of mutations as parameters, of which all but the quick ones are slow."""
    return [name if name in quick else pytest.param(name, marks=pytest.mark.slow) for name in mutations]


def changed(owner, name, change):
    """A function, method or property of something, and another in its place: `change(right, self, ...)`."""
    right = getattr_static(owner, name)
    if isinstance(right, property | cached_property):
        get = right.fget if isinstance(right, property) else right.func
        return owner, name, property(lambda self: change(get, self))
    return owner, name, lambda *arguments, **named: change(right, *arguments, **named)


def times(owner, name, factor):
    """What a function, method or property returns is wrong by a factor."""
    return changed(owner, name, lambda right, *a, **named: factor * right(*a, **named))


def mirrored(owner, name, field):
    """What a method returns is that of the same with a number of the other sign."""

    def change(right, self, *arguments):
        return right(replace(self, **{field: -getattr(self, field)}), *arguments)

    return changed(owner, name, change)
