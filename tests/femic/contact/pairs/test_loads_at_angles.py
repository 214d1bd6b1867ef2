"""Loads at angles: a law in closed form, angles that no load has, what is called how often."""

import numpy as np
import pytest

from femic.contact.motions.none import load_at_angle
from geometries.errors import Failure


def third_root(load):
    """Degrees that go like the third root of a load [N], as those of small patches do: 10 at 1 kN."""
    return load ** (1 / 3)


@pytest.mark.parametrize("accuracy", [0.05, 1e-3, 1e-9])
def test_a_load_is_the_third_power_of_its_angle(accuracy):
    load = load_at_angle(third_root, 23.0, (1e2, 1e6), accuracy)
    assert load == pytest.approx(23.0**3, rel=1.01 * accuracy)


@pytest.mark.parametrize("end", [1e3, 1e6])
def test_the_angle_at_an_end_has_its_load(end):
    assert load_at_angle(third_root, third_root(end), (1e3, 1e6), 1e-3) == pytest.approx(end, rel=1e-12)


@pytest.mark.parametrize(("degrees", "loads"), [(5.0, (1e3, 1e6)), (120.0, (1e3, 1e6)), (11.0, (1e3, 1e3))])
def test_an_angle_that_no_load_has_is_a_failure_with_both_ends(degrees, loads):
    angles = [f"{third_root(load):.3g} under {load:.3g} N" for load in loads]
    with pytest.raises(Failure, match=f"the patch turns by {degrees:g} degrees") as failure:
        load_at_angle(third_root, degrees, loads, 1e-3)
    assert all(angle in str(failure.value) for angle in angles)
    assert "give an angle between" in str(failure.value)


def test_contacts_at_the_ends_are_solved_once():
    solved = []

    def angle(load):
        solved.append(load)
        return third_root(load)

    load_at_angle(angle, 23.0, (1e2, 1e6), 1e-3)
    assert len(solved) == len(set(np.round(np.log(solved), 12)))
