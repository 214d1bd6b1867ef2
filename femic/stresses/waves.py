"""Displacements and stresses of a section's points from the waves along x."""

import numpy as np

from femic.reference.harmonic.waves import spectrum, synthesis_weights
from femic.stresses.half_space import stress_of
from femic.stresses.spectra import Spectra
from geometries.arrays import Array, Indices
from geometries.bodies import Body

SHEARS = ((6, 1, 2), (7, 0, 2), (8, 0, 1))  # column of values, and its place in the matrix of strains


def synthesised(spectra: Spectra, k: Array, fields: Array, place: Indices, xi: Array) -> Array:
    """Values (n, c) at points from their waves (len(k), 2, places, c).

    `place` (n,) is the number of each point's place in the section, `xi` (n,) its coordinate in the chart
    [mm].
    """
    wavenumbers = spectrum(spectra.largest, spectra.body.rolling_radius)
    distinct, number = np.unique(xi, return_inverse=True)
    even, odd = synthesis_weights(spectra.axis, k, wavenumbers, wavenumbers.shares(0.0, distinct))
    values = np.empty((len(xi), fields.shape[-1]))
    for x in range(len(distinct)):
        here = np.flatnonzero(number == x)
        at = fields[:, :, place[here]]
        values[here] = np.tensordot(even[:, x], at[:, 0], 1) + np.tensordot(odd[:, x], at[:, 1], 1)
    return values


def in_local_axes(body: Body, s: Array, values: Array) -> tuple[Array, Array]:
    """Displacements (n, 3) and stresses (n, 3, 3) along x, s, n from values (n, 9) in section axes.

    Values are displacements, strains xx, yy, zz, and shear strains yz, xz, xy.
    """
    axes = np.moveaxis(body.surface.axes(np.zeros_like(s), s), 2, 0)  # (n, direction, component)
    strain = np.empty((len(s), 3, 3))
    for a in range(3):
        strain[:, a, a] = values[:, 3 + a]
    for column, a, b in SHEARS:
        strain[:, a, b] = strain[:, b, a] = values[:, column] / 2
    stress = axes @ stress_of(body.material, strain) @ np.swapaxes(axes, 1, 2)
    return np.einsum("nic,nc->ni", axes, values[:, :3]), stress
