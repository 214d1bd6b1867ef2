"""The grid of a file for CONTACT, which is that of the scene's contact, and the distances on it."""

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from femic.cache.files import write_text
from femic.contact.loading import Loading
from femic.contact.pairs.automatic_grid import grids_of
from femic.contact.pairs.contact_size import SIZING, contact_size
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.scenes.ic_names import is_map
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.errors import Failure

FILE = "contact_distances.txt"
FAR = 1000.0  # mm: written where no upper body is opposite, for CONTACT reads no infinite numbers


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of the bodies along n [mm], (n_x, n_s), after an approach [mm], and which that is."""

    values: Array
    approach: float
    meaning: str


def grid_is_given(scene: Scene) -> bool:
    """Whether a file has the grid of the scene's table [grid]: it is there, or the contact has no loads."""
    own = set(tomllib.loads(scene.text).get("grid", {})) - {"check"}
    return bool(own) or not scene.contact.loadings or not scene.contact.automatic


def on_contact_grid(scene: Scene) -> Scene:
    """Return a scene with the grid of its contact under the largest load, or with its own where it has one.

    The grid is sized as for contact with C, so that it has no more strips than C is computed for.
    """
    if grid_is_given(scene):
        return scene
    problem = scene.contact_problem
    names = [name for name in problem.specification.ics if not is_map(name)]
    specification = replace(problem.specification, ics=tuple(dict.fromkeys((C, *names))))
    grid, _ = grids_of(replace(problem, specification=specification))[-1]
    return replace(scene, grid=grid)


def largest_loading(scene: Scene) -> Loading | None:
    """Return the largest load of a scene's contact, or its largest approach; None where it has neither."""
    loadings = scene.contact.loadings
    return max(loadings, key=lambda each: (each.load or 0.0, each.approach or 0.0), default=None)


def missed_contact(scene: Scene) -> str:
    """Return a sentence where the contact of a scene under the largest load leaves its grid; else nothing."""
    loading, grid = largest_loading(scene), scene.grid
    if loading is None:
        return ""
    try:
        size = contact_size(pair_on_grid(scene.contact_problem, grid), loading)
    except Failure as failure:
        return f"whether contact is on the grid is not known: {failure}"
    low, high = grid.extent
    half = grid.n_x * grid.dx / 2
    if low <= size.s[0] and size.s[1] <= high and size.x[1] <= half:
        return ""
    return (
        f"the grid misses contact: it covers s = {low:.4g} ... {high:.4g} mm, x = {-half:.4g} ... {half:.4g} "
        f"mm, and contact at {loading} is at s = {size.s[0]:.4g} ... {size.s[1]:.4g} mm, x = "
        f"{size.x[0]:.4g} ... {size.x[1]:.4g} mm: leave [grid] out and contact.grid at 'automatic', or give "
        f"grid.s = {(size.s[0] + size.s[1]) / 2:.3g} and elements that cover it"
    )


def distances(scene: Scene) -> Distances:
    """Return the distances on a scene's grid after the approach of its largest load, which B-hat tells.

    Without loads, and where contact is not on the grid, they are those of bodies that just touch.
    """
    on_grid, loading = pair_on_grid(scene.contact_problem, scene.grid), largest_loading(scene)
    if loading is None:
        return distances_after(
            on_grid, 0.0, "the bodies just touch: subtract zeta cos(delta) for an approach zeta"
        )
    try:
        contact = on_grid.solve(on_grid.operator(SIZING), loading)
    except Failure as failure:
        return distances_after(on_grid, 0.0, f"the bodies just touch, as no approach was found: {failure}")
    by_load = f"the approach by B-hat at {loading}; the load is a result"
    meaning = by_load if loading.approach is None else "as contact.approaches says"
    if scene.contact.exact:
        meaning += "; linearised, whatever contact.gap says"
    return distances_after(contact.on_grid, contact.normal.approach, meaning)


def distances_after(on_grid: PairOnGrid, approach: float, meaning: str = "") -> Distances:
    """Return h - approach cos(delta) on a grid, where h are the distances of bodies that just touch."""
    values = on_grid.distance - approach * on_grid.cosine
    return Distances(np.where(np.isfinite(values), values, FAR), approach, meaning)


def write_distances(found: Distances, folder: Path) -> Path:
    """Write distances as a list for CONTACT, x fastest; return the path of the file."""
    lines = "\n".join(repr(float(value)) for value in found.values.T.ravel())
    return write_text(f"{lines}\n", folder / FILE)
