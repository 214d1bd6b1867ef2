"""The points below a contact at which stresses are computed: a lattice in x, s, depth; a deeper column."""

from dataclasses import dataclass

import numpy as np

from compare.stresses.contacts import Contacts
from femic.stresses.points import InnerPoints, require_inside
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput
from geometries.patches import N

ALONG_X, ALONG_S, INTO_DEPTH, DEEPER_STILL = 17, 25, 13, 12  # points
WIDER, LONGER, DEEPER = 1.5, 1.3, 2.0  # over the width, the length and the half-width of the patch
GRADING = 1.5  # power of depths: closer together near the surface
SHRINKING, MOST_SHRINKINGS = 0.9, 40  # of the depth, until all normals stay inside the body and apart
LEAST_SPREAD = 0.25  # of the distance between normals at the surface: deeper they cross


@dataclass(frozen=True, eq=False)
class Lattice:
    """Points at x (n_x,), arc lengths s (n_s,) of the lower contour, and depths (n_d,) in a body [mm].

    The column below the middle of the patch, s[middle], goes on to the depths `deeper` (n_c,), which may be
    none. `offset` [mm] is added to s on the body's own contour.
    """

    x: Array
    s: Array
    depth: Array
    deeper: Array
    middle: int
    offset: float

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of x, s and depths."""
        return len(self.x), len(self.s), len(self.depth)

    @property
    def column(self) -> Array:
        """Depths [mm] below the middle of the patch, (n_d + n_c,)."""
        return np.concatenate([self.depth, self.deeper])

    @property
    def points(self) -> InnerPoints:
        """All points on the body's own contour, in one row: the lattice, then what is deeper."""
        on_lattice = InnerPoints(self.x[:, None, None], self.s[:, None], self.depth).flat
        below = InnerPoints(self.x[:, None], np.asarray(self.s[self.middle]), self.deeper).flat
        x, s, depth = (
            np.concatenate([getattr(part, name) for part in (on_lattice, below)])
            for name in ("x", "s", "depth")
        )
        return InnerPoints(x, s + self.offset, depth)

    def of_points(self, values: Array) -> tuple[Array, Array]:
        """Return values (n, ...) at all points on the lattice, (n_x, n_s, n_d, ...), and on the column.

        The column has shape (n_x, n_d + n_c, ...).
        """
        count, rest = int(np.prod(self.shape)), values.shape[1:]
        on_lattice = values[:count].reshape(*self.shape, *rest)
        below = values[count:].reshape(len(self.x), len(self.deeper), *rest)
        return on_lattice, np.concatenate([on_lattice[:, self.middle], below], axis=1)


def lattice_below(contacts: Contacts, body: str) -> Lattice:
    """Return the lattice below the contacts with all ICs in a body.

    s goes over 1.5 widths of the patch, as far as both contours go, and has its middle; x over 1.3 lengths,
    and has 0; depths go to two half-widths, or where that is less as far as normals stay inside the body and
    apart. Below the middle alone they go on to two half-widths, if that is inside the body.
    """
    half_length, (low, high) = _patch(contacts)
    half_width, middle = (high - low) / 2, (low + high) / 2
    first, last = contacts.problem.extent
    offset, of_body = contacts.offset(body), contacts.problem.bodies[body]
    low = max(first, middle - WIDER * half_width, of_body.s_range[0] - offset)
    high = min(last, middle + WIDER * half_width, of_body.s_range[1] - offset)
    before = ALONG_S // 2
    s = np.concatenate(
        [np.linspace(low, middle, before + 1), np.linspace(middle, high, ALONG_S - before)[1:]]
    )
    x = LONGER * half_length * np.linspace(-1, 1, ALONG_X)
    wanted = DEEPER * min(half_width, half_length)
    deepest = _deepest(of_body, s + offset, wanted)
    below = _deepest(of_body, s[[before]] + offset, wanted)
    deeper = np.linspace(deepest, below, DEEPER_STILL + 1)[1:] if below > deepest else np.zeros(0)
    return Lattice(x, s, deepest * np.linspace(0, 1, INTO_DEPTH) ** GRADING, deeper, before, offset)


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
