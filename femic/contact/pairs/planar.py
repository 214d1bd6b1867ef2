"""Planar contact, as programs for it solve it: each patch in a plane of its own, on half-spaces.

The upper body comes down by an approach zeta. Where both profiles then overlap is a patch; parts nearer than
`COMBINED` belong to one. Its plane has the mean inclination of the rail over the overlap, weighted with the
square of its depth: with the vertical depth e at x = 0, this is e^(5/2) dy for a strip over its length along
x, nearly as pressures are distributed. In the plane, ICs are A, and the distance is
that of the displaced bodies along the normal of the plane: nothing is linearised, and elements do not turn.
Patches do not act on each other. The approach is the one at which all patches carry the load together. This
is what the program CONTACT does by default, but for steep patches: docs/theory/contact.md.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.normal import NormalContact, NormalProblem, PotentialAreaTooSmall, solve
from femic.contact.pairs.area_grids import (
    boxes_on_grid,
    finer_grid,
    fitting_grid,
    merge_ranges,
    overlap_half_length,
    overlaps,
)
from femic.contact.pairs.areas import AreaTooSmall
from femic.contact.pairs.grids import extend_grid
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
            "extra_gap: planar contact does not allow it, because it acts along the normals of the lower "
            "surface; leave it out"
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
    approach, which is found on coarse grids first. Raises Failure where no approach has the load.
    """

    def solve_coarse(zeta: float) -> list[PlanarPatch]:
        return _solve_patches([*_coarse_parts(bodies, zeta, roll)], zeta, roll)

    approach = _find_approach(solve_coarse, load, roll, about or 1e-3)
    coarse = solve_coarse(approach)
    main = max(coarse, key=lambda patch: patch.normal_force)
    grids = [
        fitting_grid(
            boxes_on_grid(patch.on_grid.grid, patch.contact), elements if patch is main else elements // 2
        )
        for patch in coarse
    ]

    def solve_fine(zeta: float) -> list[PlanarPatch]:
        parts = [
            (replace(patch.on_grid, grid=grid), patch.window)
            for patch, grid in zip(coarse, grids, strict=True)
        ]
        return _solve_patches(parts, zeta, roll)

    for _ in range(MOST_TRIES):
        try:
            approach = _find_approach(solve_fine, load, roll, approach)
            patches = solve_fine(approach)
            # on all elements under its own force: those twice as large have it, too
            forces = [patch.normal_force for patch in patches]
            parts = [(patch.on_grid, patch.window) for patch in patches]
            patches = _solve_patches(parts, approach, roll, forces)
        except AreaTooSmall as short:
            grids[short.number] = extend_grid(grids[short.number], short.short.ends)
            continue
        finer = [finer_grid(patch.contact, 0.0, 256) or patch.on_grid.grid for patch in patches]
        if finer == grids:
            return PlanarContact(tuple(patches), approach)
        grids = finer
    raise Failure(f"planar contact at {load:g} N: no grids found that it fits")


def _find_approach(
    patches_at: Callable[[float], list[PlanarPatch]], load: float, roll: float, approach: float
) -> float:
    """Return the approach [mm] at which patches carry the load, by the secant in logarithms."""

    def excess(log_approach: float) -> float:
        vertical = sum(
            patch.normal_force * np.cos(patch.plane.angle - roll)
            for patch in patches_at(float(np.exp(log_approach)))
        )
        return float(np.log(max(vertical, 1e-300) / load))

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
        f"planar contact: at an approach of {np.exp(x):.5g} mm it carries {load * np.exp(f):.6g} N, "
        f"not {load:g} N, and no other is found; give another load"
    )


def _coarse_parts(
    bodies: PairOnGrid, approach: float, roll: float
) -> Iterator[tuple[PairOnGrid, tuple[float, float]]]:
    """Yield the bodies over the plane of each overlap at an approach [mm], on a coarse grid; its window."""
    surfaces, down, aside = bodies.undeformed, approach * np.cos(roll), -approach * np.sin(roll)
    assert isinstance(surfaces, Undeformed)
    contour = surfaces.lower.contour
    ranges = merge_ranges(overlaps(surfaces, approach, roll), gap=COMBINED)
    middles = [(one[1] + other[0]) / 2 for one, other in pairwise(ranges)]
    limits = [surfaces.s_range[0], *middles, surfaces.s_range[1]]
    for each, window in zip(ranges, pairwise(limits), strict=True):
        s = np.linspace(*each, SAMPLES)
        inclination = contour.inclination(s)
        depth = np.maximum(-surfaces.vertical_distance(s, down, aside), 0.0)
        weights = depth**2.5 * np.cos(inclination) if np.any(depth) else np.ones_like(s)
        centre = float(np.average(s, weights=weights))
        over = planar(bodies, centre, float(np.average(inclination, weights=weights)))
        plane = over.undeformed
        assert isinstance(plane, TangentPlane)
        along = plane.line.along(contour.position(s))
        low, high = float(np.min(along)), float(np.max(along))
        about = float(np.sqrt(8 * max(down, 1e-9) * plane.upper.circle_radius(np.array(0.0))))
        half_x = overlap_half_length(plane, np.linspace(low, high, 65), (down, aside), about)
        inside = COARSE - 8  # elements over the overlap
        grid = Grid(COARSE, COARSE, 2 * half_x / inside, (high - low) / inside, (low + high) / 2)
        start, end = plane.line.along(contour.position(np.array(window)))
        yield replace(over, grid=grid), (float(start), float(end))


def _solve_patches(
    parts: Sequence[tuple[PairOnGrid, tuple[float, float]]],
    approach: float,
    roll: float,
    normal_forces: Sequence[float] | None = None,
) -> list[PlanarPatch]:
    """Return the patches of bodies over planes and windows at an approach [mm].

    With `normal_forces` [N] they are those under these forces, with the distances at that approach. Raises
    AreaTooSmall where one comes near the end of its grid.
    """
    patches = []
    for number, (on_grid, window) in enumerate(parts):
        strips = on_grid.grid.strips
        inside = (strips > window[0]) & (strips < window[1])
        distance = on_grid.distance_at(approach * np.cos(roll), -approach * np.sin(roll))
        problem = NormalProblem(
            on_grid.grid,
            on_grid.flat,
            on_grid.flat,
            np.where(inside, distance, np.inf),
            np.ones(on_grid.grid.n_s),
        )
        try:
            if normal_forces is None:
                contact = solve(problem, approach=0.0)
            else:
                contact = solve(problem, load=normal_forces[number])
        except PotentialAreaTooSmall as short:
            raise AreaTooSmall(number, short) from short
        patches.append(PlanarPatch(on_grid, window, contact))
    return patches
