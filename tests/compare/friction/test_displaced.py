"""Rolling with the distance of the displaced wheel: without friction, and where distances are linear."""

from dataclasses import replace

import numpy as np
import pytest

from compare.contact.pair_on_grid import Case, placed_on
from compare.friction.bodies import Solver
from compare.friction.curve import Curve, Path
from compare.friction.displaced import displaced, displaced_numbers
from compare.friction.operators import approximation
from compare.friction.rolling import compute_rolling
from femic.contact.estimates import Measured
from femic.contact.frictional import Pressing
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.grids import Grid
from tests.compare.friction.scenes import scene

LOAD = 1e4
SCENE = scene(
    10.3, motion="rolling", loads=[LOAD], longitudinal=[-1e-3, 0.0, 1e-3], friction=[0.3], ics=["Bhat"]
)
GRID = Grid(24, 36, 0.7, 0.5)


def path_of(friction, of=SCENE, grid=GRID):
    solver = Solver(of, placed_on(of, grid), RunOptions())
    return Path.of(solver, solver.problem(approximation(solver.placed, "Bhat"), friction), "a path")


def test_without_friction_it_is_the_contact_with_the_exact_distance():
    """Pressures and approach, by the fixed point of contacts that know nothing of tangential tractions."""
    path = path_of(0.0)
    linear = path.solved(0.0, None)
    found, placed = displaced(path, linear).contact, path.solver.placed
    exact = placed.contact(placed.operator("Bhat"), Case(LOAD, None), exact=True)
    assert found.approach == pytest.approx(exact.approach, rel=1e-5)
    np.testing.assert_allclose(found.p[..., 2], exact.p, atol=1e-4 * exact.p.max())
    assert abs(np.max(found.p) / np.max(linear.contact.p) - 1) > 1e-3


def test_the_distance_is_that_at_its_own_approach():
    path = path_of(0.3)
    placed, found = path.solver.placed, displaced(path, path.solved(0.0, None))
    approach = found.contact.approach
    distance = placed.distance_at(approach) + approach * placed.cosine
    problem = replace(path.problem, problem=replace(path.problem.problem, distance=distance))
    again = problem.contact(found.creepages, Pressing(load=LOAD))
    assert again.contact.approach == pytest.approx(approach, rel=1e-4)
    assert again.contact.force == pytest.approx(found.contact.force, abs=1e-4 * 0.3 * LOAD)


def test_on_a_plane_nothing_changes():
    """The distance of a plane and a paraboloid is linear in the approach, to the square of slopes."""
    of = load_scene(
        "flat",
        {
            "upper": {"contour": {"kind": "arc", "radius": 400.0, "flank_inclination_deg": 3.0}},
            "contact": {"motion": "compression", "loads": [1.0]},
        },
    )
    placed = placed_on(of, Grid(8, 6, 0.4, 0.6))
    moved = placed.distance_at(0.01) + 0.01 * placed.cosine
    np.testing.assert_allclose(moved, placed.distance, atol=1e-12)


def test_the_file_has_what_it_changes():
    dataset = compute_rolling(SCENE).isel(friction=0, ics=0)
    path = path_of(0.3, grid=Grid(dataset.sizes["x"], dataset.sizes["s"], *steps(dataset)))
    found = displaced(path, path.solved(0.0, None)).contact
    assert float(dataset.displaced_xi) == 0.0
    assert float(dataset.displaced_F_x) == pytest.approx(found.force[0], abs=1e-4 * 0.3 * LOAD)
    changed = float(dataset.displaced_F_x - dataset.F_x.sel(xi=0.0))
    moved = float(dataset.displaced_zero_creepage - dataset.zero_creepage)
    assert moved == pytest.approx(-changed / float(dataset.slope), rel=1e-3)
    assert moved != 0.0


@pytest.mark.parametrize("followers", [2, 1])
def test_contacts_of_different_forms_are_not_compared(followers, monkeypatch):
    """What fewer elements at the leading edge change is not what the distance changes."""
    path = path_of(0.3)
    first = path.solved(0.0, None)
    curve = Curve({}, {}, Measured({"zero_creepage": -1e-3, "slope": 1e7}, {}, {}), first)
    simpler = replace(first.contact, motion=replace(first.contact.motion, followers=followers))
    monkeypatch.setattr("compare.friction.displaced.displaced", lambda *_: replace(first, contact=simpler))
    known = displaced_numbers(path, curve)
    assert np.isnan(known["zero_creepage"]) == np.isnan(known["p_max"]) == (followers != 2)


def steps(dataset):
    return [float(np.diff(dataset[name])[0]) for name in ("x", "s")]
