"""Parts of the datasets of all contacts with friction: maps, variations, differences of ICs, other supports.

Beside a number `NAME` stand `larger_NAME`, the number on elements twice as large (in compression with steps
of load twice as large, too), and `change_NAME`, by how much it changes with ICs plus their estimated errors:
0 where no errors are known, as of approximations; and `floor_NAME`, by how much it may change against that of
other ICs on the same elements where single elements are in another state. `larger_p`, over `larger_x` and
`larger_s`, and `change_p` are those of the tractions.

From these follow estimates of differences between the contacts of several ICs, such as distances to C. On the
same elements much of the error of both contacts is the same, and is no error of their difference. So a
difference is evaluated again on elements twice as large, with numbers plus their floors, and with changed
ICs: its error is estimated as

    F |d_h - d_2h| + |d| / 20 + sum over ICs of |d(number + floor) - d|
    + sum over ICs of max over +- of |d(ICs +- their estimated errors) - d|,

with F = 1.25 and the first order of `femic.contact.estimates`. Two grids may agree by luck: elements know a
difference, like any number, to a share of itself; and ICs whose edges and borders are not the same cut
elements in other places (`floors`).

Each solution is stored as soon as it is finished.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.contact.estimates import SAFETY, Measured
from femic.contact.friction.motion import friction_factors, in_words
from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.ics import C, c_jobs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.pair_with_friction import Change, PairWithFriction
from femic.contact.pairs.quantities import Quantity
from femic.contact.pairs.supports import changed_supports_with_friction
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import INCLINATION, PREFIXES, SECONDS, S, X, ics_of, variables
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.patches import DIRECTIONS, Grid

# --- maps and variations --------------------------------------------------------------------------------


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
    `femic.contact.estimates`.
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


# --- differences between ICs ----------------------------------------------------------------------------


MISSED = 0.05  # share of a difference that elements may miss

Difference = Callable[[xr.Dataset], xr.DataArray]
Norm = Callable[[xr.DataArray], xr.DataArray]


def on_larger_elements(dataset: xr.Dataset) -> xr.Dataset:
    """Return numbers and tractions on elements twice as large, by the same names; NaN where missing."""
    names = _varied_names(dataset, LARGER)
    places = [name for name in ("x", "s") if LARGER + name in dataset.coords]
    return dataset[[LARGER + name for name in names]].rename(
        {LARGER + name: name for name in (*names, *places)}
    )


def with_floors(dataset: xr.Dataset, ics: str) -> xr.Dataset:
    """Return the contacts with the numbers of some ICs plus their floors."""
    at = dataset.ics == ics
    names = _varied_names(dataset, FLOOR)
    return dataset.assign({name: dataset[name] + dataset[FLOOR + name].where(at, 0.0) for name in names})


def with_changed_ics(dataset: xr.Dataset, ics: str, sign: float) -> xr.Dataset:
    """Return the contacts with some ICs plus (sign 1) or minus (-1) their estimated errors."""
    at = dataset.ics == ics
    changed = {
        name: dataset[name] + sign * dataset[CHANGE + name].where(at, 0.0)
        for name in _varied_names(dataset, CHANGE)
    }
    return dataset.assign(changed)


def estimate_of_difference(dataset: xr.Dataset, difference: Difference, norm: Norm = abs) -> xr.DataArray:
    """Return the estimated error of a difference between contacts; NaN where it is not known.

    `difference` takes it from contacts; its sign is of use, where it has one. `norm` makes a size of several
    differences: by the triangle inequality the sizes are as far apart as the size of what changes, at most.
    """
    given = difference(dataset)
    estimate = SAFETY * norm(difference(on_larger_elements(dataset)) - given) + MISSED * norm(given)
    if _varied_names(dataset, FLOOR):
        for ics in ics_of(dataset):
            estimate = estimate + norm(difference(with_floors(dataset, ics)) - given)
    for ics in _with_known_errors(dataset):
        ways = [norm(difference(with_changed_ics(dataset, ics, sign)) - given) for sign in (1.0, -1.0)]
        estimate = estimate + xr.concat(ways, "sign").max("sign", skipna=False)
    return estimate


def _varied_names(dataset: xr.Dataset, prefix: str) -> list[str]:
    """Return the names of what a prefix gives a variation of."""
    return [str(name).removeprefix(prefix) for name in dataset.data_vars if str(name).startswith(prefix)]


def _with_known_errors(dataset: xr.Dataset) -> list[str]:
    """Return the ICs by which anything changes; those of unknown changes, NaN, are among them."""
    changes = [dataset[CHANGE + name] for name in _varied_names(dataset, CHANGE)]
    return [name for name in ics_of(dataset) if any(bool((one.sel(ics=name) != 0).any()) for one in changes)]


# --- other supports -------------------------------------------------------------------------------------


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


# --- solutions by friction and ICs ----------------------------------------------------------------------


FRICTION = {"units": "1", "long_name": "coefficient of friction"}
FACTOR = {"units": "1", "long_name": "factor of friction by the contact angle"}
Labelled = Callable[[PairWithFriction, Any], xr.Dataset]  # a solution, which has its `seconds`, as arrays


def by_friction_and_ics(pair: PairWithFriction, labelled: Labelled) -> xr.Dataset:
    """Return the solutions along the dimensions friction and ICs."""
    by_angle = pair.specification.friction_by_angle
    frictions, ics = pair.specification.coefficients, pair.problem.specification.ics
    parts = {
        (friction, name): _solve_or_load(pair, friction, name, labelled)
        for name in ics
        for friction in frictions
    }
    rows = [xr.concat([parts[friction, name] for name in ics], "ics") for friction in frictions]
    joined = xr.concat(rows, "friction").assign_coords(
        friction=("friction", list(frictions), FRICTION), ics=list(ics)
    )
    grid = pair.on_grid.grid
    inclination = pair.on_grid.undeformed.lower.contour.inclination(grid.strips)
    joined["inclination"] = "s", inclination, INCLINATION
    joined["friction_factor"] = "s", friction_factors(by_angle, inclination), FACTOR
    c_quality = parts[frictions[0], C].attrs if C in ics else {}
    words = {"friction_by_angle": in_words(by_angle)}
    exact = {"dx": grid.dx, "ds": grid.ds, "s_middle": grid.s}  # differences of coordinates are rounded
    return joined.drop_attrs(deep=False).assign_attrs(c_quality | exact | words)


def _solve_or_load(pair: PairWithFriction, friction: float, name: str, labelled: Labelled) -> xr.Dataset:
    """Return a solution, from the store if it is there."""
    store, solve = pair.options.store, pair.motion.solve
    assert solve is not None
    key = store.key("friction", results_digest(), *_inputs(pair, friction, name))
    part = store.get(key)
    if part is None:
        solution = solve(pair, friction, name)
        part = labelled(pair, solution).assign(seconds=((), solution.seconds, SECONDS))
        part = part.assign_attrs(_c_quality(pair, name))
        store.put(key, part)
    else:
        pair.options.watch.on_stage(f"  friction {friction:g}, {name}: stored by an earlier run")
    return part


def _c_quality(pair: PairWithFriction, name: str) -> dict[str, float | str]:
    """Return errors and cost of C on the grid; empty for other ICs and for given C."""
    if name != C or name in pair.given:
        return {}
    c = pair.reference
    return {
        "C_estimate": c.estimate,
        "C_asymmetry": c.asymmetry.share,
        "C_asymmetry_component": c.asymmetry.component,
        "C_seconds": c.seconds,
    }


def _inputs(pair: PairWithFriction, friction: float, name: str) -> tuple[object, ...]:
    """Return the inputs that a solution depends on, without the other keys of the scene."""
    problem, alone = pair.problem, replace(pair.specification, coefficients=(friction,))
    specification = replace(problem.specification, ics=(name,), friction=alone)
    common = problem.pair, specification, pair.on_grid.grid
    if name in pair.given:
        return *common, pair.given[name]
    jobs = c_jobs(problem, pair.on_grid).values() if name == C else ()
    return *common, *map(_c_inputs, jobs)


def _c_inputs(job: MatrixJob) -> tuple[object, ...]:
    """Return all inputs of C; the engine by its name, because the digest covers its code."""
    settings = replace(job.settings, engine=None)  # type: ignore[arg-type]
    return job.body, job.grid, job.components, job.discounts, settings, job.settings.engine.name
