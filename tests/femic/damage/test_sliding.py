"""Work of friction: closed forms of Hertz and Carter, forces times creepages, zero without creepage."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.error_floors import floors
from femic.contact.estimates import from_grids
from femic.contact.exact.carter import TractiveRolling
from femic.contact.exact.hertz import LineContact
from femic.contact.friction.kinematics import Creepages
from femic.contact.friction.motion import Shift
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.contact.rolling import RollingContact
from femic.damage.sliding import Sliding, grid_error, sliding_of, utilised_friction, work_error
from geometries.errors import WrongInput
from geometries.grids import Grid
from tests.femic.contact.friction_problems import POINT, groove, paraboloids, wheel_on
from tests.femic.damage.cases import CREEPAGE, FRICTION, HERTZ, full_sliding, x_of

LOAD = Loading(POINT.load)


def work_of(contact):
    return sliding_of(contact, 1.0).total_work


# ---- closed forms


def test_energy_of_full_sliding_is_that_of_hertz_pressures():
    """Strips have friction creepage times int p dx = pi/2 a p_max (1 - s^2/b^2); sums of square roots."""
    errors = []
    for n_x in (30, 60, 120):
        sliding = full_sliding(n_x, 26)
        exact = np.pi / 2 * HERTZ.a * HERTZ.p_max * (1 - (sliding.grid.strips / HERTZ.b) ** 2)
        errors.append(np.max(np.abs(sliding.energy / (FRICTION * CREEPAGE * exact) - 1)[3:-3]))
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
    exact = TractiveRolling.at_force(surfaces, 900.0, 0.3, share * 0.3 * 900.0)
    errors = []
    for n_x in (100, 1600):
        grid = Grid(n_x, 3, 2 * exact.half_width / n_x, 0.4)
        along = np.stack([exact.traction(x_of(grid)), exact.slip(x_of(grid))])
        traction, slip = (np.multiply.outer(one, np.ones((3, 1)) * [1.0, 0.0]) for one in along)
        p = np.multiply.outer(surfaces.pressure(900.0, x_of(grid)), np.ones(3))
        sliding = Sliding(grid, p, traction, slip, 5.0)
        errors.append(sliding.total_work / (exact.force * exact.creepage * 3 * grid.ds) - 1)
    assert abs(errors[1]) < 1e-3
    assert abs(errors[1]) < abs(errors[0]) / 3


def test_speed_changes_power_alone():
    slow, fast = full_sliding(speed=5.0), full_sliding(speed=20.0)
    np.testing.assert_allclose(fast.power_density, 4 * slow.power_density)
    np.testing.assert_array_equal(fast.work, slow.work)


# ---- solved contacts


@pytest.mark.parametrize("creepages", [Creepages(-1e-3, 5e-4, 1e-4), Creepages(4e-3, 2e-3, -3e-4)], ids=str)
def test_work_on_slip_is_that_of_forces_and_creepages_on_half_spaces(creepages):
    wheel = wheel_on(paraboloids(40, 36, offset=(0.2, 0.3)))
    contact = wheel.contact(creepages, LOAD).contact
    x, s = wheel.rolling.x[:, None], wheel.rolling.s
    p_x, p_s = (contact.p[..., k] * wheel.problem.grid.area for k in (0, 1))
    xi, upsilon, phi = creepages.longitudinal, creepages.lateral, creepages.spin
    exact = xi * p_x.sum() - upsilon * p_s.sum() - phi * np.sum(x * p_s - s * p_x)
    error = grid_error(contact, work_of)
    assert abs(work_of(contact) - exact) < error < 0.3 * exact


def test_work_on_slip_is_that_of_the_rigid_motion_in_a_groove():
    wheel = wheel_on(groove(32, 36))
    rolling = wheel.contact(Creepages(-1e-3, 5e-4, 1e-4), LOAD)
    exact = wheel.power(rolling) - wheel.climbing(rolling)
    error = grid_error(rolling.contact, work_of)
    assert abs(work_of(rolling.contact) - exact) < error < 0.1 * exact


def test_where_little_slides_what_grids_miss_of_the_work_counts():
    """At 1 % of the work of full sliding; the force is that of Kalker's linear theory, nearly."""
    wheel = wheel_on(paraboloids(32, 36))
    rolling = wheel.contact(Creepages(2e-4), LOAD)
    finer = wheel_on(paraboloids(64, 72)).contact(Creepages(2e-4), LOAD)
    exact = 2e-4 * finer.contact.force[0]
    missed = exact - work_of(rolling.contact)
    assert grid_error(rolling.contact, work_of) < 0.6 * missed  # does not know it
    assert 0.95 * missed < work_error(wheel, rolling, work_of) < 1.3 * missed
    double = work_error(wheel, rolling, lambda contact: 2 * work_of(contact))
    assert double == pytest.approx(2 * work_error(wheel, rolling, work_of))


@pytest.mark.parametrize(
    "number", [work_of, lambda contact: 3 * work_of(contact)], ids=["work", "three times"]
)
def test_errors_of_grids_count_where_much_slides(number):
    wheel = wheel_on(paraboloids(32, 36))
    rolling = wheel.contact(Creepages(4e-3), LOAD)
    assert work_error(wheel, rolling, number) == grid_error(rolling.contact, number) > 0


def test_uncertain_elements_count_by_the_work_of_full_sliding():
    """Beside changes from grid to grid, and not by the own work, a quarter of it here."""
    contact = wheel_on(paraboloids(32, 36)).contact(Creepages(1e-3), LOAD).contact
    by_changes = from_grids(*(work_of(level) for level in (contact, contact.coarser)))
    uncertain = floors(contact.slip_state)["work"] * contact.largest_work
    assert grid_error(contact, work_of) - by_changes == pytest.approx(uncertain, rel=1e-3)
    assert uncertain > 0.05 * by_changes


def test_no_creepage_on_a_plane_no_work():
    contact = wheel_on(paraboloids()).contact(Creepages(), LOAD).contact
    sliding = sliding_of(contact, 30.0)
    assert contact.p.max() > 100
    assert sliding.total_work == 0
    assert np.all(sliding.power_density == 0)
    rolling = RollingContact(contact, Creepages())
    assert work_error(wheel_on(paraboloids()), rolling, work_of) == 0


def test_work_grows_with_creepage():
    wheel = wheel_on(paraboloids())
    works = [work_of(wheel.contact(Creepages(xi), LOAD).contact) for xi in (2e-4, 1e-3, 3e-3, 1e-2)]
    assert np.all(np.diff(works) > 0)


def test_a_fast_creepage_slides_as_a_whole():
    wheel = wheel_on(paraboloids(28, 26))
    contact = wheel.contact(Creepages(0.1), LOAD).contact
    assert work_of(contact) == pytest.approx(0.3 * POINT.load * 0.1, rel=5e-3)
    assert utilised_friction(contact) == pytest.approx(0.3, rel=1e-3)


def test_negative_work_of_leading_edges_is_no_work():
    sliding = full_sliding()
    turned = replace(sliding, slip=sliding.slip * np.where(np.arange(40) > 35, -1.0, 1.0)[:, None, None])
    assert turned.signed_work.min() < 0
    assert turned.work.min() == 0
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
        sliding_of(contact, 1.0)


def test_no_utilised_friction_without_contact():
    contact = wheel_on(paraboloids(10, 9)).contact(Creepages(1e-3), Loading(approach=-0.1)).contact
    with pytest.raises(WrongInput, match="contact without pressure"):
        utilised_friction(contact)
