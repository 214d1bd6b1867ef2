"""Where along a swept axis something exceeds a level, and how that is told."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from compare.pages.parts import listed
from compare.reports.sweep.axes import ShownAxis
from geometries.arrays import Array

NOWHERE, EVERYWHERE, UNKNOWN = "nowhere", "everywhere", "not computed"


@dataclass(frozen=True)
class Range:
    """A range of an axis in which a level is exceeded; None: from its first, or up to its last value."""

    start: float | None = None
    end: float | None = None

    def told(self, span: float) -> str:
        """The range as text; interpolated ends have the digits that a `span` of values is worth."""
        start, end = (None if one is None else _rounded(one, span) for one in (self.start, self.end))
        if start is None:
            return EVERYWHERE if end is None else f"up to {end}"
        return f"from {start} on" if end is None else f"from {start} to {end}"


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
            None if start == 0 else _crossing(at, values, int(start) - 1, level),
            None if end == len(at) else _crossing(at, values, int(end) - 1, level),
        )
        for start, end in zip(starts, ends, strict=True)
    ]


def _crossing(at: Array, values: Array, k: int, level: float) -> float:
    """Where the line from the k-th value to the next one has a level."""
    return float(at[k] + (level - values[k]) / (values[k + 1] - values[k]) * (at[k + 1] - at[k]))


def _rounded(value: float, span: float) -> str:
    """A value to three digits, or to a thousandth of a span of values that is small beside it."""
    further = max(0, int(np.floor(np.log10(abs(value) / span)))) if value and span else 0
    return np.format_float_positional(float(f"{value:.{3 + further}g}"), trim="-")


def told(axis: ShownAxis, values: Array, level: float) -> tuple[str, str]:
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
    texts = [one.told(float(np.ptp(axis.values))) for one in ranges]
    again = f"again {texts[1]}" if len(ranges) > 1 else ""
    more = f"and {len(ranges) - 2} times more" if len(ranges) > 2 else ""
    first = texts[0] if ranges else NOWHERE
    return first, ", ".join(filter(None, (again, more, missing)))


def _of_categories(over: Sequence[str], known: int) -> str:
    if not over:
        return NOWHERE
    return EVERYWHERE if len(over) == known else f"at {listed(over)}"


def grouped(texts: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Pairs of what is told and a value it is told of, those that follow each other and are equal as one."""
    return [
        (text, listed(value for _, value in members))
        for text, members in groupby(texts, key=lambda one: one[0])
    ]
