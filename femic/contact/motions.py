"""The motions whose contact is solved, each registered once: no friction, rolling, compression.

What solves a contact is imported when it is called, since scenes are checked by this registry, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from femic.late import Late

if TYPE_CHECKING:
    from femic.contact.pairs.quantities import Quantity


@dataclass(frozen=True)
class ContactMotion:
    """A motion: the keys of its specification, and how its contact is solved.

    `keys` are the keys of the specification that not all motions have; values of `growing` ones must grow.
    The numbers of a contact, of `table`, are along `dimension`.

    With friction, `solve(pair, friction, name)` gives the solution with a coefficient of friction and the ICs
    of a name, and `one_point(pair, problem, label)` the place and the numbers of one contact with the ICs of
    a problem; `pair` is a `femic.contact.pairs.pair_with_friction.PairWithFriction`. Contact without friction
    is solved as a whole by `femic.contact.pairs.frictionless`. `misfits(problem, sizing)` yields why a
    contact has no solution with this motion, as far as it is known before.
    """

    keys: tuple[str, ...]
    dimension: str
    table: Late
    growing: tuple[str, ...] = ()
    slip_unit: str = "1"  # per unit of rolled distance; or mm
    wheel_rolls: bool = False  # at one load; the rail sees the displacements of the wheel as it rolls
    solve: Callable[..., Any] | None = None
    one_point: Callable[..., Any] | None = None
    misfits: Callable[..., Any] = lambda *_: ()

    @property
    def has_friction(self) -> bool:
        """Whether there is friction."""
        return "friction" in self.keys

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """The numbers of a contact by name."""
        quantities: Mapping[str, Quantity] = self.table.resolved
        return quantities


PAIRS = "femic.contact.pairs"
MOTIONS: dict[str, ContactMotion] = {
    "none": ContactMotion(
        keys=("approaches", "gap", "shape_load", "lateral_force"),
        dimension="case",
        table=Late(f"{PAIRS}.quantities:OF_FRICTIONLESS"),
    ),
    "rolling": ContactMotion(
        keys=("friction", "friction_by_angle", "longitudinal", "lateral", "spin", "equal_force"),
        growing=("longitudinal",),
        dimension="xi",
        table=Late(f"{PAIRS}.quantities:OF_ROLLING"),
        wheel_rolls=True,
        solve=Late(f"{PAIRS}.solved_curve:solve_curve"),
        one_point=Late(f"{PAIRS}.solved_curve:nearest_to_no_creepage"),
        misfits=Late(f"{PAIRS}.solved_curve:forces_beyond_creepages"),
    ),
    "transient": ContactMotion(
        keys=("friction", "friction_by_angle", "creepage", "lateral", "spin", "distance"),
        dimension="distance",
        table=Late(f"{PAIRS}.quantities:OF_ROLLING"),
        wheel_rolls=True,
        solve=Late(f"{PAIRS}.solved_transient:solve_transient"),
        one_point=Late(f"{PAIRS}.solved_transient:last_distance"),
    ),
    "compression": ContactMotion(
        keys=("friction", "friction_by_angle"),
        growing=("loads",),
        dimension="load",
        table=Late(f"{PAIRS}.quantities:OF_COMPRESSION"),
        slip_unit="mm",
        solve=Late(f"{PAIRS}.solved_compression:solve_compression"),
        one_point=Late(f"{PAIRS}.solved_compression:last_load"),
    ),
}
