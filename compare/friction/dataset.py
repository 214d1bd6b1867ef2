"""Maps of contacts with friction as labelled arrays."""

import xarray as xr

from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.pair_with_friction import PairWithFriction
from geometries.patches import DIRECTIONS


def maps(pair: PairWithFriction, contact: FrictionalContact) -> xr.Dataset:
    """Return tractions, sticking, slip and work of friction of a contact on its grid."""
    on_grid, unit = ("x", "s"), pair.motion.slip_unit
    return xr.Dataset(
        {
            "p": ((*on_grid, "direction"), contact.p, {"units": "MPa"}),
            "stick": (on_grid, contact.stick),
            "slip": ((*on_grid, "tangential"), contact.slip, {"units": unit}),
            "work": (on_grid, contact.dissipation, {"units": "MPa" if unit == "1" else f"MPa {unit}"}),
        },
        coords={
            "x": ("x", pair.on_grid.x, {"units": "mm"}),
            "s": ("s", pair.on_grid.grid.strips, {"units": "mm"}),
            "direction": list(DIRECTIONS),
            "tangential": list(DIRECTIONS[:2]),
        },
    )
