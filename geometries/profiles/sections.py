"""Sections along a rail or about a wheel: lists of profiles, `.slcs` and `.slcw`.

Lines, comments `!`, `%` and `"` apart: offset and scale; number of sections; numbers of features, kinks
and accelerations; 1 or 2 for the interpolation; `position 'file'` for each section; the numbers of kinks
and of accelerations, a line each, where there are any; and where there are two features or more, a line
for each section with its position and where the features lie, -1 for one that is absent. A position is
scale * (offset + number). Files are sought beside the list.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.profile import Kind, Profile, kind_by_name
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
    listed = _read_list(Path(path))
    kind, read = kind_by_name(listed.source), dict[str, Profile]()
    for named in listed.named:
        if named.file not in read:  # once, if it is named several times
            read[named.file] = _read_named(listed, named, kind, axes=axes, unit=unit, surface=surface)
    sections = tuple(
        Section(named.position, read[named.file], place)
        for named, place in zip(listed.named, listed.places, strict=True)
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
    listed = _read_list(Path(path))
    k = _find_section(listed, choice)
    named, name = listed.named[k], listed.source.path
    kind = kind_by_name(listed.source)
    profile = _read_named(listed, named, kind, axes=axes, unit=unit, surface=surface)
    note = f"Section {k + 1} of {len(listed.named)} of {name.name}, at {named.position:g}."
    return replace(profile, name=f"{name.stem}-{k + 1}", notes=(note, *profile.notes))


def _read_named(listed: _Listed, named: _Named, kind: Kind | None, **options: Any) -> Profile:
    """Profile of a section; raises WrongInput that names the line of the list, too."""
    path = listed.source.path.parent / named.file.replace("\\", "/")
    try:
        return read_profile(path, kind, **options)
    except WrongInput as error:
        raise listed.source.wrong(named.line, str(error)) from None


def _find_section(listed: _Listed, choice: SectionChoice) -> int:
    """Index of a section. Raises WrongInput, with the sections of the list, where there is none."""
    named, source = listed.named, listed.source
    parts = [f"{k}: at {each.position:g}, {each.file}" for k, each in enumerate(named, 1)]
    if len(parts) > DESCRIBED:
        parts = [*parts[: DESCRIBED - 1], "...", parts[-1]]
    there_are = f"; {source.path.name} has {'; '.join(parts)}"
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


def _read_list(path: Path) -> _Listed:
    """What a list says. Raises WrongInput."""
    source = read_source(path)
    if source.path.suffix.lower() not in LISTS:
        raise source.refused("a list of sections must end in .slcs (rail) or .slcw (wheel)")
    content = ((k, text) for k, line in enumerate(source.lines, 1) if (text := uncommented(line, COMMENTS)))
    lines = _Lines(source, content)
    line, (offset, scale) = lines.numbers("offset and scale", 2)
    if not scale > 0:
        raise source.wrong(line, f"scale = {scale:g}: must be positive")
    (count,) = lines.counts("number of sections", 1, (1, MAX_SECTIONS))
    features, *jumping = lines.counts("numbers of features, kinks, accelerations", 3, (0, 999))
    (method,) = lines.counts("interpolation", 1, (1, 2))
    named = []
    for _ in range(count):
        line, text = lines.following("section")
        match = SECTION.match(text)
        if match is None:
            raise source.wrong(line, f"{shortened(text)}: position and 'file' of a section are expected")
        position = scale * (offset + number(source, line, match[1], "position"))
        named.append(_Named(line, position, match[2] or match[3]))
    for before, after in pairwise(named):
        if not after.position > before.position:
            raise source.wrong(
                after.line, f"position {after.position:g} after {before.position:g}: positions must increase"
            )
    kinks, accelerations = (  # at inner features only
        tuple(lines.counts(what, n, (1, max(features - 2, 1)))) if n and features >= 2 else ()
        for what, n in zip(("kinks", "accelerations"), jumping, strict=True)
    )
    places: list[tuple[float | None, ...]] = []
    for section in named:
        values: list[float] = []
        if features >= 2:
            line, (place, *values) = lines.numbers("position and features", features + 1)
            if not math.isclose(scale * (offset + place), section.position, rel_tol=1e-9, abs_tol=1e-3):
                raise source.wrong(
                    line, f"position {place:g}: differs from that of the section, {section.position:g}"
                )
        places.append(tuple(None if value == -1 else value for value in values))
    for line, text in content:
        raise source.wrong(line, f"{shortened(text)}: not expected; correct the numbers at the beginning")
    return _Listed(source, named, method, kinks, accelerations, places)
