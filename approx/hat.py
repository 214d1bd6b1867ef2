"""Integrals of the half-space kernels with a piecewise bilinear traction: the hat over 2 x 2 elements.

The hat (1 - |X| / 2a) (1 - |S| / 2b) is the average of the uniform element over an element, so its integrals
are averages of the integrals over the uniform rectangle, over an element about the observer. The average is a
product of two quadratures: Gauss-Legendre rules, whose number of nodes follows from the distance to the
nearest corner (the size of an ellipse in the complex plane that contains no singularity), and beside the
patch, where this ellipse is too small, tanh-sinh rules on both sides of the edge line. Errors:
docs/evidence/analytic.md.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from approx.rectangle import over_rectangle, with_signs
from geometries.arrays import Array
from geometries.patches import Patch
from geometries.quadrature import gauss

GAUSS_DIGITS = 17  # accuracy of the Gauss rules
GAUSS = (2, 3, 4, 6, 8, 12, 16, 24)  # numbers of nodes of the Gauss rules
LEAST, PER_DECADE, MOST = 81, 20, 161  # nodes of the tanh-sinh rule: least, per decade of aspect, most
TANH_SINH_REACH = 3.2  # range of the tanh-sinh rule: its last nodes lie 1e-16 from the ends of the interval
AT_ONCE = 2**20  # number of evaluations of the rectangle at a time


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes, and weights of sum 1, of the windows about some observers; shape (observers, nodes)."""

    at: Array
    weights: Array


def over_hat(patch: Patch, x: Array, s: Array) -> Array:
    """Integrals I_xx, I_ss, I_xs, J_x, J_s [mm] under the hat of peak 1, shape (5, *x.shape).

    `patch` is one element (half-sides a, b), the hat covers 4a x 4b about its centre. x, s [mm], of one
    shape: observer minus patch centre.
    """
    abs_x, abs_s = np.abs(x.ravel()), np.abs(s.ravel())
    rules_x = _rules(abs_x / patch.a, np.maximum(abs_s - 2 * patch.b, 0) / patch.a)
    rules_s = _rules(abs_s / patch.b, np.maximum(abs_x - 2 * patch.a, 0) / patch.b)
    fine = _tanh_sinh_size(patch)
    out = np.empty((5, x.size))
    for rule_x, rule_s in np.unique(np.stack([rules_x, rules_s]), axis=1).T:
        group = np.flatnonzero((rules_x == rule_x) & (rules_s == rule_s))
        evaluations = len(group) * (rule_x or 2 * fine) * (rule_s or 2 * fine)
        for observers in np.array_split(group, -(-evaluations // AT_ONCE)):
            window_x = _nodes(abs_x[observers], patch.a, rule_x, fine)
            window_s = _nodes(abs_s[observers], patch.b, rule_s, fine)
            out[:, observers] = _averaged(patch, window_x, window_s)
    return with_signs(out.reshape(5, *x.shape), x, s)


def over_hat_lags(patch: Patch, n_x: int, n_s: int) -> Array:
    """The integrals of `over_hat` [mm] at the lags (2 a k, 2 b l) of a grid, shape (5, n_x, n_s).

    k = 0 ... n_x - 1, l = 0 ... n_s - 1.
    """
    x, s = 2 * patch.a * np.arange(n_x, dtype=float), 2 * patch.b * np.arange(n_s, dtype=float)
    return over_hat(patch, *np.broadcast_arrays(x[:, None], s))


def _averaged(patch: Patch, window_x: Nodes, window_s: Nodes) -> Array:
    """Weighted sums over the product of two rules, shape (5, observers)."""
    points = np.broadcast_arrays(window_x.at[:, :, None], window_s.at[:, None, :])
    at_nodes = over_rectangle(patch, *points)
    return np.einsum("kpij,pi,pj->kp", at_nodes, window_x.weights, window_s.weights, optimize=True)


def _rules(centre: Array, gap: Array) -> Array:
    """Number of Gauss nodes that each window centre - 1 ... centre + 1 needs; 0 if `GAUSS` has not as many.

    Seen from the window, the corners are singularities at +-1 +- i gap. The integrand is analytic in the
    ellipse about the window through the nearest of them, of semi-axes' sum rho: n nodes err by rho^(-2n).
    """
    z = 1 - centre + 1j * gap
    rho = np.abs(z + np.sqrt(z - 1) * np.sqrt(z + 1))
    rho = np.maximum(np.maximum(rho, 1 / rho), 1 + 1e-9)
    needed = GAUSS_DIGITS / (2 * np.log10(rho))
    return np.append(GAUSS, 0)[np.searchsorted(GAUSS, needed)]


def _nodes(centre: Array, half: float, rule: int, fine: int) -> Nodes:
    """Nodes of the windows centre - half ... centre + half: `rule` Gauss nodes, or for 0 tanh-sinh nodes."""
    if rule:
        abscissas, weights = gauss(rule)
        return Nodes(centre[:, None] + half * abscissas, np.broadcast_to(weights / 2, (len(centre), rule)))
    low, high = centre - half, centre + half
    edge = np.clip(half, low, high)
    share, weights = _tanh_sinh(fine)
    pieces = [(low[:, None], (edge - low)[:, None]), (edge[:, None], (high - edge)[:, None])]
    abscissas = np.concatenate([start + length * share for start, length in pieces], axis=1)
    return Nodes(abscissas, np.concatenate([length * weights for _, length in pieces], axis=1) / (2 * half))


def _tanh_sinh_size(patch: Patch) -> int:
    """Number of nodes of the tanh-sinh rule, which grows with the aspect of the patch."""
    decades = abs(np.log10(patch.a / patch.b))
    return int(min(LEAST + PER_DECADE * decades, MOST))


@lru_cache
def _tanh_sinh(n: int) -> tuple[Array, Array]:
    """Nodes in 0 ... 1, doubly exponentially denser to both ends, and weights (Takahasi, Mori 1974)."""
    t = np.linspace(-TANH_SINH_REACH, TANH_SINH_REACH, n)
    u = np.pi / 2 * np.sinh(t)
    return 1 / (1 + np.exp(-2 * u)), np.pi / 4 * np.cosh(t) / np.cosh(u) ** 2 * (t[1] - t[0])
