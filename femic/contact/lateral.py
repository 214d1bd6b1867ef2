"""The lateral position of the upper body that a lateral force asks for.

A body that is moved aside is pushed back: the lateral force falls as the position grows. The position is
bracketed by steps that grow, and found by Brent's method.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from scipy.optimize import brentq

from geometries.errors import Failure

GROWTH = 2.0  # of the steps with which a position is bracketed
MOST_STEPS = 24  # largest number of them

Contact = TypeVar("Contact")


@dataclass(frozen=True, eq=False)
class AtPosition(Generic[Contact]):
    """A contact at the lateral position [mm] that a force asks for.

    `stiffness` [N/mm] is that against lateral movements, by the two positions nearest to it.
    """

    contact: Contact
    position: float
    stiffness: float


def at_lateral_force(
    contact_at: Callable[[float], tuple[float, Contact]],
    force: float,
    *,
    start: float,
    step: float,
    accuracy: float,
) -> AtPosition[Contact]:
    """The contact with a lateral force [N] on the upper body, to an accuracy [mm] of its position.

    `contact_at` gives the lateral force [N] and the contact at a position [mm]. It is sought from `start` on,
    with a first step [mm]. Raises Failure where no position is found that has the force, and as `contact_at`.
    """
    found: dict[float, tuple[float, Contact]] = {}

    def beyond(position: float) -> float:
        has, contact = contact_at(position)
        found[position] = has - force, contact
        return has - force

    low, high = _bracket(beyond, start, step)
    position = low if low == high else float(brentq(beyond, low, high, xtol=accuracy))
    defect, contact = found[position]
    others = [(abs(other - position), other) for other in found if other != position]
    nearest = min(others)[1] if others else position + step
    other_defect = found[nearest][0] if nearest in found else beyond(nearest)
    return AtPosition(contact, position, abs((other_defect - defect) / (nearest - position)))


def _bracket(beyond: Callable[[float], float], start: float, step: float) -> tuple[float, float]:
    """Two positions between which the force is reached; the same one twice where it is met exactly."""
    before, defect = start, beyond(start)
    if defect == 0:
        return start, start
    way = step if defect > 0 else -step
    for _ in range(MOST_STEPS):
        after = before + way
        if beyond(after) * defect <= 0:
            return (before, after) if before < after else (after, before)
        before, way = after, GROWTH * way
    raise Failure(
        f"lateral force: not reached with the upper body between {min(start, before):g} and "
        f"{max(start, before):g} mm; give a `shift` nearer to its position, or a smaller `lateral_force`"
    )
