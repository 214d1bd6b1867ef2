"""B, B-bar, B-hat: half-space ICs turned by the orientation difference of two elements.

alpha = delta(s_I) - delta(s_J) is the inclination of the observer minus that of the load, the same
for both bodies. Source: [BVSV] section 3; design section 3 corrects the printed matrix of B-bar.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation(alpha: Array) -> Array:
    """R_x(alpha) = [[1, 0, 0], [0, cos, -sin], [0, sin, cos]], shape (3, 3, *alpha.shape)."""
    zero, one = np.zeros_like(alpha), np.ones_like(alpha)
    cos, sin = np.cos(alpha), np.sin(alpha)
    return np.array([[one, zero, zero], [zero, cos, -sin], [zero, sin, cos]])


def matmul(left: Array, right: Array) -> Array:
    """Matrix product over the first two axes."""
    return np.einsum("ik...,kj...->ij...", left, right)


def load_rotated(a: Array, alpha: Array) -> Array:
    """B = A R_x(alpha): the load is turned into the observer's frame."""
    return matmul(a, rotation(alpha))


def observer_rotated(a: Array, alpha: Array) -> Array:
    """B-bar = R_x(alpha) A: the displacement is turned."""
    return matmul(rotation(alpha), a)


def split_rotation(a: Array, alpha: Array) -> Array:
    """B-hat = R_x(alpha/2) A R_x(alpha/2): half each; keeps reciprocity."""
    half = rotation(alpha / 2)
    return matmul(matmul(half, a), half)
