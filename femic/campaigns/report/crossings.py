"""Where along a swept axis numbers exceed a level, as text."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import xarray as xr

from compare.report.parts import join_words
from femic.campaigns.report.axes import Names, ShownAxis, swept, text_of, values_text
from geometries.arrays import Array

NOWHERE, EVERYWHERE = "nowhere", "everywhere"


@dataclass(frozen=True)
class Range:
    """A range of an axis in which a level is exceeded; None: from its first, or up to its last value."""

    start: float | None = None
    end: float | None = None

    def text(self, span: float) -> str:
        """Return the range as text; ends have the digits that are significant in a `span` of values."""
        start, end = (None if place is None else _rounded(place, span) for place in (self.start, self.end))
        if start is None:
            return EVERYWHERE if end is None else f"up to {end}"
        return f"from {start} on" if end is None else f"from {start} to {end}"


def exceeded(at: Array, values: Array, level: float) -> list[Range]:
    """Return the ranges in which values (n,) over an axis exceed a level, interpolated linearly.

    Values that are NaN are left out.
    """
    known = np.isfinite(values)
    at, values = at[known], values[known]
    above = np.concatenate([[False], values > level, [False]])
    starts, ends = (np.flatnonzero(above[1:] & ~above[:-1]), np.flatnonzero(above[:-1] & ~above[1:]))

    def crossing(k: int) -> float:
        share = (level - values[k]) / (values[k + 1] - values[k])
        return float(at[k] + share * (at[k + 1] - at[k]))

    return [
        Range(
            None if start == 0 else crossing(int(start) - 1),
            None if end == len(at) else crossing(int(end) - 1),
        )
        for start, end in zip(starts, ends, strict=True)
    ]


def _rounded(value: float, span: float) -> str:
    """Return a value as text with three digits, and with as many as a thousandth of a span needs."""
    digits = 3
    if value and span:
        digits += max(0, int(np.floor(np.log10(abs(value) / span))))
    rounded = float(f"{value:.{digits}g}")
    if 0 < abs(value) < span / 10:
        rounded = round(rounded, 3 - int(np.floor(np.log10(span))))
    return np.format_float_positional(rounded, trim="-")


@dataclass(frozen=True)
class Crossing:
    """The range where a level is exceeded, at a place of the other axes ("": at all), and more ranges."""

    text: str
    place: str = ""
    more: str = ""

    def along(self, axis: ShownAxis) -> str:
        """Return the crossing as part of a sentence: from flank = 32 on at ratio = 1.05."""
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

    def crossing(self, level: float) -> Crossing:
        """Return where the sizes exceed a level."""
        place = join_words([values_text({name: value}) for name, value in self.place.items()] or [""])
        known = np.isfinite(self.sizes)
        if not self.axis.is_number:
            over = self.axis.values[known & (self.sizes > level)]
            if len(over) in (0, np.sum(known)):
                return Crossing(EVERYWHERE if len(over) else NOWHERE, place)
            return Crossing(f"at {join_words(map(text_of, over))}", place)
        span = float(np.ptp(self.axis.values))
        texts = [part.text(span) for part in exceeded(self.axis.values, self.sizes, level)] or [NOWHERE]
        again = [f"again {texts[1]}"] if len(texts) > 1 else []
        further = [f"and {len(texts) - 2} times more"] if len(texts) > 2 else []
        return Crossing(texts[0], place, ", ".join([*again, *further]))

    def extent(self, level: float) -> float:
        """Return the share of the known part of the axis, or of its categories, that exceeds a level."""
        known = np.isfinite(self.sizes)
        at = self.axis.at[known]
        if not self.axis.is_number or np.ptp(at) == 0:
            return float(np.mean(self.sizes[known] > level))
        covered = 0.0
        for part in exceeded(self.axis.at, self.sizes, level):
            covered += at[-1] if part.end is None else part.end
            covered -= at[0] if part.start is None else part.start
        return covered / float(np.ptp(at))


def lines_of(sizes: xr.DataArray, axes: Sequence[ShownAxis]) -> list[Line]:
    """Return sizes over the swept dims as lines along the main axis, at all places of the others."""
    axis = main_axis(axes)
    names = [other.name for other in swept(axes) if other is not axis]
    rows = sizes.transpose(*names, axis.name).values.reshape(-1, len(axis.values))
    places = product(*(other.values for other in swept(axes) if other is not axis))
    return [
        Line(axis, dict(zip(names, place, strict=True)), row) for place, row in zip(places, rows, strict=True)
    ]


def extreme_crossings(lines: Sequence[Line], level: float) -> list[Crossing]:
    """Return where a level is exceeded: on the lines of the largest and of the least extent, if any."""
    known = [line for line in lines if np.any(np.isfinite(line.sizes))]
    if not known:
        return []
    by_extent = sorted(known, key=lambda line: (line.extent(level), np.nanmax(line.sizes)))
    most, least = by_extent[-1].crossing(level), by_extent[0].crossing(level)
    return [Crossing(most.text, more=most.more)] if most.text == least.text else [most, least]


def main_axis(axes: Iterable[ShownAxis]) -> ShownAxis:
    """Return the axis along which crossings are reported: of numbers, with the most values."""
    return max(swept(axes), key=lambda axis: (axis.is_number, len(axis.values)))


def over_level(sizes: xr.DataArray, level: float) -> str:
    """Return the share of the known scenes whose numbers exceed a level."""
    known = sizes.values[np.isfinite(sizes.values)]
    return f"{100 * np.mean(known > level):.0f} %" if known.size else "–"


def known_count(sizes: xr.DataArray) -> str:
    """Return "15 of 21 scenes" where not all are known, else ""."""
    known = int(np.sum(np.isfinite(sizes.values)))
    return "" if known == sizes.size else f"{known} of {sizes.size} scenes"
