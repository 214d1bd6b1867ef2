"""Fatigue indices against the formulas of their sources, in load and semi-axes."""

import numpy as np
import pytest

from femic.damage.fatigue import RailDamage, Subsurface, subsurface_index, surface_index
from geometries.errors import WrongInput
from tests.femic.damage.cases import HERTZ


@pytest.mark.parametrize("mu", [0.0, 0.15, 0.4])
def test_indices_are_those_of_ekberg_kabo_and_andersson(mu):
    load, a, b, k = HERTZ.load, HERTZ.a, HERTZ.b, 280.0
    assert surface_index(HERTZ.p_max, mu, k) == pytest.approx(mu - 2 * np.pi * a * b * k / (3 * load))
    material = Subsurface(hydrostatic=0.35, residual=-90.0)
    assert subsurface_index(HERTZ.p_max, mu, material) == pytest.approx(
        load / (4 * np.pi * a * b) * (1 + mu**2) - 0.35 * 90
    )


def test_indices_of_many_contacts():
    p, mu = np.array([[800.0], [1500.0]]), np.array([0.0, 0.2, 0.5])
    assert surface_index(p, mu, 300.0).shape == (2, 3)
    for index in (surface_index(p, mu, 300.0), subsurface_index(p, mu, Subsurface())):
        assert np.all(np.diff(index, axis=0) > 0)
        assert np.all(np.diff(index, axis=1) > 0)


def test_rail_damage_goes_through_its_breakpoints():
    law = RailDamage()
    t = np.array([0.0, 15.0, 40.0, 65.0, 120.0, 175.0, 285.0])
    np.testing.assert_allclose(law.per_passage(t), 1e-5 * np.array([0, 0, 0.5, 1, 0.5, 0, -1]), atol=1e-20)
    around = law.per_passage(np.array([65 - 1e-9, 65 + 1e-9]))
    assert around[0] == pytest.approx(around[1], rel=1e-8)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: surface_index(900.0, 0.2, 0.0), "yield_shear = 0.0: must be positive and finite"),
        (lambda: surface_index(-900.0, 0.2, 300.0), "p_max = -900.0: must be positive and finite"),
        (lambda: subsurface_index(900.0, -0.2, Subsurface()), "utilised = -0.2: friction must be zero or"),
        (lambda: Subsurface(hydrostatic=-1.0), "hydrostatic = -1.0: must be zero or positive"),
        (lambda: Subsurface(residual=np.nan), "residual = nan: must be finite"),
        (lambda: RailDamage(peak=200.0), "onset, peak, balance = 15, 200, 175 N: must grow"),
        (lambda: RailDamage(largest=0.0), "largest = 0.0: must be positive"),
        (lambda: RailDamage().per_passage(-5.0), "t_gamma = -5.0: must be zero or positive"),
    ],
)
def test_wrong_numbers_are_refused(call, message):
    with pytest.raises(WrongInput, match=message):
        call()
