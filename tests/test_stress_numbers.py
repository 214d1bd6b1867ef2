"""From which angle on half-spaces are off inside the bodies: crossings of errors that are known."""

import pytest
import stress_numbers


def rows(*errors):
    """Rows at 20, 40, 60 ... degrees, whose half-spaces are off by these in both numbers."""
    return [
        {"angle": 20.0 * (k + 1), "bodies": {"upper": {"half_space": error, "section": abs(error)}}}
        for k, error in enumerate(errors)
    ]


def first(off, *errors):
    angles = stress_numbers._first_angles(rows(*errors), off)
    assert angles["upper, half_space"] == angles["upper, section"]
    return angles["upper, section"]


def test_errors_pass_a_limit_between_the_loads_around_it():
    assert first(0.05, 0.01, -0.03, -0.07, -0.2) == pytest.approx(50.0)
    assert first(0.05, 0.1, 0.2) == pytest.approx(10.0)  # errors are 0 where the patch is a point
    assert first(0.05, 0.0, 0.09, 0.01, 0.2) == pytest.approx(20 + 20 * 5 / 9)  # the first of several


def test_errors_that_stay_below_pass_nowhere():
    assert first(0.05, 0.01, -0.05) is None
