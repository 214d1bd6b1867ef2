"""Automatic grids: as large as the contact, found with B-hat, and fine enough for the smallest patch."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from compare.contact.pair_on_grid import NEARLY, Case, Placed
from femic.contact.edges import ENDS, MARGIN
from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.normal import NormalContact, PotentialAreaTooSmall
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.grids import Grid

SIZING = "Bhat"  # the ICs with which grids are sized
TRIED = 32  # elements along x and s of the grids that are tried
GROWTH = 1.5  # by which a grid that is too short is made longer
FEWEST = 10  # elements across a patch that tell its size well enough
MOST_TRIES = 60
ROOM = 0.12  # room beside the largest patch, as a share of its length, for patches by other ICs
LEAST_CURVATURE = 1e-4  # relative, of bodies with which grids are tried first [1/mm]
MOST_UNLIKE = 1e8  # ratio of these
NEARBY = 1e-3  # step over which curvatures are taken, as a share of the contours and of the rolling radius
STEP = 8  # numbers of elements are multiples of it, for the sake of coarser grids
MOST_STRIPS, MOST_ALONG_X = 96, 256  # of a grid; loads that need more have grids of their own

Range = tuple[float, float]


@dataclass(frozen=True)
class Size:
    """The ranges of x and s that all patches of a contact cover [mm]."""

    x: Range
    s: Range


@dataclass(frozen=True)
class Sizing:
    """Two bodies, on any grid, whose grids are sized, with `elements` across the smallest patch of each.

    Beside `ROOM` there are `margin` elements beside the largest patch.
    """

    bodies: Placed
    elements: int
    margin: int = MARGIN + 1

    @property
    def extent(self) -> Range:
        """Arc lengths [mm] between which the bodies may touch."""
        return self.bodies.undeformed.s_range

    def grids(self, cases: Sequence[Case]) -> list[tuple[Grid, list[Case]]]:
        """Grids, each with the cases that are solved on it, in the order of their size.

        Cases share a grid and so C, as long as it does not have more than `MOST_STRIPS` strips.
        """
        sizes = {case: self.size(case) for case in cases}
        groups: list[list[Case]] = []
        for case in sorted(cases, key=lambda case: sizes[case].x[1]):
            if groups and _fits(self.grid([sizes[other] for other in [*groups[-1], case]])):
                groups[-1].append(case)
            else:
                groups.append([case])
        return [(self.grid([sizes[case] for case in group]), group) for group in groups]

    def grid(self, sizes: Sequence[Size]) -> Grid:
        """A grid for some sizes of contacts."""
        dx, ds = (
            float(min(high - low for low, high in ranges)) / self.elements
            for ranges in ([size.x for size in sizes], [size.s for size in sizes])
        )
        x = max(high for _, high in (size.x for size in sizes))
        low, high = min(size.s[0] for size in sizes), max(size.s[1] for size in sizes)
        room_x, room_s = 2 * ROOM * x + self.margin * dx, ROOM * (high - low) + self.margin * ds
        n_x, n_s = _rounded((2 * x + 2 * room_x) / dx), _rounded((high - low + 2 * room_s) / ds)
        middle = (low + high) / 2
        return self._within(Grid(n_x, n_s, dx, ds, 0.0 if abs(middle) < NEARLY * ds else float(middle)))

    def large_enough(self, grid: Grid, cases: Sequence[Case], variants: Sequence[str]) -> Grid:
        """The grid, made longer where the contact by another approximation needs it."""
        for variant, case in product(variants, cases):
            for _ in range(MOST_TRIES):
                placed = replace(self.bodies, grid=grid)
                try:
                    placed.settled(placed.operator(variant), case)
                    break
                except PotentialAreaTooSmall as short:
                    grid = self.longer(grid, short, case)
        return grid

    def longer(self, grid: Grid, short: PotentialAreaTooSmall, case: Case) -> Grid:
        """The grid with `STEP` more elements at the ends at which it is too short.

        Raises Failure where a contour ends there.
        """
        self._require_room(short, case, grid.extent)
        ends = short.ends
        along_x = 2 * STEP if ENDS[0] in ends or ENDS[1] in ends else 0
        before, after = (STEP * (end in ends) for end in ENDS[2:])
        middle = grid.s + (after - before) * grid.ds / 2
        longer = Grid(grid.n_x + along_x, grid.n_s + before + after, grid.dx, grid.ds, middle)
        return self._within(longer)

    def size(self, case: Case) -> Size:
        """The size of a contact with B-hat, on coarse grids that are made longer or shorter until they fit.

        Raises Failure where the contact reaches the end of a contour, and where there is none.
        """
        (half_x, s), n_s = self._first_guess(case), TRIED
        for _ in range(MOST_TRIES):
            low, high = max(s[0], self.extent[0]), min(s[1], self.extent[1])
            grid = Grid(TRIED, n_s, 2 * half_x / TRIED, (high - low) / n_s, (low + high) / 2)
            placed = replace(self.bodies, grid=grid)
            try:
                contact = placed.settled(placed.operator(SIZING), case).normal
            except PotentialAreaTooSmall as short:
                if self._at_ends(short, (low, high)):
                    n_s *= 2
                    if n_s > MOST_STRIPS:
                        self._require_room(short, case, (low, high))
                half_x *= GROWTH if ENDS[0] in short.ends or ENDS[1] in short.ends else 1.0
                grown = (GROWTH - 1) * (high - low)
                s = low - grown * (ENDS[2] in short.ends), high + grown * (ENDS[3] in short.ends)
                continue
            size, across = size_of(placed, contact), _across(contact)
            if min(across) >= FEWEST:
                return size
            half_x = size.x[1] * GROWTH if across[0] < FEWEST else half_x
            if across[1] < FEWEST:
                room = (GROWTH - 1) / 2 * (size.s[1] - size.s[0])
                s = size.s[0] - room, size.s[1] + room
        raise Failure(
            f"contact at {case}: no grid found that it fits; give contact.grid = 'scene' and a [grid]"
        )

    def hertz(self, case: Case) -> LoadedPoint:
        """The ellipse of Hertz of the curvatures where the bodies touch first, without an extra gap."""
        modulus = combined_modulus(self.bodies.pair.upper.material, self.bodies.pair.lower.material)
        point = PointContact(*self._curvatures(), modulus)
        return point.at_load(case.load) if case.load else point.at_approach(case.approach or 0.0)

    def _first_guess(self, case: Case) -> tuple[float, Range]:
        """Half-length along x and range of s [mm] with which grids are tried first: a little beyond Hertz."""
        touching, patch = self.bodies.undeformed.touching[0], self.hertz(case)
        half_s = GROWTH * patch.b
        return GROWTH * patch.a, (touching - half_s, touching + half_s)

    @property
    def nearby(self) -> tuple[float, Array]:
        """A short step [mm], and how far bodies are apart so far beside the place where they touch first.

        Shape (3,) [mm]: along s to both sides, and along x. Infinite where a contour ends there.
        """
        undeformed, (start, end) = self.bodies.undeformed, self.extent
        touching, step = undeformed.touching[0], NEARBY * min(end - start, undeformed.upper.rolling_radius)
        across = undeformed.distance(0.0, touching + step * np.array([-1.0, 1.0]))
        return step, np.append(across, undeformed.distance(step, touching))

    def _curvatures(self) -> tuple[float, float]:
        """Relative curvatures [1/mm] along x and s where the bodies touch, at least `LEAST_CURVATURE`.

        And not more unlike each other than an ellipse of Hertz may be.
        """
        step, apart = self.nearby
        before, behind, ahead = np.where(np.isfinite(apart), apart, 0.0)
        of_x, of_s = (max(float(rise) / step**2, LEAST_CURVATURE) for rise in (2 * ahead, before + behind))
        least = max(of_x, of_s) / MOST_UNLIKE
        return max(of_x, least), max(of_s, least)

    def _require_room(self, short: PotentialAreaTooSmall, case: Case, s: Range) -> None:
        """Raise Failure where the contact reaches the end of a contour."""
        if ended := self._at_ends(short, s):
            raise Failure(
                f"contact at {case}: it reaches the end of a contour at {' and '.join(ended)} "
                f"(s = {self.extent[0]:g} ... {self.extent[1]:g} mm); give longer contours or a smaller load"
            )

    def _at_ends(self, short: PotentialAreaTooSmall, s: Range) -> list[str]:
        """At which ends a grid over a range of s is too short and cannot be longer."""
        at_limit = {ENDS[2]: s[0] <= self.extent[0], ENDS[3]: s[1] >= self.extent[1]}
        return [end for end, limited in at_limit.items() if limited and end in short.ends]

    def _within(self, grid: Grid) -> Grid:
        """The grid, moved or with narrower strips so that it stays on the contours."""
        (low, high), (start, end) = self.extent, grid.extent
        if end - start > high - low:
            return Grid(grid.n_x, grid.n_s, grid.dx, (high - low) / grid.n_s, (low + high) / 2)
        return Grid(grid.n_x, grid.n_s, grid.dx, grid.ds, grid.s + max(0, low - start) - max(0, end - high))


def size_of(placed: Placed, contact: NormalContact) -> Size:
    """The ranges that the patches of a contact cover [mm]; those of x about the middle of the grid."""
    grid = placed.grid
    x = [place for patch in contact.patches for place in patch.x]
    s = [place for patch in contact.patches for place in patch.s]
    half = max(abs(place - (grid.n_x - 1) / 2) for place in x) * grid.dx
    return Size((-half, half), (grid.strips[0] + min(s) * grid.ds, grid.strips[0] + max(s) * grid.ds))


def _across(contact: NormalContact) -> tuple[int, int]:
    """Numbers of elements in contact along x and s, from the first to the last."""
    along_x, along_s = (np.flatnonzero(contact.in_contact.any(axis=axis)) for axis in (1, 0))
    return int(np.ptp(along_x)) + 1, int(np.ptp(along_s)) + 1


def _rounded(n: float) -> int:
    """The next multiple of `STEP`."""
    return STEP * int(np.ceil(n / STEP))


def _fits(grid: Grid) -> bool:
    return grid.n_s <= MOST_STRIPS and grid.n_x <= MOST_ALONG_X
