"""The points below a contact at which stresses are computed: a lattice in x, s and depth."""

from dataclasses import dataclass

import numpy as np

from compare.stresses.contacts import Contacts
from femic.stresses.points import InnerPoints, require_inside
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput
from geometries.patches import N

ALONG_X, ALONG_S, INTO_DEPTH = 17, 25, 13  # points
WIDER, LONGER, DEEPER = 1.5, 1.3, 2.0  # over the width, the length and the half-width of the patch
GRADING = 1.5  # power of depths: closer together near the surface
SHRINKING, MOST_SHRINKINGS = 0.9, 40  # of the depth, until all normals stay inside the body


@dataclass(frozen=True, eq=False)
class Lattice:
    """Points at x (n_x,), arc lengths s (n_s,) of the lower contour, and depths (n_d,) in a body [mm].

    `offset` [mm] is added to s on the body's own contour.
    """

    x: Array
    s: Array
    depth: Array
    offset: float

    @property
    def points(self) -> InnerPoints:
        """The points on the body's own contour, shape (n_x, n_s, n_d)."""
        return InnerPoints(self.x[:, None, None], self.s[:, None] + self.offset, self.depth)


def lattice_below(contacts: Contacts, body: str) -> Lattice:
    """Return the lattice below the contacts with all ICs in a body.

    s goes over 1.5 widths of the patch, as far as both contours go; x over 1.3 lengths, and has 0; depths go
    to two half-widths, or where that is less as far as the normals stay inside the body.
    """
    half_length, (low, high) = _patch(contacts)
    half_width, middle = (high - low) / 2, (low + high) / 2
    first, last = contacts.problem.extent
    s = np.linspace(max(first, middle - WIDER * half_width), min(last, middle + WIDER * half_width), ALONG_S)
    x = LONGER * half_length * np.linspace(-1, 1, ALONG_X)
    offset, of_body = contacts.offset(body), contacts.problem.bodies[body]
    s = np.clip(s, of_body.s_range[0] - offset, of_body.s_range[1] - offset)
    deepest = _deepest(of_body, s + offset, DEEPER * min(half_width, half_length))
    return Lattice(x, s, deepest * np.linspace(0, 1, INTO_DEPTH) ** GRADING, offset)


def _patch(contacts: Contacts) -> tuple[float, tuple[float, float]]:
    """Half-length about x = 0 and ends along s of the contacts with all ICs [mm]."""
    pressed = np.any([p[..., N] > 0 for p in contacts.tractions.values()], axis=0)
    x, s, grid = contacts.on_grid.x, contacts.grid.strips, contacts.grid
    half_length = float(np.max(np.abs(x[pressed.any(axis=1)]))) + grid.dx / 2
    strips = s[pressed.any(axis=0)]
    return half_length, (float(strips[0]) - grid.ds / 2, float(strips[-1]) + grid.ds / 2)


def _deepest(body: Body, s: Array, depth: float) -> float:
    """The largest depth [mm] up to `depth` at which all points below s are inside the body."""
    for _ in range(MOST_SHRINKINGS):
        try:
            require_inside(body, InnerPoints(np.zeros_like(s), s, np.full_like(s, depth)))
        except WrongInput:
            depth *= SHRINKING
        else:
            return depth
    raise Failure("the body is too thin below the contact for stresses inside it")
