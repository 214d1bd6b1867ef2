"""Grids of a contact: as large as the contact with B-hat, and fine enough for the smallest patch.

From the curvatures where two bodies touch first, Hertz's contact is a first guess of the size. The size with
B-hat is found on coarse grids, and grids are made for it. They are made longer where contacts with other ICs
need it.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeVar

import numpy as np

from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact, PotentialAreaTooSmall
from femic.contact.pairs.areas import touching_beyond
from femic.contact.pairs.ics import NONE_GIVEN, C, NormalICs, select_given
from femic.contact.pairs.pair_on_grid import NEARLY, PairOnGrid, pair_on_grid
from femic.contact.pairs.quantities import lacking
from femic.contact.patch import ENDS, MARGIN
from femic.contact.specification import ContactProblem
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid

# --- first touch ---

LEAST_CURVATURE = 1e-4  # relative, of bodies with which grids are tried first [1/mm]
MOST_UNLIKE = 1e8  # ratio of these
CURVATURE_STEP = 1e-3  # over which curvatures are taken, as a share of the contours and of the rolling radius


def hertz(bodies: PairOnGrid, loading: Loading) -> LoadedPoint:
    """Return the ellipse of Hertz of the curvatures where the bodies touch first, without an extra gap.

    They are at least `LEAST_CURVATURE`, and their ratio is within the limits of an ellipse of Hertz.
    """
    step, apart = distances_nearby(bodies)
    before, behind, ahead = np.where(np.isfinite(apart), apart, 0.0)
    along_x, along_s = (max(float(rise) / step**2, LEAST_CURVATURE) for rise in (2 * ahead, before + behind))
    least = max(along_x, along_s) / MOST_UNLIKE
    modulus = combined_modulus(bodies.pair.upper.material, bodies.pair.lower.material)
    point = PointContact(max(along_x, least), max(along_s, least), modulus)
    return point.at_load(loading.load) if loading.load else point.at_approach(loading.approach or 0.0)


def distances_nearby(bodies: PairOnGrid) -> tuple[float, Array]:
    """Return a short step [mm], and the distances of the bodies so far beside the place of first contact.

    Shape (3,) [mm]: along s to both sides, and along x. Infinite where a contour ends there.
    """
    undeformed, (start, end) = bodies.undeformed, bodies.undeformed.s_range
    touching = undeformed.touching[0]
    step = CURVATURE_STEP * min(end - start, undeformed.upper.rolling_radius)
    across = undeformed.distance(0.0, touching + step * np.array([-1.0, 1.0]))
    return step, np.append(across, undeformed.distance(step, touching))


# --- size of a contact ---

SIZING = "Bhat"  # the ICs with which grids are sized
TRIED = 32  # elements along x and s of the grids that are tried
GROWTH = 1.5  # by which a grid that is too short is made longer
FEWEST = 10  # elements across a patch that tell its size well enough
MOST_TRIES = 60
MOST_STRIPS = 96  # of a grid; loads that need more have grids of their own
MOST_BETWEEN = 512  # strips of a coarse grid over several patches
COUNTS = 0.1  # share of the pressures from which on elements are fine enough for a patch, too

Range = tuple[float, float]


@dataclass(frozen=True)
class Size:
    """The ranges of x and s that all patches of a contact cover [mm].

    `smallest` are the least length along x and width along s of patches that count, None: of the only one.
    """

    x: Range
    s: Range
    smallest: tuple[float, float] | None = None

    @property
    def patch(self) -> tuple[float, float]:
        """Length along x and width along s of the smallest patch [mm]."""
        return self.smallest or (self.x[1] - self.x[0], self.s[1] - self.s[0])


def contact_size(bodies: PairOnGrid, loading: Loading, *, all_patches: bool = True) -> Size:
    """Return the size of a contact with B-hat, on coarse grids made longer or shorter until they fit.

    Without `all_patches` only of those about the place where the bodies touch first.

    Raises Failure where the contact reaches the end of a contour, and where there is none.
    """
    touching, ellipse = bodies.undeformed.touching[0], hertz(bodies, loading)
    half_x, n_s = GROWTH * ellipse.a, TRIED
    s = _on_contours(bodies, touching - GROWTH * ellipse.b, touching + GROWTH * ellipse.b)
    for _ in range(MOST_TRIES):
        on_grid = replace(bodies, grid=_coarse_grid(half_x, s, n_s))
        try:
            contact = on_grid.solve(on_grid.operator(SIZING), loading).normal
            along_x, along_s = (np.flatnonzero(contact.in_contact.any(axis=axis)) for axis in (1, 0))
            few_x, few_s = (int(np.ptp(along)) + 1 < FEWEST for along in (along_x, along_s))
            one = len(contact.patches) == 1
            size = patch_size(on_grid, contact) if one else _size_of_all(on_grid, loading, contact)
        except PotentialAreaTooSmall as short:  # a longer grid, with more strips where it cannot be longer
            if _at_ends(bodies, short, s):
                n_s *= 2
                if n_s > MOST_STRIPS:
                    require_room(bodies, short, s)
            half_x *= GROWTH if ENDS[0] in short.ends or ENDS[1] in short.ends else 1.0
            before, after = ((GROWTH - 1) * (s[1] - s[0]) * (end in short.ends) for end in ENDS[2:])
            s = _on_contours(bodies, s[0] - before, s[1] + after)
            continue
        if not (few_x or few_s):
            further = _with_further_patches(on_grid, s, loading, contact) if all_patches else None
            return further or size
        half_x = size.x[1] * GROWTH if few_x else half_x
        if few_s:
            room = (GROWTH - 1) / 2 * (size.s[1] - size.s[0])
            s = _on_contours(bodies, size.s[0] - room, size.s[1] + room)
    raise no_grid(loading)


def _with_further_patches(
    tried: PairOnGrid, s: Range, loading: Loading, contact: NormalContact
) -> Size | None:
    """Return the size of a contact with patches beyond a grid over a range of s, None where there are none.

    A bump of an extra gap may bear all of the load, so that there is none where the contours touch first.

    Raises Failure where one of them reaches the end of a contour.
    """
    beyond = touching_beyond(tried, contact)
    if not beyond.size:
        return None
    (low, high), half_x = s, tried.grid.n_x * tried.grid.dx / 2
    strip = (high - low) / tried.grid.n_s
    for _ in range(MOST_TRIES):
        room = (GROWTH - 1) * (high - low) / 2
        low, high = min(low, beyond[0] - room), max(high, beyond[-1] + room)
        over = _on_contours(tried, low, high)
        n_s = min(MOST_BETWEEN, int(np.ceil((over[1] - over[0]) / strip)))
        on_grid = replace(tried, grid=_coarse_grid(half_x, over, n_s))
        try:
            found = on_grid.solve(on_grid.operator(SIZING), loading).normal
            size = _size_of_all(on_grid, loading, found)
            return size if size.s[0] < s[0] or size.s[1] > s[1] else None
        except PotentialAreaTooSmall as short:
            require_room(tried, short, over)
            half_x *= GROWTH if ENDS[0] in short.ends or ENDS[1] in short.ends else 1.0
            beyond = np.array([low, high])
    raise no_grid(loading)


def _size_of_all(on_grid: PairOnGrid, loading: Loading, contact: NormalContact) -> Size:
    """Return the size of a contact, from strips enough for the smallest patch."""
    size, grid = patch_size(on_grid, contact), on_grid.grid
    n_s = min(MOST_BETWEEN, int(np.ceil(grid.n_s * FEWEST * grid.ds / size.patch[1])))
    if n_s <= grid.n_s:
        return size
    finer = replace(on_grid, grid=replace(grid, n_s=n_s, ds=grid.ds * grid.n_s / n_s))
    return patch_size(finer, finer.solve(finer.operator(SIZING), loading).normal)


def _coarse_grid(half_x: float, s: Range, n_s: int) -> Grid:
    """Return a grid for the size of a contact: half-length along x, range of s [mm], number of strips."""
    low, high = s
    return Grid(TRIED, n_s, 2 * half_x / TRIED, (high - low) / n_s, (low + high) / 2)


def _on_contours(bodies: PairOnGrid, low: float, high: float) -> Range:
    """Return the part of a range of s that lies on the contours."""
    start, end = bodies.undeformed.s_range
    return max(low, start), min(high, end)


def require_room(bodies: PairOnGrid, short: PotentialAreaTooSmall, s: Range) -> None:
    """Raise Failure where the contact reaches the end of a contour."""
    start, end = bodies.undeformed.s_range
    if ended := _at_ends(bodies, short, s):
        raise Failure(
            f"{short.contact}: it reaches the end of a contour at {' and '.join(ended)} "
            f"(s = {start:g} ... {end:g} mm); give longer contours or a smaller load"
        )


def _at_ends(bodies: PairOnGrid, short: PotentialAreaTooSmall, s: Range) -> list[str]:
    """At which ends a grid over a range of s is too short and cannot be longer."""
    start, end = bodies.undeformed.s_range
    at_limit = {ENDS[2]: s[0] <= start, ENDS[3]: s[1] >= end}
    return [end for end, limited in at_limit.items() if limited and end in short.ends]


def patch_size(on_grid: PairOnGrid, contact: NormalContact) -> Size:
    """Return the ranges that the patches of a contact cover [mm]; those of x about the middle of the grid."""
    grid = on_grid.grid
    x = [place for patch in contact.patches for place in patch.x]
    s = [place for patch in contact.patches for place in patch.s]
    half = max(abs(place - (grid.n_x - 1) / 2) for place in x) * grid.dx
    ends = grid.strips[0] + min(s) * grid.ds, grid.strips[0] + max(s) * grid.ds
    if len(contact.patches) == 1:
        return Size((-half, half), ends)
    counting = [
        patch for patch in contact.patches if np.sum(contact.p[patch.elements]) > COUNTS * np.sum(contact.p)
    ]
    smallest = (
        min(patch.x[1] - patch.x[0] for patch in counting) * grid.dx,
        min(patch.s[1] - patch.s[0] for patch in counting) * grid.ds,
    )
    return Size((-half, half), ends, smallest)


def no_grid(loading: Loading) -> Failure:
    """Return the failure of a loading for which no grid fits."""
    return Failure(
        f"contact at {loading}: no grid found that it fits; give contact.grid = 'scene' and a [grid]"
    )


# --- size of grids ---

ROOM = 0.12  # room beside the largest patch, as a share of its length, for patches by other ICs
STEP = 8  # numbers of elements are multiples of it, for the sake of coarser grids
MOST_ELEMENTS = 60_000  # of a grid that is made finer
MOST_ALONG_X = 256  # elements of a grid; loads that need more have grids of their own

Outcome = TypeVar("Outcome")


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
        sizes = {loading: contact_size(self.bodies, loading) for loading in loadings}
        groups: list[list[Loading]] = []
        for loading in sorted(loadings, key=lambda loading: sizes[loading].x[1]):
            if groups:
                grid = self.grid([sizes[other] for other in [*groups[-1], loading]])
                if grid.n_s <= MOST_STRIPS and grid.n_x <= MOST_ALONG_X:
                    groups[-1].append(loading)
                    continue
            groups.append([loading])
        return [(self.grid([sizes[loading] for loading in group]), group) for group in groups]

    def grid(self, sizes: Sequence[Size]) -> Grid:
        """Return a grid for some sizes of contacts."""
        dx, ds = (float(min(size.patch[axis] for size in sizes)) / self.elements for axis in (0, 1))
        x = max(high for _, high in (size.x for size in sizes))
        low, high = min(size.s[0] for size in sizes), max(size.s[1] for size in sizes)
        room_x, room_s = 2 * ROOM * x + self.margin * dx, ROOM * (high - low) + self.margin * ds
        n_x, n_s = round_up((2 * x + 2 * room_x) / dx), round_up((high - low + 2 * room_s) / ds)
        middle = (low + high) / 2
        grid = Grid(n_x, n_s, dx, ds, 0.0 if abs(middle) < NEARLY * ds else float(middle))
        return keep_on_contours(grid, self.extent)

    def large_enough(self, grid: Grid, loadings: Sequence[Loading], variants: Sequence[str]) -> Grid:
        """Return the grid, made longer where the contact with another approximation needs it."""
        for variant, loading in product(variants, loadings):

            def grid_of(on_grid: PairOnGrid, variant: str = variant, loading: Loading = loading) -> Grid:
                on_grid.solve(on_grid.operator(variant), loading)
                return on_grid.grid

            grid = self.on_long_enough_grid(grid, grid_of)
        return grid

    def resolved(self, grid: Grid, loadings: Sequence[Loading], most_strips: int) -> Grid:
        """Return the grid with strips halved until they resolve the distance, or are more than `most_strips`.

        What p_max lacks otherwise is part of its estimate (`lacking`).
        """
        while 2 * grid.n_s <= most_strips and 2 * grid.n_x * grid.n_s <= MOST_ELEMENTS:
            on_grid = replace(self.bodies, grid=grid)
            operator = on_grid.operator(SIZING)
            if not any(lacking(on_grid, on_grid.solve(operator, loading).normal) for loading in loadings):
                break
            grid = replace(grid, n_s=2 * grid.n_s, ds=grid.ds / 2)
        return grid

    def on_long_enough_grid(self, grid: Grid, solve: Callable[[PairOnGrid], Outcome]) -> Outcome:
        """Return the solution of `solve` on a grid, which is made longer while a contact reaches its ends.

        Raises Failure where a contour ends there, and as `solve`.
        """
        for _ in range(MOST_TRIES):
            try:
                return solve(replace(self.bodies, grid=grid))
            except PotentialAreaTooSmall as short:
                require_room(self.bodies, short, grid.extent)
                grid, loading = keep_on_contours(extend_grid(grid, short.ends), self.extent), short.loading
        raise no_grid(loading)


def extend_grid(grid: Grid, ends: Collection[str]) -> Grid:
    """Return the grid with `STEP` more elements at some ends; at both ends of x where it is at one."""
    along_x = 2 * STEP if ENDS[0] in ends or ENDS[1] in ends else 0
    before, after = (STEP * (end in ends) for end in ENDS[2:])
    middle = grid.s + (after - before) * grid.ds / 2
    return Grid(grid.n_x + along_x, grid.n_s + before + after, grid.dx, grid.ds, middle)


def keep_on_contours(grid: Grid, s_range: Range) -> Grid:
    """Return the grid, moved or with narrower strips so that it stays on the contours."""
    (low, high), (start, end) = s_range, grid.extent
    if end - start > high - low:
        return Grid(grid.n_x, grid.n_s, grid.dx, (high - low) / grid.n_s, (low + high) / 2)
    return replace(grid, s=grid.s + max(0.0, low - start) - max(0.0, end - high))


def round_up(n: float) -> int:
    """Return the next multiple of `STEP`."""
    return STEP * int(np.ceil(n / STEP))


# --- grids of a problem ---

WITH_C, WITH_FRICTION, WITHOUT_C = 160, 256, 1024  # strips of grids that are made finer, at most
COARSE_MARGIN = 2 * MARGIN + 1  # elements beside a patch, so that elements twice as large have a margin


def make_sizing(problem: ContactProblem) -> Sizing:
    """Return the sizing of a problem's grids; contacts with friction are solved on larger elements, too."""
    bodies, elements = pair_on_grid(problem, problem.grid), problem.specification.elements
    return Sizing(bodies, elements, COARSE_MARGIN if problem.specification.friction else MARGIN + 1)


def grids_of(
    problem: ContactProblem, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> list[tuple[Grid, list[Loading]]]:
    """Return the grids of a problem and the loadings on each: the given one, or automatic ones.

    ICs that are given have a grid of their own, on which all is solved. With friction there is one grid, of
    the largest load, which the steps to it share. Raises WrongInput where given ICs have different grids, and
    Failure where no grid fits.
    """
    specification, loadings = problem.specification, list(problem.specification.loadings)
    if own := select_given(specification.ics, given):
        common = {name: ics.grid for name, ics in own.items()}
        if len(set(common.values())) > 1:
            raise WrongInput(f"contact.ics: {', '.join(common)} have different grids: name one")
        return [(next(iter(common.values())), loadings)]
    if not specification.automatic:
        return [(problem.grid, loadings)]
    sizing, variants = make_sizing(problem), [name for name in specification.ics if name != C]

    def fit(grid: Grid, on_grid: Sequence[Loading], most_strips: int) -> Grid:
        """Return the grid, made longer where patches need it, and finer where distances do."""
        return sizing.resolved(sizing.large_enough(grid, on_grid, variants), on_grid, most_strips)

    if specification.friction:
        largest = loadings[-1:]
        grid = sizing.grid([contact_size(sizing.bodies, largest[0])])
        return [(fit(grid, largest, WITH_FRICTION), loadings)]
    most_strips = WITH_C if C in specification.ics else WITHOUT_C
    return [(fit(grid, on_grid, most_strips), on_grid) for grid, on_grid in sizing.grids(loadings)]


def on_fitting_grid(
    problem: ContactProblem, grid: Grid, solve: Callable[[PairOnGrid], Outcome], *, longer: bool = True
) -> Outcome:
    """Return the solution of `solve` on a grid, made `longer` where needed if the problem has automatic ones.

    Raises Failure where a contact comes near the ends of another grid, and as `Sizing.on_long_enough_grid`.
    """
    if longer and problem.specification.automatic:
        return make_sizing(problem).on_long_enough_grid(grid, solve)
    try:
        return solve(pair_on_grid(problem, grid))
    except PotentialAreaTooSmall as short:
        raise Failure(f"{short.contact}: {short}") from short
