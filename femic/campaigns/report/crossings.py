"""Where along a swept axis something exceeds a level, and how that is told."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import xarray as xr

from compare.report.parts import listed
from femic.campaigns.report.axes import Names, ShownAxis, named, swept, text_of
from geometries.arrays import Array

NOWHERE, EVERYWHERE = "nowhere", "everywhere"
TOLD = 0.05  # the level of which sentences tell


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
    """A value to three digits, those of a thousandth of a span at least; of small ones no digits below."""
    digits = 3
    if value and span:
        digits += max(0, int(np.floor(np.log10(abs(value) / span))))
    rounded = float(f"{value:.{digits}g}")
    if 0 < abs(value) < span / 10:
        rounded = round(rounded, 3 - int(np.floor(np.log10(span))))
    return np.format_float_positional(rounded, trim="-")


@dataclass(frozen=True)
class Found:
    """Where a level is exceeded at a place of the other axes ("": at all), and what there is to add."""

    text: str
    place: str = ""
    more: str = ""

    def along(self, axis: ShownAxis) -> str:
        """The same as part of a sentence: from flank = 32 on at ratio = 1.05."""
        text = self.text
        for word in ("from ", "up to ", "at "):
            if text.startswith(word):
                text = f"{word}{axis.name} = {text.removeprefix(word)}"
        return f"{text} at {self.place}" if self.place else text


@dataclass(frozen=True, eq=False)
class Line:
    """Sizes of numbers along an axis, (n,), at a place of the other axes."""

    axis: ShownAxis
    place: Names
    sizes: Array

    def found(self, level: float) -> Found:
        """Where the sizes exceed a level."""
        place = listed([named({name: value}) for name, value in self.place.items()] or [""])
        known = np.isfinite(self.sizes)
        if not self.axis.is_number:
            over = self.axis.values[known & (self.sizes > level)]
            if len(over) in (0, np.sum(known)):
                return Found(EVERYWHERE if len(over) else NOWHERE, place)
            return Found(f"at {listed(map(text_of, over))}", place)
        ranges = exceeded(self.axis.values, self.sizes, level)
        texts = [one.told(float(np.ptp(self.axis.values))) for one in ranges] or [NOWHERE]
        again = [f"again {texts[1]}"] if len(texts) > 1 else []
        further = [f"and {len(texts) - 2} times more"] if len(texts) > 2 else []
        return Found(texts[0], place, ", ".join([*again, *further]))

    def extent(self, level: float) -> float:
        """On which share of the known part of the axis the sizes exceed a level; categories: of how many."""
        known = np.isfinite(self.sizes)
        at = self.axis.at[known]
        if not self.axis.is_number or np.ptp(at) == 0:
            return float(np.mean(self.sizes[known] > level))
        covered = 0.0
        for one in exceeded(self.axis.at, self.sizes, level):
            covered += at[-1] if one.end is None else one.end
            covered -= at[0] if one.start is None else one.start
        return covered / float(np.ptp(at))


@dataclass(frozen=True, eq=False)
class Lines:
    """Sizes of numbers along the axis of a grid that has most values, at all places of the others."""

    axis: ShownAxis
    all: Sequence[Line]
    known_of: str  # "15 of 21 scenes", "" where all are known

    @classmethod
    def of(cls, sizes: xr.DataArray, axes: Sequence[ShownAxis]) -> "Lines":
        """The lines of sizes over the swept dims."""
        axis = along(axes)
        rest = [one for one in swept(axes) if one is not axis]
        rows = sizes.transpose(*(one.name for one in rest), axis.name).values.reshape(-1, len(axis.values))
        places = product(*(one.values for one in rest))
        lines = [
            Line(axis, dict(zip((one.name for one in rest), place, strict=True)), row)
            for place, row in zip(places, rows, strict=True)
        ]
        return cls(axis, lines, known_of(sizes))

    @cached_property
    def known(self) -> list[Line]:
        """The lines on which anything is known."""
        return [line for line in self.all if np.any(np.isfinite(line.sizes))]

    def found(self, level: float) -> list[Found]:
        """Where a level is exceeded: at the place where it is most, then where it is least; [] of nothing."""
        if not self.known:
            return []
        by_extent = sorted(self.known, key=lambda line: (line.extent(level), np.nanmax(line.sizes)))
        most, least = by_extent[-1].found(level), by_extent[0].found(level)
        return [Found(most.text, more=most.more)] if most.text == least.text else [most, least]


def along(axes: Iterable[ShownAxis]) -> ShownAxis:
    """The axis along which crossings are told: of numbers, with the most values."""
    return max(swept(axes), key=lambda axis: (axis.is_number, len(axis.values)))


def known_of(sizes: xr.DataArray) -> str:
    """How many scenes are known, where these are not all."""
    known = int(np.sum(np.isfinite(sizes.values)))
    return "" if known == sizes.size else f"{known} of {sizes.size} scenes"
