"""The only module that loads the optional sparse direct solver, MKL's PARDISO (extra `direct`)."""

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
import scipy

from geometries.arrays import Array

SYMMETRIC_POSITIVE_DEFINITE = 2


def available() -> bool:
    """Whether pypardiso is installed."""
    return find_spec("pypardiso") is not None


def factor(upper_triangle: "scipy.sparse.csr_matrix") -> Callable[[Array], Array]:
    """Factor a symmetric positive definite matrix; the result takes a right-hand side to its solution."""
    import pypardiso

    solver = pypardiso.PyPardisoSolver(mtype=SYMMETRIC_POSITIVE_DEFINITE)
    solver.factorize(upper_triangle)

    def solve(right_hand_side: Array) -> Array:
        return np.asarray(solver.solve(upper_triangle, right_hand_side))

    return solve
