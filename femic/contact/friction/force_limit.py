"""Whether friction can supply prescribed forces.

With bounds g of tractions |p|, weighted sums W p reach the forces f if and only if c f <= sum g |c W| for all
c. The least of sum g |c W| with c f = 1 is the factor by which all the forces may grow. It is found by least
squares with weights g / |c W| (Weiszfeld 1937, Tohoku Mathematical Journal 43, 355-386); each c on the way
gives a factor that is not too small.
"""

import numpy as np

from geometries.arrays import Array
from geometries.errors import Failure

STEPS = 50
SMALLEST = 1e-9  # of |c W|, and of eigenvalues, as shares of the largest


class ForcesBeyondFriction(Failure):
    """Prescribed forces that no tractions within the bounds of friction supply."""


def require_attainable(weights: Array, bound: Array, targets: Array) -> None:
    """Raise ForcesBeyondFriction where no tractions within bounds (n_x, n_s) supply forces `targets` (k,).

    The forces are the sums of weights (k, n_x, n_s, 2) times tractions.
    """
    factor = attainable_factor(weights, bound, targets)
    if factor <= 1:
        raise ForcesBeyondFriction(
            "prescribed forces exceed what friction can supply: together they may be no more than "
            f"{factor:.4g} times as large; use smaller forces, a larger load, or more friction"
        )


def attainable_factor(weights: Array, bound: Array, targets: Array) -> float:
    """Return the factor by which forces may grow; infinite for none, 0 where there are no tractions."""
    loaded = bound > 0
    largest = np.sum(bound * np.linalg.norm(weights, axis=-1), axis=(1, 2))
    if not np.all(largest > 0):
        return 0.0
    if not np.any(targets):
        return np.inf
    contributions = (
        np.moveaxis(weights[:, loaded], 0, -1) / largest
    )  # (m, 2, k), of forces as shares of their largest
    shares, g = targets / largest, bound[loaded]
    c, least = shares / (shares @ shares), np.inf
    for _ in range(STEPS):
        size = np.linalg.norm(contributions @ c, axis=1)
        least = min(least, float(g @ size))
        each = g / np.maximum(size, max(SMALLEST * float(np.max(size)), 1e-300))
        matrix = np.einsum("e,eik,eil->kl", each, contributions, contributions)
        matrix += SMALLEST * np.trace(matrix) * np.eye(len(c))
        c = np.linalg.solve(matrix, shares)
        c /= shares @ c
    return least
