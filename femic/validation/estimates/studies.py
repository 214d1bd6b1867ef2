"""Studies of random contacts: numbers on a grid, a coarser and a much finer one, and their estimates."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from compare.contact.crossings import NUMBERS, PairDeviations
from compare.contact.dataset import variables
from compare.friction.dataset import FLOOR, LARGER, floors
from compare.friction.differences import Difference, estimate_of_difference, on_larger_elements
from femic.contact.estimates import Measured, Numbers, errors
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.pair_on_grid import PairContact
from femic.contact.pairs.quantities import OF_ROLLING, kinds, measured, numbers
from femic.contact.pairs.rolling_numbers import measured_rolling
from femic.validation.estimates.contacts import RandomContact
from geometries.errors import Failure

STICKING, SLIDING = 0.3, 0.95  # sliding shares: fewer stick, more slide
TOLERANCE = 1e-4  # of tractions: errors of results are 1e-3 and more


@dataclass(frozen=True)
class GridComparison:
    """Numbers of a contact on its grid, on elements four times smaller, on larger ones, and estimates.

    Estimates of numbers that are exact are NaN: these have no error of elements.
    """

    numbers: Numbers
    finer: Numbers
    larger: Numbers
    estimates: Numbers
    regime: str


def regime(contact: NormalContact | FrictionalContact) -> str:
    """Return the regime of a contact: by its patches and the share of them that slides."""
    if len(contact.patches) > 1:
        return "several patches"
    if isinstance(contact, NormalContact):
        return "one patch"
    share = contact.sliding_share
    return "sticking" if share < STICKING else "sliding" if share > SLIDING else "mixed"


def without_exact(estimates: Numbers, known: Measured) -> dict[str, float]:
    """Return estimates, NaN of numbers that are exact."""
    return {name: np.nan if name in known.exact else value for name, value in estimates.items()}


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
    fine = measured(case.on_grid, contact.normal, prescribed=("load", "position"))
    exact, larger = (numbers(case.on_grid, normal) for normal in (finer.normal, coarse))
    estimates = without_exact(contact.estimated_errors(), fine)
    return GridComparison(fine.numbers, exact, larger, estimates, regime(contact.normal))


def rolling(case: RandomContact) -> GridComparison:
    """Solve steady rolling at given creepages, or without force along x; raises Failure likewise."""
    of_regime, fine, *larger = _rolled_on_grids(case)
    finer = _rolled(case.finer, case.finer.problem)[1].numbers
    estimates = without_exact(errors(kinds(OF_ROLLING), fine, larger), fine)
    return GridComparison(fine.numbers, finer, larger[0].numbers, estimates, of_regime)


def differences(case: RandomContact) -> GridComparison:
    """Solve steady rolling with A and with B-hat, and compare the differences of their numbers."""
    cases = {name: replace(case, ics=name) for name in ("A", "Bhat")}
    on_grids = {name: _rolled_on_grids(one) for name, one in cases.items()}
    finer = {name: _rolled(one.finer, one.finer.problem)[1].numbers for name, one in cases.items()}
    of_regime, known = on_grids["A"][:2]
    tables = {
        "": [own.numbers for _, own, *_ in on_grids.values()],
        LARGER: [larger.numbers for _, _, larger, _ in on_grids.values()],
        FLOOR: [floors(own, OF_ROLLING) for _, own, *_ in on_grids.values()],
    }
    dataset = xr.Dataset(variables(OF_ROLLING, "ics", tables), {"ics": [*cases]})
    rows = {name: _difference(name) for name in OF_ROLLING}
    return GridComparison(
        {name: float(row(dataset)) for name, row in rows.items()},
        {name: finer["A"][name] - finer["Bhat"][name] for name in rows},
        {name: float(row(on_larger_elements(dataset))) for name, row in rows.items()},
        without_exact(
            {name: float(estimate_of_difference(dataset, row)) for name, row in rows.items()}, known
        ),
        of_regime,
    )


def frictionless_differences(case: RandomContact) -> GridComparison:
    """Solve a contact without friction, and compare errors of its numbers with A over those with B-hat."""

    def solved(case: RandomContact) -> PairDeviations:
        on_grid = case.on_grid
        return PairDeviations(on_grid, {"A": on_grid.operator("A"), C: on_grid.operator("Bhat")})

    def error(ours: Measured, theirs: Measured, number: str) -> float:
        return ours.numbers[number] / theirs.numbers[number] - 1

    contact, finer, load = solved(case), solved(case.finer), case.load
    found = {number: contact.error(number, "A", load) for number in NUMBERS}
    _, larger, *_ = zip(contact.levels(load, "A"), contact.levels(load, C), strict=True)
    return GridComparison(
        {number: value for number, (value, _) in found.items()},
        {number: finer.error(number, "A", load)[0] for number in NUMBERS},
        {number: error(*larger, number) for number in NUMBERS},
        {number: estimate for number, (_, estimate) in found.items()},
        "frictionless",
    )


def _difference(name: str) -> Difference:
    """Return the difference of a number with A to that with B-hat."""
    return lambda dataset: dataset[name].sel(ics="A") - dataset[name].sel(ics="Bhat")


def _rolled(case: RandomContact, problem: FrictionalProblem) -> tuple[str, Measured]:
    """Return the regime and the numbers of rolling on the grid of a problem."""
    forces, rolling = {"longitudinal": 0.0} if case.free else {}, case.rolling(problem)
    rolled = rolling.contact(case.creepages, Loading(case.load), forces=forces, tolerance=TOLERANCE)
    return regime(rolled.contact), measured_rolling(case.on_grid, rolling, rolled)


def _rolled_on_grids(case: RandomContact) -> tuple[str, Measured, Measured, Measured]:
    """Return the regime, and the numbers on the grid and on elements twice and four times as large."""
    (of_regime, fine), (_, coarse), (_, coarser) = (_rolled(case, problem) for problem in grids(case))
    return of_regime, fine, coarse, coarser


def grids(case: RandomContact) -> list[FrictionalProblem]:
    """Return the problem on its elements, and on elements twice and four times as large."""
    problem = case.problem
    return [problem, problem.coarsened, problem.coarsened.coarsened]


Study = Callable[[RandomContact], GridComparison]
STUDIES: Mapping[str, Study] = {
    "frictionless": frictionless,
    "rolling": rolling,
    "differences": differences,
    "frictionless differences": frictionless_differences,
}
