"""Rolling of scenes: Kalker's slope and full slip at small loads, prescribed forces, estimates, C in it."""

import numpy as np
import pytest

from approx.matrix import matrix
from compare.contact.pair_on_grid import placed_on
from compare.friction import bodies, rolling
from compare.friction.bodies import Solver
from compare.friction.curve import Path
from compare.friction.operators import (
    BodyICs,
    FullReferenceICs,
    _reciprocal,
    approximation,
    full_reference_ics,
    total_ics,
)
from compare.friction.rolling import compute_rolling, scaled_force
from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.dense import Asymmetry, GridOperator, reciprocity_defects
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.materials import both_bodies
from tests.compare.friction.scenes import scene

SMALL = 2.0  # N: a patch of a degree in all
XI = [-2e-3, -2e-4, 0.0, 2e-4, 2e-3]


def rolls(upper_radius=14.0, **contact):
    return scene(upper_radius, **{"motion": "rolling", "loads": [SMALL], "longitudinal": XI} | contact)


@pytest.fixture(scope="module")
def small():
    """A small contact, hardly inclined: what half-spaces do."""
    return compute_rolling(rolls(friction=[0.3], elements=14))


def test_small_contacts_have_the_slope_of_kalker(small):
    """The creep-force slope without force is G a b C11, where nearly all sticks."""
    of_bhat = small.sel(ics="Bhat", friction=0.3)
    at = of_bhat.isel(xi=2)
    G = both_bodies(*[rolls().bodies[name].material for name in ("upper", "lower")]).G
    c11 = creepage_coefficients(float(at.a), float(at.b), 0.3, degree=12).C11
    expected = G * float(at.a * at.b) * c11
    assert float(of_bhat.slope) == pytest.approx(expected, rel=0.05)


def test_small_contacts_slide_whole_at_large_creepages(small):
    force = scaled_force(small).sel(friction=0.3)
    np.testing.assert_allclose(force.isel(xi=-1), 1.0, atol=2e-3)
    np.testing.assert_allclose(small.sliding_share.isel(xi=-1), 1.0)
    np.testing.assert_allclose(force.isel(xi=0), -force.isel(xi=-1), atol=2e-3)


def test_without_inclination_all_ics_are_those_of_half_spaces(small):
    assert float(small.rms.max()) < 5e-3
    assert float(small.rms.sel(ics="Bhat").max()) == 0.0


def test_tractions_are_compared_at_the_force_that_is_asked_for(small):
    area = float(np.diff(small.x)[0] * np.diff(small.s)[0])
    force = small.p.sel(direction="x").sum(["x", "s"]) * area
    np.testing.assert_allclose(force / (0.3 * SMALL), 0.5, rtol=1e-3)
    assert np.all(small.equal_creepage > small.zero_creepage)


def test_tractions_obey_coulombs_law(small):
    p_t, p_n = small.p.sel(direction=["x", "s"]).values, small.p.sel(direction="n").values
    size = np.linalg.norm(p_t, axis=-1)
    tolerance = 1e-3 * p_n.max()
    assert np.all(size <= 0.3 * p_n + tolerance)
    slides = (p_n > 0) & ~small.stick.values
    np.testing.assert_allclose(size[slides], 0.3 * p_n[slides], atol=tolerance)


@pytest.fixture(scope="module")
def conforming():
    """A patch over tens of degrees by A, B-hat, and the matrix of B-hat in the place of C."""
    of = rolls(
        10.3, loads=[1e4], friction=[0.3], elements=8, ics=["A", "Bhat", "C"], longitudinal=[-1e-3, 0.0, 1e-3]
    )
    patch = pytest.MonkeyPatch()
    patch.setattr("compare.friction.bodies.full_reference_ics", in_place_of_c)
    yield of, compute_rolling(of)
    patch.undo()


def in_place_of_c(of, placed, _):
    operator = GridOperator.of(matrix("Bhat", of.pair, placed.grid))
    perturbed = GridOperator(1.02 * operator.transformed, operator.n_x)
    return FullReferenceICs(operator, perturbed, 0.02, Asymmetry(0.0, "nn"), 0.0)


def test_fast_operators_and_matrices_give_the_same_curve(conforming):
    """A matrix has the curvature of the wheel along x, which fast operators leave out."""
    _, dataset = conforming
    assert float(dataset.rms.sel(ics="Bhat")[0]) < 0.03
    assert float(dataset.rms.sel(ics="A")[0]) > float(dataset.rms.sel(ics="Bhat")[0])


def test_the_largest_difference_of_curves_is_that_at_the_worst_creepage(conforming):
    _, dataset = conforming
    force = scaled_force(dataset).sel(friction=0.3)
    for name in ("A", "Bhat", "C"):
        away = np.abs(force.sel(ics=name).values - force.sel(ics="C").values)
        largest, rms = (float(dataset[key].sel(ics=name, friction=0.3)) for key in ("largest", "rms"))
        assert largest == pytest.approx(np.max(away))
        assert rms == pytest.approx(np.sqrt(np.mean(away**2)))
    assert 0 < float(dataset.rms.sel(ics="A")[0]) < float(dataset.largest.sel(ics="A")[0])


def test_estimates_of_c_have_the_change_by_its_error(conforming):
    _, dataset = conforming
    assert np.all(dataset.estimate_F_x.sel(ics="C") > 0)
    known = dataset.estimate_approach.sel(ics="C") / dataset.approach.sel(ics="C")
    assert np.all(known > 0.005)  # ICs are 2 % larger


def test_curves_are_the_same_from_a_search_as_from_prescribed_forces(conforming):
    of, dataset = conforming
    placed = placed_on(of, Grid(dataset.sizes["x"], dataset.sizes["s"], *steps(dataset)))
    solver = Solver(of, placed, RunOptions())
    path = Path.of(solver, solver.problem(approximation(placed, "A"), 0.3), "A")
    begun = path.first()
    searched = path.searched(0.0, begun)
    expected = float(dataset.zero_creepage.sel(ics="A")[0])
    assert searched.creepages.longitudinal == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("variant", ["A", "Bhat", "mix"])
def test_the_form_of_an_operator_does_not_matter(variant, monkeypatch):
    placed = placed_on(rolls(10.3, shift=0.1), Grid(8, 6, 0.5, 0.7, 0.3))
    p = np.random.default_rng(1).random((8, 6, 3))
    first = approximation(placed, variant)(p)
    monkeypatch.setattr("compare.friction.operators.MOST_DENSE", 4)
    np.testing.assert_allclose(approximation(placed, variant)(p), first, atol=1e-14 * np.max(np.abs(first)))


def steps(dataset):
    return [float(np.diff(dataset[name])[0]) for name in ("x", "s")]


def test_numbers_have_no_estimates_where_larger_elements_have_no_solution(monkeypatch):
    told = []
    monkeypatch.setattr(rolling, "_coarse", lambda *of: told.append(of[2]))
    dataset = compute_rolling(rolls(friction=[0.3], ics=["A"], longitudinal=[0.0, 1e-3]))
    assert told == [f"friction 0.3, A, {words} elements" for words in ("larger", "still larger")]
    assert np.all(np.isnan(dataset.estimate_F_x))
    assert not np.any(np.isnan(dataset.F_x))


def test_forces_beyond_the_curve_are_refused():
    of = rolls(friction=[0.3], ics=["A"], longitudinal=[0.0, 5e-5], equal_force=0.9)
    path = path_of(of)
    with pytest.raises(Failure, match=r"F_x = .* N is beyond the curve; give further creepages"):
        path.searched(0.9 * path.largest, path.first())


def path_of(of):
    found = []
    with pytest.raises(InterruptedError):
        bodies.on_fitting_grid(of, RunOptions(), lambda solver: stop(found, solver))
    (solver,) = found
    return Path.of(solver, solver.problem(solver.operator("A"), 0.3), "A")


def stop(found, solver):
    found.append(solver)
    raise InterruptedError


def test_grids_that_are_too_short_are_made_longer_and_a_scenes_own_is_not():
    tried = []

    def short_at_first(solver):
        tried.append(solver.placed.grid)
        if len(tried) == 1 or not solver.scene.contact.automatic:
            raise PotentialAreaTooSmall(("x > 0",))
        return "done"

    assert bodies.on_fitting_grid(rolls(), RunOptions(), short_at_first) == "done"
    assert tried[1].n_x > tried[0].n_x
    with pytest.raises(Failure, match=r"contact at 2 N: potential contact area"):
        bodies.on_fitting_grid(rolls(grid="scene"), RunOptions(), short_at_first)


def test_only_a_rolling_wheel_is_seen_as_rolling():
    of = rolls(10.3)
    grid = Grid(6, 4, 0.2, 0.2)
    placed = placed_on(of, grid)
    random = np.random.default_rng(0)
    ics = {name: BodyICs(random.standard_normal((6, 4, 4, 3, 3)), None, None) for name in ("lower", "upper")}
    pressed_on = scene(10.3, motion="compression", loads=[1.0])
    rolled, pressed = (total_ics(one, placed, ics) for one in (of, pressed_on))
    np.testing.assert_array_equal(rolled[..., 1:, :], pressed[..., 1:, :])
    assert np.max(np.abs(rolled[1:, ..., 0, :] - pressed[1:, ..., 0, :])) > 0
    np.testing.assert_array_equal(pressed, ics["lower"].ics + ics["upper"].ics)


@pytest.mark.slow  # two models by finite elements
def test_c_of_planes_moves_as_half_spaces_do():
    """All nine components; coarse cells."""
    of = load_scene(
        "flat", {"engine": {"tolerance": 0.3}, "contact": {"motion": "compression", "loads": [1.0]}}
    )
    placed = placed_on(of, Grid(6, 4, 0.4, 0.6))
    c = full_reference_ics(of, placed, RunOptions())
    p = np.random.default_rng(0).random((6, 4, 3))
    p -= p.mean(axis=(0, 1))  # no resultant: the rigid-body discount does not matter
    expected = approximation(placed, "A")(p)
    found = c.operator(p)
    found -= (found - expected).mean(axis=(0, 1))
    np.testing.assert_allclose(found, expected, atol=0.1 * np.max(np.abs(expected)))
    assert 0 < c.estimate < 0.2


def test_ics_that_are_made_reciprocal_are_so_and_stay_as_they_are_where_they_were():
    ics = np.random.default_rng(0).standard_normal((5, 4, 4, 3, 3))
    made = _reciprocal(ics)
    assert np.max(reciprocity_defects(made)) < 1e-15
    np.testing.assert_array_equal(_reciprocal(made), made)
    np.testing.assert_allclose(np.einsum("xssii->xsi", made), np.einsum("xssii->xsi", ics))


def test_the_approach_that_is_taken_from_a_pair_is_vertical_and_does_not_turn():
    """Along z at any lag, per vertical traction, the sum of the bodies'; of rolling, too."""
    of, grid = rolls(10.3), Grid(6, 4, 0.2, 0.9, 1.1)
    placed, random = placed_on(of, grid), np.random.default_rng(0)
    ics = {name: random.standard_normal((6, 4, 4, 3, 3)) for name in ("lower", "upper")}
    approaches = {"lower": 3.0, "upper": -2.5}
    taken = total_ics(of, placed, {name: BodyICs(of_body, None, None) for name, of_body in ics.items()})
    taken -= total_ics(
        of, placed, {name: BodyICs(of_body, None, None, approaches[name]) for name, of_body in ics.items()}
    )
    delta = grid.strips / 10.0
    along_z = np.stack([0 * delta, -np.sin(delta), np.cos(delta)], axis=-1)
    expected = 0.5 * np.einsum("ai,bj->abij", along_z, along_z)
    np.testing.assert_allclose(taken, np.broadcast_to(expected, taken.shape), atol=1e-12)
