"""Studies of random contacts: numbers on a grid, a coarser and a much finer one, and their estimates."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from femic.contact.estimates import Measured, Numbers, errors
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.pair_on_grid import PairContact
from femic.contact.pairs.quantities import OF_ROLLING, kinds, numbers
from femic.contact.pairs.rolling_numbers import measured_rolling
from femic.validation.estimates.contacts import RandomContact
from geometries.errors import Failure

TOLERANCE = 1e-4  # of tractions: errors of results are 1e-3 and more


@dataclass(frozen=True)
class GridComparison:
    """Numbers of a contact on its grid, on elements four times smaller, on larger ones, and estimates."""

    numbers: Numbers
    finer: Numbers
    larger: Numbers
    estimates: Numbers


def frictionless(case: RandomContact) -> GridComparison:
    """Solve a contact without friction; raises Failure where one of the grids has no solution."""

    def solved(case: RandomContact) -> SolvedContact:
        loading = Loading(case.load)
        normal = case.on_grid.solve_in_place(case.on_grid.operator(case.ics), loading)
        return SolvedContact(loading, case.ics, PairContact(case.on_grid, normal))

    contact, finer = solved(case), solved(case.finer)
    coarse = contact.normal.coarser
    if coarse is None:
        raise Failure("the grid is too small")
    fine, exact, larger = (numbers(case.on_grid, normal) for normal in (contact.normal, finer.normal, coarse))
    return GridComparison(fine, exact, larger, contact.estimated_errors())


def rolling(case: RandomContact) -> GridComparison:
    """Solve steady rolling at given creepages, or without force along x; raises Failure likewise."""
    forces = {"longitudinal": 0.0} if case.free else {}

    def solved(case: RandomContact, problem: FrictionalProblem) -> Measured:
        rolling = case.rolling(problem)
        rolled = rolling.contact(case.creepages, Loading(case.load), forces=forces, tolerance=TOLERANCE)
        return measured_rolling(case.on_grid, rolling, rolled)

    fine, *larger = (solved(case, problem) for problem in grids(case))
    finer = solved(case.finer, case.finer.problem).numbers
    return GridComparison(fine.numbers, finer, larger[0].numbers, errors(kinds(OF_ROLLING), fine, larger))


def grids(case: RandomContact) -> list[FrictionalProblem]:
    """Return the problem on its elements, and on elements twice and four times as large."""
    problem = case.problem
    return [problem, problem.coarsened, problem.coarsened.coarsened]


Study = Callable[[RandomContact], GridComparison]
STUDIES: Mapping[str, Study] = {"frictionless": frictionless, "rolling": rolling}
