"""Frictionless contact of two bodies: all loads with all ICs, on grids that fit.

`load_at_angle` finds the load under which the patch turns by an angle, however the contact is solved.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from scipy.optimize import brentq

from femic.contact.estimates import Measured, Numbers, changes, errors
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact, PotentialAreaTooSmall
from femic.contact.operators.protocols import Operator
from femic.contact.pairs.grids import grids_of, on_fitting_grid
from femic.contact.pairs.ics import (
    NONE_GIVEN,
    C,
    NormalICs,
    ReferenceICs,
    normal_operator,
    normal_reference_ics,
    select_given,
)
from femic.contact.pairs.pair_on_grid import PairContact, PairOnGrid
from femic.contact.pairs.quantities import OF_FRICTIONLESS, kinds, measured, numbers
from femic.contact.specification import ContactProblem
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.errors import Failure
from geometries.patches import Grid


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
    contact: PairContact
    perturbed: PairContact | None = None
    linearised: bool = False
    displaced: PairContact | None = None
    seconds: float = 0.0

    @property
    def on_grid(self) -> PairOnGrid:
        """The bodies on the grid."""
        return self.contact.on_grid

    @property
    def normal(self) -> NormalContact:
        """Pressures and gaps."""
        return self.contact.normal

    def estimated_errors(self) -> dict[str, float]:
        """Estimated errors of `OF_FRICTIONLESS`; NaN where they are not known.

        That is where the grid is too small for larger elements, and where `displaced` is missing.
        """
        of_all, coarser = kinds(OF_FRICTIONLESS), self.normal.coarser
        given = "approach" if self.loading.load is None else "load"
        fine = measured(self.on_grid, self.normal, prescribed=(given, "position"))
        larger, parts = list[Measured](), list[Numbers]()
        while coarser is not None and len(larger) < 2:
            larger.append(measured(self.on_grid, coarser))
            coarser = coarser.coarser
        for other in (self.perturbed, self.displaced):
            if other is not None:
                parts.append(changes(fine, of_all, numbers(other.on_grid, other.normal)))
        if self.linearised and self.displaced is None:
            parts.append(dict.fromkeys(of_all, np.nan))
        known = errors(of_all, fine, larger, parts)
        if np.isfinite(self.contact.lateral_stiffness):  # the position follows the lateral force
            known["position"] += known["F_y"] / self.contact.lateral_stiffness
        return known


@dataclass(frozen=True, eq=False)
class FrictionlessContacts:
    """The contacts of a problem, by loading and name of the ICs, in the order of its specification."""

    problem: ContactProblem
    contacts: Mapping[tuple[Loading, str], SolvedContact]
    references: Mapping[Grid, ReferenceICs]  # C on the grids, where it is among the ICs
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
    problem: ContactProblem, options: RunOptions = DEFAULT, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> FrictionlessContacts:
    """Solve all contacts of a problem; `given` are ICs by the names in its specification.

    Raises WrongInput and Failure as `PairOnGrid.solve` and `grids_of`, and NotConverged of C.
    """
    start = perf_counter()
    contacts: dict[tuple[Loading, str], SolvedContact] = {}
    references: dict[Grid, ReferenceICs] = {}
    for grid, loadings in grids_of(problem, given):
        solver = _Solver(problem, loadings, select_given(problem.specification.ics, given), options)
        solved, reference = on_fitting_grid(problem, grid, solver.on_grid, longer=not solver.given)
        contacts |= solved
        if reference is not None:
            references[next(iter(solved.values())).on_grid.grid] = reference
    return FrictionlessContacts(problem, contacts, references, perf_counter() - start)


@dataclass(frozen=True, eq=False)
class _Solver:
    """Solves contacts under some loadings on the same grid."""

    problem: ContactProblem
    loadings: Sequence[Loading]
    given: Mapping[str, NormalICs]
    options: RunOptions

    def on_grid(
        self, on_grid: PairOnGrid
    ) -> tuple[dict[tuple[Loading, str], SolvedContact], ReferenceICs | None]:
        """Return the contacts with all ICs on a grid, and C on it."""
        grid, reference = on_grid.grid, None
        self.options.watch.on_stage(
            f"  {grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm: "
            + ", ".join(map(str, self.loadings))
        )
        contacts: dict[tuple[Loading, str], SolvedContact] = {}
        for name in self.problem.specification.ics:
            operator: Operator
            perturbed: Operator | None = None
            if name in self.given:
                ics, estimate = self.given[name].at(on_grid)
                operator, perturbed = normal_operator(ics), normal_operator(ics + estimate)
            elif name == C:
                reference = normal_reference_ics(self.problem, on_grid, self.options)
                operator, perturbed = reference.operator, reference.perturbed
            else:
                operator = on_grid.operator(name)
            for loading in self.loadings:
                try:
                    contacts[loading, name] = self.solved(on_grid, loading, name, operator, perturbed)
                except PotentialAreaTooSmall as short:
                    raise PotentialAreaTooSmall(short.ends, loading, name) from short
        return contacts, reference

    def solved(
        self, on_grid: PairOnGrid, loading: Loading, name: str, operator: Operator, perturbed: Operator | None
    ) -> SolvedContact:
        """Solve a contact, also with perturbed ICs, and of the displaced bodies where that is another one."""
        start, exact = perf_counter(), self.problem.specification.exact
        contact = on_grid.solve(operator, loading, exact=exact)
        seconds = perf_counter() - start
        with_errors = on_grid.solve(perturbed, loading, exact=exact) if perturbed else None
        displaced = None if exact else _displaced(on_grid, operator, loading)
        return SolvedContact(loading, name, contact, with_errors, not exact, displaced, seconds)


def _displaced(on_grid: PairOnGrid, operator: Operator, loading: Loading) -> PairContact | None:
    """Return the contact with the exact distance; None where it is larger than the grid, or there is none."""
    try:
        return on_grid.solve(operator, loading, exact=True)
    except Failure:
        return None


def load_at_angle(
    angle_of: Callable[[float], float],
    degrees: float,
    loads: tuple[float, float],
    accuracy: float,
    patch: str = "the patch",
) -> float:
    """Return the load [N] between two under which a patch turns by an angle [deg].

    `angle_of` returns the angle [deg] under a load [N]. It is called at both ends first; it should not jump,
    as it does from one grid to another: a root may be such a jump. `accuracy` is that of the load, relative,
    and `patch` says in messages which one it is. Raises Failure where the angle is not between those at the
    ends.
    """
    ends = [float(np.log(load)) for load in loads]
    angles = [angle_of(load) for load in loads]
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
        return (angle_of(float(np.exp(logarithm))) if turned is None else turned) - degrees

    return float(np.exp(brentq(excess, *ends, xtol=accuracy)))
