"""A contact at a limit: its bodies, and its numbers against a closed form or a finer contact.

Errors and estimates are shares of the number itself. Of the work of friction, of sliding shares, and of
forces and moments that vanish by symmetry they are shares of the largest that is possible, the scale of
`femic.contact.estimates`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from compare.validation.extremes.cases import BeyondLimit, Limit, WithinLimit, refusal
from compare.validation.extremes.engines import NO_CHANGES, Changes
from femic.contact.estimates import Measured, Numbers
from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import ALL, Quantity, kinds
from femic.contact.specification import ContactProblem, ExtraGap, Profile
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import require_solvable
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid

FINER = 4  # by which elements of a reference contact are smaller
FORCES = ("F_x", "F_y")
OF_LARGEST = ("sliding_share", "dissipation")  # they may be nearly 0 without symmetry
VANISHES = 1e-9  # of the largest possible: smaller forces vanish by symmetry
NOTED = ("p_max", "a", "b", "approach", "F_x", "F_y")  # numbers shown with a case


@dataclass(frozen=True)
class ContactSolution:
    """A contact on its grid: its numbers, their estimates and the scales of errors, by name.

    `on` solves the same contact with the same ICs on another grid.
    """

    problem: ContactProblem
    on_grid: PairOnGrid
    numbers: Numbers
    estimates: Numbers
    scales: Numbers
    on: Callable[[Grid], Numbers]
    options: RunOptions = DEFAULT

    def finer(self, factor: int = FINER) -> Numbers:
        """Return the numbers on elements that are smaller by a factor."""
        grid = self.on_grid.grid
        return self.on(Grid(factor * grid.n_x, factor * grid.n_s, grid.dx / factor, grid.ds / factor, grid.s))


Solver = Callable[[ContactProblem, RunOptions], ContactSolution]


@dataclass(frozen=True)
class Truth:
    """What numbers of a contact are compared with: by name, those that are compared alone."""

    name: str
    numbers: Callable[[ContactSolution], Numbers]


@dataclass(frozen=True)
class ContactCase:
    """A built-in scene with changes, under a label, solved by `solve` and compared with `truth`.

    `gap` is added to the distance of the bodies.
    """

    label: str
    base: str
    changes: Changes
    solve: Solver
    truth: Truth
    gap: ExtraGap | None = None

    @property
    def problem(self) -> ContactProblem:
        """The contact; raises WrongInput for what scenes do not take."""
        problem = load_scene(self.base, self.changes).contact_problem
        return replace(problem, specification=replace(problem.specification, extra_gap=self.gap))

    def __call__(self, options: RunOptions) -> WithinLimit:
        """Solve and compare the contact; raises Failure where there is no solution.

        Its seconds are those of the contact with its estimates, without `truth`.
        """
        start = perf_counter()
        solved = self.solve(self.problem, options)
        seconds = perf_counter() - start
        return compare(self.label, solved, self.truth.numbers(solved), self.truth.name, seconds)


@dataclass(frozen=True)
class BeyondContact:
    """A scene beyond the limits, under a label: refused when it is read, or when it is solved.

    When it is solved, the failures `also` count as refusals.
    """

    label: str
    base: str
    changes: Changes
    solve: Solver
    also: tuple[type[Failure], ...] = ()

    def __call__(self, options: RunOptions) -> BeyondLimit:
        """Return the message of femic."""

        def solve(options: RunOptions) -> ContactSolution:
            scene = load_scene(self.base, self.changes)
            require_solvable(scene)
            return self.solve(scene.contact_problem, options)

        return refusal(self.label, solve, self.also)(options)


Cases = Sequence[ContactCase | BeyondContact]


def contact_limits(part: str, table: Mapping[tuple[str, str], Cases]) -> list[Limit]:
    """Return the limits of contact without or with friction, of cases by name and range of a parameter."""
    return [
        Limit(
            part,
            name,
            allowed,
            [case for case in cases if isinstance(case, ContactCase)],
            [case for case in cases if isinstance(case, BeyondContact)],
        )
        for (name, allowed), cases in table.items()
    ]


def compare(label: str, solved: ContactSolution, truth: Numbers, against: str, seconds: float) -> WithinLimit:
    """Return a case with the errors of the numbers that a truth has; its note names the worst.

    It has no estimate where elements twice as large have no solution.
    """
    errors = {name: abs(solved.numbers[name] - value) for name, value in truth.items()}
    scales = {name: _scale(name, truth, solved.scales[name]) for name in truth}
    shares = {name: _over(error, scales[name]) for name, error in errors.items()}
    note = ", ".join(
        f"{ALL[name].symbol} {solved.numbers[name]:.4g}" for name in NOTED if name in solved.numbers
    )
    estimates = {name: solved.estimates[name] for name in truth}
    if not np.all(np.isfinite(list(estimates.values()))):
        worst = max(shares, key=shares.__getitem__)
        note += (
            f"; worst: {ALL[worst].symbol}, without an estimated error, because larger elements give "
            "no solution"
        )
        return WithinLimit(label, shares[worst], None, None, against, seconds, note)
    used = {name: _over(errors[name], estimate) for name, estimate in estimates.items()}
    worst = max(used, key=used.__getitem__)
    largest = max(_over(estimate, scales[name]) for name, estimate in estimates.items())
    note += f"; worst: {ALL[worst].symbol}"
    return WithinLimit(label, max(shares.values()), largest, used[worst], against, seconds, note)


def _scale(name: str, truth: Numbers, largest: float) -> float:
    """Return what an error is a share of; of a force, the force whatever its direction."""
    if name in OF_LARGEST:
        return largest
    together = FORCES if name in FORCES else (name,)
    size = float(np.hypot.reduce([truth.get(other, 0.0) for other in together]))
    return size if size > VANISHES * largest else largest


def _over(amount: float, scale: float) -> float:
    """Return an amount over a scale; 0 for none."""
    return float(amount / max(scale, np.finfo(float).tiny)) if amount else 0.0


def error_scales(measured: Measured, quantities: Mapping[str, Quantity]) -> dict[str, float]:
    """Return the scales of the errors of numbers, by name."""
    return {name: measured.scale(name, kind).changes for name, kind in kinds(quantities).items()}


# --- truths that contacts without and with friction share ------------------------------------------------


def finer(*names: str, factor: int = FINER) -> Truth:
    """Return as truth some numbers of the same contact on smaller elements."""

    def numbers(solved: ContactSolution) -> dict[str, float]:
        found = solved.finer(factor)
        return {name: found[name] for name in names}

    return Truth(f"elements 1/{factor}", numbers)


def same_as(name: str, other: ContactCase, factors: Numbers) -> Truth:
    """Return as truth the numbers of another case, times factors, by name."""

    def numbers(solved: ContactSolution) -> dict[str, float]:
        found = other.solve(other.problem, solved.options).numbers
        return {name: factor * found[name] for name, factor in factors.items()}

    return Truth(name, numbers)


# --- bodies: rollers on crowns, for which half-spaces and Hertz hold; a groove on a rail; two bumps ---------


CROWN, ROLLER = 300.0, 500.0  # mm
TIGHT = 10.0  # radius of the arc of a rail that a groove embraces [mm]
FLANK = 60.0  # degrees
BUMP_RADIUS, APART = 50.0, 6.0  # of two bumps, and their distance [mm]
BUMP_GRID = {"n_x": 48, "n_s": 208, "dx": 0.04, "ds": 0.04}
BUMP_POINTS = 4001  # of a gap that is linear between them
STEP = 1e-4  # mm, to both sides of a crown, for its curvature


def crossed(
    load: float, *, crown: float = CROWN, roller: float = ROLLER, bodies: Changes = NO_CHANGES, **contact: Any
) -> Changes:
    """Return changes of `flat`: a roller on a rail with a crown, so flat that Hertz and A hold.

    `bodies` has further keys of both.
    """
    return {
        "lower": {"contour": _arc(crown, 20.0), **bodies.get("lower", {})},
        "upper": {"rolling_radius": roller, **bodies.get("upper", {})},
        "contact": {"loads": [load], "ics": ["A"], **contact},
    }


def conformal(
    load: float,
    ratio: float,
    *,
    flanks: float | list[float] = FLANK,
    roller: float = ROLLER,
    bodies: Changes = NO_CHANGES,
    **contact: Any,
) -> Changes:
    """Return changes of `geometry1`: a wheel whose groove is by a ratio wider than the rail it embraces.

    `bodies` has further keys of both.
    """
    return {
        "lower": {"contour": _arc(TIGHT, flanks), **bodies.get("lower", {})},
        "upper": {
            "contour": _arc(TIGHT * (1 + ratio), flanks),
            "rolling_radius": roller,
            **bodies.get("upper", {}),
        },
        "contact": {"loads": [load], "ics": ["Bhat"], **contact},
        "engine": {"kind": "harmonic", "check": False, "tolerance": 0.1},
    }


def _arc(radius: float, flanks: float | list[float]) -> Changes:
    return {"kind": "arc", "radius": radius, "flank_inclination_deg": flanks}


def bumps(*, load: float = 200.0, automatic: bool = False, **contact: Any) -> Changes:
    """Return changes of `flat`: a roller above two bumps (`two_bumps`), on a grid that has both."""
    own: Changes = {} if automatic else {"grid": BUMP_GRID, "rotation_reach": 5.0}
    kind = "automatic" if automatic else "scene"
    return {
        **own,
        "upper": {"rolling_radius": BUMP_RADIUS},
        "contact": {"loads": [load], "ics": ["A"], "grid": kind, **contact},
    }


def two_bumps() -> Profile:
    """Return the gap between a plane and two bumps along x, by whose radius it is curved."""
    s = np.linspace(-4 * APART, 4 * APART, BUMP_POINTS)
    return Profile(s, (np.abs(s) - APART / 2) ** 2 / (2 * BUMP_RADIUS))


def base_scene(changes: Changes) -> str:
    """Return the name of the built-in scene that changes of rollers or of conformal bodies are of."""
    return "geometry1" if "engine" in changes else "flat"


# --- Hertz ----------------------------------------------------------------------------------------------


def hertz_contact(problem: ContactProblem) -> LoadedPoint:
    """Return the contact of Hertz of the bodies at their crowns, under the last load."""
    lower, upper = (problem.bodies[name] for name in ("lower", "upper"))
    crown = np.array([-STEP, STEP])
    low, high = (float(np.ptp(body.contour.inclination(crown))) / (2 * STEP) for body in (lower, upper))
    modulus = combined_modulus(upper.material, lower.material)
    return PointContact(1 / upper.rolling_radius, low - high, modulus).at_load(
        problem.specification.loads[-1]
    )


def hertz_bump(problem: ContactProblem) -> LoadedPoint:
    """Return the contact of Hertz of one of two bumps, under half of the load."""
    modulus = combined_modulus(*(problem.bodies[name].material for name in ("upper", "lower")))
    curvature = 1 / BUMP_RADIUS
    return PointContact(curvature, curvature, modulus).at_load(problem.specification.loads[-1] / 2)
