"""Whether numbers are within a limit, given their estimated errors: yes, no, or not decided."""

import numpy as np
from numpy.typing import ArrayLike

from compare.report.tables import Cell
from geometries.arrays import Array

YES, NO, NOT_DECIDED = "yes", "no", "not decided"


def decide(values: ArrayLike, errors: ArrayLike, limit: float) -> Array:
    """Return for each value whether it is within a limit, in the shape of both; empty where it is NaN.

    Yes where value + error <= limit, no where value - error > limit, otherwise not decided: an error that is
    not known, NaN, decides nothing.
    """
    value, error = np.broadcast_arrays(np.asarray(values, dtype=float), np.asarray(errors, dtype=float))
    known = [np.isnan(value), value + error <= limit, value - error > limit]
    return np.asarray(np.select(known, ["", YES, NO], NOT_DECIDED))


def verdict(values: ArrayLike, errors: ArrayLike, limit: float) -> str:
    """Return whether all values are within a limit, as `decide` has each; empty where none is known.

    One that is not within the limit decides; yes needs all of them, also those that are not known.
    """
    each = {str(word) for word in np.ravel(decide(values, errors, limit))}
    if each <= {""}:
        return ""
    return NO if NO in each else YES if each == {YES} else NOT_DECIDED


def verdict_cell(values: ArrayLike, errors: ArrayLike, limit: float, below: str) -> Cell:
    """Return a verdict, below it the number that it follows from; a dash where there is none."""
    return Cell(verdict(values, errors, limit) or "–", below=below)
