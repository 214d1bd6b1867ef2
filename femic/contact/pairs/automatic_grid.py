"""Automatic grids: as large as the contact, found with B-hat, and fine enough for the smallest patch."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeVar

import numpy as np

from femic.contact.edges import ENDS, MARGIN
from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact, PotentialAreaTooSmall
from femic.contact.pairs.given_ics import NONE_GIVEN, NormalICs, approximations_of, given_of
from femic.contact.pairs.pair_on_grid import NEARLY, PairOnGrid, pair_on_grid
from femic.contact.specification import ContactProblem
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
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

COARSE_MARGIN = 2 * MARGIN + 1  # elements beside a patch, so that elements twice as large have a margin

Range = tuple[float, float]
Outcome = TypeVar("Outcome")


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

    bodies: PairOnGrid
    elements: int
    margin: int = MARGIN + 1

    @property
    def extent(self) -> Range:
        """Arc lengths [mm] between which the bodies may touch."""
        return self.bodies.undeformed.s_range

    def grids(self, loadings: Sequence[Loading]) -> list[tuple[Grid, list[Loading]]]:
        """Grids, each with the loadings that are solved on it, in the order of their size.

        Loadings share a grid and so C, as long as it does not have more than `MOST_STRIPS` strips.
        """
        sizes = {loading: self.size(loading) for loading in loadings}
        groups: list[list[Loading]] = []
        for loading in sorted(loadings, key=lambda loading: sizes[loading].x[1]):
            if groups and _fits(self.grid([sizes[other] for other in [*groups[-1], loading]])):
                groups[-1].append(loading)
            else:
                groups.append([loading])
        return [(self.grid([sizes[loading] for loading in group]), group) for group in groups]

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

    def large_enough(self, grid: Grid, loadings: Sequence[Loading], variants: Sequence[str]) -> Grid:
        """The grid, made longer where the contact with another approximation needs it."""
        for variant, loading in product(variants, loadings):

            def figure_grid(on_grid: PairOnGrid, variant: str = variant, loading: Loading = loading) -> Grid:
                on_grid.solve(on_grid.operator(variant), loading)
                return on_grid.grid

            grid = self.on_long_enough_grid(grid, figure_grid)
        return grid

    def on_long_enough_grid(self, grid: Grid, solve: Callable[[PairOnGrid], Outcome]) -> Outcome:
        """Return the solution of `solve` on a grid, which is made longer while a contact reaches its ends.

        Raises Failure where a contour ends there, and as `solve`.
        """
        for _ in range(MOST_TRIES):
            try:
                return solve(replace(self.bodies, grid=grid))
            except PotentialAreaTooSmall as short:
                grid, loading = self.longer(grid, short), short.loading
        raise _no_grid(loading)

    def longer(self, grid: Grid, short: PotentialAreaTooSmall) -> Grid:
        """The grid with `STEP` more elements at the ends at which it is too short.

        Raises Failure where a contour ends there.
        """
        self._require_room(short, grid.extent)
        ends = short.ends
        along_x = 2 * STEP if ENDS[0] in ends or ENDS[1] in ends else 0
        before, after = (STEP * (end in ends) for end in ENDS[2:])
        middle = grid.s + (after - before) * grid.ds / 2
        longer = Grid(grid.n_x + along_x, grid.n_s + before + after, grid.dx, grid.ds, middle)
        return self._within(longer)

    def size(self, loading: Loading) -> Size:
        """The size of a contact with B-hat, on coarse grids that are made longer or shorter until they fit.

        Raises Failure where the contact reaches the end of a contour, and where there is none.
        """
        (half_x, s), n_s = self._first_guess(loading), TRIED
        for _ in range(MOST_TRIES):
            low, high = max(s[0], self.extent[0]), min(s[1], self.extent[1])
            grid = Grid(TRIED, n_s, 2 * half_x / TRIED, (high - low) / n_s, (low + high) / 2)
            on_grid = replace(self.bodies, grid=grid)
            try:
                contact = on_grid.solve(on_grid.operator(SIZING), loading).normal
            except PotentialAreaTooSmall as short:
                if self._at_ends(short, (low, high)):
                    n_s *= 2
                    if n_s > MOST_STRIPS:
                        self._require_room(short, (low, high))
                half_x *= GROWTH if ENDS[0] in short.ends or ENDS[1] in short.ends else 1.0
                grown = (GROWTH - 1) * (high - low)
                s = low - grown * (ENDS[2] in short.ends), high + grown * (ENDS[3] in short.ends)
                continue
            size, across = size_of(on_grid, contact), _across(contact)
            if min(across) >= FEWEST:
                return size
            half_x = size.x[1] * GROWTH if across[0] < FEWEST else half_x
            if across[1] < FEWEST:
                room = (GROWTH - 1) / 2 * (size.s[1] - size.s[0])
                s = size.s[0] - room, size.s[1] + room
        raise _no_grid(loading)

    def hertz(self, loading: Loading) -> LoadedPoint:
        """The ellipse of Hertz of the curvatures where the bodies touch first, without an extra gap."""
        modulus = combined_modulus(self.bodies.pair.upper.material, self.bodies.pair.lower.material)
        point = PointContact(*self._curvatures(), modulus)
        return point.at_load(loading.load) if loading.load else point.at_approach(loading.approach or 0.0)

    def _first_guess(self, loading: Loading) -> tuple[float, Range]:
        """Half-length along x and range of s [mm] with which grids are tried first: a little beyond Hertz."""
        touching, patch = self.bodies.undeformed.touching[0], self.hertz(loading)
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

    def _require_room(self, short: PotentialAreaTooSmall, s: Range) -> None:
        """Raise Failure where the contact reaches the end of a contour."""
        if ended := self._at_ends(short, s):
            raise Failure(
                f"{short.contact}: it reaches the end of a contour at {' and '.join(ended)} "
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


def size_of(on_grid: PairOnGrid, contact: NormalContact) -> Size:
    """The ranges that the patches of a contact cover [mm]; those of x about the middle of the grid."""
    grid = on_grid.grid
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


def _no_grid(loading: Loading) -> Failure:
    return Failure(
        f"contact at {loading}: no grid found that it fits; give contact.grid = 'scene' and a [grid]"
    )


def sizing_of(problem: ContactProblem) -> Sizing:
    """The sizing of a problem's grids; contacts with friction are solved on larger elements, too."""
    bodies, elements = pair_on_grid(problem, problem.grid), problem.specification.elements
    return Sizing(bodies, elements, COARSE_MARGIN if problem.specification.friction else MARGIN + 1)


def grids_of(
    problem: ContactProblem, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> list[tuple[Grid, list[Loading]]]:
    """The grids of a problem and the loadings on each: the given one, or automatic ones.

    ICs that are given have a grid of their own, on which all is solved. With friction there is one grid, of
    the largest load, which the steps to it share. Raises WrongInput where given ICs have different grids, and
    Failure where no grid fits.
    """
    specification, loadings = problem.specification, list(problem.specification.loadings)
    if own := given_of(specification.ics, given):
        return [(_common_grid(own), loadings)]
    if not specification.automatic:
        return [(problem.grid, loadings)]
    sizing, variants = sizing_of(problem), approximations_of(specification.ics, given)
    if specification.friction:
        largest = loadings[-1:]
        grid = sizing.grid([sizing.size(largest[0])])
        return [(sizing.large_enough(grid, largest, variants), loadings)]
    return [
        (sizing.large_enough(grid, on_grid, variants), on_grid) for grid, on_grid in sizing.grids(loadings)
    ]


def on_fitting_grid(
    problem: ContactProblem, grid: Grid, solve: Callable[[PairOnGrid], Outcome], *, longer: bool = True
) -> Outcome:
    """Return the solution of `solve` on a grid, made `longer` where needed if the problem has automatic ones.

    Raises Failure where a contact comes near the ends of another grid, and as `Sizing.on_long_enough_grid`.
    """
    if longer and problem.specification.automatic:
        return sizing_of(problem).on_long_enough_grid(grid, solve)
    try:
        return solve(pair_on_grid(problem, grid))
    except PotentialAreaTooSmall as short:
        raise Failure(f"{short.contact}: {short}") from short


def _common_grid(given: Mapping[str, NormalICs]) -> Grid:
    grids = {name: ics.grid for name, ics in given.items()}
    if len(set(grids.values())) > 1:
        raise WrongInput(f"contact.ics: {', '.join(grids)} have different grids: name one")
    return next(iter(grids.values()))
