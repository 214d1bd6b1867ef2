"""What proves a solution of the equations of a section at a wavenumber."""

import numpy as np
from scipy.sparse import spmatrix
from scipy.sparse.linalg import norm

from femic.reference.accuracy import NotConverged
from geometries.arrays import Array

# A tenth of the tightest tolerance. The relative error of the displacements is a quarter of the residual or
# less (measured by a step of iterative refinement). Rounding leaves residuals of 1e-14 at large k, and of
# 5e-12 at k = 0 and nu = 0.28. They grow in proportion to 1 / (1 - 2 nu): 3e-9 at nu = 0.4999, and there 1e-7
# under a patch of aspect 0.01 (144 000 unknowns).
LARGEST_RESIDUAL = 1e-5


def column_weights(forces: spmatrix) -> Array:
    """Weights of the columns of forces (unknowns, n) in a sum that proves all their solutions, shape (n,).

    Each column is divided by its norm, which keeps large columns from hiding small ones, and multiplied by a
    repeatable random number of size 1 to 2 and either sign, which keeps two columns from cancelling.
    """
    generator = np.random.default_rng(0)
    n = forces.shape[1]
    factors = generator.uniform(1.0, 2.0, n) * generator.choice([-1.0, 1.0], n)
    return np.asarray(factors / norm(forces, axis=0))


def require_small(residual: float, k: float, unknowns: int) -> None:
    """Raise NotConverged where the residual at a wavenumber [1/mm] is too large, or no number."""
    if not residual <= LARGEST_RESIDUAL:
        raise not_solved(
            k, unknowns, f"the residual is {residual:.1e} of the forces, {LARGEST_RESIDUAL:.0e} allowed"
        )


def not_solved(k: float, unknowns: int, reason: str) -> NotConverged:
    """The error at a wavenumber [1/mm]."""
    return NotConverged(
        f"section at the wavenumber k = {k:.4g} 1/mm, {unknowns:,} unknowns: not solved: {reason}. Likely "
        "cause: a Poisson's ratio too close to 0.5, cells that are strongly distorted or of very different "
        "sizes, or moduli or lengths beyond what numbers can hold. Try a smaller nu, a smaller "
        "`growth`, or lengths and moduli of usual size"
    )
