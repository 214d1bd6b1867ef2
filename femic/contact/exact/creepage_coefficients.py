"""Kalker's creepage coefficients: forces of steady rolling per creepage where nothing slips, on an ellipse.

Rolling towards +x with vanishing creepage, of elastically similar bodies (K = 0). The rigid slip of the upper
surface over the lower one per rolled distance is w_x = -xi - spin s, w_s = upsilon + spin x, in the middle of
the contact -xi and upsilon; nothing slips, so du/dx = w in the whole ellipse, u = upper - lower, and the
traction is 0 on the leading edge (infinite on the trailing one). On the upper body, c = sqrt(a b), G and nu
combined,

    F_x = G c^2 C11 xi,  F_s = -G c^2 (C22 upsilon + c C23 spin),  M_n = -G c^3 (C32 upsilon + c C33 spin),

with C32 = -C23. Kalker has them with xi_K = -xi.

Here by polynomials (after Kalker 1967) in the unit disk X = x/a, Y = s/b: the traction is

    (1 - r^2)^(-1/2) times the sum of q[n, m] Z[n, m](r) (cos or sin)(m t), m <= n, n - m even,

Z of degree n, orthogonal by that weight, and 1 on the edge. Its Radon transform in direction t is
pi P_n (cos or sin)(m t), P_n of Legendre, and the displacement of a half-space is a mean of Radon transforms:
with the wave number of direction t, k = (cos t / a, sin t / b),

    u(X, Y) = 1/G integral over t = 0 ... pi of (1 - nu k k^T / k^2) / |k| q(t) P_n(X cos t + Y sin t).

So du/dx is a polynomial, known without any integral but those over t, by the trapezoidal rule. It is w to the
last degree that there is; what is left free makes sum q[n, m] (cos or sin)(m t), the intensity on the edge,
vanish on the leading half by least squares with weight cos(t)^2. Errors fall as degree^-4.

Source: Kalker (1967), On the rolling contact of two elastic bodies in the presence of dry friction, Delft;
Kalker (1990), Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer, appendix E.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import WrongInput
from geometries.patches import S, X

DEGREE = 24  # of the polynomials
LEAST_DEGREE = 6
WIDEST = 100.0  # largest ratio of the semi-axes, either way: the errors grow with it
NODES = 8, 60  # over t, per degree and per ratio of the semi-axes: errors of rounding
EDGE_NODES = 4  # on a quarter of the edge, per degree


@dataclass(frozen=True)
class CreepageCoefficients:
    """C11, C22, C23, C32, C33 [-] of an ellipse of semi-axes a along x and b along s [mm].

    `estimate` bounds their relative errors: the largest difference to two thirds of the degree.
    """

    a: float
    b: float
    C11: float
    C22: float
    C23: float
    C32: float
    C33: float
    estimate: float

    def forces(self, G: float, xi: float, upsilon: float, spin: float) -> tuple[float, float, float]:
        """F_x, F_s [N] and M_n [N mm] on the upper body: creepages xi, upsilon [-], spin [1/mm], G [MPa]."""
        c = np.sqrt(self.a * self.b)
        F_x = G * c**2 * self.C11 * xi
        F_s = -G * c**2 * (self.C22 * upsilon + c * self.C23 * spin)
        M_n = -G * c**3 * (self.C32 * upsilon + c * self.C33 * spin)
        return float(F_x), float(F_s), float(M_n)


def creepage_coefficients(a: float, b: float, nu: float, *, degree: int = DEGREE) -> CreepageCoefficients:
    """Return the coefficients of an ellipse, by polynomials up to a degree; nu is the combined one.

    Raises WrongInput for semi-axes whose ratio is beyond `WIDEST`, nu beyond 0 ... 0.5, and too low a degree.
    """
    if not (0 < a < np.inf and 0 < b < np.inf and 1 / WIDEST <= a / b <= WIDEST):
        raise WrongInput(f"a = {a!r}, b = {b!r}: must be positive, a / b within 1/{WIDEST:g} ... {WIDEST:g}")
    if not 0 <= nu <= 0.5:
        raise WrongInput(f"nu = {nu!r}: must lie in 0 ... 0.5")
    if degree < LEAST_DEGREE:
        raise WrongInput(f"degree = {degree!r}: at least {LEAST_DEGREE}")
    fine, coarse = (_five(a / b, nu, n) for n in (degree, 2 * degree // 3))
    estimate = np.max(np.abs(coarse - fine) / np.abs(fine))
    C11, C22, C23, C32, C33 = map(float, fine)
    return CreepageCoefficients(a, b, C11, C22, C23, C32, C33, float(estimate))


def _five(ratio: float, nu: float, degree: int) -> Array:
    """C11, C22, C23, C32, C33 of a / b, shape (5,)."""
    a, b = float(np.sqrt(ratio)), float(1 / np.sqrt(ratio))
    along, across = _Modes.up_to((0, 1), degree), _Modes.up_to((1, 0), degree)
    by_xi = _tractions(along, [(X, 0, 0, 1.0)], ratio, nu)
    by_upsilon = _tractions(across, [(S, 0, 0, 1.0)], ratio, nu)
    by_spin = _tractions(across, [(X, 1, 1, -b), (S, 1, 1, a)], ratio, nu)
    forces = [2 * np.pi * along.coefficient(by_xi, X, 0, 0)]
    forces += [2 * np.pi * across.coefficient(q, S, 0, 0) for q in (by_upsilon, by_spin)]
    moments = [
        2 * np.pi / 3 * (a * across.coefficient(q, S, 1, 1) - b * across.coefficient(q, X, 1, 1))
        for q in (by_upsilon, by_spin)
    ]
    return -np.array(forces + moments)


@dataclass(frozen=True, eq=False)
class _Modes:
    """Polynomials of two directions, of degrees n and orders m, shape (modes,) each.

    `least` is the least order of the tractions along x and along s: those of 0 go with cos, even in s, those
    of 1 with sin, odd. One of the two is even and the other one odd.
    """

    least: tuple[int, int]
    degree: int
    direction: Indices
    n: Indices
    m: Indices

    @classmethod
    def up_to(cls, least: tuple[int, int], degree: int) -> Self:
        """All modes up to a degree."""
        all_three = [
            (i, n, m)
            for i in (X, S)
            for n in range(degree + 1)
            for m in range(n % 2, n + 1, 2)
            if m >= least[i]
        ]
        return cls(least, degree, *np.array(all_three).T)

    def waves(self, t: Array) -> Array:
        """cos(m t) or sin(m t) of both directions, shape (2, degree + 1, *t.shape)."""
        angles = np.multiply.outer(np.arange(self.degree + 1), t)
        both = np.cos(angles), np.sin(angles)
        return np.stack([both[least] for least in self.least])

    def place(self, direction: int, n: int, m: int) -> int:
        """Return the number of a mode."""
        return int(np.flatnonzero((self.direction == direction) & (self.n == n) & (self.m == m))[0])

    def coefficient(self, q: Array, direction: int, n: int, m: int) -> float:
        """Return the coefficient of a mode."""
        return float(q[self.place(direction, n, m)])


def _tractions(modes: _Modes, slopes: list[tuple[int, int, int, float]], ratio: float, nu: float) -> Array:
    """Coefficients q (modes,) of the tractions whose displacements have slopes du/dx, 0 ahead.

    They act on an ellipse of a / b = `ratio`, a b = 1, between bodies of G = 1. Slopes are given by
    direction, degree, order and coefficient: the polynomials are 1, X and Y.
    """
    tested = _Modes.up_to(modes.least, modes.degree - 1)
    targets = np.zeros(tested.n.size)
    for direction, n, m, coefficient in slopes:
        targets[tested.place(direction, n, m)] = coefficient / (2 * n + 1)
    # of P_n'(t) = sum of (2 j + 1) P_j(t), j = n - 1, n - 3, ...
    contributes = (modes.n > tested.n[:, None]) & ((modes.n - tested.n[:, None]) % 2 == 1)
    waves = _wave_slopes(modes, ratio, nu)
    waves = waves[tested.direction[:, None], modes.direction, tested.m[:, None], modes.m]
    orthogonal, triangle = np.linalg.qr((contributes * waves).T, mode="complete")
    fixed = orthogonal[:, : targets.size] @ np.linalg.solve(triangle[: targets.size].T, targets)
    free = orthogonal[:, targets.size :]
    edge = _on_leading_edge(modes)
    return np.asarray(fixed - free @ np.linalg.lstsq(edge @ free, edge @ fixed)[0])


def _wave_slopes(modes: _Modes, ratio: float, nu: float) -> Array:
    """Integrals over t of du_i/dx due to waves in direction j, times waves: (2, 2, orders, orders)."""
    per_degree, per_ratio = NODES
    nodes = max(per_degree * modes.degree, int(per_ratio * max(ratio, 1 / ratio)))
    t = (np.arange(nodes) + 0.5) * np.pi / nodes
    k = np.stack([np.cos(t) / np.sqrt(ratio), np.sin(t) * np.sqrt(ratio)])
    size = np.hypot(*k)
    compliance = np.eye(2)[:, :, None] - nu * k[:, None] * k / size**2
    weighted = compliance * k[X] / size * np.pi / nodes
    waves = modes.waves(t)
    return np.einsum("imt,ijt,jnt->ijmn", waves, weighted, waves, optimize=True)


def _on_leading_edge(modes: _Modes) -> Array:
    """Intensities on the leading edge, weighted, due to the modes: (2 nodes, modes)."""
    nodes, weights = np.polynomial.legendre.leggauss(EDGE_NODES * modes.degree)
    t = (nodes + 1) * np.pi / 4
    edge_waves = modes.waves(t) * np.sqrt(weights) * np.cos(t)
    edge = np.zeros((2, t.size, modes.n.size))
    for i in (X, S):
        here = modes.direction == i
        edge[i][:, here] = edge_waves[i, modes.m[here]].T
    return edge.reshape(-1, modes.n.size)
