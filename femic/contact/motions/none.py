"""Frictionless contact of two bodies: all loads with all ICs, on grids that fit.

`load_at_angle` finds the load under which the patch turns by an angle, however the contact is solved.
`sensitivities` are differences of displacements by A and by B-hat under given pressures, mapped from patch to
patch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from time import perf_counter

import numpy as np
import scipy

from femic.contact.estimates import Measured, Numbers, changes, errors
from femic.contact.loading import Loading
from femic.contact.motions import motion
from femic.contact.motions.motion import COMMON, Motion, Want
from femic.contact.pairs.quantities import OF_FRICTIONLESS, half_length, kinds, measured, numbers, s_range
from femic.contact.specification import ContactProblem
from femic.lazy import lazy_imports
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array, Mask
from geometries.errors import Failure
from geometries.patches import Grid

with lazy_imports():
    import xarray as xr

    from femic.contact import datasets
    from femic.contact import normal as solver
    from femic.contact.operators import protocols
    from femic.contact.pairs import grids, pair_on_grid
    from femic.contact.pairs import ics as pair_ics

# --- all contacts of a problem ---


@dataclass(frozen=True, eq=False)
class SolvedContact:
    """A contact with some ICs, by name.

    `perturbed` is the same with C, or ICs that are given, plus their estimated error; None of others.
    `linearised`: with a distance that is linearised in the approach. What that does is part of the estimates
    then, and `displaced` is the contact with the distance of the displaced body, None where it is not found
    on the grid.
    """

    loading: Loading
    ics: str
    contact: pair_on_grid.PairContact
    perturbed: pair_on_grid.PairContact | None = None
    linearised: bool = False
    displaced: pair_on_grid.PairContact | None = None
    seconds: float = 0.0

    @property
    def on_grid(self) -> pair_on_grid.PairOnGrid:
        """The bodies on the grid."""
        return self.contact.on_grid

    @property
    def normal(self) -> solver.NormalContact:
        """Pressures and gaps."""
        return self.contact.normal

    @cached_property
    def measured(self) -> Measured:
        """Its numbers, with the scales and floors of their errors."""
        given = "approach" if self.loading.load is None else "load"
        return measured(self.on_grid, self.normal, prescribed=(given, "position"))

    @cached_property
    def measured_on_larger(self) -> list[Measured]:
        """Those on elements twice and four times as large, as far as there are such grids."""
        coarser, found = self.normal.coarser, list[Measured]()
        while coarser is not None and len(found) < 2:
            found.append(measured(self.on_grid, coarser))
            coarser = coarser.coarser
        return found

    def variations(self) -> dict[str, Numbers]:
        """Numbers by what varies them, named as in `femic.contact.datasets`; NaN where not known."""
        given, larger = self.measured.numbers, self.measured_on_larger
        perturbed = numbers(self.perturbed.on_grid, self.perturbed.normal) if self.perturbed else given
        return {
            datasets.LARGER: larger[0].numbers if larger else dict.fromkeys(given, np.nan),
            datasets.CHANGE: {name: perturbed[name] - value for name, value in given.items()},
            **datasets.difference_errors(self.measured, OF_FRICTIONLESS, datasets.WITHOUT_FRICTION),
        }

    def estimated_errors(self) -> dict[str, float]:
        """Estimated errors of `OF_FRICTIONLESS`; NaN where they are not known.

        That is where the grid is too small for larger elements, and where `displaced` is missing.
        """
        error_kinds, parts = kinds(OF_FRICTIONLESS), list[Numbers]()
        for other in (self.perturbed, self.displaced):
            if other is not None:
                parts.append(changes(self.measured, error_kinds, numbers(other.on_grid, other.normal)))
        if self.linearised and self.displaced is None:
            parts.append(dict.fromkeys(error_kinds, np.nan))
        known = errors(error_kinds, self.measured, self.measured_on_larger, parts)
        if np.isfinite(self.contact.lateral_stiffness):  # the position follows the lateral force
            known["position"] += known["F_y"] / self.contact.lateral_stiffness
        return known


def by_ics(contacts: Sequence[SolvedContact]) -> xr.Dataset:
    """Return numbers of contacts by the names of their ICs, with what varies them."""
    tables: dict[str, list[Numbers]] = {"": [contact.measured.numbers for contact in contacts]}
    varied = [contact.variations() for contact in contacts]
    tables |= {prefix: [each[prefix] for each in varied] for prefix in varied[0]}
    return xr.Dataset(
        datasets.variables(OF_FRICTIONLESS, "ics", tables), {"ics": [contact.ics for contact in contacts]}
    )


Contacts = dict[tuple[Loading, str], SolvedContact]


@dataclass(frozen=True, eq=False)
class FrictionlessContacts:
    """The contacts of a problem, by loading and name of the ICs, in the order of its specification."""

    problem: ContactProblem
    contacts: Mapping[tuple[Loading, str], SolvedContact]
    references: Mapping[Grid, pair_ics.ReferenceICs]  # C on the grids, where it is among the ICs
    seconds: float

    @property
    def loadings(self) -> tuple[Loading, ...]:
        """Loads, or approaches."""
        return self.problem.specification.loadings

    @property
    def ics(self) -> tuple[str, ...]:
        """Names of the ICs."""
        return self.problem.specification.ics


def solve_frictionless(
    problem: ContactProblem,
    options: RunOptions = DEFAULT,
    given: Mapping[str, pair_ics.NormalICs] | None = None,
) -> FrictionlessContacts:
    """Solve all contacts of a problem; `given` are ICs by the names in its specification.

    Raises WrongInput and Failure as `PairOnGrid.solve` and `grids_of`, and NotConverged of C.
    """
    start, contacts = perf_counter(), Contacts()
    references: dict[Grid, pair_ics.ReferenceICs] = {}
    own, exact = pair_ics.select_given(problem.specification.ics, given or {}), problem.specification.exact
    for grid, loadings in grids.grids_of(problem, own):

        def solve_on(
            on_grid: pair_on_grid.PairOnGrid, loadings: list[Loading] = loadings
        ) -> tuple[Contacts, pair_ics.ReferenceICs | None]:
            reference, solved, size = None, Contacts(), on_grid.grid
            options.watch.on_stage(
                f"  {size.n_x} x {size.n_s} elements of {size.dx:.3g} x {size.ds:.3g} mm: "
                + ", ".join(map(str, loadings))
            )
            for name in problem.specification.ics:
                operators: tuple[protocols.Operator, protocols.Operator | None]
                if name in own:
                    matrix, estimate = own[name].at(on_grid)
                    operators = (
                        pair_ics.normal_operator(matrix),
                        pair_ics.normal_operator(matrix + estimate),
                    )
                elif name == pair_ics.C:
                    reference = pair_ics.normal_reference_ics(problem, on_grid, options)
                    operators = reference.operator, reference.perturbed
                else:
                    operators = on_grid.operator(name), None
                for loading in loadings:
                    try:
                        solved[loading, name] = _solve(on_grid, loading, name, operators, exact=exact)
                    except solver.PotentialAreaTooSmall as short:
                        raise solver.PotentialAreaTooSmall(short.ends, loading, name) from short
            return solved, reference

        solved, reference = grids.on_fitting_grid(problem, grid, solve_on, longer=not own)
        contacts |= solved
        if reference is not None:
            references[next(iter(solved.values())).on_grid.grid] = reference
    return FrictionlessContacts(problem, contacts, references, perf_counter() - start)


def _solve(
    on_grid: pair_on_grid.PairOnGrid,
    loading: Loading,
    name: str,
    operators: tuple[protocols.Operator, protocols.Operator | None],
    *,
    exact: bool,
) -> SolvedContact:
    """Solve a contact, also with perturbed ICs, and of the displaced bodies where that is another one."""
    start, (operator, perturbed) = perf_counter(), operators
    contact = on_grid.solve(operator, loading, exact=exact)
    seconds = perf_counter() - start
    with_errors = on_grid.solve(perturbed, loading, exact=exact) if perturbed else None
    displaced = None
    if not exact:
        try:
            displaced = on_grid.solve(operator, loading, exact=True)
        except Failure:  # it is larger than the grid, or there is none
            displaced = None
    return SolvedContact(loading, name, contact, with_errors, not exact, displaced, seconds)


def load_at_angle(
    find_angle: Callable[[float], float],
    degrees: float,
    loads: tuple[float, float],
    accuracy: float,
    patch: str = "the patch",
) -> float:
    """Return the load [N] between two under which a patch turns by an angle [deg].

    `find_angle` returns the angle [deg] under a load [N]. It is called at both ends first; it should not
    jump, as it does from one grid to another: a root may be such a jump. `accuracy` is that of the load,
    relative, and `patch` says in messages which one it is. Raises Failure where the angle is not between
    those at the ends.
    """
    ends = [float(np.log(load)) for load in loads]
    angles = [find_angle(load) for load in loads]
    if not min(angles) <= degrees <= max(angles):
        turns = " and ".join(
            f"by {angle:.3g} under {load:.3g} N" for angle, load in zip(angles, loads, strict=True)
        )
        raise Failure(
            f"no load at which {patch} turns by {degrees:g} degrees: it turns {turns}; "
            "give an angle between these"
        )
    known = dict(zip(ends, angles, strict=True))

    def excess(logarithm: float) -> float:
        turned = known.get(logarithm)
        return (find_angle(float(np.exp(logarithm))) if turned is None else turned) - degrees

    return float(np.exp(scipy.optimize.brentq(excess, *ends, xtol=accuracy)))


# --- A and B-hat under the same pressures ---

REFERENCE = "Bhat"  # the ICs that A is compared with


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """(u_n by A - u_n by B-hat) / max u_n by B-hat on a patch, due to the pressures of another contact."""

    pressures: str  # the name of the contact that the pressures are from
    patch: str  # the name of the contact that the patch is from
    x: Array  # [mm], (n_x,)
    s: Array  # [mm], (n_s,)
    on_patch: Mask  # (n_x, n_s)
    difference: Array  # (n_x, n_s)

    @property
    def inside(self) -> Array:
        """The differences on the patch, (n,)."""
        return np.asarray(self.difference[self.on_patch])

    @property
    def largest(self) -> float:
        """The largest difference on the patch."""
        return float(np.max(np.abs(self.inside)))


def sensitivities(contacts: Mapping[str, SolvedContact]) -> Iterator[Sensitivity]:
    """Yield the sensitivities to the pressures of every contact on the patch of every contact."""
    for (source, pressures), (name, patch) in product(contacts.items(), repeat=2):
        p = map_pressures(pressures, patch)
        by_a, by_bhat = (patch.on_grid.operator(ics)(p[..., None])[..., 0] for ics in ("A", REFERENCE))
        difference = (by_a - by_bhat) / np.max(by_bhat)
        yield Sensitivity(
            source, name, patch.on_grid.x, patch.on_grid.grid.strips, patch.normal.p > 0, difference
        )


def map_pressures(contact: SolvedContact, patch: SolvedContact) -> Array:
    """Return the pressures of one contact on the patch of another, at equal x / a and s / b; (n_x, n_s)."""
    interpolate = scipy.interpolate.RegularGridInterpolator(
        _normalised(contact), contact.normal.p, bounds_error=False, fill_value=0.0
    )
    return np.asarray(interpolate(np.stack(np.meshgrid(*_normalised(patch), indexing="ij"), axis=-1)))


def _normalised(contact: SolvedContact) -> tuple[Array, Array]:
    """Return x over the half-length, and s from the middle over the half-width of the patch."""
    on_grid = contact.on_grid
    low, high = s_range(on_grid, contact.normal)
    s = (on_grid.grid.strips - (low + high) / 2) / ((high - low) / 2)
    return on_grid.x / half_length(on_grid, contact.normal), s


MOTION = Motion(
    description="frictionless",
    title="Contact without friction",
    keys=("approaches", "gap", "shape_load", "lateral_force"),
    dimension="case",
    quantities=OF_FRICTIONLESS,
    wants=(
        *COMMON,
        Want("aspect", "aspect", motion.ITSELF),
        Want("stiffness", "stiffness", motion.ITSELF),
        Want("load", "load", motion.ITSELF),
        Want("F_y/load", "F_y", motion.LOAD),
        Want("s_centre/b", "s_centre", motion.HALF_WIDTH),
        Want("position/b", "position", motion.HALF_WIDTH),
    ),
)
