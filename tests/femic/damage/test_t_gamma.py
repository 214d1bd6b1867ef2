"""T-gamma: creepages of planes, all shares together, mirrors."""

import numpy as np
import pytest

from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.damage.fatigue import t_gamma
from geometries.errors import WrongInput
from tests.femic.contact.friction_problems import POINT, groove, paraboloids, wheel_on

LOAD = Loading(POINT.load)
CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)


def test_creepages_of_a_plane_are_those_of_its_centre_of_pressure():
    wheel = wheel_on(paraboloids(offset=(0.2, 0.3)))
    rolling = wheel.contact(CREEPAGES, LOAD)
    shares, grid = t_gamma(wheel, rolling), wheel.problem.grid
    x_0, s_0 = 0.2 * grid.dx, 0.3 * grid.ds  # but for elements at edges
    assert shares.spin_rate == pytest.approx(1e-4, rel=1e-9)
    assert shares.creepages[0] == pytest.approx(-1e-3 + 1e-4 * s_0, abs=2e-7)
    assert shares.creepages[1] == pytest.approx(5e-4 + 1e-4 * x_0, abs=2e-7)
    F_x, F_s, _ = rolling.contact.force
    assert shares.longitudinal == pytest.approx(F_x * shares.creepages[0], rel=1e-9)
    assert shares.lateral == pytest.approx(-F_s * shares.creepages[1], rel=1e-9)
    assert shares.conformity == pytest.approx(0, abs=1e-12)
    assert shares.pressures == pytest.approx(0, abs=1e-12)
    assert shares.total == pytest.approx(wheel.power(rolling), rel=1e-12)
    assert shares.with_spin - shares.without_spin == pytest.approx(shares.spin, rel=1e-12)


def test_pure_spin_has_a_share_of_spin_alone():
    wheel = wheel_on(paraboloids(28, 26))
    shares = t_gamma(wheel, wheel.contact(Creepages(spin=5e-3), LOAD))
    assert shares.spin > 0
    assert abs(shares.without_spin) < 1e-6 * shares.spin
    assert shares.total == pytest.approx(shares.spin)


def test_a_mirror_keeps_shares_and_turns_lateral_creepage_and_spin():
    here, there = wheel_on(groove()), wheel_on(groove(mirrored=True), mirrored=True)
    one = t_gamma(here, here.contact(CREEPAGES, LOAD))
    two = t_gamma(there, there.contact(Creepages(-1e-3, -5e-4, -1e-4), LOAD))
    for name in ("longitudinal", "lateral", "spin", "conformity", "pressures"):
        assert getattr(two, name) == pytest.approx(getattr(one, name), rel=1e-3, abs=1e-5 * one.total)
    assert two.spin_rate == pytest.approx(-one.spin_rate, rel=1e-6)
    assert two.creepages == pytest.approx(np.multiply(one.creepages, [1, -1]), rel=1e-5)


def test_no_t_gamma_without_contact():
    wheel = wheel_on(paraboloids(10, 9))
    rolling = wheel.contact(CREEPAGES, Loading(approach=-0.1))
    with pytest.raises(WrongInput, match="contact without pressure"):
        t_gamma(wheel, rolling)
