"""What damage depends on beside the contact: which laws there are, and with which coefficients."""

from dataclasses import replace

import numpy as np
import pytest

from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw
from femic.damage.specification import ARCHARD, CONSTANTS, ENERGY, NO_SPEED, TWIN_DISC, DamageSpecification
from geometries.errors import WrongInput

ENERGETIC, DISCS, MAP = EnergyLaw(mild=1.5), TwinDiscLaw(severe=50.0), ArchardMap(slow=1e-4)
LAWS = DamageSpecification(energy=ENERGETIC, twin_disc=DISCS, archard=MAP)


def test_laws_have_the_given_coefficients():
    laws = replace(LAWS, hardness=2e3, speed=20.0).laws
    assert laws == {ENERGY: ENERGETIC, TWIN_DISC: DISCS, ARCHARD: replace(MAP, hardness=2e3)}


def test_without_a_speed_wear_by_energy_is_mild_and_no_law_depends_on_it():
    laws = LAWS.laws
    assert laws == {ENERGY: replace(ENERGETIC, severe=1.5), TWIN_DISC: DISCS}
    assert LAWS.rolling_speed == NO_SPEED
    assert replace(LAWS, speed=20.0).rolling_speed == 20.0


def test_yield_stress_in_shear_is_that_of_mises():
    stress = np.zeros((3, 3))
    stress[0, 1] = stress[1, 0] = DamageSpecification(yield_stress=600.0).yield_shear
    assert np.sqrt(1.5 * np.sum(stress**2)) == pytest.approx(600.0)  # of a deviator
    assert DamageSpecification().yield_shear is None


@pytest.mark.parametrize("name", CONSTANTS)
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_constants_are_positive_and_finite(name, value):
    with pytest.raises(WrongInput, match=f"{name} = {value!r}: must be positive and finite"):
        DamageSpecification(**{"speed": 1.0} | {name: value})


def test_archard_needs_a_speed():
    with pytest.raises(WrongInput, match=r"hardness = 3000: .* give speed"):
        DamageSpecification(hardness=3e3)
