"""Statement 42: whether contact by fast operators is that by dense matrices whose products are plain sums."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, matrix
from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.friction_contacts import grid_of, pair_of, rolling
from compare.validation.statements.runs import Runs
from femic.contact.friction.motion import Creepages, Shift
from femic.contact.frictional import FrictionalContact, solve
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.ics import ALL, C, c_of_bodies, reciprocal, sum_of_bodies
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.rolling import compressed
from geometries.arrays import Array
from geometries.patches import N, S, X, mirror_signs

SAME = 1e-5  # ten times the tolerance of contacts
ICS = ("A", "Bhat", C)
LOAD, FRICTION = 100e3, 0.4
MOTIONS = ("pressed without friction", "rolling", "compression")
CREEPAGES = Creepages(-1e-3, 2e-4, 1e-5)
STEPS = (10e3, 30e3, LOAD)  # of compression [N]
ICMatrix = Array  # (n_x, n_s, n_s, 3, 3) at lags >= 0


@dataclass(frozen=True, eq=False)
class DenseMatrix:
    """ICs [mm/MPa] as one matrix between all elements, (n_x, n_s, m, n_x, n_s, m): no lags, no transforms."""

    ics: Array
    directions: tuple[int, ...] = ALL

    @classmethod
    def from_lags(cls, ics: ICMatrix) -> "DenseMatrix":
        """Return the matrix of ICs at lags >= 0; at negative ones what is odd along x changes its sign."""
        n_x, n_s = ics.shape[:2]
        full = np.empty((n_x, n_s, 3, n_x, n_s, 3))
        for observer in range(n_x):
            for load in range(n_x):
                lag = observer - load
                between = ics[abs(lag)] * (1.0 if lag >= 0 else mirror_signs(X))
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


@dataclass(frozen=True, eq=False)
class TwoContacts:
    """The same contact by a fast operator and by a dense matrix."""

    fast: FrictionalContact
    dense: FrictionalContact

    @property
    def traction_difference(self) -> float:
        """Largest difference of a traction over the largest pressure."""
        return float(np.max(np.abs(self.fast.p - self.dense.p)) / np.max(self.dense.p[..., N]))

    @property
    def approach_difference(self) -> float:
        """Relative difference of the approaches."""
        return abs(self.fast.approach / self.dense.approach - 1)


def dense_ics(pair: PairWithFriction, name: str) -> ICMatrix:
    """Return ICs between elements, by formulas of single patches, or those of C of both bodies added."""
    if name != C:
        return matrix(name, prismatic(pair.on_grid.pair), pair.on_grid.grid)
    bodies, _ = c_of_bodies(pair.problem, pair.on_grid, pair.options, ALL)
    each = {body: replace(ics, ics=reciprocal(ics.ics)) for body, ics in bodies.items()}
    return sum_of_bodies(pair.on_grid, each, wheel_rolls=True)


def prismatic(pair: Pair) -> Pair:
    """Return the pair without curvature along x, which fast operators leave out."""
    upper, lower = (replace(solid, surface=solid.surface.prismatic) for solid in (pair.upper, pair.lower))
    return replace(pair, upper=upper, lower=lower)


def in_motion(pair: PairWithFriction, operator: FullOperator, motion: str) -> FrictionalContact:
    """Return the contact with some ICs in one of `MOTIONS`."""
    problem = pair.frictional(operator, FRICTION)
    if motion == "rolling":
        return pair.rolling(problem).contact(CREEPAGES, Loading(LOAD)).contact
    if motion == "compression":
        *_, last = compressed(problem, [Loading(load) for load in STEPS])
        return last
    still = Shift(np.zeros((*problem.distance.shape, 2)))
    return solve(replace(problem, friction=0.0), still, Loading(LOAD))


def two_contacts(runs: Runs) -> Mapping[tuple[str, str], TwoContacts]:
    """Return the contacts of each ICs in each motion by both operators."""
    return dict(_two_contacts(pair_of(runs)))


def _two_contacts(pair: PairWithFriction) -> Iterator[tuple[tuple[str, str], TwoContacts]]:
    for name in ICS:
        dense, fast = DenseMatrix.from_lags(dense_ics(pair, name)), pair.operator(name)
        for motion in MOTIONS:
            contacts = (in_motion(pair, operator, motion) for operator in (fast, dense))
            yield (name, motion), TwoContacts(*contacts)


def of_each(number: Callable[[TwoContacts], float]) -> Numbers:
    """Measure a number of both contacts of each ICs and motion."""
    return Numbers(
        lambda runs: {
            f"{symbol_of(name)}, {motion}": number(contacts)
            for (name, motion), contacts in runs.remembered("two operators", two_contacts).items()
        }
    )


def _panels(runs: Runs) -> list[Panel]:
    """Return tractions across the middle of the patch by both operators."""
    strips = grid_of(rolling(runs)).strips
    contacts = runs.remembered("two operators", two_contacts)
    return [
        Panel(
            f"{symbol_of(name)}, rolling",
            "s [mm]",
            f"{label} in the middle along x [MPa]",
            curves_of(strips, {"fast": _row(of.fast, direction), "dense": _row(of.dense, direction)}),
        )
        for name in ("Bhat", C)
        for of in (contacts[name, "rolling"],)
        for direction, label in ((X, "p_x"), (S, "p_s"), (N, "p_n"))
    ]


def _row(contact: FrictionalContact, direction: int) -> Array:
    return np.asarray(contact.p[len(contact.p) // 2, :, direction])


def _details(runs: Runs) -> Mapping[str, float]:
    """Return by how many elements the stick zones differ."""
    contacts: Mapping[tuple[str, str], TwoContacts] = runs.remembered("two operators", two_contacts)
    return {
        f"elements that stick with one operator only: {symbol_of(name)}, {motion}": float(
            np.count_nonzero(of.fast.stick != of.dense.stick)
        )
        for (name, motion), of in contacts.items()
    }


STATEMENTS = (
    Statement(
        42,
        "Contact by fast operators is contact by dense matrices.",
        (
            of_each(lambda contacts: contacts.traction_difference).below(
                SAME, "tractions", "largest difference of a traction over the largest pressure"
            ),
            of_each(lambda contacts: contacts.approach_difference).below(
                SAME, "approach", "relative difference of the approach"
            ),
        ),
        _panels,
        _details,
        columns=3,
    ),
)
