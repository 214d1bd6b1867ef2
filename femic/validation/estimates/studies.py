"""What a random contact gives on its elements, on larger ones and on much smaller ones."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from femic.contact.estimates import Measured, Numbers, errors
from femic.contact.frictional import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.pair_on_grid import PairContact
from femic.contact.pairs.quantities import OF_ROLLING, kinds, measured, numbers
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
        loading = Loading(on.load)
        normal = on.on_grid.solve_in_place(on.on_grid.operator(on.ics), loading)
        return SolvedContact(loading, on.ics, PairContact(on.on_grid, normal))

    found, finer = solved(case), solved(case.finer)
    coarse = found.normal.coarser
    if coarse is None:
        raise Failure("the grid is too small")
    fine, exact, larger = (numbers(case.on_grid, contact) for contact in (found.normal, finer.normal, coarse))
    return Outcome(fine, exact, larger, found.estimated_errors())


def rolling(case: RandomContact) -> Outcome:
    """Steady rolling at some creepages, or without force along x. Raises Failure likewise."""
    forces = {"longitudinal": 0.0} if case.free else {}

    def solved(of: RandomContact, problem: FrictionalProblem) -> Measured:
        found = of.rolling(problem).contact(
            of.creepages, Loading(of.load), forces=forces, tolerance=TOLERANCE
        )
        return measured(of.on_grid, found.contact, OF_ROLLING)

    fine, *larger = (solved(case, problem) for problem in grids(case))
    finer = solved(case.finer, case.finer.problem).numbers
    return Outcome(fine.numbers, finer, larger[0].numbers, errors(kinds(OF_ROLLING), fine, larger))


def grids(case: RandomContact) -> list[FrictionalProblem]:
    """The problem on its elements, on those twice and four times as large."""
    problem = case.problem
    return [problem, problem.coarsened, problem.coarsened.coarsened]


Study = Callable[[RandomContact], Outcome]
STUDIES: Mapping[str, Study] = {"frictionless": frictionless, "rolling": rolling}
