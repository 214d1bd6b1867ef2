"""Where along a swept axis something exceeds a level, and how that is told."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from compare.pages.parts import listed
from compare.reports.sweep.axes import Axis, text_of
from geometries.arrays import Array

NOWHERE, EVERYWHERE, UNKNOWN = "nowhere", "everywhere", "not computed"


@dataclass(frozen=True)
class Range:
    """A range of an axis in which a level is exceeded; None: from its first, or up to its last value."""

    start: float | None = None
    end: float | None = None

    def __str__(self) -> str:
        match self.start, self.end:
            case None, None:
                return EVERYWHERE
            case start, None:
                return f"from {text_of(start)} on"
            case None, end:
                return f"up to {text_of(end)}"
            case start, end:
                return f"from {text_of(start)} to {text_of(end)}"


def exceeded(at: Array, values: Array, level: float) -> list[Range]:
    """The ranges in which values (n,) over an axis exceed a level, interpolated linearly along the axis.

    Values that are NaN are left out.
    """
    known = np.isfinite(values)
    at, values = at[known], values[known]
    above = np.concatenate([[False], values > level, [False]])
    starts, ends = (np.flatnonzero(above[1:] & ~above[:-1]), np.flatnonzero(above[:-1] & ~above[1:]))
    return [
        Range(
            None if start == 0 else _crossing(at, values, start - 1, level),
            None if end == len(at) else _crossing(at, values, end - 1, level),
        )
        for start, end in zip(starts, ends, strict=True)
    ]


def _crossing(at: Array, values: Array, k: int, level: float) -> float:
    """Where the line from the k-th value to the next one has a level."""
    return float(at[k] + (level - values[k]) / (values[k + 1] - values[k]) * (at[k + 1] - at[k]))


def told(axis: Axis, values: Array, level: float) -> tuple[str, str]:
    """Where values (n,) along an axis exceed a level, and what there is to add.

    That is a second range, and how many values are not known.
    """
    known = np.isfinite(values)
    if not np.any(known):
        return UNKNOWN, ""
    missing = "" if np.all(known) else f"{np.sum(known)} of {len(known)} scenes"
    if not axis.is_number:
        over = [str(value) for value in axis.values[known & (values > level)]]
        return _of_categories(over, int(np.sum(known))), missing
    ranges = exceeded(axis.values, values, level)
    again = f"again {ranges[1]}" if len(ranges) > 1 else ""
    more = f"and {len(ranges) - 2} times more" if len(ranges) > 2 else ""
    first = str(ranges[0]) if ranges else NOWHERE
    return first, ", ".join(filter(None, (again, more, missing)))


def _of_categories(over: Sequence[str], known: int) -> str:
    if not over:
        return NOWHERE
    return EVERYWHERE if len(over) == known else f"at {listed(over)}"


def grouped(texts: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Pairs of what is told and a value it is told of, those that follow each other and are equal as one."""
    return [
        (text, listed(value for _, value in members)) for text, members in groupby(texts, key=lambda one: one[0])
    ]
