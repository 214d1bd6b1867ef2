"""Tractions as sums of waves along x, and fields at points from their waves.

Tractions are known by their amplitudes at wavenumbers that resolve them, up to a largest one: their long
part. On each strip they are uniform on elements of half-length a: an element at xi_j has the amplitudes cos(k
xi_j) and sin(k xi_j) times sin(k a) / (k a) and its force. xi is the chart coordinate, in which waves on a
body of revolution have the same wavenumber on all rolling circles.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from femic.reference.harmonic.request import SCALE_LOWEST
from femic.reference.harmonic.wavenumbers import FEWEST_ORDERS, Axis
from femic.reference.harmonic.waves import spectrum, synthesis_weights, taper
from femic.stresses.half_space import hooke_stress
from femic.stresses.points import SurfaceTractions
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.patches import Grid

# --- waves of tractions ---

FEWEST_ELEMENTS = 32  # elements of the loaded part along x, by division of those given
FEWEST_STRIPS = 24  # and along s
LARGEST = 36.0  # largest wavenumber times the loaded half-length: the limit of Filon's panels is about 45
LOG_SPACING = 0.75  # of wavenumbers in ln k, below the inverse of the loaded half-length
SPACING = 0.5 * np.pi  # times the inverse of that length: of larger wavenumbers
FADED = 60.0  # distance times the largest k up to which the long part of a traction spreads


def loaded_part(tractions: SurfaceTractions) -> SurfaceTractions:
    """Return the tractions on the least grid about x = 0 that holds all that are not 0, in enough elements.

    One element is left where there are none.
    """
    grid, loaded = tractions.grid, np.any(tractions.p != 0, axis=2)
    strips = np.flatnonzero(np.any(loaded, axis=0))
    first, last = (int(strips[0]), int(strips[-1])) if len(strips) else (0, 0)
    rows = np.flatnonzero(np.any(loaded | loaded[::-1], axis=1))
    skipped = int(rows[0]) if len(rows) else 0
    p = tractions.p[skipped : grid.n_x - skipped, first : last + 1]
    s = float(grid.strips[first] + grid.strips[last]) / 2
    along_x, along_s = -(-FEWEST_ELEMENTS // p.shape[0]), -(-FEWEST_STRIPS // p.shape[1])
    p = np.repeat(np.repeat(p, along_x, axis=0), along_s, axis=1)
    return SurfaceTractions(Grid(p.shape[0], p.shape[1], grid.dx / along_x, grid.ds / along_s, s), p)


@dataclass(frozen=True, eq=False)
class Spectra:
    """The waves of tractions on a body; `largest` is the largest wavenumber in the chart [1/mm]."""

    body: Body
    tractions: SurfaceTractions  # their loaded part
    largest: float

    @classmethod
    def from_tractions(cls, body: Body, tractions: SurfaceTractions, largest: float) -> "Spectra":
        """The waves of tractions up to a share of `LARGEST` over their half-length."""
        part = loaded_part(tractions)
        stretch = cls(body, part, 1.0).stretch
        half_length = part.grid.n_x * part.grid.dx / 2 * float(np.max(stretch))
        return cls(body, part, largest * LARGEST / half_length)

    @property
    def stretch(self) -> Array:
        """Chart length over arc length on the strips, shape (n_s,)."""
        s = self.tractions.grid.strips
        return self.body.surface.chart_x(np.ones_like(s), s, s)

    @property
    def half_length(self) -> float:
        """Half-length of the loaded part in the chart [mm]."""
        grid = self.tractions.grid
        return float(grid.n_x * grid.dx / 2 * np.max(self.stretch))

    @property
    def axis(self) -> Axis:
        """The axis of wavenumbers."""
        return Axis(SCALE_LOWEST / self.body.domain.far_radius, self.largest, self.body.rolling_radius)

    def wavenumbers(self, spacing: float) -> Array:
        """Wavenumbers to be solved [1/mm], in growing order from 0 to the largest one, shape (n,).

        Their spacing is a share of k where k is small, times the root of `spacing`. Where k is large it is a
        share of the inverse half-length of the loaded part, times `spacing`: the responses swing that fast.
        Orders of a ring are integers.
        """
        low, step = self.axis.scale, spacing * SPACING / self.half_length
        k = np.linspace(0.0, self.largest, 20001)
        k = np.unique(np.append(k, low * np.sinh(np.linspace(0, np.arcsinh(self.largest / low), 2001))))
        density = 1 / (np.sqrt(spacing) * LOG_SPACING * np.hypot(k, low)) + 1 / step
        count = np.append(0.0, np.cumsum(np.diff(k) * (density[1:] + density[:-1]) / 2))
        nodes = np.interp(np.linspace(0, count[-1], int(np.ceil(count[-1])) + 1), count, k)
        radius = self.body.rolling_radius
        if np.isinf(radius):
            return nodes
        orders = np.append(np.round(nodes * radius), np.arange(FEWEST_ORDERS))
        return np.unique(np.minimum(orders, np.floor(self.largest * radius))) / radius

    def amplitudes(self, k: float) -> tuple[Array, Array]:
        """Amplitudes of cos(k xi) and sin(k xi) in the forces [N] on the body, shape (n_s, 3) each.

        They are forces per length of chart and per strip, for the weights of a `Spectrum`.
        """
        grid = self.tractions.grid
        phase = k * np.outer(self.tractions.x, self.stretch)  # (n_x, n_s)
        force = self.body.side * grid.area * self.tractions.p
        force = force * np.sinc(k * grid.dx / 2 * self.stretch / np.pi)[:, None]
        return np.sum(np.cos(phase)[..., None] * force, axis=0), np.sum(
            np.sin(phase)[..., None] * force, axis=0
        )

    def long_part(self) -> SurfaceTractions:
        """The part of the tractions whose waves the section is solved for, on a longer grid."""
        grid, p = self.tractions.grid, self.tractions.p
        added = int(np.ceil(FADED / self.largest / grid.dx))
        n_x = grid.n_x + 2 * added
        n = next_fast_len(n_x + added)
        padded = np.pad(p, ((added, added), (0, 0), (0, 0)))
        k = 2 * np.pi * rfftfreq(n, grid.dx)
        share = taper(np.minimum(k[:, None] / self.stretch / self.largest, 1.0))
        long = irfft(share[..., None] * rfft(padded, n, axis=0), n, axis=0)[:n_x]
        return SurfaceTractions(Grid(n_x, grid.n_s, grid.dx, grid.ds, grid.s), long)


# --- fields from their waves ---

SHEARS = ((6, 1, 2), (7, 0, 2), (8, 0, 1))  # column of values, and its place in the matrix of strains


def synthesise(spectra: Spectra, k: Array, fields: Array, place: Indices, xi: Array) -> Array:
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
    stress = axes @ hooke_stress(body.material, strain) @ np.swapaxes(axes, 1, 2)
    return np.einsum("nic,nc->ni", axes, values[:, :3]), stress
