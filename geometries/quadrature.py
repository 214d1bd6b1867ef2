"""Gauss-Legendre rules on panels."""

from functools import lru_cache

import numpy as np

from geometries.arrays import Array


@lru_cache
def gauss(n: int) -> tuple[Array, Array]:
    """Nodes and weights of n points on -1 ... 1, (n,) each."""
    at, weights = np.polynomial.legendre.leggauss(n)
    return at, weights


def on_panels(start: Array, end: Array, n: int) -> tuple[Array, Array]:
    """Nodes and weights of n points on each of some panels, (..., n) each."""
    at, weights = gauss(n)
    half = (end - start)[..., None] / 2
    return start[..., None] + half * (1 + at), half * weights
