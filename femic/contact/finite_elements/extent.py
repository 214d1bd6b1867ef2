"""The edges of a patch, interpolated between the vertices at which gaps are known.

Beyond the edge of smooth bodies the gap grows as distance^(3/2) at first, so gap^(2/3) is smooth, and
vanishes at the edge. Near an end of the patch it is fitted by c0 + c1 x + c2 x^2 + c3 y^2 (+ c4 y where
nothing is symmetric), x along, y across: that is a linear function with its first corrections, for the gap
farther out and for the curvature of the edge. Where the surface ends close beyond the patch there are too
few vertices for c2: it is left out, and no vertices are skipped. (Squared pressures do as well for Hertz's
contact, and are worse in conformal ones, where they rise steeply from the edge.)
"""

import numpy as np

from geometries.arrays import Array
from geometries.errors import Failure

# The region of the fit, in spacings of vertices, from the outermost one in contact
DEPTH, WIDTH = 5.0, 2.5
LEAST_WIDTH = 0.2  # of the same region, as a share of the half-width of the patch
SKIPPED = 0.5  # spacings that are left out: weighted gaps of vertices there belong in part to the patch
SHORT = 2.5  # spacings to the end of the surface, within which the fit is linear in x, of all vertices
FEWEST, LEAST_DEPTH = 5, 0.4  # vertices of a fit; spacings between the first and the last of them
FARTHEST = 2.0  # spacings between the edge and the outermost vertex in contact


def end(along: Array, across: Array, gap: Array, spacing: float, *, symmetric: bool) -> float:
    """Return the largest coordinate `along` [mm] of the patch, from gaps [mm] at vertices, (n,) each.

    Gaps are 0 in contact; `spacing` [mm] is that of the vertices. `symmetric`: about across = 0. Raises
    Failure where vertices are too few or gaps tell no edge.
    """
    touching = gap <= 0
    last = float(along[touching].max())
    middle = 0.0 if symmetric else float(across[touching][np.argmax(along[touching])])
    width = max(WIDTH * spacing, LEAST_WIDTH * float(np.ptp(across[touching])))
    x, y = (along - last) / spacing, (across - middle) / spacing
    beyond = ~touching & (x > 0) & (x < DEPTH) & (np.abs(y) <= width / spacing)
    short = float(x[beyond].max(initial=0)) < SHORT
    near = beyond & (x > (0.0 if short else SKIPPED))
    if np.count_nonzero(near) < FEWEST or np.ptp(x[near]) < LEAST_DEPTH:
        raise Failure(
            f"edge of the patch: {np.count_nonzero(near)} vertices near it, side by side or less than "
            f"{FEWEST}; more cells, or a smaller load where the patch reaches the end of a contour"
        )
    x, y = x[near], y[near]
    of_square = np.zeros_like(x) if short else x**2
    terms = np.stack([np.ones_like(x), x, of_square, y**2, *([] if symmetric else [y])], axis=1)
    fit = np.asarray(np.linalg.lstsq(terms, gap[near] ** (2 / 3))[0], dtype=float)
    return last + spacing * _edge(fit, width / spacing)


def _edge(fit: Array, width: float) -> float:
    """Return the x nearest to 0 at which a fit vanishes, at the y, |y| <= width, where it is farthest."""
    y = np.clip(-fit[4] / (2 * fit[3]), -width, width) if len(fit) > 4 else 0.0
    constant = fit[0] + fit[3] * y**2 + (fit[4] * y if len(fit) > 4 else 0.0)
    roots = np.roots([fit[2], fit[1], constant])
    edges = [float(root.real) for root in roots if root.imag == 0 and abs(root) < FARTHEST]
    if not edges:
        raise Failure("edge of the patch: gaps do not fall to 0 there; more cells, or a smaller load")
    return min(edges, key=abs)
