"""The scale of refinement."""

import numpy as np
import pytest

from tests.femic.reference.conftest import line_errors


def test_scale_is_the_component_or_a_twentieth_of_nn():
    c = np.zeros((3, 3, 4))
    c[2, 2] = [1.0, -4.0, 2.0, 0.0]
    c[0, 0] = [0.0, 0.5, -1.0, 0.3]
    c[0, 2] = [0.01, 0.0, 0.02, 0.0]
    difference = np.full_like(c, 0.1)
    errors = line_errors(difference, c, c[2, 2])
    assert errors[0, 0] == pytest.approx(0.1 / 1.0)  # its own largest value
    assert errors[0, 2] == pytest.approx(0.1 / (0.05 * 4.0))  # small: a twentieth of nn's
    assert errors[1, 2] == pytest.approx(0.1 / (0.05 * 4.0))  # zero by symmetry
