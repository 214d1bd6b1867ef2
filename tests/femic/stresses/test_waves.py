"""Waves of tractions and strains of sections: integrals of elements, rigid motions and rings of wheels."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from femic.stresses.waves import Spectra, strain
from tests.femic.stresses.samples import SIDES, curved, flat, grid_of, unsymmetric

R = 60.0


@pytest.mark.parametrize("k", [0.0, 0.4, 3.0])
@pytest.mark.parametrize("side", SIDES)
def test_amplitudes_are_integrals_over_elements(side, k):
    """Of uniform tractions times cos(k x) and sin(k x), by quadrature over each element of a strip."""
    grid = grid_of(32, 24, 1.4, 1.0)  # as many as the loaded part has at least
    tractions = unsymmetric(grid, 1.5, 1.3)
    spectra = Spectra.from_tractions(flat(side), tractions, 1.0)
    assert spectra.tractions.grid == grid
    edges = tractions.edges[0]
    for wave, found in zip((np.cos, np.sin), spectra.amplitudes(k), strict=True):
        parts = [quad(lambda x, w=wave: w(k * x), *ends)[0] for ends in pairwise(edges)]
        expected = side * grid.ds * np.einsum("x,xsd->sd", parts, tractions.p)
        np.testing.assert_allclose(found, expected, atol=1e-12)


def strains(side, values, k):
    """Strains xx, yy, zz, yz, xz, xy at heights z of a wheel's section from steady U, V, W."""
    z = np.array([-3.0, 0.0, 8.0])
    stretch = 1 - side * z / R
    at = np.zeros((3, 3, 3))  # value and slopes along y, z; point; U, V, W
    at[0] = values
    return strain(at, k, stretch, side / (R * stretch))[:, 3:]


@pytest.mark.parametrize("side", SIDES)
def test_a_translation_of_a_wheel_has_no_strains(side):
    """Along z: at the angle x / R its parts along x and z are side sin(x / R) and cos(x / R)."""
    assert np.max(np.abs(strains(side, [side, 0.0, 1.0], 1 / R))) < 1e-15


@pytest.mark.parametrize("side", SIDES)
def test_a_ring_that_grows_has_the_hoop_strain_of_its_radius(side):
    """Displacements of 1 away from the axis: hoop strain 1 / r, r the distance from the axis."""
    found = strains(side, [0.0, 0.0, -side], 0.0)
    radius = R - side * np.array([-3.0, 0.0, 8.0])
    np.testing.assert_allclose(found[:, 0], 1 / radius)
    assert np.all(found[:, 1:] == 0)


def test_stresses_of_wheels_take_the_length_of_their_circles():
    """The chart's length over the arc length is that of the crown's circle over the strip's own."""
    body = curved(+1, rolling_radius=R)
    grid = grid_of(32, 24, 1.4, 4.0)
    spectra = Spectra.from_tractions(body, unsymmetric(grid, 1.4, 4.0), 1.0)
    circles = body.surface.circle_radius(spectra.tractions.grid.strips)
    np.testing.assert_allclose(spectra.stretch, R / circles)
