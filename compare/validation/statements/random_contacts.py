"""Statement 25: how often errors of random contacts are within their estimates, and their ratios.

Contacts are of a wheel on a rail: arcs and ellipses, unsymmetric, half of them beside the crown. In a quarter
of them a hump of the distance parts the contact into patches, which differ in size. Each is solved on a grid,
a coarser and a much finer one.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import NamedTuple

import numpy as np
import xarray as xr

from approx.pair import Pair, Solid
from compare.report.charts import Panel, make_curves
from compare.validation.statements.frame import Measure, Statement, above, below
from compare.validation.statements.runs import Runs
from femic.cache.digests import STUDY_FOLDERS, results_digest
from femic.cache.store import Arrays
from femic.cache.workers import in_processes
from femic.contact.datasets import (
    LARGER,
    Difference,
    difference_errors_of_all,
    estimate_of_difference,
    on_larger_elements,
    variables,
)
from femic.contact.estimates import Measured, Numbers, errors
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import Creepages
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions.none import SolvedContact, by_ics
from femic.contact.motions.rolling import OF_ROLLING, measured_rolling
from femic.contact.normal import NormalContact
from femic.contact.pairs.grids import Range, contact_size
from femic.contact.pairs.ics import approximation
from femic.contact.pairs.pair_on_grid import PairContact, PairOnGrid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.pairs.quantities import kinds, numbers
from femic.contact.rolling import RollingProblem
from femic.contact.specification import Profile
from femic.contact.undeformed import Undeformed
from femic.reference.run_options import RunOptions
from geometries.contours import Contour, arc, ellipse
from geometries.errors import Failure
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER, Surface

# --- random contacts ------------------------------------------------------------------------------------


FINER = 4  # by which elements of the reference are smaller
RADIUS = 10.0  # of the rail, of an arc or at the crown of an ellipse [mm]
FLANKS = (1.1, 0.9)  # inclination at which contours go on straight, to the left and to the right [rad]
HUMPS = 0.25  # share of contacts with a hump
HUMP = (0.3, 1.0)  # width and height of one, as shares of the patch's half-width and its sagitta
REACH = 9.0  # arc length to both sides on which bodies may touch [mm]
ICS = ("A", "A", "A", "B", "Bhat", "mix")  # each as often as it is named
FEWEST, MOST, MOST_OF_OTHERS = 8, 20, 13  # elements across the patch; products of A are faster
ROOM = (3, 6)  # elements beside the patch
FREE = 0.25  # share of contacts without force along x
LONGEST = 12.0  # half-length of a patch [mm]
STEEL = Material(210e3, 0.3)


@dataclass(frozen=True, eq=False)
class RandomContact:
    """A wheel on a rail, ICs, load [N], friction, creepages, and a grid."""

    on_grid: PairOnGrid
    ics: str
    load: float
    friction: float
    creepages: Creepages
    free: bool  # along x: the creepage is that without force
    times: int = FINER  # by which elements of the reference are smaller

    @property
    def finer(self) -> "RandomContact":
        """The same on the smaller elements of the reference."""
        grid, times = self.on_grid.grid, self.times
        finer = Grid(times * grid.n_x, times * grid.n_s, grid.dx / times, grid.ds / times, grid.s)
        return replace(self, on_grid=replace(self.on_grid, grid=finer))

    @property
    def problem(self) -> FrictionalProblem:
        """The contact with friction on the grid."""
        return frictional_problem(self.on_grid, approximation(self.on_grid, self.ics), self.friction)

    @property
    def problems(self) -> list[FrictionalProblem]:
        """The problem on its elements, and on elements twice and four times as large."""
        problem = self.problem
        return [problem, problem.coarsened, problem.coarsened.coarsened]

    def rolling(self, problem: FrictionalProblem) -> RollingProblem:
        """Return the wheel that rolls on the grid of a problem."""
        return rolling_problem(self.on_grid, problem)


def random_contact(seed: int, number: int, ics: Sequence[str] = ICS) -> RandomContact:
    """Return the contact of a number and a seed: the first of its own random ones that a grid fits."""
    random = np.random.default_rng([seed, number])
    while True:
        try:
            return _drawn_contact(random, ics)
        except Failure:
            continue


def _drawn_contact(random: np.random.Generator, ics: Sequence[str]) -> RandomContact:
    """Draw a contact; raises Failure where no grid fits it."""
    rolling_radius = random.uniform(250, 700)
    ratio = 1 + 10 ** random.uniform(-1.7, 0)
    if random.random() < 0.7:
        contours = arc(RADIUS, *FLANKS), arc(ratio * RADIUS, *FLANKS)
    else:
        along, deep = (RADIUS * random.uniform(0.7, 1.3) for _ in range(2))
        contours = ellipse(along, deep, *FLANKS), ellipse(ratio * along, deep, *FLANKS)
    low, high = (_crown_curvature(contour) for contour in contours)
    shift = random.choice([0.0, 1.0]) * random.uniform(-0.4, 0.4) * (1 / high - 1 / low)
    materials = STEEL, Material(STEEL.E * 10 ** random.uniform(-0.3, 0.3), STEEL.nu)
    rail, wheel = Surface(LOWER, contours[0]), Surface(UPPER, contours[1], rolling_radius)
    hertz = PointContact(1 / rolling_radius, low - high, combined_modulus(*materials))
    half_width = 10 ** random.uniform(-0.7, 0.6)  # of Hertz's patch [mm]
    load = (half_width / hertz.at_load(1.0).b) ** 3
    patch = hertz.at_load(load)
    if patch.a > LONGEST:
        raise Failure("a patch longer than those of wheels")
    on_grid = PairOnGrid(
        Pair(Solid(materials[0], wheel), Solid(materials[1], rail)),
        Undeformed(wheel, rail, (-REACH, REACH), shift),
        Grid(16, 16, 0.1, 0.1),
    )
    if random.random() < HUMPS:
        on_grid = replace(on_grid, extra_gap=_hump(random, on_grid, load, low - high))
    name = str(random.choice(list(ics)))
    most, size = MOST if name == "A" else MOST_OF_OTHERS, contact_size(on_grid, Loading(load))
    n_x, dx, _ = _elements(random, most, size.x, size.patch[0])
    n_s, ds, middle = _elements(random, most, size.s, size.patch[1])
    on_grid = replace(on_grid, grid=Grid(n_x, n_s, dx, ds, middle))
    friction = random.uniform(0.1, 0.6)
    # creepages from sticking to sliding; in Kalker's linear theory G a b C is about 3e5 a b
    saturated = friction * load / (80e3 * patch.a * patch.b * 4)
    creepage = saturated * 10 ** random.uniform(-1.0, 1.2)
    turn = random.uniform(0, 2 * np.pi)
    spin = random.choice([0.0, 1.0]) * random.uniform(-1, 1) * creepage / np.sqrt(patch.a * patch.b)
    creepages = Creepages(float(creepage * np.cos(turn)), float(creepage * np.sin(turn)), float(spin))
    return RandomContact(on_grid, name, load, friction, creepages, free=bool(random.random() < FREE))


def _crown_curvature(contour: Contour) -> float:
    """Return the curvature at the crown [1/mm]."""
    return abs(float(np.gradient(contour.inclination(np.array([-0.01, 0.0, 0.01])), 0.01)[1]))


def _hump(random: np.random.Generator, on_grid: PairOnGrid, load: float, curvature: float) -> Profile:
    """Draw a gap beside the middle of the patch, higher than the bodies come together without it.

    `curvature` is that of the lower contour less that of the upper one [1/mm].
    """
    size = contact_size(on_grid, Loading(load))
    half, middle = (size.s[1] - size.s[0]) / 2, (size.s[0] + size.s[1]) / 2
    width = half * random.uniform(*HUMP)
    place = middle + half * random.uniform(-0.3, 0.3)
    s = place + width * np.linspace(-1, 1, 801)  # smooth within elements
    height = half**2 * curvature * random.uniform(*HUMP)
    return Profile(s, height * np.cos(np.pi * (s - place) / (2 * width)) ** 2)


def _elements(
    random: np.random.Generator, most: int, ends: Range, smallest: float
) -> tuple[int, float, float]:
    """Draw number, size and middle of elements along a line over all patches, of which one is smallest."""
    elements, room = FEWEST * (most / FEWEST) ** random.random(), 2 * random.integers(ROOM[0], ROOM[1] + 1)
    step = smallest / elements
    count = 4 * int(np.ceil(((ends[1] - ends[0]) / step + room) / 4))
    return count, float(step), float(sum(ends) / 2 + step * random.uniform(-0.5, 0.5))


# --- studies --------------------------------------------------------------------------------------------


COMPARED = "A", "Bhat"
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
    fine = contact.measured
    exact, larger = (numbers(case.on_grid, normal) for normal in (finer.normal, coarse))
    estimates = without_exact(contact.estimated_errors(), fine)
    return GridComparison(fine.numbers, exact, larger, estimates, regime(contact.normal))


def rolling(case: RandomContact) -> GridComparison:
    """Solve steady rolling at given creepages, or without force along x; raises Failure likewise."""
    (found, fine), *larger = [_roll(case, problem) for problem in case.problems]
    _, finer = _roll(case.finer, case.finer.problem)
    coarse = [numbers for _, numbers in larger]
    estimates = without_exact(errors(kinds(OF_ROLLING), fine, coarse), fine)
    return GridComparison(fine.numbers, finer.numbers, coarse[0].numbers, estimates, found)


def differences_in_rolling(case: RandomContact) -> GridComparison:
    """Solve steady rolling with A and with B-hat, and compare the differences of their numbers."""
    cases = [replace(case, ics=name) for name in COMPARED]
    levels = [[_roll(one, problem) for problem in one.problems] for one in cases]
    finer = [_roll(one.finer, one.finer.problem)[1].numbers for one in cases]
    (found, known), _, _ = levels[0]
    tables: dict[str, Sequence[Numbers]] = {
        "": [own.numbers for (_, own), *_ in levels],
        LARGER: [larger.numbers for _, (_, larger), _ in levels],
        **difference_errors_of_all((own for (_, own), *_ in levels), OF_ROLLING),
    }
    dataset = xr.Dataset(variables(OF_ROLLING, "ics", tables), {"ics": list(COMPARED)})
    return _compared(dataset, finer, known, found)


def differences_without_friction(case: RandomContact) -> GridComparison:
    """Solve a contact without friction with A and with B-hat, and compare differences of its numbers."""

    def solved(case: RandomContact, ics: str) -> SolvedContact:
        loading = Loading(case.load)
        normal = case.on_grid.solve_in_place(case.on_grid.operator(ics), loading)
        return SolvedContact(loading, ics, PairContact(case.on_grid, normal))

    ours, finer = ([solved(one, ics) for ics in COMPARED] for one in (case, case.finer))
    exact = [numbers(contact.on_grid, contact.normal) for contact in finer]
    return _compared(by_ics(ours), exact, ours[0].measured, regime(ours[0].normal))


def _compared(
    dataset: xr.Dataset,
    finer: Sequence[Numbers],
    known: Measured,
    regime: str,
) -> GridComparison:
    """Compare differences of numbers between two ICs, with their variations, to those on smaller elements."""

    def difference(name: str) -> Difference:
        return lambda contacts: contacts[name].isel(ics=0) - contacts[name].isel(ics=1)

    rows = {name: difference(name) for name in finer[0]}
    estimates = {name: float(estimate_of_difference(dataset, row)) for name, row in rows.items()}
    return GridComparison(
        {name: float(row(dataset)) for name, row in rows.items()},
        {name: finer[0][name] - finer[1][name] for name in rows},
        {name: float(row(on_larger_elements(dataset))) for name, row in rows.items()},
        without_exact(estimates, known),
        regime,
    )


def _roll(case: RandomContact, problem: FrictionalProblem) -> tuple[str, Measured]:
    """Return the regime and the numbers of rolling on the grid of a problem."""
    forces, wheel = {"longitudinal": 0.0} if case.free else {}, case.rolling(problem)
    rolled = wheel.contact(case.creepages, Loading(case.load), forces=forces, tolerance=TOLERANCE)
    return regime(rolled.contact), measured_rolling(case.on_grid, wheel, rolled)


Study = Callable[[RandomContact], GridComparison]
STUDIES: Mapping[str, Study] = {
    "frictionless": frictionless,
    "rolling": rolling,
    "differences in rolling": differences_in_rolling,
    "differences without friction": differences_without_friction,
}


# --- coverage -------------------------------------------------------------------------------------------


NOTHING = 1e-9  # of estimates: errors that are rounding
ROWS = "numbers", "finer", "larger", "estimates"  # of a comparison, by name of the number
SPARE = 1.25  # contacts to start with for one that has a solution on all grids


class Coverage(NamedTuple):
    """Share of errors within estimates, worst error over estimate, median of estimate over error."""

    held: float
    worst: float
    median: float


def coverage(comparisons: Sequence[GridComparison], name: str, *, factor: float = 1.0) -> Coverage:
    """Return the coverage of a number's estimates times a factor.

    Contacts in which the number is exact do not count.
    """
    number, finer, estimate = (
        np.array([getattr(comparison, kind)[name] for comparison in comparisons])
        for kind in ("numbers", "finer", "estimates")
    )
    known = np.isfinite(estimate)
    if not np.any(known):
        return Coverage(1.0, 0.0, np.nan)  # a number that is exact in all contacts
    error, bound = np.abs(number - finer)[known], factor * estimate[known]
    finite = error > NOTHING * np.maximum(bound, np.finfo(float).tiny)  # rounding would have any ratio
    with np.errstate(divide="ignore", invalid="ignore"):
        return Coverage(
            float(np.mean(error <= bound)),
            float(np.max(np.where(finite, error / bound, 0.0))),
            float(np.median(bound[finite] / error[finite])) if np.any(finite) else np.nan,
        )


def by_regime(comparisons: Iterable[GridComparison]) -> dict[str, list[GridComparison]]:
    """Return contacts by their regime."""
    regimes: dict[str, list[GridComparison]] = {}
    for comparison in comparisons:
        regimes.setdefault(comparison.regime, []).append(comparison)
    return regimes


def compare_contact(study: Study, seed: int, number: int, ics: Sequence[str] = ICS) -> GridComparison | None:
    """Return the random contact of a number; None where it has no solution on one of the grids."""
    try:
        return study(random_contact(seed, number, ics))
    except Failure:
        return None


def comparisons(study: Study, seed: int, ics: Sequence[str] = ICS) -> Iterator[GridComparison]:
    """Yield random contacts, endlessly; contacts without a solution on one of the grids are left out."""
    found = (compare_contact(study, seed, number, ics) for number in count())
    return (comparison for comparison in found if comparison is not None)


def stored_comparisons(name: str, seed: int, count: int, options: RunOptions) -> list[GridComparison]:
    """Return random contacts of a study, each stored; a quarter more are solved, since some have no solution.

    Raises Failure where fewer than `count` have one.
    """
    key = options.store.key("coverage", results_digest(*STUDY_FOLDERS), name, seed)
    numbers = range(round(SPARE * count))
    parts = {number: options.store.part(key, f"contact{number}") for number in numbers}
    missing = [number for number, part in parts.items() if part is None]
    solve = partial(_solve_numbered, name, seed)
    for done, (number, arrays) in enumerate(in_processes(solve, missing, options.workers), start=1):
        parts[number] = arrays
        options.store.put_part(key, f"contact{number}", arrays)
        options.watch.on_stage(f"  {name}: {done} of {len(missing)} random contacts")
    solved = []
    for part in parts.values():
        if part and "none" not in part:
            names = [str(name) for name in part["names"]]
            rows = {key: dict(zip(names, map(float, part[key]), strict=True)) for key in ROWS}
            solved.append(GridComparison(**rows, regime=str(part["regime"])))
    if len(solved) < count:
        raise Failure(f"{name}: only {len(solved)} of {len(numbers)} random contacts have a solution")
    return solved[:count]


def _solve_numbered(name: str, seed: int, number: int) -> tuple[int, Arrays]:
    """Return a number and the arrays of its comparison for the store; a marker where there is none."""
    comparison = compare_contact(STUDIES[name], seed, number)
    if comparison is None:
        return number, {"none": np.zeros(0)}
    names = list(comparison.numbers)
    rows = {key: np.array([getattr(comparison, key)[name] for name in names]) for key in ROWS}
    return number, {"names": np.array(names), "regime": np.array(comparison.regime), **rows}


# --- the statement --------------------------------------------------------------------------------------


HELD = 0.95  # least share of errors that are within their estimates
USEFUL = 10.0  # largest median of estimate over error
COUNTS = {
    "frictionless": 200,
    "rolling": 200,
    "differences in rolling": 400,
    "differences without friction": 200,
}
SEED = 8  # of the random contacts of each study; no share of an estimate was found with them
SHOWN = ("p_max", "approach", "area", "F_x", "F_y", "sliding_share")  # numbers that are drawn
FACTORS = (0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35, 1.5)


def random_contacts(runs: Runs, study: str) -> list[GridComparison]:
    """Return random contacts of a study on grids of three fineness levels."""
    count = COUNTS[study]
    return runs.once(
        f"{count} random contacts, {study}", lambda: stored_comparisons(study, SEED, count, runs.options)
    )


def covered(study: str, kind: str) -> Measure:
    """Measure the share of errors that are "held", or the "median" width, of random contacts by number.

    Numbers that are given have no errors, and no width.
    """

    def measure(runs: Runs) -> Mapping[str, float]:
        contacts = random_contacts(runs, study)
        values = {name: getattr(coverage(contacts, name), kind) for name in contacts[0].numbers}
        return {f"{study}, {name}": value for name, value in values.items() if np.isfinite(value)}

    return measure


def coverage_details(runs: Runs) -> Mapping[str, float]:
    """Return the worst ratio of error to estimate, and the median ratio of estimate to error, by number."""
    details: dict[str, float] = {}
    for study in STUDIES:
        contacts = random_contacts(runs, study)
        for name in contacts[0].numbers:
            cover = coverage(contacts, name)
            if np.isfinite(cover.median):
                details[f"{study}, {name}: worst error over estimate"] = cover.worst
                details[f"{study}, {name}: median of estimate over error"] = cover.median
                for regime, those in by_regime(contacts).items():
                    held = coverage(those, name).held
                    details[f"{study}, {name}: held, {regime} ({len(those)})"] = held
    return details


def _panels(runs: Runs) -> Iterator[Panel]:
    """Return the share of contacts whose error is at most a multiple of its estimate, over the multiple."""
    for study in STUDIES:
        contacts = random_contacts(runs, study)
        held = {
            name: np.array([coverage(contacts, name, factor=factor).held for factor in FACTORS])
            if name in contacts[0].numbers
            else np.full(len(FACTORS), np.nan)
            for name in SHOWN
        }
        yield Panel(
            f"{study}, {len(contacts)} random contacts",
            "multiple of the estimate [-]",
            "share of contacts with an error below [-]",
            make_curves(FACTORS, held),
            marks=(1.0,),
        )


STATEMENTS = (
    Statement(
        25,
        "In contacts with A and the B family, the error of a number, and of its difference between two "
        "ICs, is within the estimated error in at least 95 % of the cases, and half of the estimated "
        "errors are at most ten times the error.",
        (
            *(
                above(
                    HELD,
                    f"held {study}",
                    f"share of {COUNTS[study]} random contacts, {study}, whose error is within its estimate",
                )(covered(study, "held"))
                for study in STUDIES
            ),
            *(
                below(
                    USEFUL,
                    f"width {study}",
                    f"median of estimate over error of {COUNTS[study]} random contacts, {study}",
                )(covered(study, "median"))
                for study in STUDIES
            ),
        ),
        _panels,
        coverage_details,
    ),
)
