"""Melan's theorem for a contact that travels along x: the best residual stresses, by convex optimisation.

Residual stresses do not depend on x. Those admitted are rho_xx(s, z); rho_ss(z); with an Airy function
F(s, z) rho_ss = F_zz, rho_zz = F_ss, rho_sz = -F_sz; with a potential f(s, z) rho_xz = f_s, rho_xs = -f_z:
all in equilibrium, without tractions on the surface. F and f are products of cubic splines, even and odd
in s.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.optimize import minimize
from scipy.special import logsumexp, softmax

from femic.stresses.half_space import fields, lattice_corners
from geometries.materials import Material

STEEL = Material(210e3, 0.3)
KNOTS_S = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.3, 1.7, 2.3, 3.2, 5.0])  # half-widths, and mirrored
KNOTS_Z = np.array([0.0, 0.06, 0.12, 0.2, 0.28, 0.36, 0.46, 0.6, 0.8, 1.1, 1.6, 2.4, 4.0])
PLACES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))  # of components in a tensor
X, S, Z, SZ, XZ, XS = range(6)
HARDENED = (60.0, 240.0, 960.0)  # in turn: the maximum over places is smooth, ever less so


def elastic(friction, half_width, at, n=60):
    """Stresses over p_0 (s, z, x, 3, 3) below a sliding Hertz ellipse of half-length 1; `at` are s, z, x."""
    parts = 6 * n
    x = (np.arange(parts) + 0.5) / parts * 2 - 1
    p = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0)).reshape(n, 6, n, 6).mean(axis=(1, 3))
    edges = np.linspace(-1, 1, n + 1)
    corners = lattice_corners(edges, half_width * edges, p[..., None] * [friction, 0.0, 1.0])
    s, z, x = np.meshgrid(*at, indexing="ij")
    return fields(STEEL, corners, x.ravel(), s.ravel(), z.ravel())[1].reshape(*s.shape, 3, 3)


def deviator(stress):
    """Vectors (..., 5) whose squared length is J2 of stresses (..., 3, 3)."""
    xx, ss, zz = (stress[..., i, i] - np.trace(stress, axis1=-2, axis2=-1) / 3 for i in range(3))
    shears = [stress[..., i, j] for i, j in PLACES[3:]]
    return np.stack([np.sqrt(0.75) * xx, (ss - zz) / 2, *shears], axis=-1)


def _splines(knots, values, order):
    """Derivatives (n, splines) of cubic splines on knots, which end where knots do."""
    basis = BSpline(np.concatenate([[knots[0]] * 3, knots, [knots[-1]] * 3]), np.eye(len(knots) + 2), 3)
    return np.nan_to_num((basis.derivative(order) if order else basis)(values, extrapolate=False))


@dataclass(frozen=True)
class Melan:
    """The problem for stresses (s, z, x, 3, 3) over p_0 below an ellipse; with `shear` rho_xz is admitted."""

    s: np.ndarray
    z: np.ndarray
    stress: np.ndarray
    half_width: float
    shear: bool

    @cached_property
    def residual(self):
        """Matrix (5, places, unknowns) of the deviators of residual stresses."""
        n_s, n_z = len(self.s), len(self.z)
        knots = self.half_width * np.concatenate([-KNOTS_S[:0:-1], KNOTS_S])
        # the function and its mirror image
        along_s = [(_splines(knots, self.s, d), (-1) ** d * _splines(knots, -self.s, d)) for d in range(3)]
        half = along_s[0][0].shape[1] // 2
        even, odd = ([(one + sign * other)[:, half:] for one, other in along_s] for sign in (1, -1))
        down = [_splines(KNOTS_Z, self.z, d)[:, :-2] for d in range(3)]  # they vanish far below

        def product(of_s, of_z):
            return sparse.csr_matrix(np.kron(of_s, of_z))

        blocks = [
            {X: sparse.identity(n_s * n_z)},
            {S: sparse.kron(np.ones((n_s, 1)), sparse.identity(n_z))},
            {
                S: product(even[0], down[2][:, 2:]),
                Z: product(even[2], down[0][:, 2:]),
                SZ: -product(even[1], down[1][:, 2:]),
            },
        ]
        if self.shear:
            blocks.append({XZ: product(odd[1], down[0][:, 1:]), XS: -product(odd[0], down[1][:, 1:])})
        units = np.zeros((6, 3, 3))
        for component, (i, j) in enumerate(PLACES):
            units[component, i, j] = units[component, j, i] = 1.0
        weights = deviator(units)  # (6, 5)
        return [
            sparse.hstack(
                [sum(weights[c, k] * part for c, part in block.items()) for block in blocks]
            ).tocsr()
            for k in range(5)
        ]

    @cached_property
    def limit(self):
        """p_0/k at which the best residual stresses found leave all places and x just below yield."""
        own = np.moveaxis(deviator(self.stress).reshape(-1, self.stress.shape[2], 5), -1, 0)  # (5, places, x)
        unknowns = np.zeros(self.residual[0].shape[1])

        def squares(v):
            apart = np.stack([part @ v for part in self.residual])[..., None] + own
            return apart, np.sum(apart**2, axis=0)

        for hardness in HARDENED:

            def value(v, hardness=hardness):
                apart, j2 = squares(v)
                share = softmax(hardness * j2.ravel()).reshape(j2.shape)
                pull = 2 * np.sum(share * apart, axis=-1)
                slope = sum(part.T @ one for part, one in zip(self.residual, pull, strict=True))
                return logsumexp(hardness * j2) / hardness, slope

            unknowns = minimize(value, unknowns, jac=True, method="L-BFGS-B", options={"maxiter": 400}).x
        return float(1 / np.sqrt(np.max(squares(unknowns)[1])))
