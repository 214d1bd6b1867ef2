"""Wheels in elliptic grooves on rails: Hertz while the contact is small, estimates where it is not."""

import numpy as np
import pytest

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.normal import solve
from geometries.patches import Grid
from tests.femic.contact.problems import (
    GROOVES,
    ROLLING_RADIUS,
    STEEL,
    differences,
    elliptic,
    numbers,
    of_hertz,
)

SIZES = {"wide": (60.0, 30.0, 660e3), "tall": (36.0, 14.0, 58e3)}  # of the grid in mm; load in N


def figure_grid(name, n):
    length, width, _ = SIZES[name]
    return Grid(n, n + 8, length / n, width / (n + 8))


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
@pytest.mark.parametrize("name", GROOVES)
def test_grooves_under_small_loads_agree_with_hertz(name, variant):
    """The radius of an ellipse at its crown is lateral^2 / vertical."""
    wheel, rail = (vertical / lateral**2 for lateral, vertical in GROOVES[name])
    hertz = PointContact(1 / ROLLING_RADIUS, rail - wheel, combined_modulus(STEEL, STEEL)).at_load(10.0)
    contact = solve(elliptic(name, Grid(36, 26, 3.8 * hertz.a / 36, 4.2 * hertz.b / 26), variant), load=10.0)
    assert np.all(np.abs(numbers(contact) / of_hertz(hertz) - 1) < [2e-3, 2e-3, 5e-3, 0.02, 0.03, 0.03])


@pytest.mark.parametrize("variant", ["A", "Bhat"])
@pytest.mark.parametrize("name", GROOVES)
def test_estimate_under_large_loads_covers_the_difference_to_a_fine_grid(name, variant):
    """Conformal contacts of 34 degrees and more; elements of a quarter of the size stand for the truth."""
    load = SIZES[name][2]
    coarse, fine = (solve(elliptic(name, figure_grid(name, n), variant), load=load) for n in (24, 96))
    inclinations = coarse.problem.cosine[coarse.in_contact.any(axis=0)]
    assert np.arccos(np.min(inclinations)) > np.radians(17)
    assert np.all(np.abs(numbers(coarse) / numbers(fine) - 1) < differences(coarse))
    assert np.all(differences(fine) < differences(coarse) / 3)


@pytest.mark.parametrize("name", GROOVES)
def test_contacts_in_grooves_are_symmetric(name):
    contact = solve(elliptic(name, figure_grid(name, 24)), load=SIZES[name][2], tolerance=1e-9)
    for mirrored in (contact.p[::-1], contact.p[:, ::-1]):
        np.testing.assert_allclose(mirrored, contact.p, atol=1e-6 * contact.p.max())
