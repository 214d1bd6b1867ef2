"""How often estimates of contact results hold: random contacts against elements four times smaller.

python benchmarks/contact_estimates.py rolling --count 200 --seed 2
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, Solid
from compare.results.contact.grids import Sizing
from compare.results.contact.pairing import Case, Placed
from compare.results.friction.operators import approximation
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

FINER = 4  # by which elements of the reference are smaller
RADIUS = 10.0  # of the rail, of an arc or at the crown of an ellipse [mm]
FLANKS = (1.1, 0.9)  # inclination at which contours go on straight, to the left and to the right [rad]
REACH = 9.0  # arc length to both sides on which bodies may touch [mm]
ICS = ("A", "A", "A", "B", "Bhat", "mix")  # each as often as it is named
FEWEST, MOST, MOST_OF_OTHERS = 8, 20, 13  # elements across the patch; products of A are faster
ROOM = (3, 6)  # elements beside the patch
LONGEST = 12.0  # half-length of a patch [mm]


@dataclass(frozen=True)
class RandomContact:
    """A wheel on a rail, ICs, load [N], friction, creepages, and a grid."""

    placed: Placed
    ics: str
    load: float
    friction: float
    creepages: Creepages

    @property
    def finer(self) -> "RandomContact":
        grid = self.placed.grid
        n_x, n_s = FINER * grid.n_x, FINER * grid.n_s
        return replace(
            self, placed=replace(self.placed, grid=Grid(n_x, n_s, grid.dx / FINER, grid.ds / FINER, grid.s))
        )

    @property
    def problem(self) -> FrictionalProblem:
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
    return RandomContact(replace(placed, grid=grid), name, load, friction, creepages)


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
