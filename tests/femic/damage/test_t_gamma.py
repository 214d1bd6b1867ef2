"""T-gamma: creepages of planes, all shares together, mirrors."""

import pytest

from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.damage.fatigue import t_gamma
from geometries.errors import WrongInput
from tests.femic.contact.friction_problems import POINT, groove, paraboloids, wheel_on

LOAD = Loading(POINT.load)
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
