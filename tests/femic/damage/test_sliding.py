"""Work of friction and T-gamma: Hertz, Carter, forces times creepages, zero without creepage, mirrors."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.exact.friction import TractiveRolling
from femic.contact.exact.hertz import LineContact
from femic.contact.friction.motion import Creepages, Shift
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.damage.fatigue import t_gamma, utilised_friction
from femic.damage.laws import Sliding
from femic.damage.wear import find_sliding
from geometries.errors import WrongInput
from geometries.patches import Grid
from tests.femic.contact.friction_problems import POINT, groove, paraboloids, wheel_on
from tests.femic.damage.cases import CREEPAGE, FRICTION, HERTZ, along_x, full_sliding

LOAD = Loading(POINT.load)


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


def test_all_work_of_full_sliding_is_friction_times_load_times_creepage_at_any_speed():
    sliding, fast = full_sliding(120, 90), full_sliding(120, 90, speed=40.0)
    assert sliding.total_work == pytest.approx(FRICTION * HERTZ.load * CREEPAGE, rel=2e-3)
    assert np.max(sliding.power_density) == pytest.approx(10.0 * FRICTION * HERTZ.p_max * CREEPAGE, rel=2e-3)
    np.testing.assert_allclose(sliding.velocity, 10.0 * CREEPAGE)
    np.testing.assert_allclose(fast.power_density, 4 * sliding.power_density)
    np.testing.assert_array_equal(fast.work, sliding.work)


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


# ---- solved contacts


def test_work_grows_with_creepage_from_none():
    """A fast one slides as a whole."""
    wheel = wheel_on(paraboloids(28, 26))
    contacts = [wheel.contact(Creepages(xi), LOAD).contact for xi in (0.0, 2e-4, 1e-3, 3e-3, 1e-2, 0.1)]
    still = find_sliding(contacts[0], 30.0)
    assert contacts[0].p.max() > 100
    assert still.total_work == 0
    assert np.all(still.power_density == 0)
    works = [find_sliding(contact, 1.0).total_work for contact in contacts]
    assert np.all(np.diff(works) > 0)
    assert works[-1] == pytest.approx(0.3 * POINT.load * 0.1, rel=5e-3)
    assert utilised_friction(contacts[-1]) == pytest.approx(0.3, rel=1e-3)


def test_negative_work_of_leading_edges_is_no_work():
    sliding = full_sliding()
    turned = replace(sliding, slip=sliding.slip * np.where(np.arange(40) > 35, -1.0, 1.0)[:, None, None])
    assert np.all(turned.work[36:] == 0)
    assert turned.total_work < sliding.total_work


# ---- bad input


@pytest.mark.parametrize("speed", [0.0, -3.0, np.nan, np.inf])
def test_speeds_that_are_not_positive_and_other_shapes_are_refused(speed):
    with pytest.raises(WrongInput, match=r"speed = .*: must be positive and finite"):
        full_sliding(speed=speed)
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


# ---- T-gamma


CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)


def test_shares_on_a_plane_are_forces_times_creepages_of_the_centre_of_pressure():
    """Together they are all work: there nothing else turns the slip, and pressures do none."""
    wheel = wheel_on(paraboloids(offset=(0.2, 0.3)))
    rolling = wheel.contact(CREEPAGES, LOAD)
    longitudinal, lateral, spin = t_gamma(wheel, rolling)
    grid = wheel.problem.grid
    x_0, s_0 = 0.2 * grid.dx, 0.3 * grid.ds  # but for elements at edges
    F_x, F_s, _ = rolling.contact.force
    assert longitudinal == pytest.approx(F_x * (-1e-3 + 1e-4 * s_0), abs=2e-7 * abs(F_x))
    assert lateral == pytest.approx(-F_s * (5e-4 + 1e-4 * x_0), abs=2e-7 * abs(F_s))
    assert longitudinal + lateral + spin == pytest.approx(wheel.power(rolling), rel=1e-9)


def test_pure_spin_has_a_share_of_spin_alone():
    wheel = wheel_on(paraboloids(28, 26))
    rolling = wheel.contact(Creepages(spin=5e-3), LOAD)
    longitudinal, lateral, spin = t_gamma(wheel, rolling)
    assert spin == pytest.approx(wheel.power(rolling))
    assert spin > 0
    assert abs(longitudinal + lateral) < 1e-6 * spin


def test_a_mirror_keeps_the_shares():
    here, there = wheel_on(groove()), wheel_on(groove(mirrored=True), mirrored=True)
    rolling = here.contact(CREEPAGES, LOAD)
    one = t_gamma(here, rolling)
    two = t_gamma(there, there.contact(Creepages(-1e-3, -5e-4, -1e-4), LOAD))
    assert two == pytest.approx(one, rel=1e-3, abs=1e-5 * here.power(rolling))


def test_no_t_gamma_without_contact():
    wheel = wheel_on(paraboloids(10, 9))
    rolling = wheel.contact(CREEPAGES, Loading(approach=-0.1))
    with pytest.raises(WrongInput, match="contact without pressure"):
        t_gamma(wheel, rolling)
