"""What a table of creep forces is over, and how accurate it has to be."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, Field

from approx.variants import VARIANTS
from femic.key_types import Amount, EachDistinct, Place, Several, Whole

MOST_SPIN, LEAST_TOLERANCE = 10.0, 0.005


def _growing(values: tuple[float, ...]) -> tuple[float, ...]:
    """Return the values; raise ValueError with the first that is below the one before it."""
    for value, after in pairwise(values):
        if after < value:
            raise ValueError(f"{after:g} comes after {value:g}: values must increase; sort them")
    return values


@dataclass(frozen=True)
class TableSpecification:
    """Positions, loads, friction and spin of a table of creep forces, and its tolerance.

    Each key is declared here alone; the table [table] of a scene file is made from these declarations.
    """

    shifts: Annotated[
        Several[Place],
        Field(
            description="lateral shifts of the upper body along y [mm], in increasing order, with more "
            "between them where needed; default: contact.shift alone"
        ),
        EachDistinct,
        AfterValidator(_growing),
    ] = ()
    loads: Annotated[
        Several[Amount],
        Field(
            description="vertical loads [N], in increasing order, with more between them where needed; "
            "default: contact.loads"
        ),
        EachDistinct,
        AfterValidator(_growing),
    ] = ()
    friction: Annotated[
        Several[Annotated[float, Field(gt=0, le=2)]],
        Field(
            min_length=1,
            description="coefficients of friction, in increasing order, with more between them where needed",
        ),
        EachDistinct,
        AfterValidator(_growing),
    ] = (0.3,)
    spin: Annotated[
        float,
        Field(
            ge=0,
            le=MOST_SPIN,
            description="largest spin of the wheel about z, over that which makes a contact slide; 0: none. "
            "Spin by the contact angle is in the contacts themselves",
        ),
    ] = 1.0
    ics: Annotated[
        str, Field(description=f"ICs of the contacts: {', '.join(VARIANTS)}, or C (minutes per position)")
    ] = "Bhat"
    elements: Annotated[Whole, Field(ge=8, le=32, description="elements across the smallest patch")] = 12
    tolerance: Annotated[
        float,
        Field(
            ge=LEAST_TOLERANCE,
            le=0.5,
            description="error of forces that 95 % of other contacts have at most, solved on elements of "
            "half the size, as a share of friction times normal force; of p_max as a share of it",
        ),
    ] = 0.03
