"""Gauss-Legendre rules on panels."""

from functools import lru_cache

import numpy as np

from geometries.arrays import Array


@lru_cache
def gauss(n: int) -> tuple[Array, Array]:
    """Return nodes and weights of the n-point rule on -1 ... 1, shape (n,) each."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return nodes, weights


def on_panels(start: Array, end: Array, n: int) -> tuple[Array, Array]:
    """Return nodes and weights of the n-point rule on the panels start ... end, shape (..., n) each."""
    nodes, weights = gauss(n)
    half = (end - start)[..., None] / 2
    return start[..., None] + half * (1 + nodes), half * weights
