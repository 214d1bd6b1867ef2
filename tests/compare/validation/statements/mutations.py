"""Statements hold as the program is, and miss criteria where something in it is wrong."""

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


def missed(keys):
    """Those of some criteria, by number and name, that are missed in some case."""
    runs = remembering()
    return {key for key in keys if not all(map(CRITERIA[key].met, CRITERIA[key].measure(runs).values()))}


def quick_and_slow(mutations, quick):
    """The names of mutations as parameters, of which all but the quick ones are slow."""
    return [name if name in quick else pytest.param(name, marks=pytest.mark.slow) for name in mutations]
