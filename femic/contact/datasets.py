"""What datasets of contacts are: units and meanings, maps, variations, estimates of differences between ICs.

Beside a number `NAME` stand `larger_NAME`, the number on elements twice as large (in compression with steps
of load twice as large, too), and `change_NAME`, by how much it changes with ICs plus their estimated errors:
0 where no errors are known, as of approximations; and `floor_NAME`, by how much it may change against that of
other ICs on the same elements where single elements are in another state; and `missed_NAME`, the share of
its differences between ICs that elements may miss. `larger_p`, over `larger_x` and `larger_s`, and `change_p`
are those of the tractions.

From these follow estimates of differences between the contacts of several ICs, such as distances to C. On the
same elements much of the error of both contacts is the same, and is no error of their difference. So a
difference is evaluated again on elements twice as large, with numbers plus their floors, and with changed
ICs: its error is estimated as

    F |d_h - d_2h| + m |d| + sum over ICs of |d(number + floor) - d|
    + sum over ICs of max over +- of |d(ICs +- their estimated errors) - d|,

with F = 1.25 and the first order of `femic.contact.estimates`. Two grids may agree by luck: elements know a
difference, like any number, to a share m of itself, which falls with the part of elements at the edge of the
contact; and ICs whose edges and borders are not the same cut elements in other places (`difference_errors`).
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
import xarray as xr

from femic.contact.estimates import EDGE, SAFETY, Measured
from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import Quantity
from geometries.arrays import Array
from geometries.patches import DIRECTIONS, Grid

# --- labels ---

X = {"units": "mm", "long_name": "place along the direction of rolling"}
S = {"units": "mm", "long_name": "arc length of the lower contour"}
SECONDS = {"units": "s", "long_name": "time of the solution, without C"}
INCLINATION = {"units": "rad", "long_name": "inclination of the lower contour"}
TRACTION = "traction on the upper body"
SIMPLIFIED = {"long_name": "whether the contact was only solved in the less accurate form"}
LARGER, CHANGE = "larger_", "change_"  # before the names of numbers, of tractions, and of places
FLOOR, MISSED = "floor_", "missed_"  # before the names of numbers
DISPLACED, STEADY = "displaced_", "steady_"
PREFIXES = {  # before the name of a quantity: what the variable is besides its meaning
    "": "",
    "estimate_": ": estimated error",
    DISPLACED: ": with the exact distance of the displaced body",
    "supported_": ": with other supports",
    LARGER: ": on elements twice as large",
    CHANGE: ": change with the ICs plus their estimated errors",
    FLOOR: ": change if single elements change their state",
    MISSED: ": share of differences between ICs that elements may miss",
    STEADY: ": in steady rolling",
    f"estimate_{STEADY}": ": estimated error in steady rolling",
}


def variables(
    quantities: Mapping[str, Quantity], dims: str | tuple[str, ...], tables: Mapping[str, object]
) -> dict[str, xr.Variable]:
    """Return variables PREFIX + NAME of quantities; `tables` has nested lists of numbers by `PREFIXES`."""
    return {
        prefix + name: xr.Variable(
            dims,
            np.vectorize(itemgetter(name), otypes=[float])(table),
            {
                "units": "1" if prefix == MISSED else quantity.unit,
                "long_name": quantity.meaning + PREFIXES[prefix],
            },
        )
        for prefix, table in tables.items()
        for name, quantity in quantities.items()
    }


def read_grid(dataset: xr.Dataset) -> Grid:
    """Return the grid of contacts with friction, to the last digit: C on it is in the store."""
    dx, ds, middle = (float(dataset.attrs[name]) for name in ("dx", "ds", "s_middle"))
    return Grid(dataset.sizes["x"], dataset.sizes["s"], dx, ds, middle)


# --- maps and variations ---


def maps(on_grid: PairOnGrid, contact: FrictionalContact, slip_unit: str = "1") -> xr.Dataset:
    """Return tractions, sticking, slip and work of friction of a contact on its grid.

    Slip is per unit of rolled distance, or in another unit.
    """
    places, work = ("x", "s"), "MPa" if slip_unit == "1" else f"MPa {slip_unit}"
    return xr.Dataset(
        {
            "p": ((*places, "direction"), contact.p, {"units": "MPa", "long_name": TRACTION}),
            "stick": (places, contact.stick, {"long_name": "whether the element sticks"}),
            "slip": ((*places, "tangential"), contact.slip, {"units": slip_unit, "long_name": "slip"}),
            "work": (places, contact.dissipation, {"units": work, "long_name": "work of friction"}),
        },
        coords={
            "x": ("x", on_grid.x, X),
            "s": ("s", on_grid.grid.strips, S),
            "direction": list(DIRECTIONS),
            "tangential": list(DIRECTIONS[:2]),
        },
    )


def varied_tractions(on_grid: PairOnGrid, larger: FrictionalContact | None, change: Array) -> xr.Dataset:
    """Return tractions on elements twice as large, NaN without such a contact, and changes of tractions.

    `change` [MPa], (n_x, n_s, 3), is that with ICs plus their estimated errors.
    """
    coords = {}
    for name, places, about in (("x", on_grid.x, X), ("s", on_grid.grid.strips, S)):
        centres = places[: len(places) // 2 * 2].reshape(-1, 2).mean(axis=1)
        coords[LARGER + name] = (
            LARGER + name,
            centres,
            about | {"long_name": about["long_name"] + PREFIXES[LARGER]},
        )
    shape = (*(len(at) for _, at, _ in coords.values()), len(DIRECTIONS))
    p = np.full(shape, np.nan) if larger is None else larger.p
    about_larger, about_change = (
        {"units": "MPa", "long_name": TRACTION + PREFIXES[prefix]} for prefix in (LARGER, CHANGE)
    )
    return xr.Dataset(
        {
            f"{LARGER}p": ((*coords, "direction"), p, about_larger),
            f"{CHANGE}p": (("x", "s", "direction"), change, about_change),
        },
        coords=coords,
    )


# --- differences between ICs ---


@dataclass(frozen=True)
class Shares:
    """By name of a number: what of its floor two ICs do not have in common, what of a difference is missed.

    The latter is a share of the part of elements that are at the edge of the contact.
    """

    floors: Mapping[str, float]
    missed: Mapping[str, float]


OF_FLOOR, OF_DIFFERENCE = 0.025, 0.3  # shares of numbers that are not named
WITH_FRICTION = Shares(
    dict.fromkeys(("area", "sliding_share"), 0.1)
    | {"dissipation": 0.042, "F_x": 0.036, "F_y": 0.022, "M_x": 0.008, "M_z": 0.017}
    | {"approach": 0.01, "a": 0.0125, "b": 0.03, "angle": 0.03},
    {},
)
WITHOUT_FRICTION = Shares(  # pressures are smooth where no border parts stick and slip
    {"area": 0.08, "stiffness": 0.035, "F_y": 0.02, "M_x": 0.02}
    | {"a": 0.0028, "b": 0.005, "angle": 0.005, "aspect": 0.0035}
    | {"p_max": 0.0003, "approach": 0.0},
    {"p_max": 0.1, "approach": 0.08},
)


def difference_errors(
    contact: Measured | None, quantities: Mapping[str, Quantity], shares: Shares = WITH_FRICTION
) -> dict[str, dict[str, float]]:
    """Return what elements may do to differences between ICs, by `FLOOR` and `MISSED`; NaN for no contact.

    Edges and borders cut the same elements with both nearly alike; whether an element counts as in contact,
    or as sliding, is no continuous error, and less common to both. Shares were found as those of
    `femic.contact.estimates`.
    """
    if contact is None:
        return {prefix: dict.fromkeys(quantities, np.nan) for prefix in (FLOOR, MISSED)}
    floors = {
        name: contact.floor(name, quantity.kind) * shares.floors.get(name, OF_FLOOR)
        for name, quantity in quantities.items()
    }
    at_edge = contact.floors[EDGE]
    return {
        FLOOR: floors,
        MISSED: {name: at_edge * shares.missed.get(name, OF_DIFFERENCE) for name in quantities},
    }


def difference_errors_of_all(
    contacts: Iterable[Measured | None], quantities: Mapping[str, Quantity]
) -> dict[str, list[dict[str, float]]]:
    """Return the same for several contacts with friction."""
    rows = [difference_errors(contact, quantities) for contact in contacts]
    return {prefix: [row[prefix] for row in rows] for prefix in (FLOOR, MISSED)}


OF_UNKNOWN_EDGE = 0.07  # share of a difference that is missed where the part at edges is not known

Difference = Callable[[xr.Dataset], xr.DataArray]
Norm = Callable[[xr.DataArray], xr.DataArray]


def on_larger_elements(dataset: xr.Dataset) -> xr.Dataset:
    """Return numbers and tractions on elements twice as large, by the same names; NaN where missing."""
    names = _varied_names(dataset, LARGER)
    places = [name for name in ("x", "s") if LARGER + name in dataset.coords]
    return dataset[[LARGER + name for name in names]].rename(
        {LARGER + name: name for name in (*names, *places)}
    )


def with_variation(dataset: xr.Dataset, prefix: str, ics: str, sign: float = 1.0) -> xr.Dataset:
    """Return the contacts with the numbers of some ICs plus (sign 1) or minus (-1) a variation of them.

    `prefix` is `FLOOR`, or `CHANGE` for that by the estimated errors of the ICs.
    """
    varied = dataset.ics == ics
    return dataset.assign(
        {
            name: dataset[name] + sign * dataset[prefix + name].where(varied, 0.0)
            for name in _varied_names(dataset, prefix)
        }
    )


def estimate_of_difference(dataset: xr.Dataset, difference: Difference, norm: Norm = abs) -> xr.DataArray:
    """Return the estimated error of a difference between contacts; NaN where it is not known.

    `difference` takes it from contacts; its sign is of use, where it has one. `norm` makes a size of several
    differences: by the triangle inequality the sizes are as far apart as the size of what changes, at most.
    """
    given, changes = difference(dataset), _varied_names(dataset, CHANGE)
    size = norm(given)
    estimate = SAFETY * norm(difference(on_larger_elements(dataset)) - given) + _missed(dataset, size)
    if _varied_names(dataset, FLOOR):
        for ics in dataset.ics.values:
            estimate = estimate + norm(difference(with_variation(dataset, FLOOR, ics)) - given)
    for ics in dataset.ics.values:
        if any(bool((dataset[CHANGE + name].sel(ics=ics) != 0).any()) for name in changes):  # NaN, too
            both = [
                norm(difference(with_variation(dataset, CHANGE, ics, sign)) - given) for sign in (1.0, -1.0)
            ]
            estimate = estimate + xr.concat(both, "sign").max("sign", skipna=False)
    return estimate


def _missed(dataset: xr.Dataset, size: xr.DataArray) -> xr.DataArray:
    """Return what elements may miss of a difference of a size; the largest share of all numbers counts."""
    shares = [dataset[MISSED + name] for name in _varied_names(dataset, MISSED)]
    if not shares:
        return OF_UNKNOWN_EDGE * size
    of_names = [share.max([dim for dim in share.dims if dim not in size.dims]) for share in shares]
    return size * xr.concat(xr.broadcast(*of_names), "name").max("name")


def _varied_names(dataset: xr.Dataset, prefix: str) -> list[str]:
    """Return the names of what a prefix gives a variation of."""
    return [str(name).removeprefix(prefix) for name in dataset.data_vars if str(name).startswith(prefix)]
