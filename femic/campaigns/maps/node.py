"""What a map of C keeps of a scene: C_nn of both bodies on the scene's grid, and B-hat_nn there."""

import numpy as np
import xarray as xr

from compare.contact.compute import c_on
from compare.contact.pair_on_grid import placed_on
from femic.campaigns.maps.c_map import bhat_nn
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene

DIMS = ("lag", "observed", "loaded")
ABOUT = {
    "c": "C_nn of both bodies after the discount",
    "c_estimate": "its estimated error",
    "bhat": "B-hat_nn of both bodies",
}
OF_NODE = frozenset({*DIMS, *ABOUT, "lag_x", "observed_s", "loaded_s"})


def node(scene: Scene, options: RunOptions = DEFAULT) -> xr.Dataset:
    """`c`, `c_estimate`, `bhat` (lag, observed, loaded) [mm/MPa] on the grid of a scene.

    They are what frictionless contact takes, with the strips of the upper body opposite those of the lower
    one. Raises as `femic.reference.matrix.reference.matrices`.
    """
    placed = placed_on(scene, scene.grid)
    ic, estimate = c_on(scene, placed, options)
    values = {"c": ic, "c_estimate": estimate.astype(np.float32), "bhat": bhat_nn(placed)}
    mm = {"units": "mm"}
    return xr.Dataset(
        {name: (DIMS, value, {"units": "mm/MPa", "long_name": ABOUT[name]}) for name, value in values.items()}
        | {
            "lag_x": ("lag", scene.grid.lags, mm | {"long_name": "lag along x"}),
            "observed_s": ("observed", scene.grid.strips, mm | {"long_name": "arc length of a strip"}),
            "loaded_s": ("loaded", scene.grid.strips, mm | {"long_name": "arc length of a strip"}),
        }
    )
