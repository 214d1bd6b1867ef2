"""Even and odd: how a load at x = 0 halves the body, and what the other half does.

Under a load in direction j the displacement component j is even in x and the other components
follow from the mirror image: the component along the mirrored axis changes its sign once more. The
same holds across y = 0 where section and patch are their own mirror image.
"""

import numpy as np
from numpy.typing import NDArray

from geometries.bodies import PrismaticBody
from geometries.patches import Patch

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

X, S, N = range(3)  # directions; in global axes x, y, z


def parity(direction: int, mirrored: int) -> Array:
    """+1 for components even in the mirrored coordinate under a load in `direction`, else -1."""
    flips = np.where(np.arange(3) == mirrored, -1.0, 1.0)
    return flips * flips[direction]


def quarter_suffices(body: PrismaticBody, patch: Patch) -> bool:
    """Whether section and patch are symmetric in y, so that y >= 0 is enough."""
    return patch.s == 0 and body.contour.symmetric


def held_by_symmetry(nodes: Array, direction: int, *, half_section: bool) -> Mask:
    """Components (n_nodes, 3) that vanish on the planes of symmetry, where they are odd."""
    held = np.zeros((nodes.shape[1], 3), dtype=bool)
    tolerance = 1e-9 * np.ptp(nodes, axis=1).max()
    for mirrored in (X, S) if half_section else (X,):
        on_plane = np.abs(nodes[mirrored]) < tolerance
        held |= on_plane[:, None] & (parity(direction, mirrored) < 0)
    return held
