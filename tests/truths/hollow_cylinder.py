"""Influence coefficients of a thick-walled cylinder in plane strain, loaded inside, clamped outside.

The cavity is the contact surface of an upper body, s = 0 at its top: the local normal n points
into the material, radially outward; delta = s / r_i is the angle of a point, tractions are positive
along s and n. u = 0 at r_o.

The displacement of angular order m is u_n = U(r) cos(m delta), u_s = V(r) sin(m delta), or a
quarter of a wave further, u_n = -U sin, u_s = V cos. Its compliance at r_i approaches that of a
cavity in infinite space like (r_i / r_o)^2m: the cavity is summed in closed form, the rest order by
order. In the functions of one order and of the cavity r_i = 2 G = 1; kappa = 3 - 4 nu.
Michell (1899); table of Barber, Elasticity, chapter 9.
"""

import numpy as np


def pressure(material, r_i, r_o):
    """u_n at r_i due to unit traction along n everywhere [mm/MPa]; Lame."""
    c = 1 - 2 * material.nu
    return r_i * c * (r_o**2 - r_i**2) / (2 * material.G * (r_i**2 + c * r_o**2))


def twist(material, r_i, r_o):
    """u_s at r_i due to unit traction along s everywhere [mm/MPa]."""
    return r_i * (1 - (r_i / r_o) ** 2) / (2 * material.G)


def line_load_ics(material, r_i, r_o, b, s):
    """Displacement i at s due to unit force per length j, along s, n [mm/(N/mm)], shape (2, 2, n).

    The force is spread evenly over |s'| <= b and turns with the surface.
    """
    delta, beta, kappa = np.asarray(s) / r_i, b / r_i, 3 - 4 * material.nu
    orders = np.arange(1, 5 + int(25 / np.log(r_o / r_i)))
    rest = np.stack([compliance(m, kappa, r_o / r_i) for m in orders], axis=-1)
    rest[..., 1:] -= cavity_compliance(orders[1:], kappa)
    rest *= np.sinc(orders * beta / np.pi)  # the strip: 1/(2 pi r_i) (1 + 2 sum of sinc cos(m delta))
    waves = np.multiply.outer(orders, delta)
    cos, sin = rest @ np.cos(waves), rest @ np.sin(waves)
    nn, sn = cavity(kappa, delta, beta)
    ics = np.array([[nn + cos[1, 1], sn + sin[1, 0]], [-sn - sin[0, 1], nn + cos[0, 0]]])
    uniform = np.diag([twist(material, r_i, r_o), pressure(material, r_i, r_o)]) / (2 * np.pi * r_i)
    return ics / (2 * np.pi * material.G) + uniform[..., None]


# --- one order -------------------------------------------------------------------------------------


def compliance(m, kappa, r_o):
    """U, V (rows) at r = 1 due to the tractions T_n cos(m delta), T_s sin(m delta) (columns), m > 0."""
    return solutions(m, kappa, 1.0, r_o)[:2] @ amplitudes(m, kappa, r_o)


def amplitudes(m, kappa, r_o):
    """Parts of the four solutions in the response to T_n and to T_s (columns), shape (4, 2)."""
    clamped, traction = solutions(m, kappa, r_o, r_o)[:2], -solutions(m, kappa, 1.0, r_o)[2:]
    return np.linalg.solve(np.concatenate([clamped, traction]), np.eye(4)[:, 2:])


def solutions(m, kappa, r, r_o):
    """U, V, sigma_rr, sigma_rs (rows) at r of the solutions r^(m-1), r^(m+1), r^(-m-1), r^(1-m)."""
    growing, decaying = r / r_o, 1 / r
    sizes = np.array([growing ** (m - 1), growing ** (m + 1), decaying ** (m + 1), decaying ** (m - 1)])
    rows = [
        [-m, kappa - m - 1, m, kappa + m - 1],
        [m, kappa + m + 1, m, m - 1 - kappa],
        [-m * (m - 1), -(m + 1) * (m - 2), -m * (m + 1), -(m + 2) * (m - 1)],
        [m * (m - 1), m * (m + 1), -m * (m + 1), -m * (m - 1)],
    ]
    if m == 1:  # the last solution is a translation like the first: the one with a net force instead
        log = 2 * kappa * np.log(r)
        for row, entry in zip(rows, (log - 1, -log - 1, kappa + 3, 1 - kappa), strict=True):
            row[3] = entry
    return np.array(rows) * sizes / np.array([[1], [1], [r], [r]])


# --- cavity in infinite space ----------------------------------------------------------------------


def cavity_compliance(m, kappa):
    """The compliance as r_o grows, m > 1."""
    near, far = kappa / (m - 1), 1 / (m + 1)
    return np.array([[far + near, far - near], [far - near, far + near]]) / 2


def cavity(kappa, delta, beta):
    """Sums over m > 1 of the cavity's cos(m delta) (nn and ss) and sin(m delta) (sn and -ns) of a strip.

    Their integrals over delta are periodic and continuous, so the mean over the strip is a difference.
    """
    ends = [integrals(kappa, np.asarray(delta) + end) for end in (beta, -beta)]
    return (ends[0] - ends[1]) / (2 * beta) / 2


def integrals(kappa, delta):
    """Integrals from 0 to delta of twice the sums of a point load.

    These are (kappa - 1) sin F - (kappa + 1)/2 cos L - 1 - cos/2 and
    (kappa - 1) cos F + (kappa + 1)/2 sin L - sin/2, F = (delta - pi sgn)/2, L = ln(2 - 2 cos).
    """
    delta = delta - 2 * np.pi * np.round(delta / (2 * np.pi))
    versine, sgn, cos, sin = 2 * np.sin(delta / 2) ** 2, np.sign(delta), np.cos(delta), np.sin(delta)
    F, L = (delta - np.pi * sgn) / 2, np.log(2 * np.where(versine > 0, versine, 1))
    sin_F = (sin - delta * cos - np.pi * sgn * versine) / 2
    cos_F = sin * F - versine / 2
    cos_L = sin * L - delta - sin
    sin_L = versine * (L - 1)
    even = (kappa - 1) * sin_F - (kappa + 1) / 2 * cos_L - delta - sin / 2
    odd = (kappa - 1) * cos_F + (kappa + 1) / 2 * sin_L - versine / 2
    return np.array([even, odd])
