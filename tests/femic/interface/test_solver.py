"""Contacts on call: those of `solve_contact`, after any others, in threads; worn gaps, forces, mistakes."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest

import femic
from femic.contact.exact.hertz import PointContact, combined_modulus

STEEL = femic.Material(E=210e3, nu=0.3)
PAIR = femic.Pair(
    femic.Body(femic.arc(10.6, 60.0), STEEL, rolling_radius=500.0), femic.Body(femic.arc(10.0, 60.0), STEEL)
)
LOAD, FRICTION = 10e3, 0.3
SETUP = femic.ContactSetup(elements=10)
SOLVER = femic.ContactSolver(PAIR, LOAD, setup=SETUP)
XI = -1e-3, 0.0, 2e-3


def solved(**arguments):
    return SOLVER.solve(LOAD, friction=FRICTION, **arguments)


def test_contacts_are_those_of_solve_contact():
    setup = femic.ContactSetup(grid=SOLVER.grid)
    rolling = femic.Rolling(LOAD, FRICTION, longitudinal=XI, lateral=5e-4, spin=1e-4)
    there = femic.solve_contact(PAIR, rolling, ["Bhat"], setup).squeeze()
    pressed = femic.solve_contact(PAIR, femic.Frictionless([LOAD]), ["Bhat"], setup).squeeze()
    for k, xi in enumerate(XI):
        here = solved(longitudinal=xi, lateral=5e-4, spin=1e-4)
        for name in ("F_x", "F_y", "M_x", "M_z", "p_max", "area", "sliding_share"):
            expected = there[name][k].item()
            assert here.numbers[name] == pytest.approx(expected, rel=1e-5, abs=1e-3), name
        assert here.numbers["work"] == pytest.approx(there.dissipation[k].item(), rel=1e-5)
        assert here.force[2] == pytest.approx(LOAD, rel=1e-9)
    here = SOLVER.solve(LOAD)
    assert here.pressures.max() == pytest.approx(pressed.p_max.item(), rel=1e-5)
    assert here.approach == pytest.approx(pressed.approach.item(), rel=1e-6)
    assert not here.slip.any()
    assert not here.stick.any()


def test_the_contact_does_not_depend_on_what_was_solved_before():
    first = solved(longitudinal=-1e-3)
    for other in (
        {"longitudinal": 0.02},
        {"lateral": 0.01, "spin": 1e-3},
        {"forces": {"longitudinal": 900.0}},
    ):
        solved(**other)
        again = solved(longitudinal=-1e-3)
        np.testing.assert_allclose(again.tractions, first.tractions, atol=2e-6 * first.pressures.max())


def test_forces_give_creepages_and_these_the_forces():
    given = {"longitudinal": 800.0, "lateral": -300.0}
    rolled = solved(forces=given, spin=2e-4)
    assert rolled.force[:2] == pytest.approx([800.0, -300.0], rel=1e-5)
    back = solved(longitudinal=rolled.creepages.longitudinal, lateral=rolled.creepages.lateral, spin=2e-4)
    np.testing.assert_allclose(back.force[:2], [800.0, -300.0], rtol=1e-4)


def test_an_approach_gives_the_load_back():
    rolled = solved(longitudinal=1e-3)
    other = SOLVER.solve(approach=rolled.approach, friction=FRICTION, longitudinal=1e-3)
    assert other.force[2] == pytest.approx(LOAD, rel=1e-5)


def test_many_are_those_one_by_one_in_the_shape_of_the_arrays():
    xi, lateral = np.array(XI), np.array([[0.0], [1e-3]])
    many = SOLVER.solve_many(load=LOAD, friction=FRICTION, longitudinal=xi, lateral=lateral)
    assert many.F_x.dims == ("case_0", "case_1")
    assert many.F_x.shape == (2, 3)
    for index in np.ndindex(2, 3):
        one = solved(longitudinal=xi[index[1]], lateral=lateral[index[0], 0])
        assert many.F_y[index].item() == pytest.approx(one.force[1], rel=1e-4, abs=1e-2)
        assert many.longitudinal[index].item() == xi[index[1]]
    assert SOLVER.solve_many(load=[LOAD / 2, LOAD]).p_max.dims == ("case",)
    assert SOLVER.solve_many(load=[LOAD / 2, LOAD]).work.values.tolist() == [0.0, 0.0]


def test_gaps_that_are_added_carry_less():
    """One all over is an approach; one on a strip takes its pressure away."""
    here, n = SOLVER.solve(LOAD), SOLVER.grid.n_s
    cosine = np.cos(SOLVER._rolling.problem.inclination)
    lower = SOLVER.solve(LOAD, extra_gap=0.01 * cosine)
    np.testing.assert_allclose(lower.pressures, here.pressures, atol=1e-5 * here.pressures.max())
    assert lower.approach - here.approach == pytest.approx(0.01, rel=1e-5)
    groove = np.zeros((SOLVER.grid.n_x, n))
    groove[:, n // 2] = 0.05
    for rolled in (SOLVER.solve(LOAD, extra_gap=groove), solved(extra_gap=groove[0])):
        assert rolled.pressures[:, n // 2].max() == 0
        assert rolled.pressures[:, n // 2 - 1].max() > here.pressures[:, n // 2 - 1].max()
    np.testing.assert_allclose(SOLVER.solve(LOAD).pressures, here.pressures, atol=2e-6 * here.pressures.max())


def test_a_cylinder_across_a_rail_has_the_pressure_of_hertz():
    cylinder = femic.Body(femic.plane(), STEEL, rolling_radius=20.0)
    solver = femic.ContactSolver(
        replace(PAIR, upper=cylinder), 100.0, "A", femic.ContactSetup(elements=30, flanks=False)
    )
    hertz = PointContact(1 / 20, 1 / 10, combined_modulus(STEEL, STEEL))
    for load in (25.0, 100.0):
        assert solver.solve(load).pressures.max() == pytest.approx(hertz.at_load(load).p_max, rel=0.01)
        slides = solver.solve(load, friction=0.2, longitudinal=0.1)  # all of it, driven
        assert slides.force[0] == pytest.approx(0.2 * load, rel=1e-3)
        assert slides.numbers["sliding_share"] == 1.0


def test_threads_share_a_solver():
    xi = np.linspace(-2e-3, 2e-3, 24)
    alone = [solved(longitudinal=each).force[0] for each in xi]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(lambda each: solved(longitudinal=each).force[0], xi))
    np.testing.assert_allclose(together, alone, rtol=1e-4, atol=1e-3 * FRICTION * LOAD)


def test_threads_with_frictions_of_their_own_share_a_solver():
    """Sliding everywhere, each has its friction, also where another's problem comes between two lines."""
    frictions = [0.1, 0.3] * 6
    with ThreadPoolExecutor(4) as threads:
        sliding = list(
            threads.map(lambda mu: SOLVER.solve(LOAD, friction=mu, longitudinal=-0.05).numbers, frictions)
        )
    for mu, numbers in zip(frictions, sliding, strict=True):
        assert numbers["sliding_share"] == 1.0
        assert abs(numbers["F_x"]) == pytest.approx(mu * LOAD, rel=0.05)

    solver = femic.ContactSolver(PAIR, LOAD, setup=SETUP)
    own = solver._rolling
    problems = cycle(replace(own, problem=replace(own.problem, friction=mu)) for mu in (0.1, 0.3))

    class BesideAnother(femic.ContactSolver):
        _rolling = property(lambda _: next(problems), lambda *_: None)

    solver.__class__ = BesideAnother
    assert abs(solver.solve(LOAD, friction=0.3, longitudinal=-0.05).force[0]) == pytest.approx(
        abs(sliding[1]["F_x"]), rel=1e-5
    )


def test_dataset_has_units_and_adds_up():
    rolled = solved(longitudinal=-1e-3, spin=1e-4)
    labelled, area = rolled.to_dataset(), SOLVER.grid.area
    assert all("long_name" in labelled[name].attrs for name in labelled.variables if labelled[name].ndim != 1)
    assert labelled.p.attrs["units"] == "MPa"
    assert labelled.attrs["spin"] == 1e-4
    assert (labelled.p.sel(direction="x").sum() * area).item() == pytest.approx(labelled.F_x.item())
    work = -(rolled.tractions[..., :2] * rolled.slip).sum() * area
    assert labelled.work.item() == pytest.approx(work)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "load = None, approach = None: give one of them"),
        ({"load": LOAD, "approach": 0.1}, "give one of them"),
        ({"load": -1.0}, "load = -1.0: must be positive"),
        ({"load": np.nan}, "load"),
        ({"load": LOAD, "friction": -0.1}, "friction = -0.1: must be zero or positive"),
        ({"load": LOAD, "friction": 0.3, "spin": np.inf}, "spin = inf"),
        ({"load": LOAD, "friction": 0.3, "forces": {"radial": 1.0}}, "forces of radial"),
        ({"load": LOAD, "extra_gap": [0.0, 1.0]}, r"extra_gap of shape \(2,\): .* is needed"),
        ({"load": LOAD, "extra_gap": np.full(SOLVER.grid.n_s, np.nan)}, r"extra_gap\[0\] = nan"),
        ({"load": "heavy"}, "load"),
    ],
)
def test_wrong_input_is_refused(arguments, message):
    with pytest.raises(femic.WrongInput, match=message):
        SOLVER.solve(**arguments)


def test_too_large_a_load_and_unknown_names_are_refused():
    with pytest.raises(femic.Failure, match="potential contact area"):
        SOLVER.solve(30 * LOAD)
    with pytest.raises(femic.WrongInput, match="gap: not an argument of solve_many"):
        SOLVER.solve_many(load=LOAD, gap=0.0)
    with pytest.raises(femic.WrongInput, match="give loads or approaches"):
        SOLVER.solve_many(friction=0.3)
    with pytest.raises(femic.WrongInput, match=r"load \(2,\), spin \(3,\): these shapes cannot be broadcast"):
        SOLVER.solve_many(load=[LOAD, LOAD], spin=[0.0, 1e-4, 2e-4])
    with pytest.raises(femic.Failure, match="exceed what friction can supply"):
        SOLVER.solve(LOAD, forces={"longitudinal": 10.0})
    with pytest.raises(femic.WrongInput, match="elsewhere"):
        femic.ContactSolver(PAIR, LOAD, "elsewhere")


def test_a_matrix_brings_its_grid():
    prismatic = replace(PAIR, upper=replace(PAIR.upper, rolling_radius=np.inf))  # as fast operators take it
    matrix = femic.compute_matrix(prismatic, SOLVER.grid, "Bhat")
    solver = femic.ContactSolver(PAIR, LOAD, matrix)
    assert solver.grid == SOLVER.grid
    np.testing.assert_allclose(solver.solve(LOAD).pressures, SOLVER.solve(LOAD).pressures, atol=1e-3)
