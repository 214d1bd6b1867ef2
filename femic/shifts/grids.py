"""Grids of a contact: one over all patches, fine enough for each and for p_max.

It covers the strips where the undeformed profiles overlap at the approach of the main patch, which is more
than that of several patches together. A patch that no such grid reaches is neglected, with a sentence.
"""

from dataclasses import replace

import numpy as np

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact
from femic.contact.pairs.automatic_grid import sizing_of
from femic.contact.pairs.contact_size import Size, contact_size
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.shifts.sides import Place, Wanted, problem_of
from geometries.bodies import Body
from geometries.grids import Grid
from geometries.track.strips import Strip, strips

SIZING = "Bhat"  # the ICs that size grids and balance the load
MOST_STRIPS = 256  # of a grid over several patches
MOST_ALONG_X = 160  # elements of such a grid, and of finer ones
ACROSS = 8  # elements across each patch, at least, along x and s
COUNTS = 0.01  # share of the pressures from which on a patch counts
ACCURACY = 0.02  # estimated error of p_max, as a share of it, above which the grid is made finer along s
REFINEMENTS = 3  # largest number


def covering(
    place: Place, bodies: dict[str, Body], wanted: Wanted, load: float
) -> tuple[Grid, tuple[str, ...]]:
    """Return a grid that covers all patches, and sentences about those that it had to leave out."""
    sizing, loading = sizing_of(problem_of(bodies, wanted, load)), Loading(load)
    size = contact_size(sizing.bodies, loading, all_patches=False)
    grid = sizing.large_enough(sizing.grid([size]), [loading], [SIZING])
    approach = _solve_on(sizing.bodies, grid, loading).approach
    further = _beside(place, grid, approach)
    if not further:
        return grid, ()
    s = [edge - place.touch.s_rail for strip in further for edge in strip.s_rail]
    wider = sizing.grid([size, Size(size.x, (min(size.s[0], *s), max(size.s[1], *s)))])
    if wider.n_s <= MOST_STRIPS:
        return sizing.large_enough(wider, [loading], [SIZING]), ()
    return grid, tuple(_neglected(bodies, strip, approach, load) for strip in further)


def _solve_on(bodies: PairOnGrid, grid: Grid, loading: Loading) -> NormalContact:
    """Return the contact with the ICs that size grids."""
    on_grid = replace(bodies, grid=grid)
    return on_grid.solve(on_grid.operator(SIZING), loading).normal


def refined(bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid) -> Grid:
    """Return a grid with enough elements across all patches that count, and for p_max; or the finest one."""
    sizing, loading = sizing_of(problem_of(bodies, wanted, load)), Loading(load)

    def solve(on_grid: PairOnGrid) -> SolvedContact:
        return SolvedContact(loading, SIZING, on_grid.solve(on_grid.operator(SIZING), loading))

    for _ in range(REFINEMENTS):
        contact = sizing.on_long_enough_grid(grid, solve)
        grid, finer = contact.on_grid.grid, finer_if_needed(contact)
        if finer is None:
            break
        grid = finer
    return grid


def finer_if_needed(contact: SolvedContact) -> Grid | None:
    """Return a grid of smaller elements where a contact needs them; None where not, or beyond the finest."""
    grid, (along_x, along_s) = contact.on_grid.grid, _factors(contact)
    finer = Grid(along_x * grid.n_x, along_s * grid.n_s, grid.dx / along_x, grid.ds / along_s, grid.s)
    return None if finer == grid or finer.n_x > MOST_ALONG_X or finer.n_s > MOST_STRIPS else finer


def _factors(contact: SolvedContact) -> tuple[int, int]:
    """Return how many times as many elements along x and along s a contact needs: 1 or 2."""
    normal = contact.normal
    shares = [float(np.sum(normal.p[patch.elements]) / np.sum(normal.p)) for patch in normal.patches]
    counting = [patch for patch, share in zip(normal.patches, shares, strict=True) if share >= COUNTS]
    few_x = any(patch.x[1] - patch.x[0] < ACROSS for patch in counting)
    few_s = any(patch.s[1] - patch.s[0] < ACROSS for patch in counting)
    rough = contact.estimated_errors()["p_max"] > ACCURACY * float(np.max(normal.p))
    return 2 if few_x else 1, 2 if few_s or rough else 1


def _beside(place: Place, grid: Grid, approach: float) -> list[Strip]:
    """Return the strips at an approach [mm] that reach beyond a grid and hold a touching point there."""
    start, end = (place.touch.s_rail + edge for edge in grid.extent)
    candidates = strips(place.layout, place.position, place.side, approach)
    return [strip for strip in candidates if any(not start < touch.s_rail < end for touch in strip.touches)]


def _neglected(bodies: dict[str, Body], strip: Strip, approach: float, load: float) -> str:
    """Return a sentence about a patch that is not solved: where it is, and what it carries at most."""
    touch = max(strip.touches, key=lambda each: approach - each.gap)
    modulus = combined_modulus(bodies["upper"].material, bodies["lower"].material)
    depth = (approach - touch.gap) * np.cos(touch.angle)
    across = max(touch.curvature_rail - touch.curvature_wheel, 1e-4)
    point = PointContact(float(np.cos(touch.angle) / touch.radius), across, modulus).at_approach(float(depth))
    share = point.load * np.cos(touch.angle) / load
    return (
        f"a second patch at a contact angle of {np.degrees(touch.angle):.1f} degrees, {touch.gap:.4f} mm "
        "above its rail at first touch, is neglected: by Hertz, with the curvatures there, it carries "
        f"{100 * share:.2g} % of the load at most"
    )
