"""What both Newton methods share: pressures and tractions together (`coupled`), and tractions (`coulomb`)."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from geometries.arrays import Array

LOOSEST = 0.1  # relative residual of the linear equations
MOST_VECTORS = 80  # of GMRES
SINGULAR = 1e-8  # share of the largest singular value below which amplitudes change no force


def correction(
    residual: Array,
    derivative: Callable[[Array], Array],
    inverse: Callable[[Array], Array],
    relative_residual: float,
) -> Array:
    """Return the change (n,) of the unknowns that takes a residual (n,) away, by preconditioned GMRES.

    `derivative` returns the change of residuals, `inverse` approximately the change of unknowns.
    """
    size = (len(residual),) * 2
    solution, _ = gmres(
        LinearOperator(size, matvec=derivative, dtype=float),
        -residual,
        rtol=relative_residual,
        restart=MOST_VECTORS,
        maxiter=1,
        M=LinearOperator(size, matvec=inverse, dtype=float),
    )
    return np.asarray(solution, dtype=float)


def inverse_of_amplitudes(forces: Sequence[Array]) -> Array:
    """Return the inverse (k, k) of how amplitudes change forces, where they do.

    `forces` (k,) are those of the tractions that undo the residuals of a unit amplitude, amplitude by
    amplitude.
    """
    k = len(forces)
    return np.asarray(np.linalg.pinv(-np.reshape(forces, (k, k)).T, rcond=SINGULAR), dtype=float)


def idle(errors: Sequence[float], steps: int) -> bool:
    """Return whether the last errors, as many as `steps`, are all larger than one before."""
    before, last = errors[:-steps], errors[-steps:]
    return bool(before) and min(last) > min(before)
