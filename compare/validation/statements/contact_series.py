"""Contacts of a pair under any load, on grids that some loads share: C is solved once for each grid.

So contacts can be compared at angles Δδ of the patch instead of loads: the load at which the patch with C
turns by an angle is sought.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from compare.studies.validity_limits import PairDeviations
from compare.validation.statements.frame import Estimated
from femic.contact.estimates import Numbers
from femic.contact.finite_elements.meshed_contact import rigid_compliance
from femic.contact.loading import Loading
from femic.contact.motions.none import SolvedContact, load_at_angle
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.protocols import Operator
from femic.contact.pairs.grids import grids_of, on_fitting_grid
from femic.contact.pairs.ics import C, ReferenceICs, normal_reference_ics
from femic.contact.pairs.pair_on_grid import PairContact, PairOnGrid
from femic.contact.pairs.quantities import angle
from femic.contact.specification import ContactProblem
from femic.reference.run_options import RunOptions

GRID_LOADS = 7  # loads that the grids are made for; groups of them share a grid
LOAD_SHARE = 1e-3  # accuracy of loads at which a patch turns by an angle
BELOW = 0.5  # least load that is tried on a grid, over the largest one of the grid before
ICS = ("A", "B", "Bhat", C)


@dataclass(frozen=True, eq=False)
class SharedGrid:
    """Bodies on a grid, the ICs by name, C as it was found, and the largest load [N] of the grid."""

    on_grid: PairOnGrid
    operators: Mapping[str, Operator]
    reference: ReferenceICs
    load: float

    @cached_property
    def deviations(self) -> PairDeviations:
        """Errors of numbers with other ICs against C, on the same elements."""
        return PairDeviations(self.on_grid, self.operators, self.reference.perturbed)

    def solve(self, loading: Loading, ics: str, *, exact: bool = False) -> PairContact:
        """Return the contact with some ICs; `exact`: with the distance of the displaced body."""
        try:
            return self.on_grid.solve(self.operators[ics], loading, exact=exact)
        except PotentialAreaTooSmall as short:
            raise PotentialAreaTooSmall(short.ends, loading, ics) from short


@dataclass(eq=False)
class ContactSeries:
    """The frictionless contacts of a problem with A, B, B-hat and C, each solved once.

    `loads` [N] are the least and the largest one that grids are made for.
    """

    problem: ContactProblem
    options: RunOptions
    loads: tuple[float, float]
    contacts: dict[tuple[float, str, bool], PairContact] = field(default_factory=dict)
    measured: dict[tuple[float, str], Numbers] = field(default_factory=dict)
    loads_at: dict[float, float] = field(default_factory=dict)  # by angle of the patch with C
    own_grids: dict[float, SharedGrid] = field(default_factory=dict)  # of these loads

    @cached_property
    def grids(self) -> list[SharedGrid]:
        """The grids, those of smaller loads first."""
        loads = tuple(map(float, np.geomspace(*self.loads, GRID_LOADS)))
        specification = replace(self.problem.specification, loads=loads, approaches=(), ics=ICS)
        problem, shared = replace(self.problem, specification=specification), []
        for grid, loadings in grids_of(problem):
            largest = max(float(loading.load or 0.0) for loading in loadings)
            shared.append(on_fitting_grid(problem, grid, partial(self._shared_grid, largest)))
        return shared

    def _shared_grid(self, load: float, on_grid: PairOnGrid) -> SharedGrid:
        grid, largest = on_grid.grid, Loading(load)
        self.options.watch.on_stage(
            f"  {self.problem.name}: C on {grid.n_x} x {grid.n_s} elements, up to {largest}"
        )
        reference = normal_reference_ics(self.problem, on_grid, self.options)
        operators: dict[str, Operator] = {ics: on_grid.operator(ics) for ics in ICS if ics != C}
        shared = SharedGrid(on_grid, operators | {C: reference.operator}, reference, load)
        for ics in ICS:  # a grid that is too short for one of them is made longer
            shared.solve(largest, ics)
        return shared

    @cached_property
    def rigid_compliance(self) -> float:
        """M_zz [mm/N] of both bodies on their supports, which the discount takes from approaches with C."""
        return rigid_compliance(self.problem, self.options)

    def grid(self, load: float) -> SharedGrid:
        """Return the grid of a load [N]."""
        if load in self.own_grids:
            return self.own_grids[load]
        return next((shared for shared in self.grids if load <= shared.load), self.grids[-1])

    def solved(self, load: float, ics: str = C, *, exact: bool = False) -> PairContact:
        """Return the contact under a load [N]; `exact`: with the distance of the displaced body."""
        key = load, ics, exact
        if key not in self.contacts:
            self.contacts[key] = self.grid(load).solve(Loading(load), ics, exact=exact)
        return self.contacts[key]

    def contact(self, load: float, ics: str = C) -> SolvedContact:
        """Return the contact under a load [N], of C also with its estimated error added."""
        shared, loading = self.grid(load), Loading(load)
        perturbed = shared.on_grid.solve(shared.reference.perturbed, loading) if ics == C else None
        return SolvedContact(loading, ics, self.solved(load, ics), perturbed)

    def numbers(self, load: float, ics: str = C) -> Numbers:
        """Return the numbers of the contact under a load [N], and their estimated errors, `estimate_...`."""
        key = load, ics
        if key not in self.measured:
            contact = self.contact(load, ics)
            estimates = contact.estimated_errors().items()
            self.measured[key] = dict(contact.measured.numbers) | {
                f"estimate_{name}": estimate for name, estimate in estimates
            }
        return self.measured[key]

    def angle(self, load: float, ics: str = C) -> float:
        """Return the angle [deg] by which the patch turns under a load [N]."""
        contact = self.solved(load, ics)
        return angle(contact.on_grid, contact.normal)

    def error(self, load: float, ics: str, name: str) -> Estimated:
        """Return a number with some ICs over the same with C, minus 1, under a load [N]."""
        return Estimated(*self.grid(load).deviations.error(name, ics, load))

    def angle_with_c(self, load: float) -> Estimated:
        """Return the angle [deg] by which the patch with C turns under a load [N]."""
        return Estimated(*self.grid(load).deviations.angle(load))

    def load_at(self, degrees: float) -> float:
        """Return the load [N] at which the patch with C turns by an angle; Failure beyond the grids.

        It is one of contacts on one grid: from one grid to the next the angle jumps. The grid is the first
        whose largest load turns the patch far enough. Where the jump between two grids passes the angle, the
        load is a little less than those of the larger grid, which it has nevertheless.
        """
        if degrees not in self.loads_at:
            angles = [self.angle(shared.load) for shared in self.grids]
            number = next((k for k, turned in enumerate(angles) if turned >= degrees), len(angles) - 1)
            shared = self.grids[number]
            least = self.grids[number - 1].load * BELOW if number else self.loads[0]

            def angle_on(load: float) -> float:
                if self.grid(load) is shared:
                    return self.angle(load)
                contact = shared.solve(Loading(load), C)
                return angle(contact.on_grid, contact.normal)

            patch = f"the patch of {self.problem.name} with C"
            load = load_at_angle(angle_on, degrees, (least, shared.load), LOAD_SHARE, patch)
            self.own_grids[load], self.loads_at[degrees] = shared, load
        return self.loads_at[degrees]
