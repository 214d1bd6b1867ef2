"""Maps of contacts with friction as labelled arrays, and what the maps and numbers vary by.

Beside a number `NAME` stand `larger_NAME`, the number on elements twice as large (in compression with steps
of load twice as large, too), and `change_NAME`, by how much it changes with ICs plus their estimated errors:
0 where no errors are known, as of approximations; and `floor_NAME`, by how much it may change against that of
other ICs on the same elements where single elements are in another state. `larger_p`, over `larger_x` and
`larger_s`, and `change_p` are those of the tractions. `compare.friction.differences` makes estimates of
differences from them.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from compare.contact.dataset import PREFIXES, S, X
from femic.contact.estimates import Measured
from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import Quantity
from femic.contact.pairs.variations import Change
from geometries.arrays import Array
from geometries.patches import DIRECTIONS

TRACTION = "traction on the upper body"
SIMPLIFIED = {"long_name": "whether only the less accurate form was solved"}
LARGER, CHANGE = "larger_", "change_"  # before the names of numbers, of tractions, and of places
FLOOR = "floor_"  # before the names of numbers
APART = 0.025  # share of a floor that two ICs do not have in common; of some numbers it is another one
APART_OF = (
    dict.fromkeys(("area", "sliding_share"), 0.1)
    | dict.fromkeys(("F_x", "dissipation"), 0.035)
    | dict.fromkeys(("M_x", "M_z", "approach", "a"), 0.0125)
)


def floors(contact: Measured | None, quantities: Mapping[str, Quantity]) -> dict[str, float]:
    """Return the parts of the floors of numbers that two ICs do not have in common; NaN for no contact.

    Edges and borders cut the same elements with both nearly alike; whether an element counts as in contact,
    or as sliding, is no continuous error, and less common to both. Shares were found as those of
    `femic.contact.error_floors`.
    """
    return {
        name: np.nan if contact is None else contact.floor(name, quantity.kind) * APART_OF.get(name, APART)
        for name, quantity in quantities.items()
    }


def maps(pair: PairWithFriction, contact: FrictionalContact) -> xr.Dataset:
    """Return tractions, sticking, slip and work of friction of a contact on its grid."""
    on_grid, unit = ("x", "s"), pair.motion.slip_unit
    work = "MPa" if unit == "1" else f"MPa {unit}"
    return xr.Dataset(
        {
            "p": ((*on_grid, "direction"), contact.p, {"units": "MPa", "long_name": TRACTION}),
            "stick": (on_grid, contact.stick, {"long_name": "whether the element sticks"}),
            "slip": ((*on_grid, "tangential"), contact.slip, {"units": unit, "long_name": "slip"}),
            "work": (on_grid, contact.dissipation, {"units": work, "long_name": "work of friction"}),
        },
        coords={
            "x": ("x", pair.on_grid.x, X),
            "s": ("s", pair.on_grid.grid.strips, S),
            "direction": list(DIRECTIONS),
            "tangential": list(DIRECTIONS[:2]),
        },
    )


def varied_tractions(pair: PairWithFriction, larger: FrictionalContact | None, change: Change) -> xr.Dataset:
    """Return tractions on elements twice as large, NaN without such a contact, and changes of tractions."""
    places = {f"{LARGER}x": (pair.on_grid.x, X), f"{LARGER}s": (pair.on_grid.grid.strips, S)}
    coords = {
        name: (name, _larger(at), attributes | {"long_name": attributes["long_name"] + PREFIXES[LARGER]})
        for name, (at, attributes) in places.items()
    }
    shape = (*(len(at) for _, at, _ in coords.values()), len(DIRECTIONS))
    p = np.full(shape, np.nan) if larger is None else larger.p
    units = {
        prefix: {"units": "MPa", "long_name": TRACTION + PREFIXES[prefix]} for prefix in (LARGER, CHANGE)
    }
    return xr.Dataset(
        {
            f"{LARGER}p": ((*coords, "direction"), p, units[LARGER]),
            f"{CHANGE}p": (("x", "s", "direction"), change.p, units[CHANGE]),
        },
        coords=coords,
    )


def _larger(places: Array) -> Array:
    """Return the centres of elements twice as large, without the last element of an odd number."""
    return places[: len(places) // 2 * 2].reshape(-1, 2).mean(axis=1)
