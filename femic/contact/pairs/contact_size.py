"""The size of a contact with B-hat, found on coarse grids."""

from dataclasses import dataclass, replace

import numpy as np

from femic.contact.edges import ENDS
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact, PotentialAreaTooSmall
from femic.contact.pairs.first_touch import hertz
from femic.contact.pairs.further_patches import touching_beyond
from femic.contact.pairs.pair_on_grid import PairOnGrid
from geometries.errors import Failure
from geometries.grids import Grid

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


@dataclass(frozen=True)
class _Trial:
    """A coarse grid for the size of a contact: half-length along x, range of s [mm], number of strips."""

    half_x: float
    s: Range
    n_s: int

    @property
    def grid(self) -> Grid:
        """The grid."""
        low, high = self.s
        return Grid(TRIED, self.n_s, 2 * self.half_x / TRIED, (high - low) / self.n_s, (low + high) / 2)


def contact_size(bodies: PairOnGrid, loading: Loading, *, all_patches: bool = True) -> Size:
    """Return the size of a contact with B-hat, on coarse grids made longer or shorter until they fit.

    Without `all_patches` only of those about the place where the bodies touch first.

    Raises Failure where the contact reaches the end of a contour, and where there is none.
    """
    trial = _first_trial(bodies, loading)
    for _ in range(MOST_TRIES):
        on_grid = replace(bodies, grid=trial.grid)
        try:
            contact = on_grid.solve(on_grid.operator(SIZING), loading).normal
            one, across = len(contact.patches) == 1, _across(contact)
            size = size_of(on_grid, contact) if one else _size_of_all(on_grid, loading, contact)
        except PotentialAreaTooSmall as short:
            trial = _enlarged(bodies, trial, short)
            continue
        if min(across) >= FEWEST:
            further = _with_further_patches(bodies, loading, trial, contact) if all_patches else None
            return further or size
        trial = _trial(bodies, *_narrowed(trial, size, across), trial.n_s)
    raise no_grid(loading)


def _with_further_patches(
    bodies: PairOnGrid, loading: Loading, trial: _Trial, contact: NormalContact
) -> Size | None:
    """Return the size of a contact with patches beyond a trial grid, None where there are none.

    A bump of an extra gap may bear all of the load, so that there is none where the contours touch first.

    Raises Failure where one of them reaches the end of a contour.
    """
    beyond = touching_beyond(replace(bodies, grid=trial.grid), contact)
    if not beyond.size:
        return None
    (low, high), half_x = trial.s, trial.half_x
    strip = (high - low) / trial.n_s
    for _ in range(MOST_TRIES):
        room = (GROWTH - 1) * (high - low) / 2
        low, high = min(low, beyond[0] - room), max(high, beyond[-1] + room)
        longer = _trial(bodies, half_x, (low, high), trial.n_s)
        n_s = min(MOST_BETWEEN, int(np.ceil((longer.s[1] - longer.s[0]) / strip)))
        on_grid = replace(bodies, grid=replace(longer, n_s=n_s).grid)
        try:
            found = on_grid.solve(on_grid.operator(SIZING), loading).normal
            size = _size_of_all(on_grid, loading, found)
            return size if size.s[0] < trial.s[0] or size.s[1] > trial.s[1] else None
        except PotentialAreaTooSmall as short:
            require_room(bodies, short, longer.s)
            half_x *= GROWTH if ENDS[0] in short.ends or ENDS[1] in short.ends else 1.0
            beyond = np.array([low, high])
    raise no_grid(loading)


def _size_of_all(on_grid: PairOnGrid, loading: Loading, contact: NormalContact) -> Size:
    """Return the size of a contact, from strips enough for the smallest patch."""
    size, grid = size_of(on_grid, contact), on_grid.grid
    n_s = min(MOST_BETWEEN, int(np.ceil(grid.n_s * FEWEST * grid.ds / size.patch[1])))
    if n_s <= grid.n_s:
        return size
    finer = replace(on_grid, grid=replace(grid, n_s=n_s, ds=grid.ds * grid.n_s / n_s))
    return size_of(finer, finer.solve(finer.operator(SIZING), loading).normal)


def _first_trial(bodies: PairOnGrid, loading: Loading) -> _Trial:
    """Return the grid that is tried first: a little larger than the patch of Hertz."""
    touching, patch = bodies.undeformed.touching[0], hertz(bodies, loading)
    half_s = GROWTH * patch.b
    return _trial(bodies, GROWTH * patch.a, (touching - half_s, touching + half_s), TRIED)


def _trial(bodies: PairOnGrid, half_x: float, s: Range, n_s: int) -> _Trial:
    """Return a trial grid, no longer than the contours."""
    start, end = bodies.undeformed.s_range
    return _Trial(half_x, (max(s[0], start), min(s[1], end)), n_s)


def _enlarged(bodies: PairOnGrid, trial: _Trial, short: PotentialAreaTooSmall) -> _Trial:
    """Return a longer trial grid, with more strips where it cannot be longer; raises Failure for too many."""
    (low, high), n_s, half_x = trial.s, trial.n_s, trial.half_x
    if _at_ends(bodies, short, trial.s):
        n_s *= 2
        if n_s > MOST_STRIPS:
            require_room(bodies, short, trial.s)
    half_x *= GROWTH if ENDS[0] in short.ends or ENDS[1] in short.ends else 1.0
    grown = (GROWTH - 1) * (high - low)
    s = low - grown * (ENDS[2] in short.ends), high + grown * (ENDS[3] in short.ends)
    return _trial(bodies, half_x, s, n_s)


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


def size_of(on_grid: PairOnGrid, contact: NormalContact) -> Size:
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


def _narrowed(trial: _Trial, size: Size, across: tuple[int, int]) -> tuple[float, Range]:
    """Return half-length and range of s [mm] of a shorter trial grid with more elements in contact."""
    half_x, s = trial.half_x, trial.s
    if across[0] < FEWEST:
        half_x = size.x[1] * GROWTH
    if across[1] < FEWEST:
        room = (GROWTH - 1) / 2 * (size.s[1] - size.s[0])
        s = size.s[0] - room, size.s[1] + room
    return half_x, s


def _across(contact: NormalContact) -> tuple[int, int]:
    """Return numbers of elements in contact along x and s, from the first to the last."""
    along_x, along_s = (np.flatnonzero(contact.in_contact.any(axis=axis)) for axis in (1, 0))
    return int(np.ptp(along_x)) + 1, int(np.ptp(along_s)) + 1


def no_grid(loading: Loading) -> Failure:
    """Return the failure of a loading for which no grid fits."""
    return Failure(
        f"contact at {loading}: no grid found that it fits; give contact.grid = 'scene' and a [grid]"
    )
