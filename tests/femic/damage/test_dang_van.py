"""Dang Van's criterion: cycles of known amplitude, invariance, limits in torsion and bending."""

import numpy as np
import pytest

from femic.damage.dang_van import DangVan, equivalent_stress, shear_amplitudes, tensors
from geometries.errors import WrongInput

RANDOM = np.random.default_rng(7)
ANGLES = np.linspace(0, 2 * np.pi, 33)  # with the peaks and the start again
CRITERION = DangVan(0.3)
XX, XS = np.eye(6)[0], np.eye(6)[5]


def cycle(sine, cosine=0 * XX, mean=0 * XX):
    """Tensors (n_steps, 3, 3) of components (6,)."""
    return tensors(np.multiply.outer(np.sin(ANGLES), sine) + np.multiply.outer(np.cos(ANGLES), cosine) + mean)


def rotation():
    turn, _ = np.linalg.qr(RANDOM.normal(size=(3, 3)))
    return turn


def test_a_shear_cycle_has_its_amplitude_whatever_its_mean():
    for mean in (0 * XS, 250.0 * XS, 80.0 * XS - 40 * np.eye(6)[3]):
        assert equivalent_stress(cycle(120.0 * XS, mean=mean), CRITERION) == pytest.approx(120.0)


def test_reversed_tension_has_half_of_it_and_a_share_of_its_hydrostatic_stress():
    assert equivalent_stress(cycle(300.0 * XX), CRITERION) == pytest.approx(150 + 0.3 * 100)


def test_tension_from_zero_counts_its_mean_in_the_hydrostatic_stress_alone():
    found = equivalent_stress(cycle(150.0 * XX, mean=150.0 * XX), CRITERION)
    assert found == pytest.approx(75 + 0.3 * 100)


@pytest.mark.parametrize(("sigma", "tau"), [(200.0, 60.0), (100.0, 140.0)])
def test_tension_and_torsion_a_quarter_apart(sigma, tau):
    """Half the difference of principal stresses is sqrt(sigma^2/4 + tau^2): it never has both at once."""
    found = equivalent_stress(cycle(sigma * XX, tau * XS), DangVan(0.0))
    assert found == pytest.approx(max(sigma / 2, tau))


def random_cycle(points=()):
    return tensors(RANDOM.normal(size=(17, *points, 6)) * 100)


def test_rotated_stresses_have_the_same_equivalent_stress():
    stresses, turn = random_cycle((3, 2)), rotation()
    here, there = (equivalent_stress(one, CRITERION) for one in (stresses, turn @ stresses @ turn.T))
    np.testing.assert_allclose(there, here, rtol=1e-10)
    assert here.shape == (3, 2)


def test_hydrostatic_stress_that_stays_counts_by_its_weight_alone():
    stresses = random_cycle((4,))
    raised = stresses + 70 * np.eye(3)
    for weight in (0.3, 0.0):
        before, after = (equivalent_stress(one, DangVan(weight)) for one in (stresses, raised))
        np.testing.assert_allclose(after, before + weight * 70)


def test_a_deviator_that_stays_does_not_count():
    stresses = random_cycle((4,))
    residual = tensors(np.array([50.0, -20, -30, 15, 40, -60]))
    np.testing.assert_allclose(
        equivalent_stress(stresses + residual, CRITERION), equivalent_stress(stresses, CRITERION)
    )


def test_compression_may_count_less():
    pressed = cycle(100.0 * XS, mean=-300.0 * np.array([1, 1, 1, 0, 0, 0]))
    assert equivalent_stress(pressed, CRITERION) == pytest.approx(100 - 0.3 * 300)
    assert equivalent_stress(pressed, DangVan(0.3, compression=0.0)) == pytest.approx(100)


def test_order_of_steps_and_repeated_cycles_do_not_matter():
    stresses = random_cycle()
    shuffled = np.concatenate([stresses, stresses])[RANDOM.permutation(34)]
    assert equivalent_stress(shuffled, CRITERION) == pytest.approx(
        float(equivalent_stress(stresses, CRITERION)), rel=1e-10
    )


def test_limits_in_torsion_and_bending_are_both_met():
    criterion = DangVan(3 * (260.0 / 420.0 - 0.5))
    for stresses in (cycle(260.0 * XS), cycle(420.0 * XX)):
        assert equivalent_stress(stresses, criterion) == pytest.approx(260.0)


def test_amplitudes_of_points_are_those_of_each_alone():
    stresses = random_cycle((5,))
    deviators = stresses - np.trace(stresses, axis1=-2, axis2=-1)[..., None, None] / 3 * np.eye(3)
    together = shear_amplitudes(deviators)
    for k in range(5):
        np.testing.assert_allclose(together[:, k], shear_amplitudes(deviators[:, k]), rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: DangVan(-0.1), "hydrostatic = -0.1: must be zero or positive"),
        (lambda: DangVan(0.3, compression=2.0), "compression = 2.0: a share"),
        (lambda: tensors(np.zeros((4, 5))), r"components of shape \(4, 5\): six in the last axis"),
        (lambda: equivalent_stress(np.zeros((4, 6)), CRITERION), r"stresses of shape \(4, 6\): \(n_steps"),
        (lambda: equivalent_stress(np.zeros((0, 3, 3)), CRITERION), r"stresses of shape \(0, 3, 3\)"),
        (lambda: equivalent_stress(np.full((2, 3, 3), np.nan), CRITERION), "values that are not finite"),
        (
            lambda: equivalent_stress(np.arange(9.0).reshape(1, 3, 3), CRITERION),
            "that are not symmetric, by 4",
        ),
    ],
)
def test_wrong_stresses_are_refused(call, message):
    with pytest.raises(WrongInput, match=message):
        call()
