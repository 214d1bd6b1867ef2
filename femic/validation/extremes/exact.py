"""ICs of a half-space and rotations in many digits, by separate formulas: corner sums, matrix products."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any, TypeAlias

import mpmath

from geometries.materials import Material
from geometries.patches import Patch

Number: TypeAlias = Any  # a number of mpmath, which has no types

DIGITS = 300  # corner sums lose r^2 / (a b), 1e20 * 1e12, and near each of both axes 1e-60


def many_digits() -> AbstractContextManager[Any]:
    """Return a context in which mpmath computes with `DIGITS` digits."""
    return mpmath.workdps(DIGITS)


def integrals(patch: Patch, x: float, s: float) -> list[Number]:
    """Return I_xx, I_ss, I_xs, J_x, J_s [mm], integrals over a patch at (x, s) [mm], as sums over corners.

    Those that vanish by symmetry are exactly 0.
    """
    with many_digits():
        a, b, at_x, at_s = (mpmath.mpf(float(v)) for v in (patch.a, patch.b, x, s))
        total = [mpmath.mpf(0)] * 5
        for i, j in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            corner_terms = _at_corner(at_x + i * a, at_s + j * b)
            total = [t + i * j * v for t, v in zip(total, corner_terms, strict=True)]
    vanishes = (False, False, x == 0 or s == 0, x == 0, s == 0)
    return [mpmath.mpf(0) if zero else v for zero, v in zip(vanishes, total, strict=True)]


def _at_corner(X: Number, S: Number) -> list[Number]:
    R = mpmath.sqrt(X * X + S * S)
    log = mpmath.log(R) if R else mpmath.mpf(0)
    return [
        S * mpmath.asinh(X / abs(S)) if S else mpmath.mpf(0),
        X * mpmath.asinh(S / abs(X)) if X else mpmath.mpf(0),
        -R,
        S * log + (X * mpmath.atan(S / X) if X else 0),
        X * log + (S * mpmath.atan(X / S) if S else 0),
    ]


def one_body(material: Material, side: int, integral_values: Sequence[Number]) -> list[list[Number]]:
    """Return A of one body [mm/MPa], 3 x 3, from the integrals [mm]."""
    with many_digits():
        E, nu = mpmath.mpf(material.E), mpmath.mpf(material.nu)
        scale = (1 + nu) / (mpmath.pi * E)  # 1 / (2 pi G)
        I_xx, I_ss, I_xs, J_x, J_s = integral_values
        nn = scale * (1 - nu) * (I_xx + I_ss)
        xn, sn = (-scale * side * (1 - 2 * nu) / 2 * J for J in (J_x, J_s))
        xs = scale * nu * I_xs
        return [[nn + scale * nu * I_xx, xs, xn], [xs, nn + scale * nu * I_ss, sn], [-xn, -sn, nn]]


def rotation(delta_i: float, delta_j: float, theta: float, side: int) -> Number:
    """Return the rotation T = R_x(delta_I) R_y(side theta) R_x(-delta_J), a 3 x 3 matrix; angles in rad."""
    with many_digits():
        return _about_x(delta_i) * _about_y(side * mpmath.mpf(theta)) * _about_x(-delta_j)


def _about_x(angle: float) -> Number:
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    return mpmath.matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


def _about_y(angle: Number) -> Number:
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    return mpmath.matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
