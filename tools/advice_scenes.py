"""Random wheels on rails, their solutions with approximations and C, and the store of these.

Shapes are arcs and ellipses, on and beside the crown. A patch turns by an angle that is drawn; the load
follows from it. Radii are those of rail heads and gauge corners; one wheel of twenty is nearly prismatic.

A scene is solved with approximations and with C on the same grid, without friction and rolling. Errors of the
elements are nearly the same with all ICs, and differences show those of the ICs. Each solution is stored in a
file: solved once, in parallel processes, and read again.
"""

import json
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from approx.pair import Pair, Solid
from femic.advice.knowledge import NORMAL_NUMBERS, contact_features, saturation
from femic.cache.digests import results_digest
from femic.cache.files import write_text
from femic.cache.workers import in_processes
from femic.contact.exact.hertz import combined_modulus
from femic.contact.friction.motion import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.normal import solve
from femic.contact.operators.dense import GridOperator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.grids import Size, Sizing, contact_size, hertz
from femic.contact.pairs.ics import ALL, C, c_jobs, ics_estimate, pair_operator
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid, undeformed_surfaces
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import numbers
from femic.contact.rolling import RollingContact, RollingProblem
from femic.contact.specification import (
    APPROACH_SHARE,
    ContactProblem,
    ContactSpecification,
    FrictionSpecification,
)
from femic.reference.engines import ENGINES
from femic.reference.harmonic.request import FAR_RADIUS
from femic.reference.job import Settings
from femic.reference.matrix.reference import matrices
from femic.reference.meshing import Cells
from femic.reference.run_options import RunOptions
from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse
from geometries.errors import Failure, WrongInput
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER

# --- random scenes ---

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
C_TOLERANCE = 1.0  # of C, met by its first cells: the study uses coarse ones, whose estimate counts
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
    # a steeper wheel would touch with its flanks
    flanks = (
        steeper,
        tuple(np.minimum(steeper, flatter).tolist()),
    )
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
        tolerance=C_TOLERANCE,
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


# --- study of a scene ---

NORMAL_ICS = ("A", "B", "Bbar", "Bhat")
ROLLING_ICS = ("A", "B", "Bhat", "mix")
SIZING = "Bhat"  # creepages are counted from that without force with these ICs
PERTURBED = "C plus its estimate"
TOLERANCE = 1e-4  # of tractions in rolling
CELLS_PER_STRIP, GROWTH = 0.5, 1.2  # first cells of C over the width of a strip, over the distance from it
SLOPE = 0.05  # force over friction times load between which and none the slope is taken


Entry = dict[str, Any]


def solve_scene(scene: RandomScene, seed: int, number: int) -> Entry:
    """Return the features of a scene, and numbers by ICs, without friction and in rolling.

    Numbers of rolling are arrays over `CREEPAGES`, forces over friction times load. ICs without a solution
    are left out; `PERTURBED` are numbers with C plus its estimate. Raises Failure where C or the contact with
    it is not found.
    """
    problem = scene.problem
    sizing = Sizing(pair_on_grid(problem, problem.grid), ELEMENTS)
    grid = sizing.grid([scene.size])
    grid = sizing.large_enough(grid, problem.specification.loadings, NORMAL_ICS)

    def solve_on(on_grid: PairOnGrid) -> Entry:
        return _solve_on_grid(scene, pair_in_motion(problem, on_grid))

    return {"seed": seed, "number": number} | sizing.on_long_enough_grid(grid, solve_on)


def _solve_on_grid(scene: RandomScene, pair: PairWithFriction) -> Entry:
    start, load, (friction,) = perf_counter(), pair.loads[0], pair.specification.coefficients
    references = reference_operators(pair.problem, pair.on_grid, pair.problem.settings.tolerance)
    solved = perf_counter()

    def problem_with(name: str) -> FrictionalProblem:
        return pair.frictional(references[name] if name in references else pair.operator(name), friction)

    frictionless = {}
    for name in (C, PERTURBED, *NORMAL_ICS):
        found = numbers(pair.on_grid, solve(problem_with(name).normal, load=load))
        frictionless[name] = {number: found[number] for number in NORMAL_NUMBERS}
    step = saturation(pair.problem, scene.size, friction, load)
    zero, rolling = _with_force(pair.rolling(problem_with(SIZING)), load, 0.0, None), {}
    for name in (C, PERTURBED, *ROLLING_ICS):
        try:
            rolling[name] = _curve_numbers(pair.rolling(problem_with(name)), load, zero, step)
        except Failure:
            if name == C:
                raise
    return {
        "features": contact_features(pair.problem, scene.size),
        "frictionless": frictionless,
        "rolling": rolling,
        "seconds": {"C": solved - start, "contact": perf_counter() - solved},
    }


def reference_operators(
    problem: ContactProblem, on_grid: PairOnGrid, tolerance: float
) -> dict[str, FullOperator]:
    """Return C on coarse cells for rolling, and the same with its estimated error added; raises Failure."""
    cells = Cells(CELLS_PER_STRIP * on_grid.grid.ds, GROWTH, GROWTH)
    jobs = {
        name: replace(job, settings=replace(job.settings, cells=cells, tolerance=tolerance))
        for name, job in c_jobs(problem, on_grid).items()
    }
    references = matrices(jobs, RunOptions(workers=1), combined=True)
    operator = pair_operator(references, on_grid, ALL, wheel_rolls=True)
    added = GridOperator.from_ics(ics_estimate(references, on_grid.grid, ALL))
    return {C: operator, PERTURBED: replace(operator, transformed=operator.transformed + added.transformed)}


def _with_force(
    problem: RollingProblem, load: float, share: float, start: RollingContact | None
) -> RollingContact:
    """Return the contact with a longitudinal force, a share of friction times load."""
    return problem.contact(
        Creepages(0.0 if start is None else start.creepages.longitudinal),
        Loading(load),
        forces={"longitudinal": share * problem.problem.friction * load},
        start=None if start is None else start.contact,
        tolerance=TOLERANCE,
    )


def _curve_numbers(
    problem: RollingProblem, load: float, start: RollingContact, step: float
) -> dict[str, Any]:
    """Return the numbers of a creep-force curve: without force, and at `CREEPAGES` times a step.

    Creepages are counted from that of `start`; each contact is found from a neighbour nearer to no force.
    """
    middle, limit = float(start.creepages.longitudinal), problem.problem.friction * load
    zero = _with_force(problem, load, 0.0, start)
    rise = _with_force(problem, load, SLOPE, zero).creepages.longitudinal - zero.creepages.longitudinal
    by_share: dict[float, RollingContact] = {0.0: zero}
    for share in sorted(CREEPAGES, key=abs):
        nearest = min(by_share, key=lambda other, share=share: abs(other - share))
        by_share[share] = problem.contact(
            replace(zero.creepages, longitudinal=middle + share * step),
            Loading(load),
            start=by_share[nearest].contact,
            tolerance=TOLERANCE,
        )
    contacts = [by_share[share].contact for share in CREEPAGES]
    force = np.array([contact.force for contact in contacts]) / limit
    return {
        "zero_creepage": float((zero.creepages.longitudinal - middle) / step),
        "slope": float(SLOPE / (rise / step)),
        "F_x": force[:, 0].tolist(),
        "F_y": force[:, 1].tolist(),
        "sliding_share": [contact.sliding_share for contact in contacts],
        "p_max": [float(np.max(contact.pressures)) for contact in contacts],
    }


# --- store of studies ---

TOOLS = "tools/advice_*.py"  # make scenes and solve them, beside the package
log = logging.getLogger(__name__)


def solve_entry(seed: int, number: int) -> Entry:
    """Return the entry of a scene; of one without a contact its seed, number and why."""
    try:
        return solve_scene(random_scene(seed, number), seed, number)
    except (Failure, WrongInput) as failure:
        return {"seed": seed, "number": number, "failure": str(failure)}


def entries(folder: Path, seed: int, code: str | None = None) -> list[Entry]:
    """Return the stored entries of a seed by number; with `code` only those that it made."""
    found = [entry for path in folder.glob(f"{seed}-*.json") if (entry := _read(path)) is not None]
    chosen = [entry for entry in found if code in (None, entry["code"])]
    return sorted(chosen, key=lambda entry: int(entry["number"]))


def solve_missing(
    folder: Path,
    wanted: Sequence[tuple[int, int]],
    workers: int,
    solve: Callable[[int, int], Entry] = solve_entry,
) -> Iterator[Entry]:
    """Solve the scenes, pairs of seed and number, that this code has not stored; yield each when it is.

    Each is stored at once: after an interruption the others are solved.
    """
    folder.mkdir(parents=True, exist_ok=True)
    code = results_digest(TOOLS)
    missing = [pair for pair in wanted if (_read(_path(folder, *pair)) or {}).get("code") != code]
    yield from in_processes(partial(_solve_and_store, folder, code, solve), missing, workers)


def _solve_and_store(
    folder: Path, code: str, solve: Callable[[int, int], Entry], pair: tuple[int, int]
) -> Entry:
    entry = solve(*pair) | {"code": code}
    write_text(json.dumps(entry) + "\n", _path(folder, *pair))
    return entry


def _path(folder: Path, seed: int, number: int) -> Path:
    return folder / f"{seed}-{number}.json"


def _read(path: Path) -> Entry | None:
    """Return an entry; None where there is none, or a damaged one."""
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except ValueError:
        log.warning(f"{path}: damaged; it is solved again")
        return None
