"""Studies of random scenes: features of a contact, its solution with approximations and C, and their store.

Features are what is known of a contact with B-hat alone, before C is solved, and on what the errors of
approximate ICs depend: by what the patch turns and where it lies, how conformal the bodies are, what lies
beyond the patch, materials, friction.

A scene is solved with approximations and with C on the same grid, without friction and rolling. Errors of the
elements are nearly the same with all ICs, and differences show those of the ICs.

Studies are stored, one file each: solved once, in parallel processes, and read again.
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

from femic.advice.scenes import CREEPAGES, ELEMENTS, RandomScene, random_scene
from femic.cache.digests import results_digest
from femic.cache.files import write_text
from femic.cache.workers import in_processes
from femic.contact.friction.motion import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.normal import solve
from femic.contact.operators.dense import GridOperator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.grids import Size, Sizing
from femic.contact.pairs.ics import ALL, C, c_jobs, ics_estimate, pair_operator
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import numbers
from femic.contact.rolling import RollingContact, RollingProblem
from femic.contact.specification import ContactProblem
from femic.reference.matrix.reference import matrices
from femic.reference.meshing import Cells
from femic.reference.run_options import RunOptions
from geometries.errors import Failure, WrongInput

# --- features of a contact ---

FLAT = 1e-6  # curvature [1/mm] below which a contour is flat
INSIDE = 0.98  # of a patch, over which its curvatures are compared
SATURATION = 4.0  # G a b times this is a slope of creep forces, nearly that of Kalker's linear theory


@dataclass(frozen=True)
class Feature:
    """A number on which errors depend: in words, and the difference that counts like one of 1 elsewhere."""

    meaning: str
    scale: float
    unit: str = ""
    logarithmic: bool = False
    only_with_friction: bool = False

    def on_scale(self, value: float) -> float:
        """Return a value over the scale."""
        return float(np.log(value) if self.logarithmic else value) / self.scale


FEATURES: Mapping[str, Feature] = {
    "angle": Feature("the angle by which the patch turns", 0.15, "deg", logarithmic=True),
    "middle": Feature("the inclination at its middle", 15.0, "deg"),
    "aspect": Feature("its aspect a/b", 0.7, logarithmic=True),
    "unlike": Feature("the relative difference of the bodies' curvatures", 1.0, logarithmic=True),
    "varying": Feature("the curvature at its ends over that at its middle", 0.5, logarithmic=True),
    "beyond": Feature(
        "the inclination of the flatter flank beyond its ends, less that of the end", 25.0, "deg"
    ),
    "modulus": Feature("the modulus of the upper over that of the lower body", 0.5, logarithmic=True),
    "nu_lower": Feature("Poisson's ratio of the lower body", 0.15),
    "nu_upper": Feature("Poisson's ratio of the upper body", 0.15),
    "long": Feature("a over the rolling radius", 1.5, logarithmic=True),
    "friction": Feature("the coefficient of friction", 0.25, only_with_friction=True),
}


def contact_features(problem: ContactProblem, size: Size) -> dict[str, float]:
    """Return the features of a contact by name; `size` is that of its patch with B-hat.

    Each angle [deg] and ratio as in `FEATURES`; 0 where there is no friction.
    """
    lower, upper = (problem.bodies[name] for name in ("lower", "upper"))
    ends, middle, friction = np.array(size.s), sum(size.s) / 2, problem.specification.friction
    inclination = np.degrees(lower.contour.inclination(ends))
    a, b = size.x[1], (size.s[1] - size.s[0]) / 2
    curvature = max(abs(float(lower.contour.curvature(middle))), FLAT)
    at_ends = np.abs(lower.contour.curvature(middle + INSIDE * b * np.array([-1.0, 1.0])))
    s = np.linspace(*upper.contour.limits, 401)  # the upper contour has the inclination of the middle there
    turned = np.abs(upper.contour.inclination(s) - float(lower.contour.inclination(middle)))
    opposite = float(upper.contour.curvature(s[np.argmin(turned)]))
    return {
        "angle": float(np.ptp(inclination)),
        "middle": abs(float(np.mean(inclination))),
        "aspect": a / b,
        "unlike": max(abs(1 - opposite / curvature), 1e-3),
        "varying": max(float(np.mean(at_ends)), FLAT) / curvature,
        "beyond": turn_beyond(problem, inclination),
        "modulus": upper.material.E / lower.material.E,
        "nu_lower": lower.material.nu,
        "nu_upper": upper.material.nu,
        "long": a / upper.rolling_radius,
        "friction": max(friction.coefficients) if friction else 0.0,
    }


def saturation(problem: ContactProblem, size: Size, friction: float, load: float) -> float:
    """Return a creepage at which a contact is nearly saturated: friction times load over a linear slope."""
    compliance = np.mean([1 / body.material.G for body in problem.bodies.values()])
    a, b = size.x[1], (size.s[1] - size.s[0]) / 2
    return float(friction * load * compliance / (SATURATION * a * b))


def turn_beyond(problem: ContactProblem, ends: np.ndarray) -> float:
    """Return by how much contours turn further beyond the ends of a patch [deg], on the side of the least."""
    turns = []
    for body in problem.bodies.values():
        left, right = np.degrees(body.contour.inclination(np.array(body.contour.limits)))
        turns += [float(ends[0] - left), float(right - ends[1])]
    return min(turns)


# --- study of a scene ---

NORMAL_ICS = ("A", "B", "Bbar", "Bhat")
ROLLING_ICS = ("A", "B", "Bhat", "mix")
SIZING = "Bhat"  # creepages are counted from that without force with these ICs
PERTURBED = "C plus its estimate"
NORMAL_NUMBERS = ("p_max", "a", "b", "angle", "approach", "area", "stiffness")
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
    of_c = reference_operators(pair.problem, pair.on_grid, pair.problem.settings.tolerance)
    solved = perf_counter()

    def problem_with(name: str) -> FrictionalProblem:
        return pair.frictional(of_c[name] if name in of_c else pair.operator(name), friction)

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
        nearest = min(by_share, key=lambda other, share=share: abs(other - share))  # type: ignore[misc]
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
    code = results_digest()  # of what makes scenes and solves them
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
