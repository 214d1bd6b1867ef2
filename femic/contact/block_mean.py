"""Values on elements twice as large."""

import numpy as np

from geometries.arrays import Array


def block_mean(values: Array) -> Array:
    """Means over four neighbours, shape (n_x / 2, n_s / 2, ...)."""
    n_x, n_s, *others = values.shape
    return np.asarray(values.reshape(n_x // 2, 2, n_s // 2, 2, *others).mean(axis=(1, 3)))
