"""The last decimals of coordinates, from the text of a file: their rounding errors become curvature."""

from collections.abc import Sequence

import numpy as np
import scipy

from geometries.arrays import Array

AROUND = 21  # coordinates among which the last decimal is sought
SHARE = 0.4  # of them that may have a finer one: nine of ten numbers do not end in 0
SAME_STEP = 1e-6  # of a step: rounding of the differences of decimal numbers


def steps_as_written(tokens: Sequence[str], values: Array) -> Array:
    """Steps of the last decimals of a column, in its unit, for each of its numbers, (n,).

    A number's own last decimal is that of its last digit; zeros at the end of its decimals are no digits,
    since many programs fill up with them. A few finer numbers among coarse ones change nothing, nor do zeros
    that a single number happens to end in; formats with a fixed number of digits are followed. Numbers that
    repeat their predecessor say nothing. A column that goes on by equal steps was not rounded but chosen: its
    step is 0.
    """
    places = np.array([last_place(token) for token in tokens], dtype=float)
    new = np.append(True, np.diff(values) != 0)
    around = scipy.ndimage.percentile_filter(places[new], 100 * SHARE, size=AROUND, mode="mirror")
    steps = 10.0 ** around[np.cumsum(new) - 1]
    return np.where(_regular(values), 0.0, steps)


def last_place(token: str) -> int:
    """Power of ten of the last digit of a number, zeros at the end of its decimals left out."""
    mantissa, _, exponent = token.lower().replace("d", "e").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2].rstrip("0"))


def _regular(values: Array) -> Array:
    """Whether all steps around each number of a column are equal and not 0, (n,)."""
    steps = np.diff(values)
    low, high = (
        each(steps, AROUND, mode="nearest")
        for each in (scipy.ndimage.minimum_filter1d, scipy.ndimage.maximum_filter1d)
    )
    equal = (low * high > 0) & (high - low <= SAME_STEP * np.abs(high))
    return np.append(equal, equal[-1:])
