"""Influence coefficients of a solid elastic sphere with a free surface, by spherical harmonics.

A net force or torque cannot be balanced on a free sphere. The tractions of degree 1 of the load are
therefore left out, that is, balanced by their negatives, which are spread over the whole surface as
e, (e.r) r and e x r. The displacement has no part of degree 1 either: that fixes the rigid motion.

On the unit sphere with G = 1, mu the cosine of the angle between observer r and load r', a unit
point force moves the surface by u,

    4 pi u = sum over n = 0, 2, 3, ... of C_rr P_n(mu) r r' + C_tr (grad P_n r' + r grad' P_n)
             + C_tt grad grad' P_n + C_ww (r x grad)(r' x grad') P_n.

The C come from the compliance of degree n: with Y a harmonic of that degree, the traction
T_r Y r + T_t grad Y moves the surface by U Y r + V grad Y. They are rational in n. Their expansion
in 1, 1/(n + 1), 1/((n + 1)(n + 2)), ... is summed in closed form, the rest falls like n^-9 and is
summed term by term. Relative to the leading term 1/angle the sums are good to 1e-10, and next to the
load to rounding, 1e-17 / angle^2. Love (1944) sections 172 to 180; Lur'e (1964) chapter 8.
"""

from math import factorial

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import solve_triangular

DEGREES = 200  # of the rest
TERMS = 8  # of the expansion for large n


def sphere_ics(material, radius, side, patch, x, s, *, nodes=12):  # noqa: PLR0917
    """Displacement i at (x, s) due to a unit total load j, along x, s, n [mm/N], shape (3, 3, n).

    Side -1: a ball below its contact point, n outward; side +1: above, n inward. s is the arc length
    along a meridian, x the longitude times the mean radius of the parallel circles of observer and
    patch centre. The load is uniform over the patch and turns with the surface. Off the patch, twelve
    nodes are good to 1e-7 where the gap is a third of the longer side 2 a or 2 b, to 1e-12 at two thirds.
    """
    at, weights = np.polynomial.legendre.leggauss(nodes)
    lat = (patch.s + patch.b * at) / radius
    loads = frames(patch.a * at[:, None] / (radius * np.cos(lat)), lat)
    lat = np.asarray(s) / radius
    lon = np.asarray(x) / (radius * (np.cos(lat) + np.cos(patch.s / radius)) / 2)
    u = green(material, radius, frames(lon, lat)[:, None, None], loads)
    mirror = np.array([1, 1, -side])  # a ball above is the mirror image of one below
    return np.einsum("pklij,k,l,i,j->ijp", u, weights / 2, weights / 2, mirror, mirror)


def frames(lon, lat):
    """Directions x (east), s (north), r (outward) as rows, in global x, y, z; shape (..., 3, 3)."""
    lon, lat = np.broadcast_arrays(lon, lat)
    c, d, e, f = np.cos(lon), np.sin(lon), np.cos(lat), np.sin(lat)
    rows = [[c, 0 * c, -d], [-f * d, e, -f * c], [e * d, f, e * c]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def green(material, radius, observers, loads, *, degrees=DEGREES, terms=TERMS):
    """Displacement i due to a unit point force j, along x, s, r of either [mm/N], shape (..., 3, 3).

    Observers and loads: frames, whose leading axes broadcast.
    """
    M = observers @ np.swapaxes(loads, -1, -2)  # cosines between the directions of both
    chord = np.linalg.norm(observers[..., 2, :] - loads[..., 2, :], axis=-1)
    f, df, ddf = sums(chord, material.nu, degrees, terms)[..., None, None]
    mu, to_load, to_observer = M[..., 2:, 2:], M[..., :2, 2:], M[..., 2:, :2]  # grad mu, grad' mu
    turn = np.array([[0, -1], [1, 0]])  # r x: from x, s to s, -x
    tangential = (
        ddf[2] * to_load * to_observer
        + df[2] * M[..., :2, :2]
        + ddf[3] * (turn @ to_load) * (to_observer @ turn.T)
        + df[3] * (mu * M[..., :2, :2] - to_load * to_observer)
    )
    u = np.block([[tangential, df[1] * to_load], [df[1] * to_observer, f[0]]])
    return u / (4 * np.pi * material.G * radius)


# --- sums over the degrees -------------------------------------------------------------------------


def sums(chord, nu, degrees, terms):
    """Sums of C P_n(mu), C = C_rr, C_tr, C_tt, C_ww, with d/dmu, d2/dmu2: shape (3, 4, *chord.shape)."""
    n = np.arange(degrees)
    exact = np.zeros((4, degrees))
    exact[0, 0] = swelling(nu)
    exact[:, 2:] = coefficients(n[2:], nu)
    weights = expansion(nu, terms)
    rest = exact - weights @ inverse_factorials(n, terms)
    by_term = [legendre.legval(1 - chord**2 / 2, legendre.legder(rest.T, m)) for m in range(3)]
    return np.einsum("ck,mk...->mc...", weights, closed_sums(chord, terms)) + np.stack(by_term)


def inverse_factorials(n, terms):
    """1, 1/(n + 1), 1/((n + 1)(n + 2)), ... shape (terms + 1, *n.shape)."""
    return np.cumprod([1 + 0 * n, *(1 / (n + k) for k in range(1, terms + 1))], axis=0)


def expansion(nu, terms):
    """Weights of the inverse factorials in the coefficients for large n, shape (4, terms + 1).

    The power series in h = 1/n of both, by Cauchy's integral: the poles are at |h| > 0.8, 1 / terms.
    """
    h = np.exp(2j * np.pi * np.arange(64) / 64) / (2 * terms)
    powers = h ** -np.arange(terms + 1)[:, None] / len(h)
    of_sums, of_terms = (
        np.real(f @ powers.T) for f in (coefficients(1 / h, nu), inverse_factorials(1 / h, terms))
    )
    return solve_triangular(of_terms, of_sums.T, trans="T").T


def closed_sums(c, terms):
    """Sums over all n of the inverse factorials times P_n, with d/dmu, d2/dmu2.

    c is the chord, c^2 = 2 - 2 mu; shape (3, terms + 1, *c.shape). By the generating function of P_n
    the sum of P_n / ((n + 1) ... (n + k + 1)) is J_k / k!, where J_k is the integral of
    u^k / sqrt(Q) over 0 < u < 1, Q = u^2 - c^2 u + c^2; the recursion is that of d(u^(k-1) sqrt(Q)).
    """
    one = np.stack([1 / c, c**-3, 3 * c**-5])
    J_0 = np.stack([np.log1p(2 / c), 2 / (c**2 * (c + 2)), 2 * (3 * c + 4) / (c**4 * (c + 2) ** 2)])
    upper_end, lower_end = np.stack([c**0, 0 * c, 0 * c]), np.stack([c, -1 / c, -(c**-3)])
    J = [J_0, upper_end - lower_end + times_c2(c, J_0) / 2]
    for k in range(2, terms):
        J.append((upper_end + (k - 0.5) * times_c2(c, J[-1]) - (k - 1) * times_c2(c, J[-2])) / k)
    return np.stack([one, *(J_k / factorial(k) for k, J_k in enumerate(J))], axis=1)


def times_c2(c, f):
    """c^2 f with its derivatives by mu from those of f, shape (3, *c.shape)."""
    return c**2 * f - np.stack([0 * c, 2 * f[0], 4 * f[1]])


# --- compliance of one degree ----------------------------------------------------------------------


def coefficients(n, nu):
    """C_rr, C_tr, C_tt, C_ww of degree n > 1, shape (4, *n.shape)."""
    (C_rr, _), (C_tr, C_tt) = compliance(n, nu)
    twist = 1 / (n - 1)
    return (2 * n + 1) * np.stack([C_rr, C_tr, C_tt / (n * (n + 1)), twist / (n * (n + 1))])


def compliance(n, nu):
    """U, V (rows) due to T_r, T_t (columns) of degree n > 1; R = G = 1."""
    U, V, T_r, T_t = regular_solutions(n, nu)
    det = T_r[0] * T_t[1] - T_r[1] * T_t[0]
    inverse = np.array([[T_t[1], -T_r[1]], [-T_t[0], T_r[0]]]) / det
    return np.einsum("ik...,kj...->ij...", np.array([U, V]), inverse)


def swelling(nu):
    """U due to T_r of degree 0: uniform tension; R = G = 1."""
    return (1 - 2 * nu) / (2 * (1 + nu))


def regular_solutions(n, nu):
    """U, V, T_r, T_t at r = 1 of grad(phi) and k r^2 grad(phi) + q phi r, phi = r^n Y, G = 1."""
    k = n + 5 - 4 * nu
    q = -2 * (3 * n + 1 - 2 * nu * (2 * n + 1))  # by Navier's equation
    pressure_like = -2 * nu * ((4 * n + 2) * k + 2 * q)  # lambda div u
    return [
        (n, k * n + q),
        (1 + 0 * n, k),
        (2 * n * (n - 1), pressure_like + 2 * (n + 1) * (k * n + q)),
        (2 * (n - 1), 2 * k * n + q),
    ]
