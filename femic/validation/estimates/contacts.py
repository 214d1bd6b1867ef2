"""Random contacts of a wheel on a rail: arcs and ellipses, unsymmetric, half of them off the crown.

In a quarter of them a hump of the distance parts the contact into patches, which differ in size.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.extra_gap import Profile
from femic.contact.friction.kinematics import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.pairs.contact_size import Range, contact_size
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.pairs.reference_ics import approximation
from femic.contact.rolling import RollingProblem
from femic.contact.undeformed import Undeformed
from geometries.contours import Contour, arc, ellipse
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER, Surface

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
        operator = approximation(self.on_grid, self.ics)
        return frictional_problem(self.on_grid, operator, self.friction)

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
    contours = _contours(random, ratio)
    low, high = (_curvature(contour) for contour in contours)
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
        on_grid = replace(on_grid, extra_gap=_hump(random, on_grid, load))
    name = str(random.choice(list(ics)))
    on_grid = replace(on_grid, grid=_grid(random, on_grid, load, MOST if name == "A" else MOST_OF_OTHERS))
    friction = random.uniform(0.1, 0.6)
    creepages = _creepages(random, friction, load, patch)
    return RandomContact(on_grid, name, load, friction, creepages, free=bool(random.random() < FREE))


def _contours(random: np.random.Generator, ratio: float) -> tuple[Contour, Contour]:
    """Draw two arcs, or two ellipses."""
    if random.random() < 0.7:
        return arc(RADIUS, *FLANKS), arc(ratio * RADIUS, *FLANKS)
    along, deep = (RADIUS * random.uniform(0.7, 1.3) for _ in range(2))
    return ellipse(along, deep, *FLANKS), ellipse(ratio * along, deep, *FLANKS)


def _hump(random: np.random.Generator, on_grid: PairOnGrid, load: float) -> Profile:
    """Draw a gap beside the middle of the patch, higher than the bodies come together without it."""
    size = contact_size(on_grid, Loading(load))
    half, middle = (size.s[1] - size.s[0]) / 2, (size.s[0] + size.s[1]) / 2
    width = half * random.uniform(*HUMP)
    place = middle + half * random.uniform(-0.3, 0.3)
    s = place + width * np.linspace(-1, 1, 801)  # smooth within elements
    height = half**2 * _relative_curvature(on_grid) * random.uniform(*HUMP)
    return Profile(s, height * np.cos(np.pi * (s - place) / (2 * width)) ** 2)


def _relative_curvature(on_grid: PairOnGrid) -> float:
    """Return the curvature of the lower contour less that of the upper one at its crown [1/mm]."""
    return _curvature(on_grid.undeformed.lower.contour) - _curvature(on_grid.undeformed.upper.contour)


def _curvature(contour: Contour) -> float:
    """Return the curvature at the crown [1/mm]."""
    return abs(float(np.gradient(contour.inclination(np.array([-0.01, 0.0, 0.01])), 0.01)[1]))


def _grid(random: np.random.Generator, on_grid: PairOnGrid, load: float, most: int) -> Grid:
    """Draw a grid about the patch; raises Failure where it does not fit the bodies."""
    size = contact_size(on_grid, Loading(load))
    n_x, dx, _ = _line(random, most, size.x, size.patch[0])
    n_s, ds, middle = _line(random, most, size.s, size.patch[1])
    return Grid(n_x, n_s, dx, ds, middle)


def _line(random: np.random.Generator, most: int, ends: Range, smallest: float) -> tuple[int, float, float]:
    """Draw number, size and middle of elements along a line over all patches, of which one is smallest."""
    elements, room = FEWEST * (most / FEWEST) ** random.random(), 2 * random.integers(ROOM[0], ROOM[1] + 1)
    step = smallest / elements
    count = 4 * int(np.ceil(((ends[1] - ends[0]) / step + room) / 4))
    return count, float(step), float(sum(ends) / 2 + step * random.uniform(-0.5, 0.5))


def _creepages(random: np.random.Generator, friction: float, load: float, hertz: LoadedPoint) -> Creepages:
    """Draw creepages, from sticking to sliding; in Kalker's linear theory G a b C is about 3e5 a b."""
    saturated = friction * load / (80e3 * hertz.a * hertz.b * 4)
    size = saturated * 10 ** random.uniform(-1.0, 1.2)
    turn = random.uniform(0, 2 * np.pi)
    spin = random.choice([0.0, 1.0]) * random.uniform(-1, 1) * size / np.sqrt(hertz.a * hertz.b)
    return Creepages(float(size * np.cos(turn)), float(size * np.sin(turn)), float(spin))
