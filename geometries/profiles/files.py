"""Profiles from files and to files: what a file says, what has to be given, and what was done.

Formats: two columns, spline blocks, MiniProf. `docs/reference/profiles.md` has them for users.

Files of two columns have y and z, and nothing else; the columns of GENSYS are such files, too. Rows are
separated by line ends, columns by blanks, commas or semicolons. `#`, `!`, `%` and quotation marks start
comments.
"""

import math
from pathlib import Path
from typing import get_args

import numpy as np

from geometries.errors import WrongInput
from geometries.profiles.axes import Axes, find_axes, one_surface, parse_axes, turned
from geometries.profiles.miniprof import is_miniprof, read_miniprof
from geometries.profiles.preparation import SelfIntersection, first_crossing
from geometries.profiles.profile import UNITS, Content, Kind, Profile, kind_by_name, parse_rows, point, row
from geometries.profiles.spline_block import block_text, is_spline_block, read_spline_block
from geometries.profiles.text import (
    DUPLICATE,
    Rows,
    Source,
    drop_near,
    drop_zigzags,
    first_fold,
    is_number,
    nearest,
    note_gaps,
    parse_source,
    read_source,
    shortened,
    uncommented,
)

# --- profiles ---

LEAST_POINTS = 4
WIDTHS = (1.0, 1000.0)  # of a profile [mm]: others are an error of the unit
SAME_UNIT = 1e-4  # rounding of 39.37 inches per metre
USUAL_WIDTHS = (40.0, 200.0)  # of a rail or a wheel [mm], by which the unit of two columns is known
TEXTS = ("", ".txt", ".csv", ".dat", ".tab", ".rail", ".wheel")  # endings of two columns
ENDINGS: dict[str, Kind] = {".prr": "rail", ".prw": "wheel"}


def read_profile(
    path: str | Path,
    kind: Kind | None = None,
    *,
    axes: str | None = None,
    unit: str | None = None,
    surface: int | None = None,
) -> Profile:
    """Profile from a file of two columns, a spline block (`.prr`, `.prw`) or MiniProf (`.ban`, `.whl`).

    Parameters
    ----------
    path
        The file. Its format is known by its ending or by its first lines.
    kind
        "rail" or "wheel", where neither the file nor its ending says it.
    axes
        To which side y grows and where z points in the file: "field" or "centre" (of the track), "up" or
        "down", or one of each, as "centre down". Needed for what neither the format nor the shape shows.
    unit
        "mm", "m" or "inch", where the file does not say it and its size does not show it.
    surface
        Number of a running surface, in the order of the file, where it has several (guard rail).

    Raises WrongInput with the path, the line and the remedy for what cannot be read, and with the argument
    and its choices for what has to be given. What was done is in `notes` of the profile.
    """
    if kind is not None and kind not in get_args(Kind):
        raise WrongInput(f"kind = {kind!r}: must be 'rail' or 'wheel'")
    if unit is not None and unit not in UNITS:
        raise WrongInput(f"unit = {unit!r}: must be 'mm', 'm' or 'inch'")
    given = parse_axes(axes)
    source = read_source(Path(path))
    return _interpret(source, _read_content(source), kind, given, unit=unit, surface=surface)


def write_profile(profile: Profile, path: str | Path) -> None:
    """Write a profile as a spline block, `.prr` for a rail, `.prw` for a wheel.

    It is read back before it is saved: reading the file gives the same points.
    """
    path = Path(path)
    if ENDINGS.get(path.suffix.lower()) != profile.kind:
        ending = ".prr" if profile.kind == "rail" else ".prw"
        raise WrongInput(f"path = '{path}': the name of a {profile.kind}'s file must end in {ending}")
    text = block_text(profile)
    source = parse_source(path, text.encode())
    again = _interpret(source, read_spline_block(source), profile.kind, Axes("field", "down"))
    if not np.array_equal(again.points, profile.points):
        raise WrongInput(
            f"{path}: {profile.points.shape[1]} points, {again.points.shape[1]} when read back: "
            f"leave out repeated points and zigzags ({' '.join(again.notes)})"
        )
    part = path.with_name(f"{path.name}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise WrongInput(f"{path}: cannot be written ({error.strerror})") from None


def _read_content(source: Source) -> Content:
    """What the file says, by its format. Raises WrongInput where it begins like none of the formats."""
    ending = source.path.suffix
    if ending.lower() in (".slcs", ".slcw"):
        raise source.refused("a list of sections: read_sections and read_section read it")
    if is_spline_block(source):
        return read_spline_block(source)
    if is_miniprof(source):
        return read_miniprof(source)
    first = next((text for line in source.lines if (text := uncommented(line, COMMENTS))), "")
    if ending.lower() not in TEXTS and not any(is_number(field) for field in first.split()):
        raise source.refused(
            f"ending '{ending}', which is none of a format of profiles, and no text of one: it begins with "
            f"{shortened(first)}; export the profile as .ban or .whl (MiniProf), as .prr or .prw (spline "
            "block), or as two columns .txt"
        )
    return read_columns(source)


def _interpret(  # noqa: PLR0913
    source: Source,
    content: Content,
    kind: Kind | None,
    axes: Axes,
    *,
    unit: str | None = None,
    surface: int | None = None,
) -> Profile:
    """Profile in millimetres and in the axes of this program, from a file and the arguments."""
    _check_count(source, content.rows)
    if content.kind and kind and content.kind != kind:
        raise source.refused(
            f"kind = '{kind}': the header or the name of the file says {content.kind}; correct one of them"
        )
    kind = kind or content.kind
    if kind is None:
        raise source.refused("kind: the file does not state it; give kind = 'rail' or 'wheel'")
    factor, notes = _find_unit(source, content, unit)
    rows, cleaned = _clean(source, content.rows.scaled(factor))
    in_mm = Content(rows, kind, y=content.y, z=content.z)
    axes, seen = find_axes(source, in_mm, kind, axes)
    if kind == "rail" or surface is not None:
        rows, chosen = one_surface(source, rows, 1.0 if axes.z == "up" else -1.0, surface)
        seen += chosen
        _check_count(source, rows)
    rows, reversed_order = turned(rows, axes)
    gaps = note_gaps(rows)
    all_notes = (*content.notes, *notes, *cleaned, *seen, *reversed_order, *gaps)
    return Profile(kind, rows.points, source.path.stem, all_notes, rows.steps)


def _find_unit(source: Source, content: Content, given: str | None) -> tuple[float, list[str]]:
    """Length of the unit [mm] and a note. Raises WrongInput where it is not known or cannot be.

    Neither given nor stated, it is the one in which the width is that of a rail or a wheel.
    """
    width = float(np.ptp(content.rows.points[0]))
    choices = "give unit = 'mm', 'm' or 'inch'"
    if content.unit and content.unit_is_key:
        factor, origin, remedy = content.unit, "by units.len.f", "correct units.len.f"
        if given and not math.isclose(UNITS[given], factor, rel_tol=SAME_UNIT):
            raise source.refused(
                f"unit = '{given}': units.len.f says otherwise; leave unit out, or correct the file"
            )
    elif given:
        factor, origin, remedy = UNITS[given], "as given", choices
    elif content.unit:
        factor, origin, remedy = content.unit, "by the format", choices
    else:
        low, high = USUAL_WIDTHS
        fitting = [factor for factor in UNITS.values() if low <= width * factor <= high]
        if len(fitting) != 1:
            raise source.refused(f"unit: y extends over {width:.4g}, so the unit is unclear; {choices}")
        factor, origin, remedy = fitting[0], "as its size shows", choices
    if not WIDTHS[0] <= width * factor <= WIDTHS[1]:
        raise source.refused(
            f"unit: y extends over {width * factor:.4g} mm with the unit {origin}; profiles have "
            f"{WIDTHS[0]:g} to {WIDTHS[1]:g} mm: {remedy}"
        )
    return factor, [f"1 unit of the file is {factor:g} mm, {origin}."]


def _clean(source: Source, rows: Rows) -> tuple[Rows, list[str]]:
    """Points in mm without repeated ones and zigzags. Raises WrongInput for folds and crossings."""
    rows, repeated = drop_near(rows, DUPLICATE)
    rows, zigzags = drop_zigzags(rows)
    rows, again = drop_near(rows, nearest(rows), both_ends=True)
    _check_count(source, rows)
    fold = first_fold(rows)
    if fold is not None:
        raise source.wrong(
            int(rows.lines[fold]),
            "the points turn back here; they must follow the surface in one direction",
        )
    try:
        crossing = first_crossing(rows.points)
    except SelfIntersection:
        raise source.refused(
            "the line through the points overlaps itself in many places; the points must follow "
            "the surface once"
        ) from None
    if crossing is not None:
        k, m = crossing
        ends = rows.points[:, [0, -1]]
        if k == 0 and m == rows.count - 2 and math.dist(*ends.T.tolist()) <= DUPLICATE:
            raise source.wrong(
                int(rows.lines[-1]), "the outline is closed; keep only the running surface, from face to face"
            )
        raise source.wrong(
            int(rows.lines[m]),
            f"the contour crosses itself: with lines {rows.lines[k]} to {rows.lines[k + 1]}; sort the points "
            "along the surface, or delete wrong ones",
        )
    return rows, repeated + zigzags + again


def _check_count(source: Source, rows: Rows) -> None:
    """Raise WrongInput for too few points."""
    if rows.count < LEAST_POINTS:
        raise source.wrong(
            int(rows.lines[-1]), f"{rows.count} points are left; a profile needs {LEAST_POINTS} or more"
        )


# --- two columns ---

COMMENTS = "#!%\"'"


def read_columns(source: Source) -> Content:
    """Points of a file of two columns; unit and axes are not stated."""
    points, lines = [], []
    for line, text in enumerate(source.lines, 1):
        if content := uncommented(text, COMMENTS):
            points.append(point(source, line, *row(source, line, content, range(2, 3))))
            lines.append(line)
    return Content(parse_rows(source, points, lines), kind_by_name(source))
