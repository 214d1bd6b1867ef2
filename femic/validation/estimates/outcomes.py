"""What a random contact gives on its elements, on larger ones and on much smaller ones."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from compare.contact.compute import SolvedContact
from compare.contact.dataset import estimates_of
from compare.contact.pair_on_grid import Case, Settled
from compare.contact.quantities import numbers as numbers_without_friction
from compare.friction.dataset import errors
from compare.friction.quantities import OF_ROLLING, measured
from femic.contact.estimates import Measured, Numbers
from femic.contact.frictional import FrictionalProblem, Pressing
from femic.validation.estimates.contacts import RandomContact
from geometries.errors import Failure

TOLERANCE = 1e-4  # of tractions: errors of results are 1e-3 and more


@dataclass(frozen=True)
class Outcome:
    """Numbers of a contact, those on elements four times smaller, on larger ones, and the estimates."""

    numbers: Numbers
    finer: Numbers
    larger: Numbers
    estimates: Numbers


def frictionless(case: RandomContact) -> Outcome:
    """Without friction. Raises Failure where one of the grids has no solution."""

    def solved(on: RandomContact) -> SolvedContact:
        given = Case(on.load, None)
        normal = on.placed.contact(on.placed.operator(on.ics), given)
        return SolvedContact(given, on.ics, Settled(on.placed, normal), None, None, 0.0)

    found, finer = solved(case), solved(case.finer)
    coarse = found.normal.coarser
    if coarse is None:
        raise Failure("the grid is too small")
    fine, exact, larger = (
        numbers_without_friction(replace(case.placed, grid=one.problem.grid), one)
        for one in (found.normal, finer.normal, coarse)
    )
    return Outcome(fine, exact, larger, estimates_of(found))


def rolling(case: RandomContact) -> Outcome:
    """Steady rolling at some creepages, or without force along x. Raises Failure likewise."""
    forces = {"longitudinal": 0.0} if case.free else {}

    def solved(of: RandomContact, problem: FrictionalProblem) -> Measured:
        found = of.rolling(problem).contact(
            of.creepages, Pressing(load=of.load), forces=forces, tolerance=TOLERANCE
        )
        return measured(OF_ROLLING, of.placed, found.contact)

    fine, *larger = (solved(case, problem) for problem in grids(case))
    finer = solved(case.finer, case.finer.problem).numbers
    return Outcome(fine.numbers, finer, larger[0].numbers, errors(OF_ROLLING, fine, larger))


def grids(case: RandomContact) -> list[FrictionalProblem]:
    """The problem on its elements, on those twice and four times as large."""
    problem = case.problem
    return [problem, problem.coarsened, problem.coarsened.coarsened]


Study = Callable[[RandomContact], Outcome]
STUDIES: Mapping[str, Study] = {"frictionless": frictionless, "rolling": rolling}
