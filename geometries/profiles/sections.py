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
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.profile import Profile, kind_by_name
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
LISTS = (".slcs", ".slcw")  # endings
DESCRIBED = 6  # sections in a message
SAME_POSITION = 1e-9  # rounding, as a share of the list's length
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
class SectionChoice:
    """One section of a list: by its number from 1 on, or by its position in the unit of the list."""

    number: int | None = None
    position: float | None = None


@dataclass(frozen=True)
class _Named:
    """A section in a list: line, position and file."""

    line: int
    position: float
    file: str


@dataclass(frozen=True)
class _Listed:
    """What a list says, before any profile is read."""

    source: Source
    named: list[_Named]
    method: int
    kinks: tuple[int, ...]
    accelerations: tuple[int, ...]
    places: list[tuple[float | None, ...]]


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
    listed = _listed(Path(path))
    kind = kind_by_name(listed.source)
    profiles = _profiles(listed, lambda path: read_profile(path, kind, axes=axes, unit=unit, surface=surface))
    sections = tuple(
        Section(named.position, profile, place)
        for named, profile, place in zip(listed.named, profiles, listed.places, strict=True)
    )
    return Sections(sections, INTERPOLATIONS[listed.method], listed.kinks, listed.accelerations)


def read_section(
    path: str | Path,
    choice: SectionChoice,
    *,
    axes: str | None = None,
    unit: str | None = None,
    surface: int | None = None,
) -> Profile:
    """Profile of one section of a list; other arguments and errors are those of `read_sections`.

    Between sections there is none: the surface there is a spline along features through all sections, which
    is not evaluated.
    """
    listed = _listed(Path(path))
    k = _chosen(listed, choice)
    alone = replace(listed, named=[listed.named[k]])
    kind = kind_by_name(listed.source)
    (profile,) = _profiles(
        alone, lambda path: read_profile(path, kind, axes=axes, unit=unit, surface=surface)
    )
    position = alone.named[0].position
    note = f"Section {k + 1} of {len(listed.named)} of {listed.source.path.name}, at {position:g}."
    return replace(profile, name=f"{listed.source.path.stem}-{k + 1}", notes=(note, *profile.notes))


def _chosen(listed: _Listed, choice: SectionChoice) -> int:
    """Index of a section. Raises WrongInput, with the sections of the list, where there is none."""
    named, source = listed.named, listed.source
    there_are = f"; {source.path.name} has {_described(named)}"
    if (choice.number is None) == (choice.position is None):
        both = "give one of both" if choice.number is not None else "give section or section_at"
        raise source.refused(f"section: a number, or section_at: a position: {both}{there_are}")
    if choice.number is not None:
        if not 1 <= choice.number <= len(named):
            raise source.refused(f"section = {choice.number}: must be 1 ... {len(named)}{there_are}")
        return choice.number - 1
    position = float(choice.position or 0.0)
    first, last = named[0].position, named[-1].position
    away = [abs(section.position - position) for section in named]
    if min(away) <= SAME_POSITION * max(last - first, abs(first), abs(last)):
        return away.index(min(away))
    where = (
        "lies between sections, where profiles are not interpolated"
        if first < position < last
        else "lies beyond the list"
    )
    raise source.refused(f"section_at = {position:g}: {where}: give the position of a section{there_are}")


def _described(named: list[_Named]) -> str:
    """Numbers, positions and files of sections."""
    parts = [f"{k}: at {each.position:g}, {each.file}" for k, each in enumerate(named, 1)]
    return "; ".join(parts if len(parts) <= DESCRIBED else [*parts[: DESCRIBED - 1], "...", parts[-1]])


def _listed(path: Path) -> _Listed:
    """What a list says. Raises WrongInput."""
    source = read_source(path)
    if source.path.suffix.lower() not in LISTS:
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
        _places(lines, what, n, features) for what, n in (("kinks", kinks), ("accelerations", accelerations))
    )
    places = [_features(lines, placing, features, section.position) for section in named]
    _check_end(lines)
    return _Listed(source, named, method, kinked, accelerated, places)


def _named(lines: _Lines, placing: list[float]) -> _Named:
    """The next section."""
    line, text = lines.following("section")
    match = SECTION.match(text)
    if match is None:
        raise lines.source.wrong(line, f"{shortened(text)}: position and 'file' of a section are expected")
    position = number(lines.source, line, match[1], "position")
    return _Named(line, placing[1] * (placing[0] + position), match[2] or match[3])


def _check_growing(source: Source, named: list[_Named]) -> None:
    """Raise WrongInput where positions do not grow."""
    for before, after in pairwise(named):
        if not after.position > before.position:
            raise source.wrong(
                after.line, f"position {after.position:g} after {before.position:g}: positions must grow"
            )


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


def _profiles(listed: _Listed, reader: Callable[[Path], Profile]) -> list[Profile]:
    """Profiles of the sections; a file that is named several times is read once."""
    read: dict[str, Profile] = {}
    for section in listed.named:
        if section.file not in read:
            path = listed.source.path.parent / section.file.replace("\\", "/")
            try:
                read[section.file] = reader(path)
            except WrongInput as error:
                raise listed.source.wrong(section.line, str(error)) from None
    return [read[section.file] for section in listed.named]
