"""C of both bodies on a grid: pairing of strips, reciprocity, the approach, positivity, its estimate."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import matrix
from femic.contact.loading import Loading
from femic.contact.motions.none import solve_frictionless
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.dense import GridOperator, reciprocity_defects
from femic.contact.pairs.grids import make_sizing
from femic.contact.pairs.ics import (
    ALL,
    BodyICs,
    approximation,
    full_reference_ics,
    normal_reference_ics,
    pair_operator,
    reciprocal,
    require_positive,
    smallest_eigenvalue,
    sum_of_bodies,
)
from femic.contact.pairs.pair_on_grid import pair_on_grid, undeformed_surfaces
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid, N
from tests.femic.contact.pairs.problems import problem


def test_c_of_the_upper_body_lies_opposite_the_lower_strips(monkeypatch):
    """Where the wheel is moved aside, both strips of a pair have the same y."""
    of = problem(12.0, shift=0.7)
    grid = Grid(8, 6, 0.2, 0.2, undeformed_surfaces(of).touching[0])
    submitted = {}

    def recorded(jobs, *_, **__):
        submitted.update(jobs)
        raise InterruptedError

    monkeypatch.setattr("femic.contact.pairs.ics.matrices", recorded)
    with pytest.raises(InterruptedError):
        normal_reference_ics(of, pair_on_grid(of, grid), RunOptions())
    middle = {name: float(job.body.contour.position(job.grid.s)[0]) for name, job in submitted.items()}
    assert middle["upper"] + 0.7 == pytest.approx(middle["lower"], abs=1e-6)
    assert abs(submitted["upper"].grid.s - submitted["lower"].grid.s) > 0.5
    assert submitted["upper"].grid.n_s == submitted["lower"].grid.n_s == 6
    assert {job.components for job in submitted.values()} == {("nn",)}  # and no loads of other directions


def test_rigid_compliance_along_z_changes_the_approach_alone():
    """As the discount's M_zz does: by itself times the load; also where ICs are not positive with it."""
    of = problem(10.2, loads=(2e3,))
    ((grid, (case,)),) = make_sizing(of).grids([Loading(2e3)])
    on_grid = pair_on_grid(of, grid)
    nn = matrix("Bhat", of.pair, grid)[..., N, N]
    give = -3e-7 * grid.area  # mm/MPa: more than B-hat has over the grid
    moved = nn + give * np.outer(on_grid.cosine, on_grid.cosine)
    plain, given = (
        on_grid.solve_in_place(GridOperator.from_ics(ics[..., None, None], (N,)), case) for ics in (nn, moved)
    )
    np.testing.assert_allclose(given.p, plain.p, atol=1e-5 * plain.p.max())
    assert given.approach - plain.approach == pytest.approx(give / grid.area * 2e3, rel=1e-6)
    of_load = on_grid.cosine[None]
    assert smallest_eigenvalue(nn, of_load) == pytest.approx(smallest_eigenvalue(moved, of_load), rel=0.1)


def without_a_turn(on_grid, nn):
    """ICs from which a turn is taken: antisymmetric pressures do negative work."""
    turn = np.sin(on_grid.undeformed.lower.contour.inclination(on_grid.grid.strips))
    return nn - 5e-5 * on_grid.grid.area * np.outer(turn, turn)


def test_c_that_is_not_positive_for_the_pressures_is_refused_before_the_solution():
    """Symmetric contact has no antisymmetric pressures, which alone do negative work here."""
    of = problem(10.2, loads=(2e3,))
    ((grid, _),) = make_sizing(of).grids([Loading(2e3)])
    on_grid = pair_on_grid(of, grid)
    nn = without_a_turn(on_grid, matrix("Bhat", of.pair, grid)[..., N, N])
    assert smallest_eigenvalue(nn, on_grid.cosine[None]) < 0
    assert on_grid.symmetric
    assert require_positive(of, on_grid, nn) > 0.1
    moved = replace(on_grid, undeformed=replace(on_grid.undeformed, shift=0.05))
    assert not moved.symmetric
    with pytest.raises(Failure, match=r"'approach'.* without vertical load would do negative work"):
        require_positive(of, moved, nn)
    with pytest.raises(Failure, match="use discount = 'approach'"):
        require_positive(replace(of, discount="source"), moved, nn)


@pytest.mark.parametrize("n_s", [6, 7])
def test_symmetric_pressures_have_the_eigenvalues_of_symmetric_eigenvectors(n_s):
    """Against all eigenvectors of a dense matrix of random symmetric ICs of one element along x."""
    rng = np.random.default_rng(n_s)
    half = rng.standard_normal((n_s, n_s))
    whole = half @ half.T + (half @ half.T)[::-1, ::-1]
    values, vectors = np.linalg.eigh(whole)
    even = [v for v, w in zip(values, vectors.T, strict=True) if np.allclose(w, w[::-1], atol=1e-8)]
    result = smallest_eigenvalue(whole[None], np.zeros((0, n_s)), symmetric=True)
    assert result == pytest.approx(min(even) / whole.diagonal().min(), rel=1e-2, abs=0.04)


def test_c_is_perturbed_by_the_estimates_of_both_bodies(monkeypatch):
    """Products with tractions differ by those of the sum of the estimates; the largest is said."""
    of, grid = problem(10.3), Grid(6, 4, 0.4, 0.5)
    on_grid, random = pair_on_grid(of, grid), np.random.default_rng(4)
    size = matrix("Bhat", of.pair, grid)
    estimates = {name: 0.01 * random.random(size.shape) * np.max(size) for name in ("lower", "upper")}
    made = {name: BodyICs(size / 2) for name in estimates}, sum(estimates.values())
    monkeypatch.setattr("femic.contact.pairs.ics.c_of_bodies", lambda *_: made)
    c, p = (
        full_reference_ics(of, on_grid, RunOptions(), wheel_rolls=True),
        random.random((6, 4, 3)),
    )
    total = estimates["lower"] + estimates["upper"]
    np.testing.assert_allclose(
        c.perturbed(p) - c.operator(p), GridOperator.from_ics(total)(p), rtol=1e-6, atol=1e-12
    )
    assert c.estimate == pytest.approx(np.max(total) / np.max(np.abs(size[..., 2, 2])), rel=1e-6)


def test_c_nn_is_perturbed_by_its_estimate(monkeypatch):
    of, grid = problem(10.3), Grid(6, 4, 0.4, 0.5)
    on_grid = pair_on_grid(of, grid)
    nn = matrix("Bhat", of.pair, grid)[..., 2, 2]
    estimate = 0.01 * nn
    monkeypatch.setattr("femic.contact.pairs.ics.normal_ics", lambda *_: (nn, estimate))
    c, p = (
        normal_reference_ics(of, on_grid, RunOptions()),
        np.random.default_rng(4).random((6, 4, 1)),
    )
    np.testing.assert_allclose(c.perturbed(p), 1.01 * c.operator(p))
    assert c.estimate == pytest.approx(0.01)


def test_only_rolling_wheels_get_the_ics_of_rolling():
    of = problem(10.3)
    grid = Grid(6, 4, 0.2, 0.2)
    on_grid = pair_on_grid(of, grid)
    random = np.random.default_rng(0)
    ics = {name: BodyICs(random.standard_normal((6, 4, 4, 3, 3))) for name in ("lower", "upper")}
    rolled, pressed = (sum_of_bodies(on_grid, ics, wheel_rolls=rolls) for rolls in (True, False))
    np.testing.assert_array_equal(rolled[..., 1:, :], pressed[..., 1:, :])
    assert np.max(np.abs(rolled[1:, ..., 0, :] - pressed[1:, ..., 0, :])) > 0
    np.testing.assert_array_equal(pressed, ics["lower"].ics + ics["upper"].ics)


@pytest.mark.slow  # two models by finite elements
def test_c_of_planes_moves_as_half_spaces_do():
    """All nine components; coarse cells."""
    of = load_scene(
        "flat", {"engine": {"tolerance": 0.3}, "contact": {"motion": "compression", "loads": [1.0]}}
    )
    on_grid = pair_on_grid(of.contact_problem, Grid(6, 4, 0.4, 0.6))
    c = full_reference_ics(of.contact_problem, on_grid, RunOptions(), wheel_rolls=False)
    p = np.random.default_rng(0).random((6, 4, 3))
    p -= p.mean(axis=(0, 1))  # no resultant: the rigid-body discount does not matter
    expected = approximation(on_grid, "A")(p)
    result = c.operator(p)
    result -= (result - expected).mean(axis=(0, 1))
    np.testing.assert_allclose(result, expected, atol=0.1 * np.max(np.abs(expected)))
    assert 0 < c.estimate < 0.2


def test_reciprocal_ics_are_reciprocal_and_already_reciprocal_ones_unchanged():
    ics = np.random.default_rng(0).standard_normal((5, 4, 4, 3, 3))
    made = reciprocal(ics)
    assert np.max(reciprocity_defects(made)) < 1e-15
    np.testing.assert_array_equal(reciprocal(made), made)
    np.testing.assert_allclose(np.einsum("xssii->xsi", made), np.einsum("xssii->xsi", ics))


def test_subtracted_approach_is_vertical_without_rotation():
    """Along z at any lag, per vertical traction, the sum of the bodies'; of rolling, too."""
    of, grid = problem(10.3), Grid(6, 4, 0.2, 0.9, 1.1)
    on_grid, random = pair_on_grid(of, grid), np.random.default_rng(0)
    ics = {name: random.standard_normal((6, 4, 4, 3, 3)) for name in ("lower", "upper")}
    approaches = {"lower": 3.0, "upper": -2.5}
    taken = sum_of_bodies(on_grid, {name: BodyICs(of_body) for name, of_body in ics.items()})
    taken -= sum_of_bodies(
        on_grid, {name: BodyICs(of_body, approaches[name]) for name, of_body in ics.items()}
    )
    delta = grid.strips / 10.0
    along_z = np.stack([0 * delta, -np.sin(delta), np.cos(delta)], axis=-1)
    expected = 0.5 * np.einsum("ai,bj->abij", along_z, along_z)
    np.testing.assert_allclose(taken, np.broadcast_to(expected, taken.shape), atol=1e-12)


class Body:
    """A body whose raw C is 0, and something with a nearer far arc: the rest of a pair is subtracted."""

    def __init__(self, approach, raw=0.0):
        self.m_zz, self.raw = approach, raw

    def paired_column(self, _, variation):
        return np.full((3, 3, 4, 6), self.raw if variation else 0.0)

    def approach(self, variation):
        return self.m_zz * (2.0 if variation else 1.0)


def test_the_approach_of_a_pair_is_read_along_the_lower_normals():
    """Of bodies that incline differently, M_zz large and of opposite signs: their sum counts, and no more."""
    on_grid = pair_on_grid(problem(13.0, shift=0.05), Grid(4, 6, 0.5, 0.9, -0.7))
    bodies, p = {"lower": Body(3.0), "upper": Body(-2.5)}, np.random.default_rng(0).random((4, 6, 1))
    load = np.sum(p[..., 0] * np.cos(on_grid.grid.strips / 10.0)) * on_grid.grid.area
    result = pair_operator(bodies, on_grid, (N,))(p)
    expected = -0.5 * load * np.cos(on_grid.grid.strips / 10.0)
    np.testing.assert_allclose(result[..., 0], np.broadcast_to(expected, (4, 6)), rtol=1e-9)
    nearer = pair_operator(bodies, on_grid, (N,), variation="nearer")(p)
    np.testing.assert_allclose(nearer, 2 * result, rtol=1e-9)


def test_c_with_other_supports_has_their_responses_and_their_approach():
    on_grid = pair_on_grid(problem(13.0, shift=0.05), Grid(4, 6, 0.5, 0.9, -0.7))
    bodies = {"lower": Body(3.0, 0.1), "upper": Body(-2.5, 0.1)}
    result, nearer = (pair_operator(bodies, on_grid, ALL, variation=name) for name in ("", "nearer"))
    ones = np.zeros((4, 6, 3))
    ones[..., 2] = 1.0
    weight = 4 * np.cos(on_grid.grid.strips / 10.0).sum() * on_grid.grid.area
    along_z = np.cos(on_grid.grid.strips / 10.0)
    np.testing.assert_allclose(result(ones)[0, :, 2], -0.5 * weight * along_z, rtol=1e-9)
    raw = 2 * 0.1 * 4 * 6 * on_grid.grid.area
    np.testing.assert_allclose(nearer(ones)[0, :, 2], raw - 1.0 * weight * along_z, rtol=1e-9)


@pytest.mark.slow  # two models by finite elements
def test_c_of_planes_gives_the_contact_of_half_spaces():
    """Within the estimate of C, and with eigenvalues as positive as those of A."""
    of = load_scene("flat", {"engine": {"tolerance": 0.01}})
    grid = Grid(24, 16, 0.4, 0.3)
    on_grid = pair_on_grid(of.contact_problem, grid)
    c = normal_reference_ics(of.contact_problem, on_grid, RunOptions())
    assert c.eigenvalue > 0
    assert c.asymmetry.share < c.estimate < 1e-2
    distance = on_grid.x[:, None] ** 2 / 40 + grid.strips**2 / 20
    by_c, by_c_and_estimate, by_a = (
        solve(NormalProblem(grid, operator, on_grid.flat, distance, on_grid.cosine), load=500.0)
        for operator in (c.operator, c.perturbed, half_space_operator(of.pair, grid, (N,)))
    )
    known = abs(by_c_and_estimate.p.max() / by_c.p.max() - 1) + c.estimate
    assert by_c.p.max() == pytest.approx(by_a.p.max(), rel=known)
    assert by_c.patches[0].s == pytest.approx(by_a.patches[0].s, abs=0.1)


@pytest.mark.slow  # two models by finite elements
def test_choice_of_the_rigid_part_changes_the_approach_and_no_pressure():
    """By M_zz times the load, where contours differ, and where the upper body is moved aside, too.

    With each body's own M_zz, read along its own normals, p_max changed by 1 % on contours such as these.
    """
    of = problem(
        11.5, inclination=75, loads=(2e4,), shift=0.05, grid=Grid(24, 16, 0.9, 0.8, -0.8), ics=("C",)
    )
    result = {}
    for discount in ("approach", "none"):
        on_grid = replace(of, discount=discount, settings=replace(of.settings, tolerance=0.1))
        (contact,) = solve_frictionless(on_grid, RunOptions(2)).contacts.values()
        result[discount] = contact.normal
    approach, none = result["approach"], result["none"]
    np.testing.assert_allclose(approach.p, none.p, atol=3e-4 * none.p.max())  # models of their own
    assert abs(approach.approach / none.approach - 1) > 1e-3
