"""Whether C_nn is positive for the pressures that a contact may have: otherwise it has several solutions."""

import numpy as np

from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.specification import ContactProblem
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import N

SAME = 1e-6  # difference of mirrored ICs over the largest, to which they are the same


def require_positive(problem: ContactProblem, on_grid: PairOnGrid, ic: Array) -> float:
    """Return the smallest eigenvalue of C_nn (n_x, n_s, n_s) for the pressures that a contact may have.

    It is divided by the least IC of an element on itself. Where loads are given these pressures are all those
    without vertical load, by which solutions may differ; where all is symmetric they are symmetric. Raises
    Failure where the eigenvalue is not positive: then no solution is the only one, nor stable.
    """
    freed = on_grid.cosine[None] if problem.specification.loads else np.zeros((0, on_grid.grid.n_s))
    symmetric = on_grid.symmetric and np.allclose(
        ic, ic[:, ::-1, ::-1], rtol=0, atol=SAME * np.max(np.abs(ic))
    )
    eigenvalue = smallest_eigenvalue(ic, freed, symmetric=symmetric)
    if eigenvalue > 0:
        return eigenvalue
    raise Failure(
        f"C_nn on {on_grid.grid.n_x} x {on_grid.grid.n_s} elements, discount = {problem.discount!r}: its "
        f"smallest eigenvalue is {eigenvalue:.2g} of the least IC of an element on itself: some pressures"
        f"{' without vertical load' if len(freed) else ''} would do negative work. " + _remedy(problem)
    )


def _remedy(problem: ContactProblem) -> str:
    if problem.discount == "source":
        return (
            "This discount takes the bending of the sections from C, more than the bodies have at long "
            "distances; use discount = 'approach'"
        )
    return "Give a smaller engine.tolerance, or larger elements" + (
        "" if problem.specification.loads else "; or loads instead of approaches"
    )


def smallest_eigenvalue(ic: Array, freed: Array, *, symmetric: bool = False) -> float:
    """Return the smallest eigenvalue of nn ICs (n_x, n_s, n_s) over the least IC of an element on itself.

    It is that of pressures without resultant along the motions `freed` (n, n_s): a give in these is added, as
    large as the largest IC. `symmetric`: of pressures that are symmetric about the middle of the grid.
    """
    own = float(np.min(np.diagonal(ic[0])))
    give = float(np.max(np.abs(ic))) * freed.T @ freed
    constrained = _folded(ic + give) if symmetric else ic + give
    whole = (constrained + np.swapaxes(constrained, 1, 2))[..., None, None] / 2
    return GridOperator.of(whole, (N,)).smallest_eigenvalue() / own


def _folded(ic: Array) -> Array:
    """Return the same for symmetric pressures: those on the strips of one half, and of the middle one."""
    n_s = ic.shape[1]
    half = (n_s + 1) // 2
    folded = ic[:, :half, :half] + ic[:, :half, ::-1][..., :half]
    if n_s % 2:  # the middle strip is its own mirror image; its pressures count once
        folded[..., -1] /= np.sqrt(2)
        folded[:, -1] /= np.sqrt(2)
    return np.asarray(folded)
