"""Automatic grids of a problem, made longer where contacts need it."""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from femic.contact.edges import MARGIN
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.contact_size import contact_size
from femic.contact.pairs.given_ics import NONE_GIVEN, C, NormalICs, given_of
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.sizing import Sizing
from femic.contact.specification import ContactProblem
from geometries.errors import Failure, WrongInput
from geometries.grids import Grid

WITH_C, WITH_FRICTION, WITHOUT_C = 160, 256, 1024  # strips of grids that are made finer, at most
COARSE_MARGIN = 2 * MARGIN + 1  # elements beside a patch, so that elements twice as large have a margin

Outcome = TypeVar("Outcome")


def sizing_of(problem: ContactProblem) -> Sizing:
    """Return the sizing of a problem's grids; contacts with friction are solved on larger elements, too."""
    bodies, elements = pair_on_grid(problem, problem.grid), problem.specification.elements
    return Sizing(bodies, elements, COARSE_MARGIN if problem.specification.friction else MARGIN + 1)


def grids_of(
    problem: ContactProblem, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> list[tuple[Grid, list[Loading]]]:
    """Return the grids of a problem and the loadings on each: the given one, or automatic ones.

    ICs that are given have a grid of their own, on which all is solved. With friction there is one grid, of
    the largest load, which the steps to it share. Raises WrongInput where given ICs have different grids, and
    Failure where no grid fits.
    """
    specification, loadings = problem.specification, list(problem.specification.loadings)
    if own := given_of(specification.ics, given):
        return [(_common_grid(own), loadings)]
    if not specification.automatic:
        return [(problem.grid, loadings)]
    sizing, variants = sizing_of(problem), [name for name in specification.ics if name != C]
    if specification.friction:
        largest = loadings[-1:]
        grid = sizing.grid([contact_size(sizing.bodies, largest[0])])
        return [(_fitting(sizing, grid, largest, variants, WITH_FRICTION), loadings)]
    most_strips = WITH_C if C in specification.ics else WITHOUT_C
    return [
        (_fitting(sizing, grid, on_grid, variants, most_strips), on_grid)
        for grid, on_grid in sizing.grids(loadings)
    ]


def _fitting(
    sizing: Sizing, grid: Grid, loadings: Sequence[Loading], variants: Sequence[str], most_strips: int
) -> Grid:
    """Return the grid, made longer where patches need it, and finer where distances do."""
    return sizing.resolved(sizing.large_enough(grid, loadings, variants), loadings, most_strips)


def on_fitting_grid(
    problem: ContactProblem, grid: Grid, solve: Callable[[PairOnGrid], Outcome], *, longer: bool = True
) -> Outcome:
    """Return the solution of `solve` on a grid, made `longer` where needed if the problem has automatic ones.

    Raises Failure where a contact comes near the ends of another grid, and as `Sizing.on_long_enough_grid`.
    """
    if longer and problem.specification.automatic:
        return sizing_of(problem).on_long_enough_grid(grid, solve)
    try:
        return solve(pair_on_grid(problem, grid))
    except PotentialAreaTooSmall as short:
        raise Failure(f"{short.contact}: {short}") from short


def _common_grid(given: Mapping[str, NormalICs]) -> Grid:
    grids = {name: ics.grid for name, ics in given.items()}
    if len(set(grids.values())) > 1:
        raise WrongInput(f"contact.ics: {', '.join(grids)} have different grids: name one")
    return next(iter(grids.values()))
