"""Random wheels on rails, over what users have: arcs and ellipses, on and beside the crown.

A patch turns by an angle that is drawn; the load follows from it. Radii are those of rail heads and gauge
corners; one wheel of twenty is nearly prismatic.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.exact.hertz import combined_modulus
from femic.contact.loading import Loading
from femic.contact.pairs.grids import Size, contact_size, hertz
from femic.contact.pairs.pair_on_grid import PairOnGrid, undeformed_surfaces
from femic.contact.specification import (
    APPROACH_SHARE,
    ContactProblem,
    ContactSpecification,
    FrictionSpecification,
)
from femic.reference.engines import ENGINES
from femic.reference.harmonic.request import FAR_RADIUS
from femic.reference.job import Settings
from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse
from geometries.errors import Failure
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER

RADII = 6.0, 40.0  # of curvature of the rail at its crown [mm]
RATIOS = 0.01, 1.0  # by which radii of the wheel are larger, as shares
HEIGHTS = 0.5, 2.0  # of ellipses over their widths
ROLLING_RADII, LONG, LONG_SHARE = (250.0, 700.0), 2000.0, 0.05  # mm; of nearly prismatic wheels, their share
ANGLES = 5.0, 110.0  # by which patches turn [deg]
ASIDE, STEEPEST = 30.0, 72.0  # largest inclination at the middle, and at the ends of patches [deg]
FLANKS, ROOM = (20.0, 75.0), 3.0  # inclinations of flanks [deg], and how much steeper than a patch they are
STEEL, STEEL_SHARE = Material(210e3, 0.3), 0.4  # and how many pairs are both of steel
MODULUS_RATIO, POISSON = 3.0, (0.2, 0.49)
FRICTION = 0.1, 0.6
CREEPAGES = (-1.0, 0.0, 0.4, 2.0)  # over that of saturation, beside that without force with B-hat
MOST_PRESSED = 0.06  # largest pressure over the combined modulus
LONGEST = 0.2  # half-length of patches over the rolling radius
ELEMENTS = 12  # across the patch
TOLERANCE = 1.0  # of C, met by its first cells: the study uses coarse ones, whose estimate counts
LOADINGS = 6  # tries of the load that turns a patch by an angle
NEAR = 0.03  # of the angle
TRIES = 200


@dataclass(frozen=True)
class RandomScene:
    """A contact to be solved with several ICs and with C; it rolls with its first coefficient of friction."""

    problem: ContactProblem
    size: Size  # of its patch with B-hat


def random_scene(seed: int, number: int) -> RandomScene:
    """Return the scene of a number and a seed: the first of its own random ones that is one."""
    random = np.random.default_rng([seed, number])
    for _ in range(TRIES):
        try:
            return _drawn(random)
        except Failure:
            continue
    raise Failure(f"scene {number} of seed {seed}: none of {TRIES} has such a patch")


def _drawn(random: np.random.Generator) -> RandomScene:
    """Draw a scene; raises Failure where there is no such patch."""
    angle, middle = random.uniform(*ANGLES), random.choice([0.0, 1.0]) * random.uniform(-ASIDE, ASIDE)
    ends = middle - angle / 2, middle + angle / 2
    if max(-ends[0], ends[1]) > STEEPEST:
        raise Failure("steeper than flanks may be")
    bodies, shift = _bodies(random, ends, middle)
    problem = _problem(bodies, shift, float(random.uniform(*FRICTION)))
    load, size = _load(problem, angle)
    specification = replace(problem.specification, loads=(load,))
    return RandomScene(replace(problem, specification=specification), size)


def _bodies(
    random: np.random.Generator, ends: tuple[float, float], middle: float
) -> tuple[dict[str, Body], float]:
    """Draw two bodies that touch where their inclination is `middle` [deg], and the shift that needs [mm]."""
    radius, ratio = _log_uniform(random, *RADII), 1 + _log_uniform(random, *RATIOS)
    height = _log_uniform(random, *HEIGHTS) if random.random() < 0.5 else 1.0
    width = radius * height  # so that width^2 over height times width is the radius
    steeper = _flanks(random, ends)
    flatter = _flanks(random, ends) if random.random() < 0.5 else steeper
    flanks = (
        steeper,
        tuple(np.minimum(steeper, flatter).tolist()),
    )  # a steeper wheel would touch with its flanks
    lower, upper = (
        arc(scale * width, *ends)
        if height == 1.0
        else ellipse(scale * width, height * (scale * width), *ends)
        for scale, ends in zip((1, ratio), flanks, strict=True)
    )
    phi = np.arctan(np.tan(np.radians(middle)) / height)
    rolling_radius = LONG if random.random() < LONG_SHARE else random.uniform(*ROLLING_RADII)
    rail = wheel = STEEL
    if random.random() >= STEEL_SHARE:
        modulus = STEEL.E * _log_uniform(random, 1 / MODULUS_RATIO, MODULUS_RATIO)
        nu = random.uniform(*POISSON), random.uniform(*POISSON)
        rail, wheel = Material(STEEL.E, float(nu[0])), Material(modulus, float(nu[1]))
    domain = Domain(FAR_RADIUS, np.inf)
    bodies = {
        "lower": Body(LOWER, lower, rail, domain),
        "upper": Body(UPPER, upper, wheel, domain, float(rolling_radius)),
    }
    return bodies, float((1 - ratio) * width * np.sin(phi))


def _flanks(random: np.random.Generator, ends: tuple[float, float]) -> tuple[float, float]:
    """Draw the inclinations [rad] of both flanks, steeper than a patch with these inclinations [deg]."""
    low, high = FLANKS
    left, right = (random.uniform(max(low, end + ROOM), high) for end in (-ends[0], ends[1]))
    return float(np.radians(left)), float(np.radians(right))


def _problem(bodies: Mapping[str, Body], shift: float, friction: float) -> ContactProblem:
    """Return the contact of two bodies, under a load that is not known yet."""
    length = 1 / float(bodies["lower"].contour.curvature(0.0))
    turn = 2 * np.pi * bodies["upper"].rolling_radius
    reach = float(min(2 * length, FAR_RADIUS / 8, turn / 6))
    solids = {name: Solid(body.material, body.surface) for name, body in bodies.items()}
    settings = Settings(
        engine=ENGINES["harmonic"],
        tolerance=TOLERANCE,
        rotation_reach=reach,
        moment_arm=min(length / 2, reach / 2),
        approach_side=length / APPROACH_SHARE,
    )
    specification = ContactSpecification(
        motion="rolling",
        loads=(1.0,),
        ics=("A", "B", "Bbar", "Bhat"),
        friction=FrictionSpecification((friction,)),
        shift=shift,
        elements=ELEMENTS,
        supports=False,
    )
    pair = Pair(solids["upper"], solids["lower"])
    grid = Grid(8, 8, 1.0, 1.0)
    return ContactProblem(
        "random", bodies, pair, specification, grid, settings, "approach", FAR_RADIUS, length
    )


def _load(problem: ContactProblem, angle: float) -> tuple[float, Size]:
    """Return the load [N] under which the patch turns by nearly an angle [deg], and the patch.

    Raises Failure where the patch is not on both contours, where it is too long, or pressed too much.
    """
    undeformed = undeformed_surfaces(problem)
    on_grid = PairOnGrid(problem.pair, undeformed, problem.grid)
    lower = problem.bodies["lower"].contour
    curvature = float(lower.curvature(undeformed.touching[0]))
    if curvature == 0:
        raise Failure("a first touch on the flanks")
    half_width = np.radians(angle / 2) / curvature
    load = float((half_width / hertz(on_grid, Loading(1.0)).b) ** 3)
    for _ in range(LOADINGS):
        size = contact_size(on_grid, Loading(load))
        turned = float(np.degrees(np.ptp(lower.inclination(np.array(size.s)))))
        if abs(turned / angle - 1) < NEAR:
            break
        load *= float(np.clip((angle / turned) ** 2.5, 0.1, 10.0))
    low, high = lower.limits
    if not low < size.s[0] < size.s[1] < high:
        raise Failure("a patch on the flanks")
    upper = problem.bodies["upper"]
    if size.x[1] > LONGEST * upper.rolling_radius:
        raise Failure("a patch longer than those of wheels")
    area = np.pi / 4 * (size.x[1] - size.x[0]) * (size.s[1] - size.s[0])
    modulus = combined_modulus(upper.material, problem.bodies["lower"].material)
    if 1.5 * load / area > MOST_PRESSED * modulus:
        raise Failure("pressures larger than materials bear")
    return load, size


def _log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))
