"""Statement 45: whether contact depends on rigid motions that are added to the ICs.

A load that also moves a whole body adds products of rigid motions to its ICs, and these motions are the
choice of a discount. Admissible at a given load, with the tilt fixed, are: a motion along z per vertical
force, which only the approach shows; a motion along x per longitudinal force, which steady rolling does not
notice, because it is the same everywhere. A motion along y and a turn about x change the gap, unless there is
no lateral force or moment; a turn about z or y is no function of the lag along x.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.friction_contacts import pair_of
from compare.validation.statements.runs import Runs
from femic.contact.friction.motion import Creepages, Shift
from femic.contact.frictional import FrictionalContact, solve
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.ics import C
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.rolling import compressed
from geometries.arrays import Array
from geometries.patches import N, S, X

UNCHANGED = 1e-4  # of tractions over p_max, and of forces over the load: contacts are solved to 1e-6
EXACTLY = 1e-5  # of the change of the approach
ICS = ("B", C)
LOAD, FRICTION = 100e3, 0.4
STEPS = (10e3, 30e3, LOAD)  # of compression [N]
CREEPAGES = Creepages(-1e-3, 2e-4, 1e-5)
OFF_CENTRE = 0.05  # mm: the upper body is moved along y by this
ALONG = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class MovedICs:
    """ICs, and a body that a force along some axis also moves along it as a whole, by `per_force` [mm/N]."""

    operator: FullOperator
    inclination: Array  # (n_s,)
    area: float  # of an element [mm^2]
    axis: str
    per_force: float
    directions: tuple[int, ...] = (X, S, N)

    @property
    def motion(self) -> Array:
        """The unit motion in the directions of the strips, (n_s, m)."""
        x, y, z = ALONG[self.axis]
        sin, cos = np.sin(self.inclination), np.cos(self.inclination)
        local = np.stack([x + 0 * sin, y * cos - z * sin, y * sin + z * cos], axis=-1)
        return np.asarray(local[:, self.directions])

    def __call__(self, tractions: Array) -> Array:
        """Return displacements [mm] due to tractions [MPa]."""
        force = float(np.sum(tractions * self.motion)) * self.area
        return np.asarray(self.operator(tractions) + self.per_force * force * self.motion)

    def restricted(self, directions: tuple[int, ...]) -> Self:
        """Return the operator in some directions."""
        return replace(self, operator=self.operator.restricted(directions), directions=directions)

    def coarsened(self) -> Self:
        """Return the operator on elements twice as large."""
        inclination = self.inclination.reshape(-1, 2).mean(axis=1)
        return replace(self, operator=self.operator.coarsened(), inclination=inclination, area=4 * self.area)


@dataclass(frozen=True, eq=False)
class BeforeAndAfter:
    """A contact without and with a motion along an axis, by `moved` [mm] per unit of the load's size."""

    before: FrictionalContact
    after: FrictionalContact
    expected: float  # change of the approach [mm]

    @property
    def tractions(self) -> float:
        """Largest change of a traction over the largest pressure."""
        return float(np.max(np.abs(self.after.p - self.before.p)) / np.max(self.before.pressures))

    @property
    def forces(self) -> float:
        """Largest change of a force over the load."""
        return float(np.max(np.abs(self.after.force - self.before.force)) / LOAD)

    @property
    def area(self) -> float:
        """Relative change of the contact area."""
        return abs(self.after.area / self.before.area - 1)

    @property
    def approach(self) -> float:
        """Change of the approach less the expected one, over the approach before."""
        change = self.after.approach - self.before.approach
        return float(abs(change - self.expected) / self.before.approach)


Solve = Callable[[FrictionalProblem], FrictionalContact]


def contact_solvers(pair: PairWithFriction) -> Mapping[str, Solve]:
    """Return how contacts are solved, by motion."""

    def pressed(problem: FrictionalProblem) -> FrictionalContact:
        still = Shift(np.zeros((*problem.distance.shape, 2)))
        return solve(replace(problem, friction=0.0), still, Loading(LOAD))

    def beside(problem: FrictionalProblem) -> FrictionalContact:
        moved = pair.on_grid.moved_to(OFF_CENTRE)
        return pressed(replace(problem, distance=moved.distance))

    def rolls(problem: FrictionalProblem) -> FrictionalContact:
        return pair.rolling(problem).contact(CREEPAGES, Loading(LOAD)).contact

    def compresses(problem: FrictionalProblem) -> FrictionalContact:
        *_, last = compressed(problem, [Loading(load) for load in STEPS])
        return last

    return {
        "without friction": pressed,
        "without friction, beside the crown": beside,
        "rolling": rolls,
        "compression": compresses,
    }


ADMISSIBLE = (  # axis of the motion, kind of contact
    ("z", "without friction"),
    ("z", "without friction, beside the crown"),
    ("z", "rolling"),
    ("z", "compression"),
    ("x", "rolling"),
)
INADMISSIBLE = (("y", "without friction, beside the crown"), ("x", "compression"))


def _contacts(
    pair: PairWithFriction, ics: tuple[str, ...], kinds: tuple[tuple[str, str], ...]
) -> Iterator[tuple[str, BeforeAndAfter]]:
    """Yield contacts before and after; the motion under the whole load is as long as the approach."""
    solvers = contact_solvers(pair)
    for name in ics:
        problem = pair.frictional(pair.operator(name), FRICTION)
        unmoved = {kind: solvers[kind](problem) for kind in dict.fromkeys(kind for _, kind in kinds)}
        for axis, kind in kinds:
            before = unmoved[kind]
            per_force = before.approach / LOAD
            moved = MovedICs(problem.operator, problem.inclination, problem.grid.area, axis, per_force)
            after = solvers[kind](replace(problem, operator=moved))
            expected = per_force * LOAD if axis == "z" else 0.0
            yield f"{symbol_of(name)}, {kind}, along {axis}", BeforeAndAfter(before, after, expected)


def admissible(runs: Runs) -> Mapping[str, BeforeAndAfter]:
    """Return the contacts that must not change."""
    return dict(_contacts(pair_of(runs), ICS, ADMISSIBLE))


def inadmissible(runs: Runs) -> Mapping[str, BeforeAndAfter]:
    """Return contacts that may change: those whose gap, or step of shift, the motion changes."""
    return dict(_contacts(pair_of(runs), ("Bhat",), INADMISSIBLE))


def of_each(name: str) -> Numbers:
    """Measure a number of `BeforeAndAfter` of each contact."""
    return Numbers(
        lambda runs: {
            case: getattr(contacts, name)
            for case, contacts in runs.remembered("rigid motions", admissible).items()
        }
    )


def _details(runs: Runs) -> Mapping[str, float]:
    """Return what motions change that are not admissible."""
    contacts: Mapping[str, BeforeAndAfter] = runs.remembered("rigid motions that matter", inadmissible)
    return {
        f"{case} (not admissible): {name}": getattr(of, name)
        for case, of in contacts.items()
        for name in ("tractions", "forces", "approach")
    }


def _panels(runs: Runs) -> list[Panel]:
    """Return tractions before and after in rolling."""
    contacts: Mapping[str, BeforeAndAfter] = runs.remembered("rigid motions", admissible)
    strips = pair_of(runs).on_grid.grid.strips
    panels = []
    for case, of in contacts.items():
        if "rolling, along z" in case:
            row = len(of.before.p) // 2
            for direction, label in ((N, "p_n"), (X, "p_x")):
                curves = {"before": of.before.p[row, :, direction], "after": of.after.p[row, :, direction]}
                panels.append(
                    Panel(case, "s [mm]", f"{label} in the middle along x [MPa]", curves_of(strips, curves))
                )
    return panels


STATEMENTS = (
    Statement(
        45,
        "Contact at a given load does not depend on rigid motions that are added to the ICs.",
        (
            of_each("tractions").below(
                UNCHANGED, "tractions", "largest change of a traction over the largest pressure"
            ),
            of_each("forces").below(UNCHANGED, "forces", "largest change of a force over the load"),
            of_each("area").below(UNCHANGED, "patch", "relative change of the contact area"),
            of_each("approach").below(
                EXACTLY, "approach", "change of the approach less the motion, over the approach"
            ),
        ),
        _panels,
        _details,
    ),
)
