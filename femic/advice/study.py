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
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from femic.advice.scenes import CREEPAGES, ELEMENTS, RandomScene, random_scene
from femic.cache.digests import results_digest
from femic.cache.files import write_text
from femic.cache.workers import in_processes
from femic.contact.estimates import Numbers
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
from geometries.contours import Contour
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
    ends, middle = np.array(size.s), sum(size.s) / 2
    inclination = np.degrees(lower.contour.inclination(ends))
    a, b = size.x[1], (size.s[1] - size.s[0]) / 2
    friction = problem.specification.friction
    return {
        "angle": float(np.ptp(inclination)),
        "middle": abs(float(np.mean(inclination))),
        "aspect": a / b,
        "unlike": _unlike(problem, middle),
        "varying": _varying(lower.contour, size),
        "beyond": _beyond(problem, inclination),
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


def _unlike(problem: ContactProblem, s: float) -> float:
    """Return 1 less the curvature of the upper over that of the lower contour, where both face each other."""
    lower, upper = (problem.bodies[name].contour for name in ("lower", "upper"))
    own = abs(float(lower.curvature(s)))
    return max(abs(1 - _curvature_at(upper, float(lower.inclination(s))) / max(own, FLAT)), 1e-3)


def _curvature_at(contour: Contour, inclination: float) -> float:
    """Return the curvature of a contour where it has an inclination [rad], or comes nearest to it."""
    s = np.linspace(*contour.limits, 401)
    return float(contour.curvature(s[np.argmin(np.abs(contour.inclination(s) - inclination))]))


def _varying(contour: Contour, size: Size) -> float:
    """Return the mean curvature at both ends of a patch over that at its middle."""
    middle, half = sum(size.s) / 2, INSIDE * (size.s[1] - size.s[0]) / 2
    ends = np.abs(contour.curvature(middle + half * np.array([-1.0, 1.0])))
    return max(float(np.mean(ends)), FLAT) / max(abs(float(contour.curvature(middle))), FLAT)


def _beyond(problem: ContactProblem, ends: np.ndarray) -> float:
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
CELLS_PER_STRIP, GROWTH = (
    0.5,
    1.2,
)  # first cells of C over the width of a strip, and over the distance from it
SLOPE = 0.05  # force over friction times load between which and none the slope is taken


@dataclass(frozen=True)
class Study:
    """A solved scene: its features, and numbers by ICs, without friction and in rolling.

    Numbers of rolling are arrays over `CREEPAGES`, forces over friction times load. ICs without a solution
    are left out; `perturbed` are numbers with C plus its estimate.
    """

    seed: int
    number: int
    features: Numbers
    frictionless: Mapping[str, Numbers]
    rolling: Mapping[str, Mapping[str, Any]]
    seconds: Mapping[str, float]

    @property
    def entry(self) -> dict[str, Any]:
        """All of it as numbers and mappings."""
        return asdict(self)


def solve_scene(scene: RandomScene, seed: int, number: int) -> Study:
    """Solve a scene; raises Failure where C or the contact with it is not found."""
    problem = scene.problem
    sizing = Sizing(pair_on_grid(problem, problem.grid), ELEMENTS)
    grid = sizing.grid([scene.size])
    grid = sizing.large_enough(grid, problem.specification.loadings, NORMAL_ICS)

    def solve_on(on_grid: PairOnGrid) -> Study:
        return _Scene(scene, pair_in_motion(problem, on_grid)).study(seed, number)

    return sizing.on_long_enough_grid(grid, solve_on)


def operators_of_c(problem: ContactProblem, on_grid: PairOnGrid, tolerance: float) -> dict[str, FullOperator]:
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


@dataclass(frozen=True, eq=False)
class _Scene:
    """A scene on its grid."""

    scene: RandomScene
    pair: PairWithFriction

    def study(self, seed: int, number: int) -> Study:
        """Solve it with all ICs."""
        start, problem = perf_counter(), self.pair.problem
        of_c = operators_of_c(problem, self.pair.on_grid, problem.settings.tolerance)
        solved = perf_counter()
        pressed = {name: self.frictionless(of_c, name) for name in (C, PERTURBED, *NORMAL_ICS)}
        rolling = self.rolling(of_c)
        seconds = {"C": solved - start, "contact": perf_counter() - solved}
        return Study(seed, number, contact_features(problem, self.scene.size), pressed, rolling, seconds)

    @property
    def load(self) -> float:
        """The load [N]."""
        return self.pair.loads[0]

    @property
    def friction(self) -> float:
        """The coefficient of friction."""
        return self.pair.specification.coefficients[0]

    def problem(self, of_c: Mapping[str, FullOperator], name: str) -> FrictionalProblem:
        """Return the contact problem with the ICs of a name."""
        operator = of_c[name] if name in of_c else self.pair.operator(name)
        return self.pair.frictional(operator, self.friction)

    def frictionless(self, of_c: Mapping[str, FullOperator], name: str) -> Numbers:
        """Return numbers of the contact without friction with the ICs of a name."""
        contact = solve(self.problem(of_c, name).normal, load=self.load)
        of_all = numbers(self.pair.on_grid, contact)
        return {name: of_all[name] for name in NORMAL_NUMBERS}

    def rolling(self, of_c: Mapping[str, FullOperator]) -> dict[str, dict[str, Any]]:
        """Return numbers of rolling by ICs, of those with a solution; raises Failure without one of C."""
        size = self.scene.size
        step = saturation(self.pair.problem, size, self.friction, self.load)
        zero = self.curve(self.problem(of_c, SIZING), 0.0, step).zero()
        found: dict[str, dict[str, Any]] = {}
        for name in (C, PERTURBED, *ROLLING_ICS):
            curve = self.curve(self.problem(of_c, name), float(zero.creepages.longitudinal), step)
            try:
                found[name] = curve.numbers(zero)
            except Failure:
                if name == C:
                    raise
        return found

    def curve(self, problem: FrictionalProblem, zero: float, step: float) -> "_Curve":
        """Return the curve of a problem about a creepage, in steps of another."""
        return _Curve(self.pair.rolling(problem), self.load, zero, step)


@dataclass(frozen=True, eq=False)
class _Curve:
    """A creep-force curve with some ICs at a few creepages: `zero` and multiples of `step` beside it."""

    problem: RollingProblem
    load: float
    middle: float
    step: float

    @property
    def limit(self) -> float:
        """Friction times load [N]."""
        return self.problem.problem.friction * self.load

    def zero(self, start: RollingContact | None = None) -> RollingContact:
        """Return the contact without longitudinal force."""
        return self.with_force(0.0, start)

    def with_force(self, share: float, start: RollingContact | None) -> RollingContact:
        """Return the contact with a longitudinal force, a share of friction times load."""
        first = Creepages(self.middle if start is None else start.creepages.longitudinal)
        return self.problem.contact(
            first,
            Loading(self.load),
            forces={"longitudinal": share * self.limit},
            start=None if start is None else start.contact,
            tolerance=TOLERANCE,
        )

    def numbers(self, start: RollingContact) -> dict[str, Any]:
        """Return the numbers of the curve."""
        zero = self.zero(start)
        near = self.with_force(SLOPE, zero)
        rise = (near.creepages.longitudinal - zero.creepages.longitudinal) / self.step
        contacts = self.contacts(zero)
        force = np.array([contact.contact.force for contact in contacts]) / self.limit
        return {
            "zero_creepage": float((zero.creepages.longitudinal - self.middle) / self.step),
            "slope": float(SLOPE / rise),
            "F_x": force[:, 0].tolist(),
            "F_y": force[:, 1].tolist(),
            "sliding_share": [contact.contact.sliding_share for contact in contacts],
            "p_max": [float(np.max(contact.contact.pressures)) for contact in contacts],
        }

    def contacts(self, zero: RollingContact) -> list[RollingContact]:
        """Return the contacts at `CREEPAGES`, each from a neighbour nearer to no force."""
        by_share: dict[float, RollingContact] = {0.0: zero}
        for share in sorted(CREEPAGES, key=abs):
            nearest = min(by_share, key=lambda other, share=share: abs(other - share))  # type: ignore[misc]
            by_share[share] = self.problem.contact(
                replace(zero.creepages, longitudinal=self.middle + share * self.step),
                Loading(self.load),
                start=by_share[nearest].contact,
                tolerance=TOLERANCE,
            )
        return [by_share[share] for share in CREEPAGES]


# --- store of studies ---

Entry = dict[str, Any]  # of `Study`; of a scene without a contact: its seed, number and why

log = logging.getLogger(__name__)


def solve_entry(seed: int, number: int) -> Entry:
    """Return the entry of a scene."""
    try:
        return solve_scene(random_scene(seed, number), seed, number).entry
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
