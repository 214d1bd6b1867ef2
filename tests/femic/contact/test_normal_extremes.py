"""Contacts at the ends of what users ask for: one element, narrow elements, tight grooves, flat punches."""

import numpy as np
import pytest

from femic.contact.exact.hertz import PointContact
from femic.contact.normal import NormalProblem, PotentialAreaTooSmall, solve
from geometries.patches import Grid
from tests.femic.contact.problems import (
    CIRCLE,
    ELLIPSE,
    MODULUS,
    conformal,
    half_spaces,
    hertzian,
    numbers,
    of_hertz,
    with_distance,
    x_of,
)


@pytest.mark.parametrize("aspect", [0.05, 0.25, 4.0, 20.0])
def test_elements_may_be_as_narrow_as_one_in_twenty(aspect):
    """A circle, 8 elements across on its coarser side: within what such elements allow."""
    coarse, fine = 16, round(16 * max(aspect, 1 / aspect))
    n_x, n_s = (fine, coarse) if aspect < 1 else (coarse, fine)
    problem = hertzian(CIRCLE, n_x, n_s, room=(2.0, 2.0))
    assert problem.grid.dx / problem.grid.ds == pytest.approx(aspect)
    contact = solve(problem, load=CIRCLE.load)
    errors = np.abs(numbers(contact) / of_hertz(CIRCLE) - 1)
    assert np.all(errors < [0.003, 0.003, 0.02, 0.07, 0.05, 0.05])


@pytest.mark.parametrize("ratio", [1e-3, 400.0])
def test_patches_may_be_very_slender(ratio):
    """Semi-axes 1 to 70 and 40 to 1, with elements to match. The tips are sharper than elements are long:

    gaps beyond them grow otherwise, and the longer axis comes out short by up to half an element.
    """
    hertz = PointContact(0.05, 0.05 * ratio, MODULUS).at_load(2000.0)
    assert max(hertz.a / hertz.b, hertz.b / hertz.a) > 40
    contact = solve(hertzian(hertz, 36, 26), load=2000.0)
    assert np.all(
        np.abs(numbers(contact) / of_hertz(hertz) - 1)
        < [0.003, 0.003, 0.01, 0.05, 0.5 * 1.9 / 18, 0.5 * 2.1 / 13]
    )


def test_a_contact_may_be_one_element():
    """Its pressure is load / area; approach = gap + own IC times pressure."""
    problem = hertzian(ELLIPSE, 37, 27)
    load, area = 1e-3, problem.grid.area
    contact = solve(problem, load=load)
    assert np.argwhere(contact.in_contact).tolist() == [[18, 13]]
    assert contact.p.max() == pytest.approx(load / area)
    unit = np.zeros((37, 27, 1))
    unit[18, 13] = 1
    own = problem.operator(unit)[18, 13, 0]
    assert contact.approach == pytest.approx(own * load / area, rel=1e-9)
    assert contact.stiffness == pytest.approx(area / own, rel=1e-9)
    assert contact.patches[0].x == pytest.approx((17.5, 18.5), abs=0.51)


def test_ten_decades_of_load_follow_hertz_while_the_contact_is_small_against_the_radii():
    """A groove of revolution on an arc, on grids of the size of the contact; conformity begins at the end."""
    surfaces = PointContact(1 / 500, 1 / 10 - 1 / 13, MODULUS)
    loads = 10.0 ** np.arange(-5, 6)
    approaches, relative = [], []
    for load in loads:
        hertz = surfaces.at_load(load)
        grid = Grid(36, 26, 1.9 * 2 * hertz.a / 36, 2.1 * 2 * hertz.b / 26)
        contact = solve(conformal(grid, ratio=0.3), load=load)
        approaches.append(contact.approach)
        relative.append(numbers(contact) / of_hertz(hertz) - 1)
    assert np.all(np.diff(approaches) > 0)
    assert np.max(np.abs(relative[:8])) < 0.04
    assert np.max(np.abs(np.diff(relative[:7], axis=0))) < 1e-4  # the same contact but for its size
    assert np.max(np.abs(relative[-1] - relative[0])) > 0.01


def test_tight_grooves_approach_the_limit_without_clearance():
    """Of 10 mm, by 1 um and less wider, on rails that end at -8 and 7 mm: so does the contact."""
    grid, pressures = Grid(16, 48, 1.5, 0.45, -1.0), []
    for ratio in (1e-4, 1e-5, 1e-6, 0.0):
        problem = conformal(grid, ratio=ratio)
        ends = with_distance(problem, np.where(np.abs(grid.strips + 0.5) < 7.5, problem.distance, np.inf))
        contact = solve(ends, approach=0.008, tolerance=1e-10)
        assert np.ptp(contact.patches[0].s) * grid.ds == pytest.approx(15.0, abs=grid.ds)
        pressures.append(contact.p)
    differences = [np.max(np.abs(p - pressures[-1])) / np.max(p) for p in pressures[:-1]]
    assert differences[0] < 0.1
    assert np.divide(differences[:-1], differences[1:]) == pytest.approx([10, 10], rel=0.1)


def test_flat_punch_agrees_with_boussinesq():
    """No gap on a circle, no contact beside it: approach = load / (2 E* radius), pressures without end."""
    errors = []
    for n in (24, 48, 96):
        grid = Grid(n, 2 * n, 3.0 / n, 1.5 / n)
        radius = np.hypot(x_of(grid)[:, None], grid.strips)
        operator = half_spaces(grid)
        problem = NormalProblem(
            grid, operator, operator, np.where(radius < 1.0, 0.0, np.inf), np.ones(grid.n_s)
        )
        contact = solve(problem, load=500.0)
        assert np.all(contact.in_contact == (radius < 1.0))
        errors.append(contact.approach / (500.0 / (2 * MODULUS)) - 1)
        assert contact.stiffness == pytest.approx(500.0 / contact.approach, rel=1e-6)
    assert abs(errors[-1]) < 0.01
    assert abs(errors[-1]) < abs(errors[0])


def test_a_flat_gap_fills_the_grid_and_is_refused():
    problem = with_distance(hertzian(ELLIPSE, 36, 26), np.zeros((36, 26)))
    with pytest.raises(PotentialAreaTooSmall) as error:
        solve(problem, load=10.0)
    assert len(error.value.ends) == 4


def test_rough_surfaces_touch_in_many_patches():
    smooth = hertzian(ELLIPSE, 48, 40, room=(2.4, 2.4))
    rough = with_distance(
        smooth, smooth.distance + 0.3 * ELLIPSE.approach * np.random.default_rng(3).random((48, 40))
    )
    contact = solve(rough, load=300.0)
    assert len(contact.patches) > 3
    assert contact.load == pytest.approx(300.0)
    assert contact.area < 0.8 * solve(smooth, load=300.0).area
    assert contact.p.max() > ELLIPSE.surfaces.at_load(300.0).p_max


def test_loads_in_sequence_may_start_from_each_other():
    """Up and down again: the same contacts, whatever came before."""
    problem = conformal(Grid(24, 36, 1.2, 0.5, -1.0))
    alone = {load: solve(problem, load=load, tolerance=1e-9) for load in (20.0, 400.0, 3000.0)}
    start = None
    for load in (20.0, 400.0, 3000.0, 400.0, 20.0):
        contact = solve(problem, load=load, start=start, tolerance=1e-9)
        np.testing.assert_allclose(contact.p, alone[load].p, atol=1e-6 * contact.p.max())
        start = contact.p
