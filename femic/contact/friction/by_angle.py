"""Friction that depends on the contact angle, as on a lubricated flange: a factor of the coefficient.

The contact angle of an element is the magnitude of the inclination of the lower surface there, in the axes in
which this surface is given. The factor is linear between pairs of angle and factor, and constant beyond them.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field, Strict

from femic.key_types import Several
from geometries.arrays import Array

Angle = Annotated[float, Field(ge=0, le=90)]  # deg
Factor = Annotated[float, Field(ge=0, le=10)]
Pairs = Sequence[tuple[float, float]]  # of an angle [deg] and the factor there


def growing(pairs: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Return the pairs; raise ValueError unless their angles grow, and where there is no friction at all."""
    for (angle, _), (after, _) in pairwise(pairs):
        if not angle < after:
            raise ValueError(
                f"angle {after:g} comes after {angle:g}: angles must grow; for a step give two that hardly "
                "differ"
            )
    if pairs and not any(factor for _, factor in pairs):
        raise ValueError("all factors are 0: give a positive one, or motion = 'none' without friction")
    return pairs


FactorsByAngle = Annotated[
    Several[Annotated[tuple[Angle, Factor], Strict(False)]],
    AfterValidator(growing),
    Field(
        description="pairs [contact angle in degrees, factor from 0 to 10] of friction that depends on the "
        "angle: each coefficient times the factor at the inclination of the lower surface, whichever side; "
        "angles grow, linear between, constant beyond; default: factor 1"
    ),
]


def friction_factors(pairs: Pairs, inclination: Array) -> Array:
    """Return the factors of friction at inclinations [rad], of the same shape; 1 without pairs."""
    if not pairs:
        return np.ones_like(inclination)
    angles, factors = zip(*pairs, strict=True)
    return np.interp(np.degrees(np.abs(inclination)), angles, factors)


def in_words(pairs: Pairs) -> str:
    """Return the factors with their angles in words; empty without pairs."""
    if not pairs:
        return ""
    values = ", ".join(f"{factor:g} at {angle:g}°" for angle, factor in pairs)
    return (
        f"The coefficient is multiplied by a factor that depends on the contact angle: {values}, linear "
        "between, constant beyond."
    )


def largest_factor(pairs: Pairs) -> float:
    """Return the largest factor at any angle; 1 without pairs."""
    return max((factor for _, factor in pairs), default=1.0)
