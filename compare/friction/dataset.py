"""What the labelled arrays of rolling and compression have in common: numbers, their errors, maps."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from compare.friction.bodies import Solver
from compare.friction.quantities import Described, kinds
from femic.contact.estimates import Measured, estimates, summed
from femic.contact.frictional import FrictionalContact
from geometries.patches import DIRECTIONS

Numbers = Mapping[str, float]
Variables = dict[str, xr.Variable]


def tables(quantities: Mapping[str, Described], dim: str, rows: Mapping[str, Sequence[Numbers]]) -> Variables:
    """Variables of quantities by prefix, from lists of numbers along a dimension."""
    return _variables(quantities, lambda prefix, name: (dim, [one[name] for one in rows[prefix]]), rows)


def scalars(quantities: Mapping[str, Described], rows: Mapping[str, Numbers]) -> Variables:
    """Variables of quantities by prefix, a number each."""
    return _variables(quantities, lambda prefix, name: ((), rows[prefix][name]), rows)


def _variables(
    quantities: Mapping[str, Described],
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


def errors(
    quantities: Mapping[str, Described],
    fine: Measured | None,
    larger: Sequence[Measured | None],
    others: Sequence[Numbers] = (),
) -> dict[str, float]:
    """Estimated errors from elements twice and four times as large, and other parts that are added.

    NaN where nothing is known of the contact, or of elements twice as large.
    """
    coarse, coarser = (*larger, None, None)[:2]
    if fine is None or coarse is None:
        return dict.fromkeys(quantities, np.nan)
    of_grids = estimates(
        fine, kinds(quantities), coarse.numbers, None if coarser is None else coarser.numbers
    )
    return summed([of_grids, *others])


def maps(solver: Solver, contact: FrictionalContact) -> xr.Dataset:
    """Tractions, sticking, slip and work of friction of a contact on its grid."""
    on_grid, rolls = ("x", "s"), solver.wanted.motion == "rolling"
    return xr.Dataset(
        {
            "p": ((*on_grid, "direction"), contact.p, {"units": "MPa"}),
            "stick": (on_grid, contact.stick),
            "slip": ((*on_grid, "tangential"), contact.slip, {"units": "1" if rolls else "mm"}),
            "work": (on_grid, contact.dissipation, {"units": "MPa" if rolls else "MPa mm"}),
        },
        coords={
            "x": ("x", solver.placed.x, {"units": "mm"}),
            "s": ("s", solver.placed.grid.strips, {"units": "mm"}),
            "direction": list(DIRECTIONS),
            "tangential": list(DIRECTIONS[:2]),
        },
    )
