"""Every factorisation's residual is looked at: what is not solved is not a result."""

import numpy as np
import pytest

from femic.accuracy import NotConverged
from femic.harmonic import engine, equations, section_model
from femic.harmonic.entry import KeptWaves
from femic.harmonic.equations import LARGEST_RESIDUAL
from femic.harmonic.section_response import Respond
from femic.work.store import Store
from tests.femic.kept_model import TASK

K = 0.3


class Changed:
    """Factors of a matrix whose solutions are changed."""

    def __init__(self, factor, change):
        self.factor, self.change = factor, change

    def solve(self, f):
        return self.change(self.factor.solve(f))


@pytest.fixture
def changed(monkeypatch):
    """Let solutions be changed from here on."""

    def start(change):
        splu = equations.splu
        monkeypatch.setattr(
            equations, "splu", lambda *args, **options: Changed(splu(*args, **options), change)
        )

    return start


@pytest.fixture(scope="module")
def respond():
    model = section_model.assemble(engine.build_section(TASK.request))
    return Respond(model, TASK.request.loads, TASK.request.observed, (1.0, 0.5))


@pytest.fixture(scope="module")
def many(respond):
    """A system with many different loads, of sizes over ten decades."""
    (part,) = respond._parts
    rng = np.random.default_rng(2)
    of_loads = part.traces[1.0].forces
    forces = of_loads @ rng.normal(size=(of_loads.shape[1], 40)) * np.geomspace(1e-5, 1e5, 40)
    return part.traces[1.0].system, forces


def half_too_large(u):
    return 1.5 * u


def one_is_no_number(u):
    u[len(u) // 2, -1] = np.nan
    return u


def infinite(u):
    return np.full_like(u, np.inf)


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
@pytest.mark.parametrize("change", [half_too_large, one_is_no_number, infinite, np.zeros_like])
def test_displacements_that_are_wrong_raise(changed, respond, change):
    changed(change)
    with pytest.raises(
        NotConverged, match=r"k = 0\.3 1/mm, [\d,]{5,} unknowns.* residual is .*1e-05 allowed.*Try"
    ):
        respond(K)
    with pytest.raises(NotConverged, match="residual"):
        engine.raw_ics(TASK.request)


@pytest.mark.parametrize("column", [0, 17, 39])
def test_a_wrong_column_among_many_raises_however_small_its_force(changed, many, column):
    """One of 40 columns is off by a thousandth of itself; the forces differ by ten decades."""
    system, forces = many

    def change(u):
        u[:, column] *= 1.001
        return u

    assert system.solved(K, forces)[1] < 1e-10
    changed(change)
    with pytest.raises(NotConverged, match=r"residual is 1\.\de-03"):
        system.solved(K, forces)


def test_two_columns_that_are_exchanged_raise(changed, many):
    system, forces = many
    forces = forces / np.linalg.norm(forces, axis=0)
    changed(lambda u: u[:, [1, 0, *range(2, u.shape[1])]])
    with pytest.raises(NotConverged, match="residual"):
        system.solved(K, forces)


def test_the_residual_is_once_to_twice_the_share_that_a_column_is_wrong_by(changed, many):
    system, forces = many
    wrong = LARGEST_RESIDUAL / 10
    changed(lambda u: u * np.where(np.arange(u.shape[1]) == 5, 1 + wrong, 1.0))
    _, residual = system.solved(K, forces)
    assert 0.999 * wrong < residual < 2.001 * wrong


def test_a_matrix_without_factors_raises_with_what_to_try(respond, monkeypatch):
    def singular(*_, **__):
        raise RuntimeError("Factor is exactly singular")

    monkeypatch.setattr(equations, "splu", singular)
    with pytest.raises(NotConverged, match=r"k = 0\.3 1/mm.*exactly singular.*Try"):
        respond(K)


class Answers:
    """Answers of an earlier run that are all here but for their residuals, which are given."""

    def __init__(self):
        self.found, self.residuals = {}, {}

    def get(self, name):
        return (self.found[name], self.residuals[name]) if name in self.found else None

    def put(self, name, answer):
        self.found[name], self.residuals[name] = answer


@pytest.mark.parametrize("workers", [1, 2])
def test_the_cost_has_the_worst_residual_also_of_what_was_kept(workers):
    kept = Answers()
    first = engine.solve(TASK.request, kept=kept, workers=workers).cost.residual
    assert first == max(kept.residuals.values())
    assert 0 < first < 1e-10
    kept.residuals[sorted(kept.residuals)[3]] = 3e-7
    del kept.found["k0.0"]  # this one is solved again
    assert engine.solve(TASK.request, kept=kept, workers=workers).cost.residual == 3e-7


def test_the_worse_of_both_far_arcs_counts(respond, monkeypatch):
    low, residuals = 0.5 * TASK.request.felt, {1.0: 1e-12, 0.5: 2e-12}
    monkeypatch.setattr(Respond, "__call__", lambda _, __, share=1.0: (np.zeros((1, 3, 1)), residuals[share]))
    assert engine._with_both_arcs(TASK.request, respond, low)[1] == 2e-12
    residuals[1.0] = 4e-12
    assert engine._with_both_arcs(TASK.request, respond, low)[1] == 4e-12


def test_the_worse_of_the_even_and_the_odd_part_counts(respond, monkeypatch):
    """Two parts, solved one after the other: the first one's residual is not forgotten."""
    (part,) = respond._parts
    given = iter([5e-9, 1e-12])
    both = Respond.__new__(Respond)
    both.__dict__.update(vars(respond) | {"_parts": [part, part]})
    u, _ = part.traces[1.0].system.solved(K, part.traces[1.0].forces)
    monkeypatch.setattr(equations.FreeSystem, "solved", lambda *_: (u, next(given)))
    assert both(K)[1] == 5e-9


def test_kept_waves_carry_their_residual(tmp_path):
    kept = KeptWaves(Store(tmp_path), "key")
    kept.put("k0.25", (np.eye(3), 4e-11))
    responses, residual = kept.get("k0.25")
    np.testing.assert_array_equal(responses, np.eye(3))
    assert residual == 4e-11
    assert kept.get("k0.5") is None
