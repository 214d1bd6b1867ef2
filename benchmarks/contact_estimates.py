"""How often estimates of contact results hold: random contacts against elements four times smaller.

    python benchmarks/contact_estimates.py rolling frictionless compression curve --count 200 --seed 2

Prints for each number how often its error is within its estimate, the worst ratio of error and estimate, and
the median of the opposite ratio, which says how much too large estimates are; the same for the difference to
elements twice as large. The shares in `contact.undecided` were found with contacts of seeds 1 and 2; others
check them. On arcs and ellipses, unsymmetric and often off the crown, with 8 to 20 elements across the patch.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from approx.pair import Pair, Solid
from compare.results.contact.compute import SolvedContact
from compare.results.contact.dataset import _estimates as estimates_without_friction
from compare.results.contact.grids import Sizing
from compare.results.contact.pairing import Case, Placed, Settled
from compare.results.contact.quantities import numbers as numbers_without_friction
from compare.results.friction.compression import _estimates as estimates_of_steps
from compare.results.friction.compression import in_halves
from compare.results.friction.curve import Path
from compare.results.friction.dataset import errors
from compare.results.friction.operators import approximation
from compare.results.friction.quantities import OF_PATCH, OF_ROLLING, measured
from compare.results.friction.rolling import OF_FREE
from contact.compression import compressed
from contact.estimates import Measured, Numbers
from contact.friction.kinematics import Creepages, Rolling
from contact.frictional import FrictionalProblem, Pressing
from contact.operators.turned import turned
from contact.references.hertz import PointContact, combined_modulus
from contact.rolling import RollingProblem
from contact.undeformed import Undeformed
from geometries.contours import arc, ellipse
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER, Surface

NOTHING = 1e-9  # of estimates: errors that are rounding
STEPS = 2  # of load in compressions, each in halves
TOLERANCE = 1e-4  # of tractions: errors of results are 1e-3 and more
FINER = 4  # by which elements of the reference are smaller
RADIUS = 10.0  # of the rail, of an arc or at the crown of an ellipse [mm]
FLANKS = (1.1, 0.9)  # inclination at which contours go on straight, to the left and to the right [rad]
REACH = 9.0  # arc length to both sides on which bodies may touch [mm]
ICS = ("A", "A", "A", "B", "Bhat", "mix")  # each as often as it is named
FEWEST, MOST, MOST_OF_OTHERS = 8, 20, 13  # elements across the patch; products of A are faster
ROOM = (3, 6)  # elements beside the patch
FREE = 0.25  # share of contacts without force along x
LONGEST = 12.0  # half-length of a patch [mm]


@dataclass(frozen=True)
class RandomContact:
    """A wheel on a rail, ICs, load [N], friction, creepages, and a grid."""

    placed: Placed
    ics: str
    load: float
    friction: float
    creepages: Creepages
    free: bool  # along x: the creepage is that without force

    @property
    def finer(self) -> "RandomContact":
        """The same on elements four times smaller."""
        grid = self.placed.grid
        n_x, n_s = FINER * grid.n_x, FINER * grid.n_s
        return replace(
            self, placed=replace(self.placed, grid=Grid(n_x, n_s, grid.dx / FINER, grid.ds / FINER, grid.s))
        )

    @property
    def problem(self) -> FrictionalProblem:
        """The contact with friction on the grid."""
        placed = self.placed
        return FrictionalProblem(
            placed.grid,
            approximation(placed, self.ics),
            turned("A", placed.pair, placed.grid),
            placed.distance,
            placed.undeformed.lower.contour.inclination(placed.grid.strips),
            self.friction,
        )

    def rolling(self, problem: FrictionalProblem) -> RollingProblem:
        """The wheel that rolls on the grid of a problem."""
        placed = replace(self.placed, grid=problem.grid)
        contour, radius = placed.undeformed.lower.contour, placed.undeformed.upper.rolling_radius
        strips = placed.grid.strips
        height = placed.undeformed.upper_height(strips)
        return RollingProblem(problem, Rolling(contour, radius, placed.x, strips, height))


def random_contacts(seed: int, ics: tuple[str, ...] = ICS) -> Iterator[RandomContact]:
    """Contacts without end; those that no grid fits are left out."""
    random = np.random.default_rng(seed)
    while True:
        try:
            yield random_contact(random, ics)
        except Failure:
            continue


def random_contact(random: np.random.Generator, ics: tuple[str, ...]) -> RandomContact:
    """A contact; raises Failure where no grid fits it."""
    rolling_radius = random.uniform(250, 700)
    ratio = 1 + 10 ** random.uniform(-1.7, 0)
    if random.random() < 0.7:
        contours = arc(RADIUS, *FLANKS), arc(ratio * RADIUS, *FLANKS)
    else:
        semi = RADIUS * random.uniform(0.7, 1.3), RADIUS * random.uniform(0.7, 1.3)
        contours = ellipse(*semi, *FLANKS), ellipse(semi[0] * ratio, semi[1], *FLANKS)
    low, high = (float(s) for s in _curvatures(contours))
    shift = random.choice([0.0, 1.0]) * random.uniform(-0.4, 0.4) * (1 / high - 1 / low)
    material = Material(210e3, 0.3), Material(210e3 * 10 ** random.uniform(-0.3, 0.3), 0.3)
    rail = Surface(LOWER, contours[0])
    wheel = Surface(UPPER, contours[1], rolling_radius)
    pair = Pair(Solid(material[0], wheel), Solid(material[1], rail))
    hertz = PointContact(1 / rolling_radius, low - high, combined_modulus(*material))
    half_width = 10 ** random.uniform(-0.7, 0.6)  # of Hertz's patch [mm]
    load = (half_width / hertz.at_load(1.0).b) ** 3
    if hertz.at_load(load).a > LONGEST:
        raise Failure("a patch longer than those of wheels")
    placed = Placed(pair, Undeformed(wheel, rail, (-REACH, REACH), shift), Grid(16, 16, 0.1, 0.1))
    size = Sizing(placed, 10).size(Case(load, None))
    name = str(random.choice(ics))
    most = MOST if name == "A" else MOST_OF_OTHERS
    along = _line(random, most, size.x[1] - size.x[0], 0.0)
    across = _line(random, most, size.s[1] - size.s[0], (size.s[0] + size.s[1]) / 2)
    grid = Grid(along[0], across[0], along[1], across[1], across[2])
    friction = random.uniform(0.1, 0.6)
    creepages = _creepages(random, friction, load, hertz.at_load(load))
    placed = replace(placed, grid=grid)
    return RandomContact(placed, name, load, friction, creepages, free=random.random() < FREE)


def _curvatures(contours):
    return [
        abs(np.gradient(contour.inclination(np.array([-0.01, 0.0, 0.01])), 0.01)[1]) for contour in contours
    ]


def _line(random, most, length, middle):
    elements, room = FEWEST * (most / FEWEST) ** random.random(), 2 * random.integers(ROOM[0], ROOM[1] + 1)
    step = length / elements
    count = 4 * int(np.ceil((elements + room) / 4))
    return count, float(step), float(middle + step * random.uniform(-0.5, 0.5))


def _creepages(random, friction, load, hertz):
    """From nearly full sticking to full sliding: Kalker's linear theory has G a b C = 3e5 * a * b about."""
    saturated = friction * load / (80e3 * hertz.a * hertz.b * 4)
    size = saturated * 10 ** random.uniform(-1.0, 0.7)
    turn = random.uniform(0, 2 * np.pi)
    spin = random.choice([0.0, 1.0]) * random.uniform(-1, 1) * size / np.sqrt(hertz.a * hertz.b)
    return Creepages(float(size * np.cos(turn)), float(size * np.sin(turn)), float(spin))


@dataclass(frozen=True)
class Outcome:
    """Numbers of a contact, those on elements four times smaller, on larger ones, and the estimates."""

    numbers: Numbers
    finer: Numbers
    larger: Numbers
    estimates: Numbers


def frictionless(case: RandomContact) -> Outcome:
    """Without friction."""

    def solved(on: RandomContact) -> SolvedContact:
        given = Case(on.load, None)
        normal = on.placed.contact(on.placed.operator(on.ics), given)
        return SolvedContact(given, on.ics, Settled(on.placed, normal), None, None, 0.0)

    found, finer = solved(case), solved(case.finer)
    coarse = found.normal.coarser
    if coarse is None:
        raise Failure("the grid is too small")
    rows = [
        numbers_without_friction(replace(case.placed, grid=one.problem.grid), one)
        for one in (found.normal, finer.normal, coarse)
    ]
    return Outcome(*rows, estimates_without_friction(found))


def rolling(case: RandomContact) -> Outcome:
    """Steady rolling at some creepages, or without force along x."""
    forces = {"longitudinal": 0.0} if case.free else {}

    def solved(of: RandomContact, problem: FrictionalProblem) -> Measured:
        found = of.rolling(problem).contact(
            of.creepages, Pressing(load=of.load), forces=forces, tolerance=TOLERANCE
        )
        return measured(OF_ROLLING, of.placed, found.contact)

    fine, *larger = (solved(case, problem) for problem in grids(case))
    finer = solved(case.finer, case.finer.problem).numbers
    return Outcome(fine.numbers, finer, larger[0].numbers, errors(OF_ROLLING, fine, larger))


def curve(case: RandomContact) -> Outcome:
    """Creepage without force, slope, creepage at half of friction times load."""

    def solved(of: RandomContact, problem: FrictionalProblem) -> Measured:
        return path(of, problem).curve().free

    fine, *larger = (solved(case, problem) for problem in grids(case))
    finer = solved(case.finer, case.finer.problem).numbers
    return Outcome(fine.numbers, finer, larger[0].numbers, errors(OF_FREE, fine, larger))


def path(case: RandomContact, problem: FrictionalProblem) -> Path:
    """The way along a creep-force curve, of all that a scene says only what this reads."""
    size = float(np.hypot(case.creepages.longitudinal, case.creepages.lateral))
    most = 3 * size + 2 * case.friction * case.load / 1e6
    wanted = SimpleNamespace(
        longitudinal=(-most, 0.0, most), lateral=case.creepages.lateral / 3, spin=0.0, equal_force=0.5
    )
    solver = SimpleNamespace(
        wanted=wanted,
        placed=case.placed,
        scene=SimpleNamespace(contact=SimpleNamespace(loads=[case.load])),
        means=SimpleNamespace(watch=SimpleNamespace(on_stage=lambda _: None)),
    )
    return Path(solver, case.rolling(problem), "random")


def compression(case: RandomContact) -> Outcome:
    """Pressed on in steps; the reference has four times as many of these, too."""

    def steps(of: RandomContact, problem: FrictionalProblem, loads: list[float]) -> list[Measured]:
        found = compressed(problem, [Pressing(load=load) for load in loads])
        return [measured(OF_PATCH, of.placed, contact) for contact in found]

    loads = [case.load * (number + 1) / STEPS for number in range(STEPS)]
    halves, quarters = in_halves(loads), in_halves(in_halves(in_halves(loads)))
    fine, *larger = (steps(case, problem, halves)[1::2] for problem in grids(case))
    once = steps(case, case.problem, loads)
    finer = steps(case.finer, case.finer.problem, quarters)[-1].numbers
    estimates = estimates_of_steps(fine, larger, once, None)[-1]
    return Outcome(fine[-1].numbers, finer, larger[0][-1].numbers, estimates)


def grids(case: RandomContact) -> list[FrictionalProblem]:
    """The problem on its elements, on those twice and four times as large."""
    problem = case.problem
    return [problem, problem.coarsened, problem.coarsened.coarsened]


STUDIES: Mapping[str, Callable[[RandomContact], Outcome]] = {
    "frictionless": frictionless,
    "rolling": rolling,
    "curve": curve,
    "compression": compression,
}


def outcomes(study: str, seed: int, ics: tuple[str, ...] = ICS) -> Iterator[Outcome]:
    """What random contacts give, without end; those without a solution on one of the grids are left out."""
    for case in random_contacts(seed, ics):
        try:
            yield STUDIES[study](case)
        except Failure as failure:
            print(f"left out: {failure}"[:110])


@dataclass(frozen=True)
class Coverage:
    """How often errors are within estimates, their worst ratio, and the median of the opposite one."""

    held: float
    worst: float
    median: float


def coverage(found: list[Outcome], name: str, *, differences: bool = False) -> Coverage:
    """That of the estimates of a number, or of its differences to elements twice as large."""
    error = np.array([abs(one.numbers[name] - one.finer[name]) for one in found])
    known = np.array(
        [abs(one.numbers[name] - one.larger[name]) if differences else one.estimates[name] for one in found]
    )
    told = error > NOTHING * np.maximum(known, np.finfo(float).tiny)  # the others would have any ratio
    with np.errstate(divide="ignore", invalid="ignore"):
        return Coverage(
            float(np.mean(error <= known)),
            float(np.max(np.where(told, error / known, 0.0))),
            float(np.median(known[told] / error[told])) if np.any(told) else np.nan,
        )


def table(study: str, found: list[Outcome]) -> str:
    """Coverage of all numbers, as Markdown."""
    lines = [
        f"| {study}, {len(found)} contacts | difference holds | worst | median "
        "| estimate holds | worst | median |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in found[0].numbers:
        before, now = (coverage(found, name, differences=flag) for flag in (True, False))
        cells = [f"{one.held:.1%} | {one.worst:.1f} | {one.median:.1f}" for one in (before, now)]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Print the tables of studies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("studies", nargs="+", choices=list(STUDIES))
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=2)
    asked = parser.parse_args()
    for study in asked.studies:
        found = [one for one, _ in zip(outcomes(study, asked.seed), range(asked.count), strict=False)]
        print(table(study, found), flush=True)


if __name__ == "__main__":
    main()
