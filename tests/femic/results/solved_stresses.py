"""A wheel that rolls on a rail, and stresses below it on few points."""

import tomllib
from contextlib import contextmanager
from functools import cache
from types import SimpleNamespace

import pytest

from femic.reference.run_options import RunOptions
from femic.results import stressed_contact
from femic.results.stressed_contact import lattice_below, solve_contacts
from femic.results.stresses import compute_stresses
from femic.scenes.load import scene_from_table
from tests.femic.contact.wheel_on_rail import scene

ONE = RunOptions(workers=1)
COARSE, FINER = ({"stresses": {"fineness": fineness, "estimated": False}} for fineness in (0.1, 0.25))
CONSTANTS = {"yield_stress": 500.0, "hardness": 3000.0, "speed": 20.0}
ROLLING = {"motion": "rolling", "loads": [5e3], "friction": [0.2, 0.4], "longitudinal": [-0.01, 0.0, 0.01]}


def with_tables(of, **tables):
    """A scene with other tables."""
    return scene_from_table(tomllib.loads(of.text) | tables, of.name)


@contextmanager
def lattices(n_x, n_s, n_d):
    """Lattices have these numbers of points."""
    with pytest.MonkeyPatch.context() as patch:
        for name, n in (("ALONG_X", n_x), ("ALONG_S", n_s), ("INTO_DEPTH", n_d), ("DEEPER_STILL", 3)):
            patch.setattr(stressed_contact, name, n)
        yield patch


@cache
def rolling_stresses():
    """The contacts of the wheel, the lattices below it and the arrays."""
    rolls = with_tables(scene(**ROLLING), **COARSE, damage=CONSTANTS | {"dang_van": {"hydrostatic": 0.2}})
    with lattices(5, 4, 3) as patch:
        contacts = solve_contacts(rolls, ONE)
        patch.setattr("femic.results.stresses.solve_contacts", lambda *_: contacts)
        return SimpleNamespace(
            contacts=contacts,
            lattices={body: lattice_below(contacts, body) for body in ("upper", "lower")},
            dataset=compute_stresses(rolls, ONE),
        )
