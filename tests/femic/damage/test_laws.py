"""Wear laws: closed forms, regimes at their borders, grids; which laws there are for a scene."""

from dataclasses import replace

import numpy as np
import pytest

from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw, depth, regime_shares
from femic.damage.specification import ARCHARD, CONSTANTS, ENERGY, NO_SPEED, TWIN_DISC, DamageSpecification
from geometries.errors import WrongInput
from tests.femic.damage.cases import CREEPAGE, FRICTION, HERTZ, full_sliding

LAWS = EnergyLaw(), TwinDiscLaw(), ArchardMap()
ids = pytest.mark.parametrize("law", LAWS, ids=[type(law).__name__ for law in LAWS])


def at(traction, slip, pressure=1000.0, speed=1.0):
    """One element, or the first of many, with these values."""
    one = full_sliding(3, 2, speed=speed)
    along = np.multiply(np.ones((3, 2, 2)), [1.0, 0.0])
    return replace(one, pressure=np.full((3, 2), pressure), traction=traction * along, slip=-slip * along)


def section_area(sliding, law):
    """Worn off a section by a passage [mm^2]."""
    return np.sum(depth(sliding, law)) * sliding.grid.ds


def rate(law, *of, **other):
    return float(law.rate(at(*of, **other))[0, 0])


# ---- laws of energy


def test_worn_volume_is_energy_times_coefficient():
    """To rounding, for one regime: 0.7 ug/J are 0.7/7850 mm^3/J; as deep as Hertz's pressures slide."""
    law, sliding = EnergyLaw(mild=0.7, transition=1e9), full_sliding(120, 26)
    metres = 1000.0
    volume = section_area(sliding, law) * metres * 1000
    joules = sliding.total_work * metres
    assert volume == pytest.approx(0.7 / 7850 * joules, rel=1e-13)
    line_load = np.pi / 2 * HERTZ.a * HERTZ.p_max * (1 - (sliding.grid.strips / HERTZ.b) ** 2)
    exact = 0.7 / 7850 * 1e-3 * FRICTION * CREEPAGE * line_load
    np.testing.assert_allclose(depth(sliding, law)[3:-3], exact[3:-3], rtol=2e-3)


def test_energy_law_jumps_at_its_transition_by_the_ratio_of_coefficients():
    law = EnergyLaw()  # power density: traction times slip times speed
    below, beyond = (rate(law, 100.0, slip, speed=8.0) for slip in (0.005 - 1e-12, 0.005 + 1e-12))
    assert beyond / below == pytest.approx(3.0, rel=1e-6)
    assert below == pytest.approx(0.7 / 7850 * 0.5e-3, rel=1e-6)


def test_twin_disc_law_has_the_values_of_its_source():
    law = TwinDiscLaw()
    np.testing.assert_allclose(law.mass(np.array([0.0, 5.0, 10.4, 50.0, 77.2])), [0, 26.5, 55, 55, 55])
    assert law.mass(10.4 - 1e-9) == pytest.approx(5.3 * 10.4)
    assert law.mass(87.2) == pytest.approx(55 + 619)
    assert law.mass(77.2 + 1e-9) == pytest.approx(55.0, abs=1e-6)
    assert rate(law, 100.0, 0.05) == pytest.approx(5.3 * 5 / 7850 * 1e-3)


# ---- Archard


def test_archards_volume_is_k_times_load_times_sliding_distance_over_hardness():
    law, sliding = ArchardMap(hardness=9e3), full_sliding(60, 44)
    load = np.sum(sliding.pressure) * sliding.grid.area
    assert section_area(sliding, law) == pytest.approx(35e-4 * load * CREEPAGE / 9e3, rel=1e-12)


@pytest.mark.parametrize(
    ("velocity", "pressure", "k"),
    [(0.19, 1000, 5e-4), (0.21, 1000, 35e-4), (0.69, 1000, 35e-4), (0.71, 1000, 5e-4), (0.4, 2399, 35e-4),
     (0.4, 2401, 350e-4), (0.1, 2401, 350e-4), (5.0, 2401, 350e-4)],
)  # fmt: skip
def test_regions_of_archards_map(velocity, pressure, k):
    law = ArchardMap()
    assert law.coefficient(np.array(velocity), np.array(pressure)) == k
    assert rate(law, 100.0, velocity / 10, pressure=float(pressure), speed=10.0) == pytest.approx(
        k * pressure * velocity / 10 / 3000
    )


# ---- at their borders


def test_power_density_at_its_transition_is_severe():
    """The transition is the power density from which on wear is severe: 64 MPa x 2^-7 x 8 m/s."""
    law = EnergyLaw(transition=4.0)
    assert rate(law, 64.0, 2.0**-7, speed=8.0) == law.severe * 0.5 / law.density * 1e-3


def test_discs_at_a_transition_are_severe():
    law = TwinDiscLaw(mild=3.0, severe=20.0, catastrophic=7.0, transitions=(8.0, 64.0))
    below, at_first, at_second = law.mass(np.array([np.nextafter(8.0, 0.0), 8.0, 64.0]))
    assert below == pytest.approx(24.0)
    assert at_first == at_second == 20.0


def test_archards_map_at_a_border():
    """Slow below the first velocity, fast above the second one; seizure where pressure exceeds its share."""
    law = ArchardMap(slow=1.0, middle=2.0, fast=3.0, seizure=4.0, hardness=4096.0, pressure_share=0.5)
    first, second = law.velocities
    velocity = np.array([np.nextafter(first, 0.0), first, second, np.nextafter(second, np.inf)])
    np.testing.assert_array_equal(law.coefficient(velocity, np.array(2048.0)), [1, 2, 2, 3])
    np.testing.assert_array_equal(law.coefficient(velocity, np.nextafter(2048.0, np.inf)), 4)


# ---- all laws


@ids
def test_within_a_regime_wear_grows_with_slip_from_none(law):
    rates = [rate(law, 100.0, slip, speed=1.0) for slip in np.linspace(0.0, 0.039, 9)]
    assert rates[0] == 0
    assert np.all(np.diff(rates) > 0)


@ids
def test_worn_area_does_not_depend_on_the_grid(law):
    """Of Hertz pressures that slide; borders of regimes cut elements, so differences may be small by luck."""
    areas = [section_area(full_sliding(n, n - 6, speed=1.0), law) for n in (12, 24, 48, 96, 192)]
    changes = np.abs(np.diff(areas)) / areas[-1]
    assert changes[-1] < 1e-3
    assert max(changes[:2]) > 5 * max(changes[2:])


# ---- shares of regimes


def test_shares_of_regimes():
    sliding = full_sliding(41, 31)
    half = np.max(sliding.work) * np.sqrt(1 - 0.5)  # of an ellipse: p > this on half of the area
    shares = regime_shares(sliding, (half, 1e9))
    assert shares.sum() == pytest.approx(1.0)
    assert shares[2] == 0
    assert shares[1] == pytest.approx(1 - 0.5**1.5, abs=0.01)  # of the load
    np.testing.assert_array_equal(regime_shares(replace(sliding, slip=0 * sliding.slip), (1.0, 2.0)), 0)


# ---- which laws there are

ENERGETIC, DISCS, MAP = EnergyLaw(mild=1.5), TwinDiscLaw(severe=50.0), ArchardMap(slow=1e-4)
OTHERS = DamageSpecification(energy=ENERGETIC, twin_disc=DISCS, archard=MAP)


def test_laws_have_the_given_coefficients_and_without_a_speed_none_depends_on_it():
    fast = replace(OTHERS, hardness=2e3, speed=20.0)
    assert fast.laws == {ENERGY: ENERGETIC, TWIN_DISC: DISCS, ARCHARD: replace(MAP, hardness=2e3)}
    assert OTHERS.laws == {ENERGY: replace(ENERGETIC, severe=1.5), TWIN_DISC: DISCS}
    assert (fast.rolling_speed, OTHERS.rolling_speed) == (20.0, NO_SPEED)


def test_yield_stress_in_shear_is_that_of_mises():
    stress = np.zeros((3, 3))
    stress[0, 1] = stress[1, 0] = DamageSpecification(yield_stress=600.0).yield_shear
    assert np.sqrt(1.5 * np.sum(stress**2)) == pytest.approx(600.0)  # of a deviator
    assert DamageSpecification().yield_shear is None


# ---- bad input


@pytest.mark.parametrize(
    ("make", "keys", "message"),
    [
        (EnergyLaw, {"mild": 0.0}, "mild = 0.0: must be positive and finite"),
        (EnergyLaw, {"density": -1.0}, "density = -1.0: must be positive and finite"),
        (TwinDiscLaw, {"transitions": (80.0, 10.0)}, r"= \(80.0, 10.0\): .* smaller one first"),
        (TwinDiscLaw, {"transitions": (-1.0, 10.0)}, "transitions = -1.0: must be positive"),
        (ArchardMap, {"hardness": 0.0}, "hardness = 0.0: must be positive and finite"),
        (ArchardMap, {"velocities": (0.7, 0.2)}, r"velocities = \(0.7, 0.2\): .* smaller one first"),
        (DamageSpecification, {"hardness": 3e3}, r"hardness = 3000: .* give speed"),
        *(
            (DamageSpecification, {"speed": 1.0} | {name: value}, f"{name} = {value!r}: must be positive and")
            for name in CONSTANTS
            for value in (0.0, -1.0, np.inf, np.nan)
        ),
    ],
)
def test_wrong_numbers_are_refused(make, keys, message):
    with pytest.raises(WrongInput, match=message):
        make(**keys)
