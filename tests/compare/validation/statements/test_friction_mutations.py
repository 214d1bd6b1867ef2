"""Signs and factors changed in the contact code change what statements on friction find in scenes.

Coarse elements, and C made of approximations: nothing is solved but contacts. What changes all ICs alike is
seen by other tests: circles of a wheel that are all alike change no criterion of statement 34.
"""

import pytest

from compare.validation.statements.friction_contacts import SINGLE
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.runs import Runs
from femic.cache.store import Store
from femic.contact.friction.motion import Shift
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs.ics import GivenICs
from femic.contact.rolling import RollingProblem
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid

TABLE = {"n_x": 16, "n_s": 16, "dx": 1.7, "ds": 2.3, "s": 0.0}
COARSE = {
    "rolling": {"longitudinal": [-4e-3, -2e-3, -1e-3, 0.0, 1e-3, 3e-3]},
    "compression": {"loads": [20e3, 60e3, 100e3]},
}
MADE_OF = "Bhat+sn:B+xn:Bhat_prime"


class Coarse(Runs):
    """Contacts on coarse elements, with C that is the mix."""

    def friction(self, name, changes, given=None):
        contact = changes["contact"] | {"grid": "scene", "ics": [*SINGLE, "C"]} | COARSE[name]
        contact.pop("elements", None)
        grid = Grid(*TABLE.values())
        c = GivenICs(grid, approximate_matrix(MADE_OF, load_scene("rolling").pair, grid))
        return super().friction(name, {"contact": contact, "grid": TABLE}, {"C": c} | (given or {}))


def cases_met(number, folder):
    """Which criteria of a statement are met in which cases; "failed" where nothing can be measured."""
    runs = Coarse(RunOptions(1, Store(folder)), 1e-3)
    try:
        return {
            (criterion.name, case): criterion.met(value)
            for criterion in STATEMENTS[number].criteria
            for case, value in criterion.measure(runs).items()
        }
    except Failure:
        return {"failed": True}


WEIGHTS = RollingProblem.weights.func
GIVEN_AT, BOUND = Shift.given_at, FrictionalProblem.bound


def weights_with(name, factor):
    """What tractions contribute to the force of a creepage, wrong by a factor."""

    def wrong(self):
        weights = dict(WEIGHTS(self))
        weights[name] = factor * weights[name]
        return weights

    return property(wrong)


def turned_back(self, approach):
    """An approach that moves surfaces along s to the other side."""
    return 2 * self.given - GIVEN_AT(self, approach)


MUTATIONS = {  # what is wrong, where, and the statement that must say so
    "sign of the longitudinal force": (
        RollingProblem,
        "weights",
        weights_with("longitudinal", -1),
        35,
    ),
    "friction three times as large": (
        FrictionalProblem,
        "bound",
        lambda self, p: 3 * BOUND(self, p),
        36,
    ),
    "approach moves surfaces the other way": (Shift, "given_at", turned_back, 37),
}


@pytest.mark.slow
@pytest.mark.parametrize("mutation", MUTATIONS)
def test_wrong_signs_and_factors_change_what_is_met_in_scenes(mutation, monkeypatch, tmp_path):
    target, name, wrong, number = MUTATIONS[mutation]
    before = cases_met(number, tmp_path / "right")
    assert "failed" not in before
    monkeypatch.setattr(target, name, wrong)
    assert cases_met(number, tmp_path / "wrong") != before
