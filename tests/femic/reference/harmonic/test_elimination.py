"""Elimination part by part leaves what a dense matrix leaves, whatever the order."""

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from scipy.sparse import csr_matrix, random_array

from femic.reference.harmonic import elimination as module
from femic.reference.harmonic.elimination import Elimination, dissect, in_parts
from femic.reference.harmonic.engine import build_section
from femic.reference.harmonic.section import assemble
from femic.reference.meshing import Cells
from geometries.bodies import Domain
from tests.femic.reference.harmonic.fields import stiffness
from tests.femic.reference.small_model import BODY, TASK

K = [0.0, 0.4, 7.0]
SMALL = replace(TASK.request, body=replace(BODY, domain=Domain(2.0, np.inf)), cells=Cells(0.5, 0.9, 0.9))


class Equations(NamedTuple):
    """The arguments of `Elimination.prepare`."""

    model: object
    free: np.ndarray
    last: np.ndarray
    forces: csr_matrix
    observers: csr_matrix


@pytest.fixture(scope="module")
def model():
    return assemble(build_section(SMALL))


@pytest.fixture(scope="module")
def equations(model):
    """Some amplitudes are held, nodes of all parts retained; loads and observers touch a few amplitudes."""
    generator = np.random.default_rng(1)
    n = model.section.mesh.doflocs.shape[1]
    free = ~model.section.supported & (generator.random((n, 3)) > 0.02)
    last = generator.random(n) < 0.02
    forces, observers = (csr_matrix(random_array((3 * n, m), density=3e-3, rng=generator)) for m in (4, 6))
    return Equations(model, free, last, forces, observers.T.tocsr())


def dense(equations, k):
    """M = [[K, F], [G, 0]] of all amplitudes."""
    f, g = equations.forces.toarray(), equations.observers.toarray()
    return np.block([[stiffness(equations.model, k).toarray(), f], [g, np.zeros((len(g), f.shape[1]))]])


@pytest.mark.parametrize("most_runs", [module.MOST_RUNS, 0], ids=["by blocks", "by places"])
@pytest.mark.parametrize("leaf", [1, 2, 7])
def test_what_is_left_is_the_schur_complement(equations, monkeypatch, leaf, most_runs):
    monkeypatch.setattr(module, "CELLS_OF_A_LEAF", leaf)
    monkeypatch.setattr(module, "MOST_RUNS", most_runs)
    elimination = Elimination.prepare(*equations)
    gone, retained = np.split(elimination.amplitudes, [-elimination.retained])
    assert len(retained) == np.sum(equations.free[equations.last]) > 10
    assert sorted([*gone, *retained]) == np.flatnonzero(equations.free).tolist()
    n = equations.free.size
    for k, left in zip(K, elimination.at(K).left, strict=True):
        matrix = dense(equations, k)
        rows, columns = (np.append(retained, np.arange(n, size)) for size in matrix.shape)
        expected = matrix[np.ix_(rows, columns)] - matrix[np.ix_(rows, gone)] @ np.linalg.solve(
            matrix[np.ix_(gone, gone)], matrix[np.ix_(gone, columns)]
        )
        np.testing.assert_allclose(left, expected, rtol=0, atol=1e-9 * np.max(np.abs(expected)))


def test_fields_solve_the_equations_with_what_is_retained(equations):
    elimination = Elimination.prepare(*equations)
    eliminated, generator = elimination.at(K), np.random.default_rng(2)
    gone, retained = np.split(elimination.amplitudes, [-elimination.retained])
    moved = generator.normal(size=(len(K), len(retained), 2))
    loads = 1e6 * generator.normal(size=(4, 2))
    u = eliminated.fields(moved, loads)
    np.testing.assert_array_equal(u[:, len(gone) :], moved)
    forces = equations.forces.toarray() @ loads
    for k, field, by_cells in zip(K, u, eliminated.forces(u), strict=True):
        everywhere = np.zeros((equations.free.size, 2))
        everywhere[elimination.amplitudes] = field
        expected = (stiffness(equations.model, k) @ everywhere)[elimination.amplitudes]
        np.testing.assert_allclose(by_cells, expected, rtol=0, atol=1e-10 * np.max(np.abs(expected)))
        defect = by_cells[: len(gone)] - forces[gone]
        assert np.max(np.abs(defect)) < 1e-9 * np.max(np.abs(expected))


def test_forces_may_differ_from_wavenumber_to_wavenumber(equations):
    elimination = Elimination.prepare(*equations)
    factors = np.array([2.0, -1.0, 0.0])
    m = elimination.retained
    at, scaled = (
        elimination.at(K, forces).left for forces in (None, factors[:, None] * elimination.forces.data)
    )
    np.testing.assert_array_equal(scaled[:, :, :m], at[:, :, :m])
    np.testing.assert_allclose(scaled[:, :, m:], factors[:, None, None] * at[:, :, m:], rtol=1e-12)


@pytest.mark.parametrize("leaf", [1, 2, 7])
def test_each_node_is_eliminated_once_with_all_of_its_cells(model, monkeypatch, leaf):
    """The nodes that a part keeps are those that other parts have too, or the last ones."""
    monkeypatch.setattr(module, "CELLS_OF_A_LEAF", leaf)
    n = model.section.mesh.doflocs.shape[1]
    last = np.arange(n) % 50 == 7
    parts = dissect(model.cells, model.section.mesh.doflocs, last)
    gone = np.concatenate([part.eliminated for part in parts])
    assert sorted(gone) == np.flatnonzero(~last).tolist()
    of_parts = []
    for part in parts:
        chosen = part.cells if part.cells is not None else np.concatenate([of_parts[h] for h in part.halves])
        assert part.cells is None or len(part.cells) <= leaf
        of_parts.append(chosen)
        inside = np.unique(model.cells[chosen])
        beside = np.unique(np.delete(model.cells, chosen, axis=0))
        assert set(part.kept) == set(inside) & (set(beside) | set(np.flatnonzero(last)))
    assert sorted(of_parts[-1]) == list(range(len(model.cells)))


def test_factors_grow_hardly_faster_than_the_unknowns():
    """As n ln n, which is what nested dissection of a plane section leaves."""
    sizes = []
    for growth in (0.6, 0.25):
        section = build_section(replace(SMALL, body=BODY, cells=Cells(0.1, growth, growth)))
        free, none = ~section.supported, csr_matrix((section.supported.size, 0))
        last = np.zeros(len(free), dtype=bool)
        elimination = Elimination.prepare(assemble(section), free, last, none, none.T.tocsr())
        numbers = sum(front.eliminated * front.shape[1] for front in elimination.fronts)
        sizes.append((np.count_nonzero(free), numbers))
    (few, of_few), (many, of_many) = sizes
    assert many > 3 * few
    assert of_many / of_few < 1.2 * many * np.log(many) / (few * np.log(few))


@pytest.mark.parametrize("n", [0, 1, 2, 5, 8, 9, 23])
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_parts_of_wavenumbers(n, workers):
    k = np.linspace(0.0, 2.0, n).tolist()
    parts = in_parts(k, 4, workers)
    assert [one for part in parts for one in part] == k
    assert all(0 < len(part) <= 4 for part in parts)
    assert len(parts) >= min(workers, n)
    assert all(abs(len(one) - len(other)) <= 1 for one, other in pairwise(parts))
