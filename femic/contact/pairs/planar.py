"""Planar contact, as programs for it solve it: each patch in a plane of its own, on half-spaces.

The upper body comes down by an approach zeta. Where both profiles then overlap is a patch; parts nearer than
`COMBINED` belong to one. Its plane has the mean inclination of the rail over the overlap, weighted with the
square of its depth: with the vertical depth e at x = 0, this is e^(5/2) dy for a strip over its length along
x, nearly as pressures are distributed. In the plane, ICs are A, and the distance is
that of the displaced bodies along the normal of the plane: nothing is linearised, and elements do not turn.
Patches do not act on each other. The approach is the one at which all patches carry the load together. This
is what the program CONTACT does by default, but for steep patches: docs/theory/contact.md.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from approx.pair import Pair, Solid
from femic.contact.normal import NormalContact, NormalProblem, PotentialAreaTooSmall, solve
from femic.contact.pairs.area_grids import Box, boxes_on_grid, finer_grid, fitting_grid, overlaps
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.undeformed import TangentPlane, Undeformed
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid
from geometries.surfaces import UPPER, Surface

PLANAR = "planar"  # the name of the contact
COMBINED = 4.0  # mm along the rail: overlaps nearer to each other are one patch, as in CONTACT
COARSE, MOST_TRIES = 40, 40  # elements of a coarse grid; grids and approaches
SAMPLES = 2001  # of an overlap, for its weighted centre
LOAD = 1e-6  # of the load: the accuracy of its balance


@dataclass(frozen=True, eq=False)
class PlanarPatch:
    """A patch in its plane: the bodies over the plane on a grid, and the contact there.

    Beyond the `window` [mm], coordinates in the plane, are other patches: no contact is possible there.
    """

    on_grid: PairOnGrid
    window: tuple[float, float]
    contact: NormalContact

    @property
    def plane(self) -> TangentPlane:
        """The plane."""
        assert isinstance(self.on_grid.undeformed, TangentPlane)
        return self.on_grid.undeformed

    @property
    def normal_force(self) -> float:
        """Force [N] along the normal of the plane."""
        return float(np.sum(self.contact.p)) * self.contact.problem.grid.area


@dataclass(frozen=True, eq=False)
class PlanarContact:
    """All patches under one approach [mm], by growing s."""

    patches: tuple[PlanarPatch, ...]
    approach: float


def planar(bodies: PairOnGrid, at: float | None = None, inclination: float | None = None) -> PairOnGrid:
    """Return bodies over a plane through the lower contour at an arc length [mm]; None: first touch.

    The plane is tangent there, or has another `inclination` [rad]. Raises WrongInput for bodies with an extra
    gap, and as `TangentPlane`.
    """
    if bodies.extra_gap is not None:
        raise WrongInput(
            "extra_gap: it is along the normals of the lower surface: leave it out of planar contact"
        )
    if not isinstance(bodies.undeformed, Undeformed):
        return bodies
    plane = TangentPlane(bodies.undeformed, at, inclination)
    upper = Solid(bodies.pair.upper.material, Surface(UPPER, plane.lower.contour))
    lower = Solid(bodies.pair.lower.material, plane.lower)
    return PairOnGrid(Pair(upper, lower), plane, bodies.grid)


def solve_planar(
    bodies: PairOnGrid, load: float, *, elements: int = 20, roll: float = 0.0, about: float = 0.0
) -> PlanarContact:
    """Return the planar contact under a load [N] along the direction at an angle `roll` [rad] to the z axis.

    There are `elements` across the main patch, and half as many across others; `about` [mm] is a guess of the
    approach. Raises Failure where no approach has the load.
    """
    return _Planar(bodies, load, elements, roll).solved(about)


@dataclass(frozen=True, eq=False)
class _Planar:
    bodies: PairOnGrid
    load: float
    elements: int
    roll: float

    def solved(self, about: float) -> PlanarContact:
        """Return the contact: its approach on coarse grids, then its patches on finer ones."""
        approach = self.approach_with(self.patches, about or 1e-3)
        coarse = self.patches(approach)
        main = max(coarse, key=lambda patch: patch.normal_force)
        grids = [self.fine_grid(patch, patch is main) for patch in coarse]

        def on_grids(zeta: float) -> list[PlanarPatch]:
            return [
                self.patch(replace(patch.on_grid, grid=grid), patch.window, zeta)
                for patch, grid in zip(coarse, grids, strict=True)
            ]

        for _ in range(MOST_TRIES):
            try:
                approach = self.approach_with(on_grids, approach)
                fine = [self.at_its_load(patch, approach) for patch in on_grids(approach)]
            except _TooShort as short:
                number = next(k for k, grid in enumerate(grids) if grid == short.grid)
                grids[number] = _longer(short.grid, short.ends)
                continue
            finer = [finer_grid(patch.contact, 0.0, 256) or patch.on_grid.grid for patch in fine]
            if finer == grids:
                return PlanarContact(tuple(fine), approach)
            grids = finer
        raise Failure(f"planar contact at {self.load:g} N: no grids found that it fits")

    def approach_with(self, patches_at: Callable[[float], list[PlanarPatch]], approach: float) -> float:
        """Return the approach [mm] at which patches carry the load, by the secant in logarithms."""

        def excess(log_approach: float) -> float:
            vertical = sum(
                patch.normal_force * np.cos(patch.plane.angle - self.roll)
                for patch in patches_at(float(np.exp(log_approach)))
            )
            return float(np.log(max(vertical, 1e-300) / self.load))

        x, f = float(np.log(approach)), excess(float(np.log(approach)))
        low, high = (x, np.inf) if f < 0 else (-np.inf, x)
        before: tuple[float, float] | None = None
        for _ in range(MOST_TRIES):
            if abs(f) <= LOAD:
                return float(np.exp(x))
            slope = 1.5 if before is None or x == before[0] else (f - before[1]) / (x - before[0])
            step = float(np.clip(-f / np.clip(slope, 0.5, 10.0), -0.7, 0.7))
            before = (x, f)
            x = x + step if low < x + step < high else (low + high) / 2
            f = excess(x)
            low, high = (max(low, x), high) if f < 0 else (low, min(high, x))
        raise Failure(
            f"planar contact: at an approach of {np.exp(x):.5g} mm it carries {self.load * np.exp(f):.6g} N, "
            f"not {self.load:g} N, and no other is found; give another load"
        )

    def patches(self, approach: float) -> list[PlanarPatch]:
        """Return the patches at an approach [mm], each in its plane, on coarse grids."""
        surfaces = self.bodies.undeformed
        assert isinstance(surfaces, Undeformed)
        ranges = _combined(overlaps(surfaces, approach, self.roll))
        ends = [end for each in ranges for end in each]
        between = [(ends[k] + ends[k + 1]) / 2 for k in range(1, len(ends) - 1, 2)]
        limits = [surfaces.s_range[0], *between, surfaces.s_range[1]]
        patches = []
        for each, window in zip(ranges, pairwise(limits), strict=True):
            over = self.over_plane(each, approach)
            assert isinstance(over.undeformed, TangentPlane)
            along = over.undeformed.line.along(surfaces.lower.contour.position(np.array(window)))
            patches.append(self.patch(over, (float(along[0]), float(along[1])), approach))
        return patches

    def over_plane(self, s: tuple[float, float], approach: float) -> PairOnGrid:
        """Return the bodies over the plane of an overlap, on a coarse grid."""
        surfaces = self.bodies.undeformed
        assert isinstance(surfaces, Undeformed)
        at = np.linspace(*s, SAMPLES)
        inclination = surfaces.lower.contour.inclination(at)
        down, aside = approach * np.cos(self.roll), -approach * np.sin(self.roll)
        depth = np.maximum(-surfaces.vertical_distance(at, down, aside), 0.0)
        weights = depth**2.5 * np.cos(inclination) if np.any(depth) else np.ones_like(at)
        centre = float(np.average(at, weights=weights))
        over = planar(self.bodies, centre, float(np.average(inclination, weights=weights)))
        plane = over.undeformed
        assert isinstance(plane, TangentPlane)
        along = plane.line.along(surfaces.lower.contour.position(at))
        low, high = float(np.min(along)), float(np.max(along))
        half_x = self.half_length(plane, (low, high), (down, aside))
        grid = Grid(COARSE, COARSE, 2 * half_x / (COARSE - 8), (high - low) / (COARSE - 8), (low + high) / 2)
        return replace(over, grid=grid)

    def half_length(self, plane: TangentPlane, t: tuple[float, float], moved: tuple[float, float]) -> float:
        """Return half of the length [mm] along x of an overlap."""
        at = np.linspace(*t, 65)

        def least(x: float) -> float:
            return float(np.min(plane.distance(x, at, *moved)))

        high = float(np.sqrt(8 * max(moved[0], 1e-9) * plane.upper.circle_radius(np.array(0.0))))
        if least(0.0) >= 0:
            return 1e-3 * high
        while least(high) < 0:
            high *= 1.5
        return float(scipy.optimize.brentq(least, 0.0, high, rtol=1e-3))

    def patch(self, on_grid: PairOnGrid, window: tuple[float, float], approach: float) -> PlanarPatch:
        """Return a patch at an approach [mm]."""
        return PlanarPatch(on_grid, window, self.contact(on_grid, window, approach))

    def at_its_load(self, patch: PlanarPatch, approach: float) -> PlanarPatch:
        """Return a patch under its own normal force, on all elements: those twice as large have it, too."""
        contact = self.contact(patch.on_grid, patch.window, approach, normal_force=patch.normal_force)
        return replace(patch, contact=contact)

    def contact(
        self,
        on_grid: PairOnGrid,
        window: tuple[float, float],
        approach: float,
        *,
        normal_force: float | None = None,
    ) -> NormalContact:
        """Return the contact at an approach [mm], or of this distance under a normal force [N]."""
        down, aside = approach * np.cos(self.roll), -approach * np.sin(self.roll)
        strips = on_grid.grid.strips
        inside = (strips > window[0]) & (strips < window[1])
        distance = np.where(inside, on_grid.distance_at(down, aside), np.inf)
        upright = np.ones(on_grid.grid.n_s)
        problem = NormalProblem(on_grid.grid, on_grid.flat, on_grid.flat, distance, upright)
        try:
            if normal_force is None:
                return solve(problem, approach=0.0)
            return solve(problem, load=normal_force)
        except PotentialAreaTooSmall as short:
            raise _TooShort(on_grid.grid, short.ends) from short

    def fine_grid(self, patch: PlanarPatch, is_main: bool) -> Grid:
        """Return a grid with enough elements across a patch."""
        boxes: list[Box] = boxes_on_grid(patch.on_grid.grid, patch.contact)
        return fitting_grid(boxes, self.elements if is_main else self.elements // 2)


class _TooShort(Failure):
    """A contact that comes near some ends of a grid."""

    def __init__(self, grid: Grid, ends: tuple[str, ...]) -> None:
        super().__init__("the contact comes near the end of its grid")
        self.grid, self.ends = grid, ends


def _longer(grid: Grid, ends: Sequence[str]) -> Grid:
    """Return a grid with more elements at some ends."""
    along_x = 16 if any(end.startswith("x") for end in ends) else 0
    before, after = 8 * ("s < 0" in ends), 8 * ("s > 0" in ends)
    middle = grid.s + (after - before) * grid.ds / 2
    return Grid(grid.n_x + along_x, grid.n_s + before + after, grid.dx, grid.ds, middle)


def _combined(ranges: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return overlaps, of which those nearer to each other than `COMBINED` are one."""
    combined = list(ranges[:1])
    for low, high in ranges[1:]:
        if low - combined[-1][1] < COMBINED:
            combined[-1] = (combined[-1][0], high)
        else:
            combined.append((low, high))
    return combined
