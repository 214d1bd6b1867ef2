"""A section of a rail or a wheel as points, in the axes that all profiles have here."""

from dataclasses import dataclass
from typing import Literal

from geometries.arrays import Array

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
