"""Profiles: sections of rails and wheels as points, in the axes that all profiles have here.

`Content` is what a file of a profile says: its points, and what its format or header states about them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from geometries.arrays import Array
from geometries.profiles.text import (
    MAX_POINTS,
    Rows,
    Source,
    as_float,
    is_number,
    number,
    shortened,
    split_columns,
    steps_as_written,
)

# --- profiles ---

Kind = Literal["rail", "wheel"]


@dataclass(frozen=True, eq=False)
class Profile:
    """Points (y, z) of a running surface [mm], shape (2, n), and how they were understood.

    y grows to the field side and z upwards, for rails and for wheels: a wheel's flange is at small y and
    hangs down to small z. Points go along the surface from the gauge side (flange) to the field side; y may
    fall where a face is undercut. Sections of the left side are mirrored. The origin is that of the source.

    `notes` are sentences about what was done to the points of the source: units, axes, points left out.
    `steps` are those of the last decimals [mm] with which y and z were written, (2, n), 0 where they are
    exact; None where the points come from no file.
    """

    kind: Kind
    points: Array
    name: str = ""
    notes: tuple[str, ...] = ()
    steps: Array | None = None


# --- what files say ---

Written = tuple[str, str]  # y and z of a point
Side = Literal["field", "centre"]
Height = Literal["up", "down"]

UNITS: Mapping[str, float] = MappingProxyType({"mm": 1.0, "m": 1000.0, "inch": 25.4})  # [mm]
RAIL_ENDINGS = (".prr", ".ban", ".rail", ".slcs")
WHEEL_ENDINGS = (".prw", ".whl", ".wheel", ".slcw")


@dataclass(frozen=True, eq=False)
class Content:
    """Points of a file in its own axes and unit; None for what the file leaves open.

    `unit` is the length of one unit [mm], by a key of the file (`unit_is_key`) or by its format; `y` is the
    side to which y grows and `z` where z points, both by the format.
    """

    rows: Rows
    kind: Kind | None = None
    unit: float | None = None
    unit_is_key: bool = False
    y: Side | None = None
    z: Height | None = None
    notes: tuple[str, ...] = ()


def kind_by_name(source: Source) -> Kind | None:
    """Kind by the ending of the file's name, or None."""
    ending = source.path.suffix.lower()
    if ending in RAIL_ENDINGS:
        return "rail"
    return "wheel" if ending in WHEEL_ENDINGS else None


def parse_rows(source: Source, points: list[Written], lines: list[int]) -> Rows:
    """Rows from points as written. Raises WrongInput for none and for too many."""
    if not points:
        raise source.wrong(len(source.lines), "no points up to the end of the file; is it cut off?")
    if len(points) > MAX_POINTS:
        raise source.wrong(
            lines[MAX_POINTS], f"more than {MAX_POINTS} points; thin them out: one per 0.1 mm is plenty"
        )
    y, z = zip(*points, strict=True)
    coordinates = np.array([[as_float(token) for token in axis] for axis in (y, z)])
    steps = np.stack(
        [steps_as_written(axis, values) for axis, values in zip((y, z), coordinates, strict=True)]
    )
    return Rows(coordinates, np.array(lines), steps)


def row(source: Source, line: int, text: str, counts: range) -> list[str]:
    """Fields of a row. Raises WrongInput for another count than `counts`, and for text from the third on."""
    fields = split_columns(source, line, text)
    if len(fields) not in counts:
        expected = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
        raise source.wrong(
            line,
            f"{shortened(text)}: {len(fields)} columns, {expected} expected; correct the row",
        )
    if not all(is_number(field) for field in fields[2:]):
        raise source.wrong(line, f"{shortened(text)}: all of its {len(fields)} columns must be numbers")
    return fields


def point(source: Source, line: int, y: str, z: str) -> Written:
    """Coordinates of a point as written. Raises WrongInput where they are no numbers."""
    number(source, line, y, "y")
    number(source, line, z, "z")
    return y, z


def only_numbers(text: str) -> bool:
    """Whether a line consists of two numbers or more and of nothing else."""
    fields = text.replace(",", " ").replace(";", " ").split()
    return len(fields) >= 2 and all(is_number(field) for field in fields)
