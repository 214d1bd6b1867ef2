"""The error measure of the design, and refusing what has not converged."""

import numpy as np
import pytest

from femic.accuracy import line_errors, require_converged
from femic.linear import NotConverged


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


def test_too_large_an_estimate_is_an_error_with_the_numbers():
    estimates = {("lower", "s = 1 mm"): np.full((3, 3), 0.001), ("upper", "x = 2 mm"): np.full((3, 3), 0.03)}
    with pytest.raises(NotConverged, match=r"C_nn of the upper body on the line x = 2 mm: 3\.00%.*engine"):
        require_converged(estimates, ["nn"], 0.01)
    require_converged(estimates, ["nn"], 0.05)


def test_an_estimate_that_is_not_a_number_is_not_convergence():
    with pytest.raises(NotConverged):
        require_converged({("lower", "l"): np.full((3, 3), np.nan)}, ["xn"], 1.0)
