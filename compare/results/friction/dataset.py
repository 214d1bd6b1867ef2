"""What the labelled arrays of rolling and compression have in common: tables of numbers, maps, attributes."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from compare.results.contact.dataset import provenance
from compare.results.friction.bodies import Solver
from compare.results.friction.quantities import Described
from contact.frictional import FrictionalContact
from geometries.arrays import Array
from geometries.patches import DIRECTIONS

Numbers = Mapping[str, float]


def tables(
    quantities: Mapping[str, Described], dims: Sequence[str], rows: Mapping[str, Sequence[Sequence[object]]]
) -> dict[str, xr.Variable]:
    """Variables of quantities by prefix, from nested lists of numbers in the order of the dimensions."""
    return {
        prefix + name: xr.Variable(
            dims,
            _picked(nested, name),
            {"units": quantity.unit, "long_name": quantity.meaning},
        )
        for prefix, nested in rows.items()
        for name, quantity in quantities.items()
    }


def _picked(nested: object, name: str) -> object:
    """The number of a name in each table of nested lists."""
    if isinstance(nested, Mapping):
        return nested[name]
    return [_picked(inner, name) for inner in nested]  # type: ignore[attr-defined]


def differences(fine: Numbers, coarse: Numbers | None, change: Numbers | None) -> dict[str, float]:
    """Estimated errors: differences to elements twice as large, and changes by the estimate of C.

    NaN where nothing is known of larger elements.
    """
    if coarse is None:
        return dict.fromkeys(fine, np.nan)
    return {
        name: abs(value - coarse[name]) + (change[name] if change else 0.0) for name, value in fine.items()
    }


def maps(solver: Solver, contacts: Sequence[Sequence[FrictionalContact]]) -> xr.Dataset:
    """Tractions, sticking and work of friction of contacts by friction and ICs, on their grid."""
    on_grid = ("friction", "ics", "x", "s")
    lower, grid = solver.placed.undeformed.lower, solver.placed.grid

    def of_all(values: object) -> Array:
        return np.array([[values(contact) for contact in row] for row in contacts])  # type: ignore[operator]

    return xr.Dataset(
        {
            "p": ((*on_grid, "direction"), of_all(lambda contact: contact.p), {"units": "MPa"}),
            "stick": (on_grid, of_all(lambda contact: contact.stick)),
            "slip": (
                (*on_grid, "tangential"),
                of_all(lambda contact: contact.slip),
                {"units": "1" if solver.wanted.motion == "rolling" else "mm"},
            ),
            "work": (
                on_grid,
                of_all(lambda contact: contact.dissipation),
                {"units": "MPa" if solver.wanted.motion == "rolling" else "MPa mm"},
            ),
            "inclination": ("s", lower.contour.inclination(grid.strips), {"units": "rad"}),
        },
        coords={
            "x": ("x", solver.placed.x, {"units": "mm"}),
            "s": ("s", grid.strips, {"units": "mm"}),
            "direction": list(DIRECTIONS),
            "tangential": list(DIRECTIONS[:2]),
        },
    )


def attributes(solver: Solver, title: str, seconds: float) -> dict[str, str | float]:
    """What made a file, and what is known of C on its grid."""
    c = solver.reference
    known = (
        {"C_estimate": c.estimate, "C_asymmetry": c.asymmetry, "C_seconds": c.seconds}
        if c is not None
        else {}
    )
    return {
        "title": title,
        "meaning": "tractions on the upper body along x, s, n of the lower surface; slip over that surface",
        **known,
        **provenance(solver.scene, seconds),
    }
