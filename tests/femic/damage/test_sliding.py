"""Work of friction: closed forms of Hertz and Carter, forces times creepages, zero without creepage."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.exact.friction import TractiveRolling
from femic.contact.exact.hertz import LineContact
from femic.contact.friction.motion import Creepages, Shift
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.damage.fatigue import utilised_friction
from femic.damage.laws import Sliding
from femic.damage.wear import find_sliding
from geometries.errors import WrongInput
from geometries.patches import Grid
from tests.femic.contact.friction_problems import POINT, paraboloids, wheel_on
from tests.femic.damage.cases import CREEPAGE, FRICTION, HERTZ, along_x, full_sliding

LOAD = Loading(POINT.load)


def work(contact):
    return find_sliding(contact, 1.0).total_work


# ---- closed forms


def test_energy_of_full_sliding_is_that_of_hertz_pressures():
    """Strips have friction creepage times int p dx = pi/2 a p_max (1 - s^2/b^2); sums of square roots."""
    errors = []
    for n_x in (30, 60, 120):
        sliding = full_sliding(n_x, 26)
        energy = np.sum(sliding.work, axis=0) * sliding.grid.dx
        exact = np.pi / 2 * HERTZ.a * HERTZ.p_max * (1 - (sliding.grid.strips / HERTZ.b) ** 2)
        errors.append(np.max(np.abs(energy / (FRICTION * CREEPAGE * exact) - 1)[3:-3]))
    assert errors[-1] < 2e-3
    assert errors[0] > 4 * errors[2]


def test_all_work_of_full_sliding_is_friction_times_load_times_creepage():
    sliding = full_sliding(120, 90)
    assert sliding.total_work == pytest.approx(FRICTION * HERTZ.load * CREEPAGE, rel=2e-3)
    assert np.max(sliding.power_density) == pytest.approx(10.0 * FRICTION * HERTZ.p_max * CREEPAGE, rel=2e-3)
    np.testing.assert_allclose(sliding.velocity, 10.0 * CREEPAGE)


@pytest.mark.parametrize("share", [0.2, 0.7, 0.97])
def test_carters_tractions_lose_force_times_creepage(share):
    """Elastic strains do no work over the whole contact: slip below the creepage is made up elsewhere."""
    surfaces = LineContact(1 / 300, 115e3)
    whole = TractiveRolling(surfaces, 900.0, 0.3, 0.0).largest_creepage
    exact = TractiveRolling(surfaces, 900.0, 0.3, whole * (1 - np.sqrt(1 - share)))
    errors = []
    for n_x in (100, 1600):
        grid = Grid(n_x, 3, 2 * exact.half_width / n_x, 0.4)
        along = np.stack([exact.traction(along_x(grid)), exact.slip(along_x(grid))])
        traction, slip = (np.multiply.outer(one, np.ones((3, 1)) * [1.0, 0.0]) for one in along)
        p = np.multiply.outer(surfaces.pressure(900.0, along_x(grid)), np.ones(3))
        sliding = Sliding(grid, p, traction, slip, 5.0)
        errors.append(sliding.total_work / (exact.force * exact.creepage * 3 * grid.ds) - 1)
    assert abs(errors[1]) < 1e-3
    assert abs(errors[1]) < abs(errors[0]) / 3


def test_speed_changes_power_alone():
    slow, fast = full_sliding(speed=5.0), full_sliding(speed=20.0)
    np.testing.assert_allclose(fast.power_density, 4 * slow.power_density)
    np.testing.assert_array_equal(fast.work, slow.work)


# ---- solved contacts


def test_no_creepage_on_a_plane_no_work():
    contact = wheel_on(paraboloids()).contact(Creepages(), LOAD).contact
    sliding = find_sliding(contact, 30.0)
    assert contact.p.max() > 100
    assert sliding.total_work == 0
    assert np.all(sliding.power_density == 0)


def test_work_grows_with_creepage():
    wheel = wheel_on(paraboloids())
    works = [work(wheel.contact(Creepages(xi), LOAD).contact) for xi in (2e-4, 1e-3, 3e-3, 1e-2)]
    assert np.all(np.diff(works) > 0)


def test_a_fast_creepage_slides_as_a_whole():
    wheel = wheel_on(paraboloids(28, 26))
    contact = wheel.contact(Creepages(0.1), LOAD).contact
    assert work(contact) == pytest.approx(0.3 * POINT.load * 0.1, rel=5e-3)
    assert utilised_friction(contact) == pytest.approx(0.3, rel=1e-3)


def test_negative_work_of_leading_edges_is_no_work():
    sliding = full_sliding()
    turned = replace(sliding, slip=sliding.slip * np.where(np.arange(40) > 35, -1.0, 1.0)[:, None, None])
    assert np.all(turned.work[36:] == 0)
    assert turned.total_work < sliding.total_work


# ---- bad input


@pytest.mark.parametrize("speed", [0.0, -3.0, np.nan, np.inf])
def test_speeds_that_are_not_positive_are_refused(speed):
    with pytest.raises(WrongInput, match=r"speed = .*: must be positive and finite"):
        full_sliding(speed=speed)


def test_other_shapes_are_refused():
    with pytest.raises(WrongInput, match=r"slip: shape \(39, 30, 2\), but the grid needs \(40, 30, 2\)"):
        replace(full_sliding(), slip=full_sliding().slip[1:])


def test_contacts_that_do_not_roll_are_refused():
    problem = paraboloids(14, 13)
    contact = solve(problem, Shift(np.zeros((14, 13, 2))), LOAD)
    with pytest.raises(WrongInput, match="contact by a shift: wear and T-gamma need rolling"):
        find_sliding(contact, 1.0)


def test_no_utilised_friction_without_contact():
    contact = wheel_on(paraboloids(10, 9)).contact(Creepages(1e-3), Loading(approach=-0.1)).contact
    with pytest.raises(WrongInput, match="contact without pressure"):
        utilised_friction(contact)
