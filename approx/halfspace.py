"""A: influence coefficients of the elastic half-space under a uniformly loaded rectangle.

Closed forms of Boussinesq and Cerruti, design section 3. Each integral over the rectangle is a
kernel at one corner, summed over the corners with signs. The terms of a kernel that depend on one
of its two coordinates only drop out of that sum, so ln(S + R) stands as asinh(S / |X|): finite on
the lines through the edges. Far away the corners cancel: the relative error grows like
1e-16 r^2 / (a b), in xn and sn several times faster.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometries.materials import HalfSpaces
from geometries.patches import Patch

Array = NDArray[np.float64]


def halfspace_ics(constants: HalfSpaces, patch: Patch, x: ArrayLike, s: ArrayLike) -> Array:
    """A per unit pressure [mm/MPa] at observers (x, s) [mm] relative to the patch centre.

    Returns shape (3, 3, *broadcast(x, s).shape): displacement i due to traction j, directions
    x, s, n. Source: [BVSV] section 2, Kalker (1990).
    """
    x, s = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(s, dtype=float))
    xx_part, ss_part, I_xs, J_x, J_s = over_rectangle(patch, x, s)
    nu, K = constants.nu, constants.mismatch_k
    I_0 = xx_part + ss_part
    nn = (1 - nu) * I_0
    xx = nn + nu * xx_part
    ss = nn + nu * ss_part
    xs = nu * I_xs
    xn, sn = -K * J_x, -K * J_s
    rows = np.array([[xx, xs, xn], [xs, ss, sn], [-xn, -sn, nn]])
    return constants.factor / (2 * np.pi * constants.G) * rows


def over_rectangle(patch: Patch, x: Array, s: Array) -> Array:
    """Integrals I_xx, I_ss, I_xs [mm], J_x, J_s [mm] over the patch, shape (5, *x.shape).

    They are the integrals of X^2/R^3, S^2/R^3, X S/R^3, X/R^2, S/R^2 with X, S = observer minus
    loaded point; that of 1/R is I_xx + I_ss.
    """
    near, far = (
        at_corner(x + patch.a, s + side * patch.b) - at_corner(x - patch.a, s + side * patch.b)
        for side in (+1, -1)
    )
    return near - far  # differences of pairs: what vanishes by symmetry is exactly 0


def at_corner(X: Array, S: Array) -> Array:
    """The five primitives at one corner, shape (5, *X.shape)."""
    R = np.hypot(X, S)
    log_R = np.log(np.where(R > 0, R, 1.0))
    return np.stack(
        [
            _times_asinh(S, X),
            _times_asinh(X, S),
            -R,
            S * log_R + _times_arctan(X, S),
            X * log_R + _times_arctan(S, X),
        ]
    )


def _times_asinh(u: Array, v: Array) -> Array:
    """U asinh(v / |u|) with its limit 0 at u = 0: u ln(v + R) up to a term of u alone."""
    return u * np.arcsinh(v / np.where(u == 0, 1.0, np.abs(u)))


def _times_arctan(u: Array, v: Array) -> Array:
    """U arctan(v / u) with its limit 0 at u = 0."""
    return u * np.arctan(v / np.where(u == 0, 1.0, u))
