"""Parts of the labelled arrays of all motions: numbers, their errors, maps."""

from collections.abc import Callable, Mapping, Sequence

import xarray as xr

from femic.contact.estimates import Numbers
from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import Quantity
from geometries.patches import DIRECTIONS

Variables = dict[str, xr.Variable]


def tables(quantities: Mapping[str, Quantity], dim: str, rows: Mapping[str, Sequence[Numbers]]) -> Variables:
    """Variables of quantities by prefix, from lists of numbers along a dimension."""
    return _variables(quantities, lambda prefix, name: (dim, [one[name] for one in rows[prefix]]), rows)


def scalars(quantities: Mapping[str, Quantity], rows: Mapping[str, Numbers]) -> Variables:
    """Variables of quantities by prefix, a number each."""
    return _variables(quantities, lambda prefix, name: ((), rows[prefix][name]), rows)


def _variables(
    quantities: Mapping[str, Quantity],
    values: Callable[[str, str], tuple[str | tuple[()], object]],
    prefixes: Mapping[str, object],
) -> Variables:
    return {
        prefix + name: xr.Variable(
            *values(prefix, name), {"units": quantity.unit, "long_name": quantity.meaning}
        )
        for prefix in prefixes
        for name, quantity in quantities.items()
    }


def maps(pair: PairWithFriction, contact: FrictionalContact) -> xr.Dataset:
    """Tractions, sticking, slip and work of friction of a contact on its grid."""
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
