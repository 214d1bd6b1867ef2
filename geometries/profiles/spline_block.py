"""Spline blocks, `.prr` (rails) and `.prw` (wheels), as Simpack has them: reading, processing, writing.

By the definition of the format y grows to the field side of a right-hand section, z points down, and the
points of a rail go by growing y, those of a wheel by falling y. Lengths are in m where `units.len.f`, the
number of units per metre, is missing. The keys say what is to be done with the points, in this order:
those too near each other are dropped, zigzags removed, shift, rotation, bounds, mirrors, scale, inversion.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from geometries.profiles.profile import UNITS, Content, Profile, kind_by_name, parse_rows, point, row
from geometries.profiles.text import Rows, Source, as_float, drop_near, drop_zigzags, number, shortened

MARKS = ("header.begin", "header.end", "spline.begin", "spline.end", "point.begin", "point.end")
NUMBERS: Mapping[str, float] = {
    "approx.smooth": 0.0,
    "point.dist.min": 0.0,
    "shift.y": 0.0,
    "shift.z": 0.0,
    "rotate": 0.0,
    "bound.y.min": 0.0,
    "bound.y.max": 0.0,
    "bound.z.min": 0.0,
    "bound.z.max": 0.0,
    "units.len.f": 1.0,
    "units.ang.f": 1.0,
}
SWITCHES = ("mirror.y", "mirror.z", "inversion")
WITHOUT_EFFECT = ("file", "file.mtime", "comment", "type", "version", "units.len", "units.ang")
KEY = re.compile(r"([a-z][\w.]*)\s*=\s*(.*)", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True)
class Block:
    """Keys of header and spline block (line and text of each value, by name), points and their weights."""

    header: Mapping[str, tuple[int, str]]
    keys: Mapping[str, tuple[int, str]]
    rows: Rows
    weighted: bool


def is_spline_block(source: Source) -> bool:
    """Whether the file is a spline block: by its ending or by the mark at its beginning."""
    if source.path.suffix.lower() in (".prr", ".prw"):
        return True
    return any(_uncommented(line).lower() in ("header.begin", "spline.begin") for line in source.lines[:200])


def read_spline_block(source: Source) -> Content:
    """Points of a spline block, processed as its keys say, in the unit of the file."""
    block = _parse(source)
    values = _read_values(source, block.keys)
    kind, named, notes = kind_by_name(source), kind_by_name(source), list[str]()
    if "type" in block.header:
        line, text = block.header["type"]
        value = number(source, line, text, "type")
        if value not in (0, 1):
            raise source.wrong(line, f"type = {text}: must be 0 (rail) or 1 (wheel)")
        kind = "wheel" if value else "rail"
        if named not in (None, kind):
            notes.append(f"The header says {kind}, the name of the file {named}: it was read as a {kind}.")
    if "comment" in block.keys:
        notes.append(f"The file says: {block.keys['comment'][1].strip(chr(39))}.")
    unknown = sorted(set(block.keys) - set(NUMBERS) - set(SWITCHES) - set(WITHOUT_EFFECT))
    if unknown:
        notes.append(f"Unknown keys, ignored: {', '.join(unknown)[:200]}.")
    if smooth := values["approx.smooth"]:
        notes.append(f"approx.smooth = {smooth:g} has no effect: the points are as measured.")
    if block.weighted:
        notes.append("The weights of the points have no effect.")
    rows, done = _process(source, block.rows, values)
    notes += done
    if kind and bool(rows.points[0, -1] > rows.points[0, 0]) != (kind == "rail"):
        usual = "growing" if kind == "rail" else "falling"
        notes.append(
            f"The points run in the opposite direction to most files of {kind}s, which have {usual} y."
        )
    unit = UNITS["m"] / values["units.len.f"]
    return Content(rows, kind, unit, "units.len.f" in block.keys, "field", "down", tuple(notes))


# --- the text ---


def _parse(source: Source) -> Block:
    """Parts of the file. Raises WrongInput at the first line that does not belong where it stands."""
    parts: dict[str, dict[str, tuple[int, str]]] = {"header": {}, "spline": {}}
    open_marks: list[str] = []
    closed: set[str] = set()
    points, lines, weighted = [], [], False
    for line, text in enumerate(source.lines, 1):
        content = _uncommented(text)
        if not content:
            continue
        if content.lower() in MARKS:
            part, _, action = content.lower().partition(".")
            around = ["spline"] if part == "point" else []
            if action == "begin" and open_marks == around and part not in closed:
                open_marks.append(part)
            elif action == "end" and open_marks == [*around, part]:
                open_marks.pop()
                closed.add(part)
            else:
                raise source.wrong(
                    line,
                    f"{content.lower()}: not expected here; the file must have header, spline, and in it "
                    "points, each once",
                )
        elif open_marks[-1:] == ["point"]:
            y, z, *weight = row(source, line, content, range(2, 4))
            points.append(point(source, line, y, z))
            lines.append(line)
            weighted |= any(as_float(value) != 1 for value in weight)
        elif open_marks:
            match, keys = KEY.fullmatch(content), parts[open_marks[-1]]
            if match is None:
                raise source.wrong(line, f"{shortened(content)}: a line KEY = VALUE is expected")
            key = match[1].lower()
            if key in keys and keys[key][1] != match[2]:
                raise source.wrong(
                    line,
                    f"{key}: also given in line {keys[key][0]}, with another value; delete one of the two",
                )
            keys[key] = (line, match[2])
        else:
            raise source.wrong(line, f"{shortened(content)}: header.begin or spline.begin is expected here")
    if "spline" not in closed:
        expected = "spline.end" if "spline" in open_marks else "spline.begin"
        raise source.wrong(len(source.lines), f"{expected} is missing; is the file cut off?")
    if "point" not in closed:
        raise source.wrong(len(source.lines), "point.begin is missing: the file has no points")
    return Block(parts["header"], parts["spline"], parse_rows(source, points, lines), weighted)


def _uncommented(line: str) -> str:
    """The line before a comment sign that is not within quotes, without blanks at its ends."""
    parts = line.split("'")
    for k in range(0, len(parts), 2):
        cut = re.split("[!%]", parts[k], maxsplit=1)
        if len(cut) > 1:
            return "'".join([*parts[:k], cut[0]]).strip()
    return line.strip()


# --- the keys ---


def _read_values(source: Source, keys: Mapping[str, tuple[int, str]]) -> dict[str, float]:
    """Values of all keys that have an effect; switches are 0 or 1, factors positive."""
    values = {
        name: number(source, keys[name][0], keys[name][1], name) if name in keys else default
        for name, default in NUMBERS.items()
    }
    for name in ("units.len.f", "units.ang.f"):
        if not values[name] >= 1e-6:
            raise source.wrong(keys[name][0], f"{name} = {keys[name][1]}: must be positive (1000: mm)")
    for name in ("approx.smooth", "point.dist.min"):
        if values[name] < 0:
            raise source.wrong(keys[name][0], f"{name} = {keys[name][1]}: must be 0 or more")
    for name in SWITCHES:
        line, text = keys.get(name, (0, "0"))
        values[name] = number(source, line, text, name)
        if values[name] not in (0, 1):
            raise source.wrong(line, f"{name} = {text}: must be 0 (no) or 1 (yes)")
    return values


# --- what is done with the points ---


def _process(source: Source, rows: Rows, values: Mapping[str, float]) -> tuple[Rows, list[str]]:
    """Processed points, still in the unit of the file, and a note for each step that did something.

    The scale comes last: it changes nothing about the order.
    """
    rows, notes = drop_near(rows, values["point.dist.min"])
    rows, dropped = drop_zigzags(rows)
    notes += dropped
    shift, angle = (values["shift.y"], values["shift.z"]), values["rotate"] / values["units.ang.f"]
    if any(shift):
        rows = rows.moved(rows.points + np.array(shift)[:, None])
        notes.append(f"Shifted by {shift[0]:g} in y and {shift[1]:g} in z (units of the file).")
    if angle:  # about the origin
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        rows = rows.turned(turn)
        notes.append(f"Rotated by {np.degrees(angle):g} degrees from y to z.")
    low, high = values["bound.y.min"], values["bound.y.max"]
    if low < high:
        inside = (rows.points[0] >= low) & (rows.points[0] <= high)
        if not np.any(inside):
            raise source.wrong(int(rows.lines[0]), f"bound.y: no point lies in {low:g} ... {high:g}")
        notes.append(f"{np.sum(~inside)} points outside of y = {low:g} ... {high:g} were deleted (bound.y).")
        rows = rows.only(inside)
    low, high = values["bound.z.min"], values["bound.z.max"]
    if low < high:
        z = np.clip(rows.points[1], low, high)
        clipped = np.sum(z != rows.points[1])
        notes.append(f"{clipped} points were clipped to z = {low:g} ... {high:g} (bound.z).")
        rows = rows.moved(np.stack([rows.points[0], z]))
    for axis, direction in (("y", [-1.0, 1.0]), ("z", [1.0, -1.0])):
        if values[f"mirror.{axis}"]:
            rows = rows.moved(rows.points * np.array(direction)[:, None])
            notes.append(f"{axis} was mirrored (mirror.{axis}).")
    if values["inversion"]:
        rows = rows.only(slice(None, None, -1))
        notes.append("The order was reversed (inversion).")
    return rows, notes


# --- writing ---


def block_text(profile: Profile) -> str:
    """Text of a spline block: in mm, y to the field side, z down, rails by growing y, wheels by falling y."""

    def one_line(text: str) -> str:
        printable = "".join(sign if sign.isprintable() else " " for sign in text)
        return printable.replace("'", "’")

    y, z = profile.points if profile.kind == "rail" else profile.points[:, ::-1]
    comments = (f"{profile.name}: y to the field side, z down", *profile.notes)
    rows = [f"    {a!r} {b!r}" for a, b in zip(y.tolist(), (0.0 - z).tolist(), strict=True)]
    return "\n".join(
        [
            *(f"! {one_line(comment)}" for comment in comments),
            "header.begin",
            "  version = 1",
            f"  type = {int(profile.kind == 'wheel')}",
            "header.end",
            "spline.begin",
            "  approx.smooth = 0",
            f"  comment = '{one_line(profile.name)}'",
            "  units.len.f = 1000",
            "  units.ang.f = 1",
            "  point.begin",
            *rows,
            "  point.end",
            "spline.end",
            "",
        ]
    )
