"""The effect of the supports of the bodies on a contact with friction."""

import xarray as xr

from compare.contact.dataset import PREFIXES, variables
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.supports import changed_supports_with_friction
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene
from geometries.grids import Grid

PREFIX = "supported_"  # of the names of numbers with other supports


def with_supports(scene: Scene, dataset: xr.Dataset, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return the arrays of a motion with `supported_NAME` (supports): one contact with C on other supports.

    It has the least coefficient of friction; rolling is at the creepage nearest 0, a compression after its
    last load. `supported_friction`, and `supported_xi` or `supported_load`, say so. The arrays are
    unchanged where they have no C, or the scene does not request it. Raises NotConverged as `matrices`.
    """
    if C not in dataset.ics.values or not scene.contact.supports:
        return dataset
    problem, friction = scene.contact_problem, float(dataset.friction.min())
    pair = PairWithFriction(problem, pair_on_grid(problem, grid_of(dataset)), options)
    points = changed_supports_with_friction(pair, friction)
    if not points:
        return dataset
    places, numbers = zip(*points.values(), strict=True)
    supported = xr.Dataset(
        variables(pair.motion.quantities, "supports", {PREFIX: numbers}), coords={"supports": list(points)}
    )
    own = {"friction": friction, pair.motion.dimension: places[0]}
    for name, value in own.items():
        about = dataset[name].attrs
        meaning = about["long_name"] + PREFIXES[PREFIX]
        supported[PREFIX + name] = (), value, about | {"long_name": meaning}
    return dataset.merge(supported)


def grid_of(dataset: xr.Dataset) -> Grid:
    """Return the grid of the arrays, to the last digit: C on it is in the store."""
    dx, ds, middle = (float(dataset.attrs[name]) for name in ("dx", "ds", "s_middle"))
    return Grid(dataset.sizes["x"], dataset.sizes["s"], dx, ds, middle)
