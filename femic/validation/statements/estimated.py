"""Numbers with their estimated errors, and what becomes of these in ratios."""

from typing import Self

import numpy as np


class Estimated(float):
    """A number with its estimated error; wherever the error does not matter, it is the number."""

    estimate: float

    def __new__(cls, value: float, estimate: float) -> Self:
        """Return a number with its estimated error, which is infinite where it is not known (NaN)."""
        number = super().__new__(cls, value)
        number.estimate = np.inf if np.isnan(estimate) else abs(estimate)
        return number


def estimate_of(value: float) -> float:
    """Return the estimated error of a number, 0 if it has none."""
    return value.estimate if isinstance(value, Estimated) else 0.0


def ratio(one: float, other: float) -> float:
    """Return a ratio of distances; infinite where the other is 0 and this is not, NaN where both are.

    Its estimated error is the most that those of both can make of it; infinite where the other may be 0.
    """
    if other == 0.0:
        return np.nan if one == 0.0 else np.inf
    if not (estimate_of(one) or estimate_of(other)):
        return one / other
    least = abs(other) - estimate_of(other)
    largest = (abs(one) + estimate_of(one)) / least if least > 0 else np.inf
    return Estimated(one / other, largest - abs(one / other))
