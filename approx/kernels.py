"""Integrals of the half-space kernels over a rectangle: of uniform traction, and of the bilinear hat.

The integrals over a rectangle are exact to rounding everywhere. The textbooks' sums of logarithms over the
corners suffer from cancellation: far away they lose digits in proportion to r^2 / (a b), and they lose digits
beside the patch. Here

- kernels are even or odd in X and in S = observer minus loaded point, so that each integral is a sum
  of integrals of one sign over rectangles in the quadrant X, S >= 0 (`_straddling`);
- over such a rectangle the differences between corners are written as products (`Rectangle`): with
  g_x = X1^2 - X0^2 and R01 = R(X0, S1), R11 - R01 = g_x / (R11 + R01), and so on, and differences
  of asinh, ln and atan as one asinh, log1p, atan2 of such products.

Errors are below 2e-15 of I_0 for I_xx and I_ss, of the value itself for I_xs, J_x, J_s; what vanishes by
symmetry is exactly 0. Limits: lengths within `LENGTHS`, where fourth powers stay finite.

The hat over 2 x 2 elements, (1 - |X| / 2a) (1 - |S| / 2b), is the average of the uniform element over an
element, so its integrals are averages of the integrals over the uniform rectangle, over an element about the
observer. The average is a product of two quadratures: Gauss-Legendre rules, whose number of nodes follows
from the distance to the nearest corner (the size of an ellipse in the complex plane that contains no
singularity), and beside the patch, where this ellipse is too small, tanh-sinh rules on both sides of the edge
line. Errors: docs/numbers/benchmarks/analytic.json.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Patch
from geometries.quadrature import gauss

XX, SS, XS, JX, JS = range(5)  # rows of the arrays of integrals
IN_CACHE = 16384  # number of points worked on at a time (measured: benchmarks/analytic.py)
LENGTHS = 1e-70, 1e70  # mm; coordinates may also be smaller, or 0
BELOW_ONE = np.nextafter(1.0, 0.0)


# --- rectangles ---


@dataclass(frozen=True)
class Interval:
    """0 <= low <= high along one axis; `length` = high - low, without the rounding of that difference."""

    low: Array
    high: Array
    length: Array

    @property
    def g(self) -> Array:
        """high^2 - low^2."""
        return self.length * (self.low + self.high)

    def __getitem__(self, part: slice | tuple[slice, None]) -> "Interval":
        return Interval(self.low[part], self.high[part], self.length[part])


@dataclass(frozen=True)
class Distances:
    """Distances from the observer to the ends of the two sides of a rectangle at S.low (0) and S.high (1)."""

    low: tuple[Array, Array]  # at X.low, on side 0 and 1
    high: tuple[Array, Array]  # at X.high
    total: tuple[Array, Array]  # high + low
    difference: tuple[Array, Array]  # high - low = g_x / total


@dataclass(frozen=True)
class Rectangle:
    """The rectangle X x S in the first quadrant, the distances along its sides, ln(R00 R11 / (R01 R10))."""

    X: Interval
    S: Interval
    along_x: Distances
    along_s: Distances
    log_ratio: Array

    @property
    def swapped(self) -> "Rectangle":
        """The rectangle with x and s exchanged."""
        return Rectangle(self.S, self.X, self.along_s, self.along_x, self.log_ratio)


def rectangle(X: Interval, S: Interval, R: tuple[Array, Array, Array, Array]) -> Rectangle:
    """The rectangle X x S from the distances R00, R01, R10, R11 of its corners: first index X, second S."""
    R00, R01, R10, R11 = R
    q, r = R01 * R10, R11 * R00
    return Rectangle(
        X,
        S,
        _distances(X.g, (R00, R01), (R10, R11)),
        _distances(S.g, (R00, R10), (R01, R11)),
        _log1m(X.g * S.g / (q * (q + r))),
    )


def _distances(g: Array, low: tuple[Array, Array], high: tuple[Array, Array]) -> Distances:
    """Distances along one direction, with their sums and differences."""
    total = low[0] + high[0], low[1] + high[1]
    return Distances(low, high, total, (g / total[0], g / total[1]))


def over(X: Interval, S: Interval) -> Rectangle:
    """The rectangle X x S."""
    corners = ((X.low, S.low), (X.low, S.high), (X.high, S.low), (X.high, S.high))
    R00, R01, R10, R11 = (np.sqrt(x * x + s * s) for x, s in corners)
    return rectangle(X, S, (R00, R01, R10, R11))


# --- over a rectangle of the first quadrant ---


def fill(out: Array, rect: Rectangle) -> None:
    """Write I_xx, I_ss, I_xs, J_x, J_s [mm] into an array of shape (5, ...)."""
    swapped = rect.swapped
    out[XX], out[SS] = even_even(rect), even_even(swapped)
    out[XS] = odd_odd(rect)
    out[JX], out[JS] = odd_even(rect), odd_even(swapped)


def even_even(rect: Rectangle) -> Array:
    """Integral of X^2/R^3: S1 D(S1) - S0 D(S0), D(S) = asinh(X1/S) - asinh(X0/S).

    Written as h D(S1) + S0 (D(S1) - D(S0)), h = S1 - S0.
    """
    X0, X1, along_x = rect.X.low, rect.X.high, rect.along_x
    R01, (R10, R11), (step0, step1) = along_x.low[1], along_x.high, along_x.difference
    low, high = rect.along_s.total
    D1 = np.arcsinh(rect.X.g / (X1 * R01 + X0 * R11))
    further = X1 + R10
    defect = (step0 + step1) * further + low * (rect.X.length + step0)
    Q = rect.S.g * defect / (high * further * low * (X0 + R01))
    return rect.S.length * D1 + rect.S.low * _log1m(Q)


def odd_odd(rect: Rectangle) -> Array:
    """Integral of XS/R^3: R01 + R10 - R00 - R11."""
    total, (step0, step1) = rect.along_x.total, rect.along_s.difference
    return rect.X.g * (step0 + step1) / (total[0] * total[1])


def odd_even(rect: Rectangle) -> Array:
    """Integral of X/R^2: S1 L(S1) - S0 L(S0) + X1 A(X1) - X0 A(X0).

    L(S) = ln(R(X1, S) / R(X0, S)), A(X) = atan(S1/X) - atan(S0/X); differences as in `even_even`.
    """
    X0, X1, w, h = rect.X.low, rect.X.high, rect.X.length, rect.S.length
    P, X0_X1 = rect.S.low * rect.S.high, X0 * X1
    L1 = np.log1p(rect.X.g / rect.along_x.low[1] ** 2) / 2
    near_term, far_term, hX1 = X0 * X0 + P, X1 * X1 + P, h * X1
    A1 = np.arctan2(hX1, far_term)
    angle = np.arctan2(h * w * (P - X0_X1), far_term * near_term + h * X0 * hX1)
    return h * L1 + rect.S.low * rect.log_ratio + w * A1 + X0 * angle


def _log1m(Q: Array) -> Array:
    """ln(1 - Q), finite at Q = 1, where its factor S0 or X0 is 0 or negligible beside the other terms."""
    return np.log1p(-np.minimum(Q, BELOW_ONE))


def checked_lengths(patch: Patch, x: Array, s: Array) -> None:
    """Raise WrongInput where half-sides or coordinates are beyond `LENGTHS`."""
    least, most = min(patch.a, patch.b), max(patch.a, patch.b)
    furthest = max(float(np.max(np.abs(coordinates), initial=0.0)) for coordinates in (x, s))
    if least < LENGTHS[0] or max(most, furthest) > LENGTHS[1]:
        raise WrongInput(
            f"lengths from {least:g} to {max(most, furthest):g} mm: only {LENGTHS[0]:g} ... {LENGTHS[1]:g} "
            "mm can be computed; choose other units (any consistent units may replace mm and MPa)"
        )


# --- scattered observers ---


def over_rectangle(patch: Patch, x: Array, s: Array) -> Array:
    """Integrals I_xx, I_ss, I_xs, J_x, J_s [mm] over the patch, shape (5, *x.shape).

    The integrands are X^2/R^3, S^2/R^3, X S/R^3, X/R^2, S/R^2; the integral of 1/R is I_xx + I_ss.
    x, s [mm], of one shape: observer minus patch centre.
    """
    out = np.empty((5, x.size))
    flat_x, flat_s = x.ravel(), s.ravel()
    for start in range(0, x.size, IN_CACHE):
        part = slice(start, start + IN_CACHE)
        _quadrant(out[:, part], patch, np.abs(flat_x[part]), np.abs(flat_s[part]))
    return with_signs(out.reshape(5, *x.shape), x, s)


def with_signs(integrals: Array, x: Array, s: Array) -> Array:
    """The integrals at (x, s) of any sign, from those at (|x|, |s|), (5, ...) [mm]; changes its argument."""
    sign_x, sign_s = np.sign(x), np.sign(s)
    integrals[XS] *= sign_x * sign_s
    integrals[JX] *= sign_x
    integrals[JS] *= sign_s
    return integrals


def _quadrant(out: Array, patch: Patch, x: Array, s: Array) -> None:
    """Write the integrals for observers at x, s >= 0, beside the patch in both directions or not."""
    straddles = (x < patch.a) | (s < patch.b)
    if straddles.any():
        beside = ~straddles
        part = np.empty((5, np.count_nonzero(beside)))
        fill(part, over(_beside(x[beside], patch.a), _beside(s[beside], patch.b)))
        out[:, beside] = part
        out[:, straddles] = _straddling(patch, x[straddles], s[straddles])
    else:
        fill(out, over(_beside(x, patch.a), _beside(s, patch.b)))


def _beside(x: Array, half: float) -> Interval:
    """The interval of the patch as seen by an observer beside it."""
    return Interval(x - half, x + half, np.full_like(x, 2 * half))


def _folded(x: Array, half: float) -> Interval:
    """The interval in which an odd kernel does not cancel: |x - half| ... x + half."""
    return Interval(np.abs(x - half), x + half, 2 * np.minimum(x, half))


def _parts(x: Array, half: float) -> Iterator[tuple[Interval, Array]]:
    """Intervals of an even kernel: cut at 0, both halves folded to X >= 0, with weights 1 or 0."""
    inside = x < half
    low = np.where(inside, 0.0, x - half)
    yield Interval(low, x + half, np.where(inside, x + half, 2 * half)), np.ones_like(x)
    rest = np.where(inside, half - x, half)  # weight 0: any interval
    yield Interval(np.zeros_like(x), rest, rest), inside.astype(float)


def _straddling(patch: Patch, x: Array, s: Array) -> Array:
    """The integrals for observers between the edge lines of the patch, shape (5, n)."""
    out = np.zeros((5, len(x)))
    odd_x, odd_s = _folded(x, patch.a), _folded(s, patch.b)
    out[XS] = odd_odd(over(odd_x, odd_s))
    for X, weight in _parts(x, patch.a):
        out[JS] += weight * odd_even(over(odd_s, X))
        for S, weight_s in _parts(s, patch.b):
            rect = over(X, S)
            out[XX] += weight * weight_s * even_even(rect)
            out[SS] += weight * weight_s * even_even(rect.swapped)
    for S, weight in _parts(s, patch.b):
        out[JX] += weight * odd_even(over(odd_x, S))
    return out


# --- a grid of lags ---


def over_lags(patch: Patch, n_x: int, n_s: int) -> Array:
    """The integrals of `over_rectangle` [mm] at the lags (2 a k, 2 b l) of a grid of patches, (5, n_x, n_s).

    k = 0 ... n_x - 1, l = 0 ... n_s - 1; negative lags by parity. Each corner is evaluated once.
    """
    X, S = _edges(patch.a, n_x), _edges(patch.b, n_s)
    out = np.empty((5, n_x, n_s))
    rows = max(1, IN_CACHE // n_s)
    for start in range(0, n_x, rows):
        block = slice(start, min(start + rows, n_x))
        fill(out[:, block], _grid(X[block], S))
    # the middle row and column: only half of the patch has been integrated
    for row, (factor_x, factor_s) in enumerate([(2, 2), (2, 2), (0, 0), (0, 2), (2, 0)]):
        out[row, 0] *= factor_x
        out[row, :, 0] *= factor_s
    return out


def _edges(half: float, n: int) -> Interval:
    """Intervals of the patches at lags 0 ... n - 1 along one axis; of the first only the half X > 0."""
    high = half * (2 * np.arange(n, dtype=np.float64) + 1)
    length = np.full_like(high, 2 * half)
    length[0] = half
    return Interval(np.append(0.0, high[:-1]), high, length)


def _grid(X: Interval, S: Interval) -> Rectangle:
    """Adjoining rectangles, for which each distance is evaluated once."""
    x, s = np.append(X.low[0], X.high)[:, None], np.append(S.low[0], S.high)
    R = np.sqrt(x * x + s * s)
    return rectangle(X[:, None], S, (R[:-1, :-1], R[:-1, 1:], R[1:, :-1], R[1:, 1:]))


# --- the hat of bilinear elements ---

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
            out[:, observers] = _average(patch, window_x, window_s)
    return with_signs(out.reshape(5, *x.shape), x, s)


def over_hat_lags(patch: Patch, n_x: int, n_s: int) -> Array:
    """The integrals of `over_hat` [mm] at the lags (2 a k, 2 b l) of a grid, shape (5, n_x, n_s).

    k = 0 ... n_x - 1, l = 0 ... n_s - 1.
    """
    x, s = 2 * patch.a * np.arange(n_x, dtype=float), 2 * patch.b * np.arange(n_s, dtype=float)
    return over_hat(patch, *np.broadcast_arrays(x[:, None], s))


def _average(patch: Patch, window_x: Nodes, window_s: Nodes) -> Array:
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
