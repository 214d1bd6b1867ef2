"""Contacts with friction of the pair of `rolling` and `compression`, and how far ICs are from C in them.

Both are solved on the same grid, so that one C serves all motions and coefficients of friction.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import wraps
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from compare.report.looks import ics_symbol
from compare.validation.statements.curves import rms
from compare.validation.statements.frame import Estimated, Measure, ratio
from compare.validation.statements.runs import Runs
from femic.contact.datasets import estimate_of_difference
from femic.contact.motions import pair_in_motion
from femic.contact.motions.rolling import scaled_force
from femic.contact.pairs.ics import NONE_GIVEN, C, GivenICs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.results.contact import compared_ics, reference_ics
from femic.scenes.load import load_scene
from geometries.arrays import Array
from geometries.patches import Grid

FRICTIONS = (0.2, 0.4, 0.6)
LOW, HIGH = FRICTIONS[0], FRICTIONS[1:]
ELEMENTS = 20  # across the patch
LOADS = (2e3, 5e3, 10e3, 15e3, 20e3, 30e3, 40e3, 55e3, 70e3, 85e3, 100e3)  # of compression [N]: up to rolling
FEW_CREEPAGES = (-0.006, -0.003, -0.002, -0.0015, -0.001, -0.0005, 0.0, 0.001, 0.003)  # of further curves
SINGLE = ("A", "B", "Bhat", "Bhat_prime")
WITHOUT_FIT = {"A": "Bhat+sn:B+xn:A", "B": "Bhat+sn:B+xn:B", "Bhat": "Bhat+sn:B"}  # by their xn
ICS = (*SINGLE, "mix", *WITHOUT_FIT.values(), "C")

Contacts = Callable[[Runs], xr.Dataset]
Distance = Callable[[xr.Dataset, float, str], float]  # of some ICs from C, at a coefficient of friction


def rolling(runs: Runs) -> xr.Dataset:
    """Return steady rolling with all ICs."""
    return runs.friction("rolling", {"contact": {"elements": ELEMENTS, "ics": list(ICS)}})


def compression(runs: Runs) -> xr.Dataset:
    """Return static compression with all ICs, up to the load of rolling."""
    contact = {"elements": ELEMENTS, "ics": list(ICS), "loads": list(LOADS)}
    return runs.friction("compression", {"contact": contact})


def on_same_grid(
    runs: Runs, motion: str, changes: Mapping[str, Any], given: Mapping[str, GivenICs] = NONE_GIVEN
) -> xr.Dataset:
    """Return rolling or compression with some keys of the scene changed, on the grid that has all ICs."""
    contacts = {"rolling": rolling, "compression": compression}[motion](runs)
    contact = {"grid": "scene"} | changes.get("contact", {})
    return runs.friction(motion, {**changes, "grid": asdict(find_grid(contacts)), "contact": contact}, given)


def find_grid(dataset: xr.Dataset) -> Grid:
    """Return the grid of the contacts of a dataset."""
    dx, ds, s = (float(dataset.attrs[name]) for name in ("dx", "ds", "s_middle"))
    return Grid(dataset.sizes["x"], dataset.sizes["s"], dx, ds, s)


def rolling_pair(runs: Runs) -> PairWithFriction:
    """Return the pair of scene `rolling` on the grid of its contacts, where C is solved."""
    grid = asdict(find_grid(rolling(runs)))
    changes = {"contact": {"ics": ["Bhat", C], "grid": "scene"}, "grid": grid}
    problem = load_scene("rolling", changes).contact_problem
    return pair_in_motion(problem, pair_on_grid(problem, problem.grid), runs.options)


# --- distances from C -----------------------------------------------------------------------------------


def curve_distance(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the root mean square distance of creep-force curves over friction times load."""
    at = dataset.sel(friction=friction, ics=ics)
    return Estimated(float(at.rms), float(at.estimate_rms))


def largest_curve_distance(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the largest distance of creep-force curves over friction times load."""
    at = dataset.sel(friction=friction, ics=ics)
    return Estimated(float(at.largest), float(at.estimate_largest))


def with_estimate(difference: Callable[[xr.Dataset, str, str], float]) -> Distance:
    """Make a difference to contacts with C a distance: its size, with its estimated error.

    The difference is one of contacts at a coefficient of friction, of some ICs to C by their names.
    """

    @wraps(difference)
    def distance(dataset: xr.Dataset, friction: float, ics: str) -> float:
        c = reference_ics(dataset)
        compared = dataset.sel(friction=[friction], ics=list(dict.fromkeys((ics, c))))

        def apart(contacts: xr.Dataset) -> xr.DataArray:
            return xr.DataArray(difference(contacts.sel(friction=friction), ics, c))

        known = estimate_of_difference(compared, apart)
        return Estimated(abs(float(apart(compared))), float(known))

    return distance


@with_estimate
def shift(at: xr.Dataset, ics: str, c: str) -> float:
    """Return the difference of the creepages without force, times the slope with C, over friction load."""
    scale = at.slope.sel(ics=c) / (at.friction * at.attrs["load"])
    return float((at.zero_creepage.sel(ics=ics) - at.zero_creepage.sel(ics=c)) * scale)


@with_estimate
def left_after_shift(at: xr.Dataset, ics: str, c: str) -> float:
    """Return the share of a curve's distance that is left when it is moved to C's creepage without force.

    The curve of these ICs is interpolated between its creepages, and compared where both are known. Of
    equal curves nothing is left.
    """
    with_c, own = (scaled_force(at).sel(ics=name).dropna("xi") for name in (c, ics))
    if min(with_c.size, own.size) < 2:
        return np.nan
    moved = float(at.zero_creepage.sel(ics=ics) - at.zero_creepage.sel(ics=c))
    curve = PchipInterpolator(own.xi.values, own.values, extrapolate=False)
    apart, left = (curve(with_c.xi.values + move) - with_c.values for move in (0.0, moved))
    both = np.isfinite(apart) & np.isfinite(left)
    distance = rms(apart[both])
    return rms(left[both]) / distance if distance else 0.0


def centre_line(at: xr.Dataset) -> xr.DataArray:
    """Return p_x [MPa] at s = 0 at equal force, by ICs and x."""
    return at.p.sel(direction="x").interp(s=0.0)


@with_estimate
def line_distance(at: xr.Dataset, ics: str, c: str) -> float:
    """Return the distance of p_x on the centre line at equal force, over p_x with C; root mean squares."""
    line, by_c = (centre_line(at).sel(ics=name).values for name in (ics, c))
    return rms(line - by_c) / rms(by_c)


@with_estimate
def line_distance_over_bound(at: xr.Dataset, ics: str, c: str) -> float:
    """Return the distance of p_x on the centre line at equal force, over friction times pressure with C."""
    line, by_c = (centre_line(at).sel(ics=name).values for name in (ics, c))
    pressures = at.p.sel(direction="n", ics=c).interp(s=0.0).values
    return rms(line - by_c) / (float(at.friction) * rms(pressures))


def traction_distance_along(*directions: str) -> Distance:
    """Measure the distance of tangential tractions over friction times pressure with C; root mean squares."""

    def difference(at: xr.Dataset, ics: str, c: str) -> float:
        by_c = at.p.sel(ics=c)
        apart = (at.p.sel(ics=ics) - by_c).sel(direction=list(directions)).values
        bound = float(at.friction) * np.linalg.norm(by_c.sel(direction="n").values)
        return float(np.linalg.norm(apart) / bound)

    return with_estimate(difference)


traction_distance = traction_distance_along("x", "s")


def sliding_distance(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the difference of the sliding shares of the patch after the last load.

    Its estimate is the sum of both: shares change by elements, on larger ones by luck not at all.
    """
    at = dataset.sel(friction=friction, ics=[ics, reference_ics(dataset)]).isel(load=-1)
    difference = float(abs(at.sliding_share.diff("ics").item()))
    return Estimated(difference, float(at.estimate_sliding_share.sum()))


@with_estimate
def pressure_distance(at: xr.Dataset, ics: str, c: str) -> float:
    """Return |p_max / p_max with C - 1| of rolling at no creepage."""
    p_max = at.p_max.sel(xi=0.0)
    return float(p_max.sel(ics=ics) / p_max.sel(ics=c) - 1)


# --- numbers of criteria --------------------------------------------------------------------------------


def case(friction: float, ics: str) -> str:
    """Return the name of a case."""
    return f"friction {friction:g}, {ics_symbol(ics)}"


def by_symbol(values: xr.DataArray, ics: Sequence[str]) -> dict[str, Array]:
    """Return the values with some ICs, by their symbols, as charts draw them."""
    return {ics_symbol(name): values.sel(ics=name).values for name in ics}


def distances_by_label(contacts: xr.Dataset, labels: Mapping[str, Distance]) -> dict[str, float]:
    """Return distances of all ICs from C at each coefficient of friction, by their labels."""
    return {
        f"{label}: {case(friction, name)}": distance(contacts, friction, name)
        for friction in FRICTIONS
        for name in compared_ics(contacts)
        for label, distance in labels.items()
    }


def measured(
    contacts: Contacts, number: Callable[..., float], cases: Mapping[str, tuple[float | str, ...]]
) -> Measure:
    """Measure a number of contacts in cases by their names: a coefficient of friction, and ICs."""

    def measure(runs: Runs) -> Mapping[str, float]:
        dataset = contacts(runs)
        return {name: number(dataset, *arguments) for name, arguments in cases.items()}

    return measure


def distances(
    contacts: Contacts, distance: Distance, ics: Sequence[str], frictions: Sequence[float]
) -> Measure:
    """Measure the distance of each of some ICs from C at each coefficient of friction."""
    return measured(
        contacts, distance, {case(friction, name): (friction, name) for friction in frictions for name in ics}
    )


def compared(
    contacts: Contacts, distance: Distance, ics: str, others: Sequence[str], frictions: Sequence[float]
) -> Measure:
    """Measure the distance of some ICs from C over that of each of others."""
    return measured(
        contacts,
        lambda dataset, friction, other: ratio(
            distance(dataset, friction, ics), distance(dataset, friction, other)
        ),
        {
            f"{case(friction, ics)} over {ics_symbol(other)}": (friction, other)
            for friction in frictions
            for other in others
        },
    )


def between_frictions(
    contacts: Contacts, distance: Distance, ics: Sequence[str], pairs: Sequence[tuple[float, float]]
) -> Measure:
    """Measure distances from C at one coefficient of friction over those at another, by pairs of both."""
    return measured(
        contacts,
        lambda dataset, one, other, name: ratio(distance(dataset, one, name), distance(dataset, other, name)),
        {
            f"{ics_symbol(name)}, friction {one:g} over {other:g}": (one, other, name)
            for one, other in pairs
            for name in ics
        },
    )
