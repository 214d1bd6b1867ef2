"""What both Newton methods share: linear equations, amplitudes that change forces or none."""

import numpy as np

from femic.contact.friction.law import correction, inverse_of_amplitudes


def test_the_correction_takes_the_residual_away() -> None:
    random = np.random.default_rng(1)
    matrix, residual = np.eye(20) + 0.1 * random.normal(size=(20, 20)), random.normal(size=20)
    change = correction(residual, lambda v: matrix @ v, lambda v: v, 1e-10)
    np.testing.assert_allclose(matrix @ change, -residual, atol=1e-9 * np.linalg.norm(residual))


def test_amplitudes_undo_forces_that_they_change_and_others_stay_zero() -> None:
    forces = np.array([[2.0, 0.5, 0.0], [0.3, -1.0, 0.0], [0.0, 0.0, 1e-12]])  # row: of an amplitude
    inverse = inverse_of_amplitudes(list(forces))
    amplitudes = inverse @ np.array([0.7, -0.2, 0.0])
    np.testing.assert_allclose(-amplitudes @ forces, [0.7, -0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(inverse @ np.array([0.0, 0.0, 1.0]), 0.0, atol=1e-12)


def test_without_amplitudes_there_is_nothing_to_invert() -> None:
    assert inverse_of_amplitudes([]).shape == (0, 0)
