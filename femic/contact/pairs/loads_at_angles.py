"""The load under which the patch of a contact turns by an angle, however the contact is solved."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from geometries.errors import Failure


def load_at_angle(
    angle_of: Callable[[float], float],
    degrees: float,
    loads: tuple[float, float],
    accuracy: float,
    patch: str = "the patch",
) -> float:
    """Return the load [N] between two under which a patch turns by an angle [deg].

    `angle_of` returns the angle [deg] under a load [N]. It is called at both ends first; it should not jump,
    as it does from one grid to another: a root may be such a jump. `accuracy` is that of the load, relative,
    and `patch` says in messages which one it is. Raises Failure where the angle is not between those at the
    ends.
    """
    ends = [float(np.log(load)) for load in loads]
    angles = [angle_of(load) for load in loads]
    if not min(angles) <= degrees <= max(angles):
        turns = " and ".join(
            f"by {angle:.3g} under {load:.3g} N" for angle, load in zip(angles, loads, strict=True)
        )
        raise Failure(
            f"no load at which {patch} turns by {degrees:g} degrees: it turns {turns}; "
            "give an angle between these"
        )
    known = dict(zip(ends, angles, strict=True))

    def excess(logarithm: float) -> float:
        turned = known.get(logarithm)
        return (angle_of(float(np.exp(logarithm))) if turned is None else turned) - degrees

    return float(np.exp(brentq(excess, *ends, xtol=accuracy)))
