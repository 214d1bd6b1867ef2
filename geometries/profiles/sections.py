"""Sections along a rail or about a wheel: lists of profiles, `.slcs` and `.slcw`.

Lines, comments `!`, `%` and `"` apart: offset and scale; number of sections; numbers of features, kinks
and accelerations; 1 or 2 for the interpolation; `position 'file'` for each section; the numbers of kinks
and of accelerations, a line each, where there are any; and where there are two features or more, a line
for each section with its position and where the features lie, -1 for one that is absent. A position is
scale * (offset + number). Files are sought beside the list.
"""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal

from geometries.errors import WrongInput
from geometries.profiles.content import kind_by_name
from geometries.profiles.files import read_profile
from geometries.profiles.profile import Profile
from geometries.profiles.text import (
    Source,
    is_number,
    number,
    read_source,
    shortened,
    split_columns,
    uncommented,
)

COMMENTS = '!%"'
MAX_SECTIONS = 10_000
SECTION = re.compile(r"(\S+?)[\s,]+(?:'([^']+)'|(\S+))")
INTERPOLATIONS: dict[int, Literal["spline", "approximating"]] = {1: "spline", 2: "approximating"}


@dataclass(frozen=True, eq=False)
class Section:
    """A profile at a position along a rail or about a wheel, in the unit of the list after scaling.

    `features` are places in the profile, as numbers of the list, None for an absent one.
    """

    position: float
    profile: Profile
    features: tuple[float | None, ...] = ()


@dataclass(frozen=True, eq=False)
class Sections:
    """Sections by growing position, and how they are to be interpolated.

    `kinks` and `accelerations` are numbers of features (from 1) along which the surface has a kink, or its
    curvature jumps.
    """

    sections: tuple[Section, ...]
    interpolation: Literal["spline", "approximating"]
    kinks: tuple[int, ...] = ()
    accelerations: tuple[int, ...] = ()


@dataclass(frozen=True)
class _Lines:
    """The lines with content that are not read yet."""

    source: Source
    lines: Iterator[tuple[int, str]]

    def following(self, what: str) -> tuple[int, str]:
        """Number and text of the next line. Raises WrongInput at the end of the file."""
        for line in self.lines:
            return line
        raise self.source.wrong(len(self.source.lines), f"{what}: missing; is the file cut off?")

    def numbers(self, what: str, count: int) -> tuple[int, list[float]]:
        """Line and numbers of the next line, which may have text behind them."""
        line, text = self.following(what)
        fields = split_columns(self.source, line, text)
        if len(fields) < count or (len(fields) > count and is_number(fields[count])):
            raise self.source.wrong(line, f"{shortened(text)}: {what}, {count} numbers, expected")
        return line, [number(self.source, line, field, what) for field in fields[:count]]

    def counts(self, what: str, count: int, limits: tuple[int, int]) -> list[int]:
        """Whole numbers of the next line."""
        line, values = self.numbers(what, count)
        for value in values:
            if value != int(value) or not limits[0] <= value <= limits[1]:
                raise self.source.wrong(
                    line, f"{what} = {value:g}: must be a whole number from {limits[0]} to {limits[1]}"
                )
        return [int(value) for value in values]


def read_sections(
    path: str | Path, *, axes: str | None = None, unit: str | None = None, surface: int | None = None
) -> Sections:
    """Sections of a list, `.slcs` (rail) or `.slcw` (wheel), with their profiles.

    `axes`, `unit` and `surface` are those of `read_profile`, for all files. Raises WrongInput with the path
    and the line of the list, and for a profile that cannot be read with its own, too.
    """
    source = read_source(Path(path))
    if source.path.suffix.lower() not in (".slcs", ".slcw"):
        raise source.refused("a list of sections must end in .slcs (rail) or .slcw (wheel)")
    content = ((k, text) for k, line in enumerate(source.lines, 1) if (text := uncommented(line, COMMENTS)))
    lines = _Lines(source, content)
    placing_line, placing = lines.numbers("offset and scale", 2)
    if not placing[1] > 0:
        raise source.wrong(placing_line, f"scale = {placing[1]:g}: must be positive")
    (count,) = lines.counts("number of sections", 1, (1, MAX_SECTIONS))
    features, kinks, accelerations = lines.counts("numbers of features, kinks, accelerations", 3, (0, 999))
    (method,) = lines.counts("interpolation", 1, (1, 2))
    named = [_named(lines, placing) for _ in range(count)]
    _check_growing(source, named)
    kinked, accelerated = (
        _places(lines, what, number_of, features)
        for what, number_of in (("kinks", kinks), ("accelerations", accelerations))
    )
    places = [_features(lines, placing, features, position) for _, position, _ in named]
    _check_end(lines)
    kind = kind_by_name(source)
    profiles = _profiles(
        source, named, lambda path: read_profile(path, kind, axes=axes, unit=unit, surface=surface)
    )
    sections = tuple(
        Section(position, profile, place)
        for (_, position, _), profile, place in zip(named, profiles, places, strict=True)
    )
    return Sections(sections, INTERPOLATIONS[method], kinked, accelerated)


def _named(lines: _Lines, placing: list[float]) -> tuple[int, float, str]:
    """Line, position and file of the next section."""
    line, text = lines.following("section")
    match = SECTION.match(text)
    if match is None:
        raise lines.source.wrong(line, f"{shortened(text)}: position and 'file' of a section are expected")
    position = number(lines.source, line, match[1], "position")
    return line, placing[1] * (placing[0] + position), match[2] or match[3]


def _check_growing(source: Source, named: list[tuple[int, float, str]]) -> None:
    """Raise WrongInput where positions do not grow."""
    for (_, before, _), (line, position, _) in pairwise(named):
        if not position > before:
            raise source.wrong(line, f"position {position:g} after {before:g}: positions must grow")


def _places(lines: _Lines, what: str, count: int, features: int) -> tuple[int, ...]:
    """Numbers of the features with kinks or accelerations; only inner features can have them."""
    if features < 2 or count == 0:
        return ()
    return tuple(lines.counts(what, count, (1, max(features - 2, 1))))


def _features(lines: _Lines, placing: list[float], count: int, position: float) -> tuple[float | None, ...]:
    """Where the features of a section lie, from its line in the table."""
    if count < 2:
        return ()
    line, values = lines.numbers("position and features", count + 1)
    if not math.isclose(placing[1] * (placing[0] + values[0]), position, rel_tol=1e-9, abs_tol=1e-3):
        raise lines.source.wrong(
            line, f"position {values[0]:g}: differs from that of the section, {position:g}"
        )
    return tuple(None if value == -1 else value for value in values[1:])


def _check_end(lines: _Lines) -> None:
    """Raise WrongInput for lines behind the last one expected."""
    for line, text in lines.lines:
        raise lines.source.wrong(
            line, f"{shortened(text)}: not expected; correct the numbers at the beginning"
        )


def _profiles(
    source: Source, named: list[tuple[int, float, str]], reader: Callable[[Path], Profile]
) -> list[Profile]:
    """Profiles of the sections; a file that is named several times is read once."""
    read: dict[str, Profile] = {}
    for line, _, name in named:
        if name not in read:
            path = source.path.parent / name.replace("\\", "/")
            try:
                read[name] = reader(path)
            except WrongInput as error:
                raise source.wrong(line, str(error)) from None
    return [read[name] for _, _, name in named]
