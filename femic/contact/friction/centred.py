"""Slip at the centres of elements, from that which is known half way between them and the next ones ahead.

Friction opposes the slip at an element, while s is known ahead of it, and s' behind it, both to the second
order. Their mean is that of the element. But where s vanishes the element has to stick, and the law must have
a solution on any grid: so the slip of an element,

    s + w (s' - s) / 2,   w = 4 max(0, s . s') / (|s| + |s'|)^2,

vanishes only with s, changes continuously, and is the mean up to errors of the second order where slip is
smooth. (With the plain mean the law has no solution on one of ten coarse grids.)
"""

from collections.abc import Callable

import numpy as np

from geometries.arrays import Array

Linear = Callable[[Array], Array]

TINY = 1e-150


def centred(slip: Array) -> Array:
    """Slip at the centres of elements, shape (n_x, n_s, 2)."""
    behind, weight = _behind(slip), _weights(slip)[0]
    return np.asarray(slip + weight / 2 * (behind - slip))


def centred_derivative(slip: Array) -> Linear:
    """Return the derivative of it at a slip: a linear function of changes of this, shape (n_x, n_s, 2)."""
    step = (_behind(slip) - slip) / 2
    weight, of_ahead, of_behind = _weights(slip)
    half, rest = weight / 2, 1 - weight / 2

    def of_change(change: Array) -> Array:
        behind = _behind(change)
        change_of_weight = np.sum(of_ahead * change + of_behind * behind, axis=-1, keepdims=True)
        return np.asarray(rest * change + half * behind + change_of_weight * step)

    return of_change


def _behind(values: Array) -> Array:
    """Return the values of the elements behind; the first ones have their own."""
    return np.concatenate([values[:1], values[:-1]])


def _weights(slip: Array) -> tuple[Array, Array, Array]:
    """Return the weight w (n_x, n_s, 1), and its derivatives by s and s', (n_x, n_s, 2) each."""
    behind = _behind(slip)
    a, b = (np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), TINY) for v in (slip, behind))
    product = np.maximum(np.sum(slip * behind, axis=-1, keepdims=True), 0.0)
    square, weight = (a + b) ** 2, 4 * product / (a + b) ** 2
    of_sizes = 2 * weight / (a + b)
    of_product = np.where(product > 0, 4 / square, 0.0)
    return weight, of_product * behind - of_sizes * slip / a, of_product * slip - of_sizes * behind / b
