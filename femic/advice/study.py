"""A random scene solved with approximations and with C on the same grid, without friction and rolling.

Errors of the elements are nearly the same with all ICs, and differences show those of the ICs.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from femic.advice.features import features_of, saturation
from femic.advice.scenes import CREEPAGES, ELEMENTS, RandomScene
from femic.contact.estimates import Numbers
from femic.contact.friction.kinematics import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import solve
from femic.contact.operators.dense import GridOperator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.body_ics import ALL, estimate_of
from femic.contact.pairs.c_jobs import c_jobs
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import numbers
from femic.contact.pairs.reference_ics import pair_operator
from femic.contact.pairs.sizing import Sizing
from femic.contact.rolling import RollingContact, RollingProblem
from femic.contact.specification import ContactProblem
from femic.reference.matrix.reference import matrices
from femic.reference.meshing.cell_size import Cells
from femic.reference.run_options import RunOptions
from geometries.errors import Failure

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


def studied(scene: RandomScene, seed: int, number: int) -> Study:
    """Solve a scene; raises Failure where C or the contact with it is not found."""
    problem = scene.problem
    sizing = Sizing(pair_on_grid(problem, problem.grid), ELEMENTS)
    grid = sizing.grid([scene.size])
    grid = sizing.large_enough(grid, problem.specification.loadings, NORMAL_ICS)

    def solve_on(on_grid: PairOnGrid) -> Study:
        return _Scene(scene, PairWithFriction(problem, on_grid)).study(seed, number)

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
    added = GridOperator.of(estimate_of(references, on_grid.grid, ALL))
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
        return Study(seed, number, features_of(problem, self.scene.size), pressed, rolling, seconds)

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
