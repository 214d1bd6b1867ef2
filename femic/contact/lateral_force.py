"""The lateral position of the upper body at which it is in equilibrium with a lateral force.

A body that is moved aside is pushed back: the lateral force falls as the position grows. The position is
bracketed by growing steps and solved for with Brent's method.
"""

from collections.abc import Callable
from typing import TypeVar

from scipy.optimize import brentq

from geometries.errors import Failure

GROWTH = 2.0  # of the steps with which a position is bracketed
MOST_STEPS = 24  # largest number of them

Contact = TypeVar("Contact")


def contact_at_lateral_force(
    contact_at: Callable[[float], tuple[float, Contact]],
    force: float,
    *,
    start: float,
    step: float,
    accuracy: float,
) -> tuple[Contact, float, float]:
    """Return the contact with a lateral force [N] on the upper body, its position [mm] and its stiffness.

    The stiffness [N/mm] is that against lateral movements, from the two nearest positions; `accuracy` [mm] is
    that of the position.
    `contact_at` gives the lateral force [N] and the contact at a position [mm]. The search begins at `start`
    with a step [mm]. Raises Failure where no position has the force, and as `contact_at`.
    """
    evaluated: dict[float, tuple[float, Contact]] = {}

    def beyond(position: float) -> float:
        has, contact = contact_at(position)
        evaluated[position] = has - force, contact
        return has - force

    low, high = _bracket(beyond, start, step)
    position = low if low == high else float(brentq(beyond, low, high, xtol=accuracy))
    defect, contact = evaluated[position]
    others = [(abs(other - position), other) for other in evaluated if other != position]
    nearest = min(others)[1] if others else position + step
    other_defect = evaluated[nearest][0] if nearest in evaluated else beyond(nearest)
    return contact, position, abs((other_defect - defect) / (nearest - position))


def _bracket(beyond: Callable[[float], float], start: float, step: float) -> tuple[float, float]:
    """Return two positions between which the force is reached; the same one twice where it is met exactly."""
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
