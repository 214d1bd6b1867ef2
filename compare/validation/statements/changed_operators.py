"""Statements 42 and 45: contact by other operators, and with rigid motions that are added to the ICs.

42: contact by fast operators is contact by dense matrices, whose products are plain sums.

45: a load that also moves a whole body adds products of rigid motions to its ICs, and these motions are the
choice of a discount. Admissible at a given load, with the tilt fixed, are: a motion along z per vertical
force, which only the approach shows; a motion along x per longitudinal force, which steady rolling does not
notice, because it is the same everywhere. A motion along y and a turn about x change the gap, unless there is
no lateral force or moment; a turn about z or y is no function of the lag along x.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from approx.pair import Pair, matrix
from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.frame import Measure, Statement, Values, below
from compare.validation.statements.friction_contacts import rolling_pair
from compare.validation.statements.runs import Runs, solved_once
from femic.contact.friction.motion import Creepages, Shift
from femic.contact.frictional import FrictionalContact, solve
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.ics import ALL, C, c_of_bodies, reciprocal, sum_of_bodies
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.rolling import compressed
from geometries.arrays import Array
from geometries.patches import N, S, X, mirror_signs

LOAD, FRICTION = 100e3, 0.4
CREEPAGES = Creepages(-1e-3, 2e-4, 1e-5)
STEPS = (10e3, 30e3, LOAD)  # of compression [N]
OFF_CENTRE = 0.05  # mm: the upper body is moved along y by this

# --- contacts that are compared -------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class TwoContacts:
    """The same contact by two operators, and by how much [mm] the approach is expected to change."""

    before: FrictionalContact
    after: FrictionalContact
    expected: float = 0.0

    @property
    def tractions(self) -> float:
        """Largest change of a traction over the largest pressure."""
        return float(np.max(np.abs(self.after.p - self.before.p)) / np.max(self.before.p[..., N]))

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


def contact_in_motion(pair: PairWithFriction, operator: FullOperator, motion: str) -> FrictionalContact:
    """Return the contact with some ICs: "rolling", in "compression", or without friction."""
    problem = pair.frictional(operator, FRICTION)
    if motion == "rolling":
        return pair.rolling(problem).contact(CREEPAGES, Loading(LOAD)).contact
    if motion == "compression":
        *_, last = compressed(problem, [Loading(load) for load in STEPS])
        return last
    on_grid = pair.on_grid.moved_to(OFF_CENTRE) if "beside the crown" in motion else pair.on_grid
    still = Shift(np.zeros((*problem.distance.shape, 2)))
    return solve(replace(problem, friction=0.0, distance=on_grid.distance), still, Loading(LOAD))


# --- 42: dense matrices ---------------------------------------------------------------------------------

SAME = 1e-5  # ten times the tolerance of contacts
DENSE_ICS = ("A", "Bhat", C)
MOTIONS = ("pressed without friction", "rolling", "compression")


@dataclass(frozen=True, eq=False)
class DenseMatrix:
    """ICs [mm/MPa] as one matrix between all elements, (n_x, n_s, m, n_x, n_s, m): no lags, no transforms."""

    ics: Array
    directions: tuple[int, ...] = ALL

    @classmethod
    def from_lags(cls, ics: Array) -> "DenseMatrix":
        """Return the matrix of ICs (n_x, n_s, n_s, 3, 3) at lags >= 0.

        At negative ones what is odd along x changes its sign.
        """
        n_x, n_s = ics.shape[:2]
        full = np.empty((n_x, n_s, 3, n_x, n_s, 3))
        for observer, load in np.ndindex(n_x, n_x):
            between = ics[abs(observer - load)] * (1.0 if observer >= load else mirror_signs(X))
            full[observer, :, :, load] = np.moveaxis(between, 2, 1)
        return cls(full)

    def __call__(self, tractions: Array) -> Array:
        """Return displacements [mm] due to tractions [MPa], (n_x, n_s, m) each."""
        size = tractions.size
        return (self.ics.reshape(size, size) @ tractions.ravel()).reshape(tractions.shape)

    def restricted(self, directions: tuple[int, ...]) -> "DenseMatrix":
        """Return the matrix from tractions in some directions to displacements in these."""
        chosen = [self.directions.index(direction) for direction in directions]
        part = self.ics[:, :, chosen][..., chosen]
        return DenseMatrix(np.ascontiguousarray(part), directions)

    def coarsened(self) -> "DenseMatrix":
        """Return the matrix on elements twice as large: means of displacements, sums over loads."""
        n_x, n_s, m = self.ics.shape[:3]
        blocks = self.ics.reshape(n_x // 2, 2, n_s // 2, 2, m, n_x // 2, 2, n_s // 2, 2, m)
        return DenseMatrix(blocks.mean(axis=(1, 3)).sum(axis=(4, 6)), self.directions)


def prismatic(pair: Pair) -> Pair:
    """Return the pair without curvature along x, which fast operators leave out."""
    upper, lower = (replace(solid, surface=solid.surface.prismatic) for solid in (pair.upper, pair.lower))
    return replace(pair, upper=upper, lower=lower)


def dense_ics(pair: PairWithFriction, name: str) -> Array:
    """Return ICs between elements, by formulas of single patches, or those of C of both bodies added."""
    if name != C:
        return matrix(name, prismatic(pair.on_grid.pair), pair.on_grid.grid)
    bodies, _ = c_of_bodies(pair.problem, pair.on_grid, pair.options, ALL)
    each = {body: replace(ics, ics=reciprocal(ics.ics)) for body, ics in bodies.items()}
    return sum_of_bodies(pair.on_grid, each, wheel_rolls=True)


@solved_once("two operators")
def dense_and_fast(runs: Runs) -> Mapping[str, TwoContacts]:
    """Return the contacts of each ICs in each motion by dense matrices, and by fast operators."""
    contacts, pair = {}, rolling_pair(runs)
    for name in DENSE_ICS:
        dense, fast = DenseMatrix.from_lags(dense_ics(pair, name)), pair.operator(name)
        for motion in MOTIONS:
            before, after = (contact_in_motion(pair, operator, motion) for operator in (dense, fast))
            contacts[f"{ics_symbol(name)}, {motion}"] = TwoContacts(before, after)
    return contacts


def _stick_details(runs: Runs) -> Values:
    """Return by how many elements the stick zones differ."""
    apart = {case: two.after.stick != two.before.stick for case, two in dense_and_fast(runs).items()}
    label = "elements that stick with one operator only"
    return {f"{label}: {case}": float(np.count_nonzero(some)) for case, some in apart.items()}


def _across_panels(
    runs: Runs, contacts: Mapping[str, TwoContacts], labels: Mapping[str, str], directions: Mapping[int, str]
) -> Iterator[Panel]:
    """Yield tractions across the middle of the patch of both contacts, under their labels."""
    strips = rolling_pair(runs).on_grid.grid.strips
    for case, two in contacts.items():
        row = len(two.before.p) // 2
        for direction, label in directions.items():
            both = {name: getattr(two, which).p[row, :, direction] for name, which in labels.items()}
            curves = make_curves(strips, both)
            yield Panel(case, "s [mm]", f"{label} in the middle along x [MPa]", curves)


def _dense_panels(runs: Runs) -> Iterator[Panel]:
    rolling = (f"{ics_symbol(name)}, rolling" for name in ("Bhat", C))
    contacts = {case: dense_and_fast(runs)[case] for case in rolling}
    return _across_panels(
        runs, contacts, {"fast": "after", "dense": "before"}, {X: "p_x", S: "p_s", N: "p_n"}
    )


# --- 45: rigid motions ----------------------------------------------------------------------------------

UNCHANGED = 1e-4  # of tractions over p_max, and of forces over the load: contacts are solved to 1e-6
EXACTLY = 1e-5  # of the change of the approach
MOVED_ICS = ("B", C)
ALONG = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
ADMISSIBLE = (  # axis of the motion, kind of contact
    ("z", "without friction"),
    ("z", "without friction, beside the crown"),
    ("z", "rolling"),
    ("z", "compression"),
    ("x", "rolling"),
)
INADMISSIBLE = (("y", "without friction, beside the crown"), ("x", "compression"))


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


def moved_contacts(
    pair: PairWithFriction, ics: Sequence[str], kinds: Sequence[tuple[str, str]]
) -> Mapping[str, TwoContacts]:
    """Return contacts without and with a motion; under the whole load it is as long as the approach."""
    contacts = {}
    for name in ics:
        operator = pair.operator(name)
        problem = pair.frictional(operator, FRICTION)
        motions = dict.fromkeys(kind for _, kind in kinds)
        unmoved = {kind: contact_in_motion(pair, operator, kind) for kind in motions}
        for axis, kind in kinds:
            before = unmoved[kind]
            per_force = before.approach / LOAD
            moved = MovedICs(operator, problem.inclination, problem.grid.area, axis, per_force)
            expected = per_force * LOAD if axis == "z" else 0.0
            two = TwoContacts(before, contact_in_motion(pair, moved, kind), expected)
            contacts[f"{ics_symbol(name)}, {kind}, along {axis}"] = two
    return contacts


@solved_once("rigid motions")
def admissible(runs: Runs) -> Mapping[str, TwoContacts]:
    """Return the contacts that must not change."""
    return moved_contacts(rolling_pair(runs), MOVED_ICS, ADMISSIBLE)


def change(number: str, contacts: Callable[[Runs], Mapping[str, TwoContacts]] = admissible) -> Measure:
    """Measure a number of `TwoContacts` of each contact that must not change."""
    return lambda runs: {case: getattr(two, number) for case, two in contacts(runs).items()}


def _inadmissible_details(runs: Runs) -> Values:
    """Return what motions change that are not admissible: they change the gap, or the step of shift."""
    return {
        f"{case} (not admissible): {number}": getattr(two, number)
        for case, two in moved_contacts(rolling_pair(runs), ("Bhat",), INADMISSIBLE).items()
        for number in ("tractions", "forces", "approach")
    }


def _motion_panels(runs: Runs) -> Iterator[Panel]:
    contacts = {case: two for case, two in admissible(runs).items() if "rolling, along z" in case}
    return _across_panels(runs, contacts, {"before": "before", "after": "after"}, {N: "p_n", X: "p_x"})


STATEMENTS = (
    Statement(
        42,
        "The fast operators give the same contact as dense matrices.",
        (
            below(SAME, "tractions", "largest difference of a traction over the largest pressure")(
                change("tractions", dense_and_fast)
            ),
            below(SAME, "approach", "relative difference of the approach")(
                change("approach", dense_and_fast)
            ),
        ),
        _dense_panels,
        _stick_details,
        columns=3,
    ),
    Statement(
        45,
        "Rigid motions added to the ICs do not change contact at a given load.",
        (
            below(UNCHANGED, "tractions", "largest change of a traction over the largest pressure")(
                change("tractions")
            ),
            below(UNCHANGED, "forces", "largest change of a force over the load")(change("forces")),
            below(UNCHANGED, "patch", "relative change of the contact area")(change("area")),
            below(EXACTLY, "approach", "change of the approach less the motion, over the approach")(
                change("approach")
            ),
        ),
        _motion_panels,
        _inadmissible_details,
    ),
)
