"""A contact at a limit: its numbers with femic's estimates, against a closed form or a finer contact.

Errors and estimates are shares of the number itself. Of the work of friction, of sliding shares, and of
forces and moments that vanish by symmetry they are shares of the largest that is possible, the scale of
`femic.contact.estimates`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np

from compare.validation.extremes.cases import BeyondLimit, Limit, WithinLimit, refusal
from compare.validation.extremes.engines import Changes
from femic.contact.estimates import Measured, Numbers
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import ALL, Quantity, kinds
from femic.contact.specification import ContactProblem, ExtraGap
from femic.reference.run_options import RunOptions
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

    def finer(self, factor: int = FINER) -> Numbers:
        """Return the numbers on elements that are smaller by a factor."""
        grid = self.on_grid.grid
        return self.on(Grid(factor * grid.n_x, factor * grid.n_s, grid.dx / factor, grid.ds / factor, grid.s))


Solver = Callable[[ContactProblem, RunOptions], ContactSolution]


@dataclass(frozen=True)
class Truth:
    """What numbers of a contact are compared with: by name, those that are compared alone."""

    name: str
    of: Callable[[ContactSolution], Numbers]


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
        return problem_of(self.base, self.changes, self.gap)

    def result(self, options: RunOptions) -> WithinLimit:
        """Solve and compare the contact; raises Failure where there is no solution.

        Its seconds are those of the contact with its estimates, without `truth`.
        """
        start = perf_counter()
        solved = self.solve(self.problem, options)
        seconds = perf_counter() - start
        return compare(self.label, solved, self.truth.of(solved), self.truth.name, seconds)


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

    def result(self, options: RunOptions) -> BeyondLimit:
        """Return the message of femic."""

        def solve() -> ContactSolution:
            scene = load_scene(self.base, self.changes)
            require_solvable(scene)
            return self.solve(scene.contact_problem, options)

        return refusal(self.label, solve, self.also)()


def problem_of(base: str, changes: Changes, gap: ExtraGap | None = None) -> ContactProblem:
    """Return the contact of a built-in scene with changes; raises WrongInput."""
    problem = load_scene(base, changes).contact_problem
    return replace(problem, specification=replace(problem.specification, extra_gap=gap))


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
        note += f"; worst: {ALL[worst].symbol}, without an estimate, since larger elements have no solution"
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


def scales_of(measured: Measured, quantities: Mapping[str, Quantity]) -> dict[str, float]:
    """Return the scales of the errors of numbers, by name."""
    return {name: measured.scale(name, kind).changes for name, kind in kinds(quantities).items()}


# --- truths that contacts without and with friction share ------------------------------------------------


def finer(*names: str, factor: int = FINER) -> Truth:
    """Return as truth some numbers of the same contact on smaller elements."""

    def of(solved: ContactSolution) -> dict[str, float]:
        numbers = solved.finer(factor)
        return {name: numbers[name] for name in names}

    return Truth(f"elements 1/{factor}", of)


def same_as(name: str, other: ContactCase, options: RunOptions, factors: Numbers) -> Truth:
    """Return as truth the numbers of another case, times factors, by name."""

    def of(_: ContactSolution) -> dict[str, float]:
        numbers = other.solve(other.problem, options).numbers
        return {name: factor * numbers[name] for name, factor in factors.items()}

    return Truth(name, of)


@dataclass(frozen=True)
class ContactLimit:
    """A parameter with its range, and contacts within and beyond it."""

    name: str
    range: str
    within: Sequence[ContactCase]
    beyond: Sequence[BeyondContact] = ()

    def as_limit(self, part: str, options: RunOptions) -> Limit:
        """Return the limit of a part."""
        return Limit(
            part,
            self.name,
            self.range,
            [partial(case.result, options) for case in self.within],
            [partial(case.result, options) for case in self.beyond],
        )
