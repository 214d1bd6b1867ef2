"""What the supports of the bodies do to a contact with friction: one contact by C with others.

It is that with the least coefficient of friction; of rolling at the creepage nearest 0, of a compression
after the last load.
"""

from collections.abc import Mapping

import xarray as xr

from compare.contact.compute import C
from compare.contact.pair_on_grid import placed_on
from compare.contact.supports import other_supports
from compare.friction.bodies import Solver
from compare.friction.compression import in_steps
from compare.friction.curve import Path
from compare.friction.dataset import tables
from compare.friction.operators import full_operator
from compare.friction.quantities import OF_PATCH, OF_ROLLING, Quantity
from femic.contact.frictional import FrictionalProblem
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene
from geometries.errors import Failure
from geometries.grids import Grid

PREFIX = "supported_"  # of the names of numbers with other supports


def with_supports(scene: Scene, dataset: xr.Dataset, options: RunOptions = DEFAULT) -> xr.Dataset:
    """The arrays of a motion with `supported_NAME` (supports): numbers of a contact by C with others.

    `supported_friction`, and `supported_xi` or `supported_load`, say which. The arrays are as they were where
    they have no C, or the scene wants none of it. Raises NotConverged as `matrices`.
    """
    if C not in dataset.ics.values or not scene.contact.supports:
        return dataset
    solver = Solver(scene, placed_on(scene, _grid(dataset)), options)
    place, rows = _place(dataset), dict[str, Mapping[str, float]]()
    for name, references, variation in other_supports(scene, solver.placed, options):
        problem = solver.problem(
            full_operator(scene, solver.placed, references, variation), place["friction"]
        )
        try:
            rows[name] = _numbers(solver, problem, name)
        except Failure as failure:
            options.watch.on_stage(f"  left out, {name}: {failure}")
    if not rows:
        return dataset
    quantities = of_motion(scene.contact.motion)
    found = xr.Dataset(
        tables(quantities, "supports", {PREFIX: list(rows.values())}), coords={"supports": list(rows)}
    )
    return dataset.merge(found).assign({PREFIX + dim: value for dim, value in place.items()})


def of_motion(motion: str) -> Mapping[str, Quantity]:
    """The quantities of a motion."""
    return OF_ROLLING if motion == "rolling" else OF_PATCH


def _place(dataset: xr.Dataset) -> dict[str, float]:
    """The coefficient of friction and the creepage or load of the contact, by the names of dimensions."""
    place = {"friction": float(dataset.friction.min())}
    if "xi" in dataset.dims:
        return place | {"xi": min(map(float, dataset.xi.values), key=abs)}
    return place | {"load": float(dataset["load"][-1])}


def _numbers(solver: Solver, problem: FrictionalProblem, label: str) -> Mapping[str, float]:
    """The numbers of the contact. Raises Failure where it is not found on the grid."""
    if solver.wanted.motion == "rolling":
        path = Path.of(solver, problem, label)
        return path.measured(path.at(min(path.xi, key=abs), None)).numbers
    return in_steps(solver, problem, solver.scene.contact.loads, label)[0][-1].numbers


def _grid(dataset: xr.Dataset) -> Grid:
    """The grid of the arrays, to the last digit: C on it is kept."""
    dx, ds, middle = (float(dataset.attrs[name]) for name in ("dx", "ds", "s_middle"))
    return Grid(dataset.sizes["x"], dataset.sizes["s"], dx, ds, middle)
