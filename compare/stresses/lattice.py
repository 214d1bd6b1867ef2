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
SHRINKING, MOST_SHRINKINGS = 0.9, 40  # of the depth, until all normals stay inside the body and apart
LEAST_SPREAD = 0.25  # of the distance between normals at the surface: deeper they cross


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
    to two half-widths, or where that is less as far as normals stay inside the body and apart.
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
    """The largest depth [mm] up to `depth` at which points below s are inside the body, and in their order.

    Below a convex contour normals meet in the centre of curvature, and cross beyond it.
    """
    for _ in range(MOST_SHRINKINGS):
        try:
            points = InnerPoints(np.zeros_like(s), s, np.full_like(s, depth))
            require_inside(body, points)
        except WrongInput:
            depth *= SHRINKING
            continue
        if np.all(_spread(body, points) >= LEAST_SPREAD):
            return depth
        depth *= SHRINKING
    raise Failure("the body is too thin below the contact for stresses inside it")


def _spread(body: Body, points: InnerPoints) -> Array:
    """Distances of neighbours along s over those at the surface, (n - 1,); negative where normals cross."""
    middle = (points.s[1:] + points.s[:-1]) / 2
    n_y, n_z = body.contour.normal(middle)
    along = np.diff(points.in_section(body), axis=1)  # (2, n - 1)
    return np.asarray((along[0] * n_z - along[1] * n_y) / np.diff(points.s))
