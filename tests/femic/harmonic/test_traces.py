"""Responses by the last block of the factors: those that fields have, and proved like these."""

from dataclasses import replace

import numpy as np
import pytest

from femic.accuracy import NotConverged
from femic.harmonic import equations, traces
from femic.harmonic.engine import build_section, strips
from femic.harmonic.equations import LARGEST_RESIDUAL, FreeSystem, Stiffness
from femic.harmonic.section import section_mesh
from femic.harmonic.section_model import assemble
from femic.harmonic.section_response import Respond, observers, strip_force
from femic.harmonic.section_size import SectionSize
from femic.harmonic.traces import FEW_LOADS, Traces
from geometries.contours import arc
from geometries.patches import Load, Patch
from tests.femic.kept_model import BODY, TASK

COMPLIANCE = 1 / BODY.material.G


@pytest.fixture(scope="module")
def model():
    return assemble(build_section(TASK.request))


def traced(model, n_strips, n_observers, compliance=COMPLIANCE):
    """Loads on strips beside each other in all directions, and observers, on the whole section."""
    patches = [Patch(0.2, 0.2, 0.4 * m - 1.0) for m in range(n_strips)]
    loads = [Load(patch, direction) for patch in patches for direction in range(3)]
    forces = np.stack([strip_force(model.section, load) for load in loads], axis=1)
    seen = observers(model.section, np.linspace(-1.5, 2.0, n_observers), 0)
    return Traces.of(model.free_of(model.supported), forces, seen, compliance)


@pytest.fixture(scope="module")
def many(model):
    return traced(model, 7, 8)


def by_fields(traced, k):
    return traced.observers @ traced.system.solved(k, traced.forces)[0]


def largest(values):
    return np.max(np.abs(values))


@pytest.mark.parametrize(("strips", "seen"), [(7, 8), (7, 2), (5, 20)])
@pytest.mark.parametrize("k", [0.0, 0.02, 0.3, 8.0])
def test_the_last_block_has_what_the_fields_have(model, strips, seen, k):
    of_model = traced(model, strips, seen)
    assert of_model.bordered is not None
    responses, residual = of_model.responses(k)
    assert responses.shape == (3 * seen, 3 * strips)
    assert largest(responses - by_fields(of_model, k)) < 1e-10 * largest(responses)
    assert 0 < residual < 1e-9


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_a_half_section_sees_both_sides_as_fields_do(monkeypatch, share):
    """Loads and observers on both sides of y = 0 share columns and places, with the signs of their parity."""
    body = replace(BODY, contour=arc(10.0, 0.3, 0.3))
    loads = tuple(
        Load(Patch(0.4, 0.3, s), direction) for s in (-1.5, 0.0, 1.0, 1.5) for direction in range(3)
    )
    seen = np.array([-2.0, -1.0, 0.0, 0.5, 1.0, 2.0])
    half = assemble(build_section(replace(TASK.request, body=body, loads=loads)))
    assert half.section.half_section
    whole = section_mesh(
        body, SectionSize(TASK.request.cells, strips(load.patch for load in loads)), half_section=False
    )

    def responses(model, few):
        monkeypatch.setattr(traces, "FEW_LOADS", few)
        return Respond(model, loads, seen, (share,))(0.3, share)[0]

    by_border, of_fields = responses(half, 0), responses(half, 100)
    assert largest(by_border - of_fields) < 1e-10 * largest(of_fields)
    assert largest(by_border - responses(assemble(whole), 0)) < 1e-3 * largest(of_fields)


def test_few_loads_are_solved_for_their_fields(model):
    few = traced(model, FEW_LOADS // 3, 8)
    assert few.bordered is None
    np.testing.assert_array_equal(few.responses(0.3)[0], by_fields(few, 0.3))


def test_the_unit_of_force_does_not_matter(many):
    """All moduli a million times as large: all responses a millionth."""
    stiffness = many.system.stiffness
    harder = Stiffness(stiffness.pattern, tuple(1e6 * part for part in stiffness.parts))
    system = FreeSystem(many.system.free, harder)
    changed = Traces.of(system, many.forces, many.observers, 1e-6 * COMPLIANCE)
    softer, (hard, _) = many.responses(0.3)[0], changed.responses(0.3)
    assert largest(1e6 * hard - softer) < 1e-11 * largest(softer)


@pytest.mark.parametrize("compliance", [1e-3 * COMPLIANCE, 1e3 * COMPLIANCE])
def test_the_natural_compliance_need_not_be_exact(model, compliance):
    of_model = traced(model, 7, 8, compliance)
    responses = of_model.responses(0.3)[0]
    assert largest(responses - by_fields(of_model, 0.3)) < 1e-8 * largest(responses)


def test_a_border_that_was_moved_is_not_read(many, monkeypatch):
    expected = by_fields(many, 0.3)
    monkeypatch.setattr(traces, "_last_block", lambda *_: None)
    np.testing.assert_array_equal(many.responses(0.3)[0], expected)


class Permuted:
    """Factors of a matrix of three rows whose rows or columns were exchanged."""

    shape = (3, 3)

    def __init__(self, rows, columns):
        self.perm_r, self.perm_c = np.array(rows), np.array(columns)


@pytest.mark.parametrize("moved", [([0, 2, 1], [0, 1, 2]), ([0, 1, 2], [1, 0, 2]), ([2, 1, 0], [2, 1, 0])])
def test_a_last_block_of_other_rows_or_columns_is_none(moved):
    assert traces._last_block(Permuted(*moved), 2) is None


# --- what is wrong raises --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("columns", "factor"),
    [(slice(None), 1.001), (slice(1), 1.001), (slice(20, 21), 1.001), (slice(1), np.nan)],
)
def test_a_block_that_is_wrong_by_a_thousandth_raises(many, monkeypatch, columns, factor):
    """All of it, or the responses to one load."""
    right, d = traces._last_block, many.bordered.d

    def wrong(factors, size):
        responses = d * np.eye(size) - right(factors, size)
        responses[:, columns] *= factor
        return d * np.eye(size) - responses

    assert many.responses(0.3)[1] < 1e-10
    monkeypatch.setattr(traces, "_last_block", wrong)
    with pytest.raises(NotConverged, match=r"k = 0\.3 1/mm, [\d,]{5,} unknowns.* residual is .*Try"):
        many.responses(0.3)


class Solving:
    """Factors whose solutions are changed."""

    def __init__(self, factors, change):
        self._factors, self._change = factors, change

    def __getattr__(self, name):
        return getattr(self._factors, name)

    def solve(self, f):
        return self._change(self._factors.solve(f))


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
@pytest.mark.parametrize("change", [lambda u: 1.5 * u, np.zeros_like, lambda u: np.full_like(u, np.nan)])
def test_a_system_that_is_not_solved_raises(many, monkeypatch, change):
    splu = equations.splu
    monkeypatch.setattr(equations, "splu", lambda *args, **named: Solving(splu(*args, **named), change))
    with pytest.raises(NotConverged, match="residual"):
        many.responses(0.3)


def test_the_residual_is_that_of_the_worst_of_equations_and_block(many, monkeypatch):
    """A thousandth more of the solution: the equations of K are that far from solved."""
    splu = equations.splu
    share = 0.1 * LARGEST_RESIDUAL
    monkeypatch.setattr(
        equations, "splu", lambda *args, **named: Solving(splu(*args, **named), lambda u: (1 + share) * u)
    )
    _, residual = replace(many).responses(0.3)
    n = many.forces.shape[1]
    assert share * np.sqrt(n) / 2 < residual < 2.5 * share * np.sqrt(n)
