"""Dang Van's criterion: cycles of known amplitude, invariance, limits in torsion and bending."""

import numpy as np
import pytest

from femic.damage.dang_van import DangVan, equivalent_stress, shear_amplitudes, tensors
from geometries.errors import WrongInput

RANDOM = np.random.default_rng(7)
ANGLES = np.linspace(0, 2 * np.pi, 33)  # with the peaks and the start again
CRITERION = DangVan(0.3)
XX, SZ, XS = np.eye(6)[[0, 3, 5]]


def cycle(sine, cosine=0 * XX, mean=0 * XX):
    """Tensors (n_steps, 3, 3) of components (6,)."""
    return tensors(np.multiply.outer(np.sin(ANGLES), sine) + np.multiply.outer(np.cos(ANGLES), cosine) + mean)


PRESSED = cycle(100.0 * XS, mean=-300.0 * np.array([1, 1, 1, 0, 0, 0]))
TO_LIMITS = DangVan(3 * (260.0 / 420.0 - 0.5))  # in torsion and in bending


@pytest.mark.parametrize(
    ("stresses", "criterion", "expected"),
    [
        *((cycle(120.0 * XS, mean=mean), CRITERION, 120.0) for mean in (0 * XS, 250 * XS, 80 * XS - 40 * SZ)),
        (cycle(300.0 * XX), CRITERION, 150 + 0.3 * 100),
        (cycle(150.0 * XX, mean=150.0 * XX), CRITERION, 75 + 0.3 * 100),  # tension from zero
        # a quarter apart: half the difference of principal stresses is sqrt(sigma^2/4 + tau^2), never both
        (cycle(200.0 * XX, 60.0 * XS), DangVan(0.0), 100.0),
        (cycle(100.0 * XX, 140.0 * XS), DangVan(0.0), 140.0),
        (PRESSED, CRITERION, 100 - 0.3 * 300),
        (PRESSED, DangVan(0.3, compression=0.0), 100.0),
        (cycle(260.0 * XS), TO_LIMITS, 260.0),
        (cycle(420.0 * XX), TO_LIMITS, 260.0),
    ],
)
def test_cycles_of_tension_and_torsion_have_their_closed_forms(stresses, criterion, expected):
    assert equivalent_stress(stresses, criterion) == pytest.approx(expected)


def random_cycle(points=()):
    return tensors(RANDOM.normal(size=(17, *points, 6)) * 100)


def test_rotated_stresses_have_the_same_equivalent_stress():
    stresses, (turn, _) = random_cycle((3, 2)), np.linalg.qr(RANDOM.normal(size=(3, 3)))
    here, there = (equivalent_stress(one, CRITERION) for one in (stresses, turn @ stresses @ turn.T))
    np.testing.assert_allclose(there, here, rtol=1e-10)
    assert here.shape == (3, 2)


def test_hydrostatic_stress_that_stays_counts_by_its_weight_alone_and_a_deviator_not_at_all():
    stresses, residual = random_cycle((4,)), tensors(np.array([50.0, -20, -30, 15, 40, -60]))
    for weight in (0.3, 0.0):
        before, after = (
            equivalent_stress(one, DangVan(weight))
            for one in (stresses, stresses + 70 * np.eye(3) + residual)
        )
        np.testing.assert_allclose(after, before + weight * 70)


def test_order_of_steps_and_repeated_cycles_do_not_matter():
    stresses = random_cycle()
    shuffled = np.concatenate([stresses, stresses])[RANDOM.permutation(34)]
    assert equivalent_stress(shuffled, CRITERION) == pytest.approx(
        float(equivalent_stress(stresses, CRITERION)), rel=1e-10
    )


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
