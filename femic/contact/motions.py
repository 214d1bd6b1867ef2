"""The motions whose contact is solved, each registered once: frictionless contact, rolling, compression."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from femic.contact.estimates import Numbers
from femic.contact.frictional import FrictionalProblem
from femic.contact.pairs.automatic_grid import Sizing
from femic.contact.pairs.creep_force import Continuation
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_COMPRESSION, OF_FRICTIONLESS, OF_ROLLING, Quantity
from femic.contact.pairs.reachable_forces import forces_beyond_creepages
from femic.contact.pairs.solved_compression import in_steps, solve_compression
from femic.contact.pairs.solved_curve import solve_curve
from femic.contact.specification import ContactProblem

Point = tuple[float, Numbers]  # a place along the dimension of a motion, and the numbers there


def _no_misfits(_: ContactProblem, __: Sizing) -> Iterator[str]:
    return iter(())


@dataclass(frozen=True)
class ContactMotion:
    """A motion: what its contact depends on, its numbers, and how it is solved.

    `keys` are the keys of the specification that not all motions have. With friction, `solve` gives the
    solution with a coefficient of friction and the ICs of a name, and `one_point` the numbers at one place,
    for a problem with some ICs and a label. Without friction all is solved by
    `femic.contact.pairs.frictionless`. `misfits` yields why a contact has no solution with this motion.
    """

    dimension: str  # "case", "xi", "load": of its numbers
    quantities: Mapping[str, Quantity]
    keys: tuple[str, ...]
    slip_unit: str = "1"
    wheel_rolls: bool = False  # whether the rail sees the displacements of the upper body as in rolling
    solve: Callable[[PairWithFriction, float, str], Any] | None = None
    one_point: Callable[[PairWithFriction, FrictionalProblem, str], Point] | None = None
    misfits: Callable[[ContactProblem, Sizing], Iterator[str]] = _no_misfits


def _nearest_to_no_creepage(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> Point:
    """The contact at the creepage nearest 0. Raises Failure where it is not found on the grid."""
    along = Continuation.of(pair, problem, label)
    xi = min(along.xi, key=abs)
    return xi, along.measured(along.at(xi, None)).numbers


def _last_load(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> Point:
    """The contact after the last load. Raises Failure where it is not found on the grid."""
    return pair.loads[-1], in_steps(pair, problem, label)[0][-1].numbers


MOTIONS: Mapping[str, ContactMotion] = MappingProxyType(
    {
        "none": ContactMotion(
            "case", OF_FRICTIONLESS, keys=("approaches", "gap", "shape_load", "lateral_force")
        ),
        "rolling": ContactMotion(
            "xi",
            OF_ROLLING,
            keys=("friction", "longitudinal", "lateral", "spin", "equal_force"),
            wheel_rolls=True,
            solve=solve_curve,
            one_point=_nearest_to_no_creepage,
            misfits=forces_beyond_creepages,
        ),
        "compression": ContactMotion(
            "load",
            OF_COMPRESSION,
            keys=("friction",),
            slip_unit="mm",
            solve=solve_compression,
            one_point=_last_load,
        ),
    }
)
