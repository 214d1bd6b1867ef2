"""Profiles of the package by name: standard ones, exact, and worn ones, from files of the package.

To add a standard profile from its published definition, write its pieces in the axes of profiles (y to the
field side, z up) and register it:

    STANDARDS["name"] = Standard("rail", "title", "source", pieces)

What is here has been checked by what its definition leaves over: radii, joints, widths and heights of a
standard are more numbers than its shape has freedoms.

To add a worn one, put its file (`.prr`, `.prw`) into `worn` and register it:

    WORN["name"] = Worn("rail", "title", "source", "name.prr")
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.pieces import (
    ArcPiece,
    Outline,
    Piece,
    PolynomialPiece,
    arc_above,
    arc_below,
    line,
)
from geometries.profiles.preparation import Prepared, prepare
from geometries.profiles.profile import Kind, Profile

# --- standard profiles ---

FLANGE_SLOPE = 2.747477419  # of the flange face of EN 13715, tan 70 degrees
FLANGE_HEIGHT_AT_0 = 93.576667419  # z [mm] of the line of the flange face at y = 0
FACE_START, FACE_END = -39.764473993, -38.426669071  # y [mm] between which the face is straight
SIDE_SLOPE = 1 / 20  # of the sides of rail heads, y by z


@dataclass(frozen=True)
class Standard:
    """A standard profile: what it is, where it is defined, and its exact pieces in the axes of profiles.

    The origin of a rail is the top of its head, that of a wheel its running circle, 70 mm from the back of
    the flange.
    """

    kind: Kind
    title: str
    source: str
    pieces: Callable[[], tuple[Piece, ...]]

    @property
    def outline(self) -> Outline:
        """The exact curve."""
        return Outline(self.pieces())

    @property
    def origin(self) -> str:
        """A sentence about what the curve is."""
        return f"{self.title}; from {self.source}, exact."


def standard(name: str) -> Standard:
    """Return a standard profile by its name in `STANDARDS`; raise WrongInput."""
    if name not in STANDARDS:
        raise WrongInput(f"profile {name!r}: not among the standard ones, {', '.join(STANDARDS)}")
    return STANDARDS[name]


def standard_profile(name: str, spacing: float = 0.1) -> Profile:
    """Return points of a standard profile, at most `spacing` [mm] apart, each joint among them.

    Raises WrongInput.
    """
    if not 0 < spacing < np.inf:
        raise WrongInput(f"spacing = {spacing!r}: must be a positive length [mm]")
    entry = standard(name)
    notes = (f"From the definition: {entry.source}; points at most {spacing:g} mm apart.",)
    return Profile(entry.kind, entry.outline.sampled(spacing), name, notes)


@dataclass(frozen=True)
class RailHead:
    """A symmetric rail head: three arcs, tangent to each other, and a side of 1:20.

    `radii` [mm] are those of the crown, of the shoulder and of the corner; the first two arcs end at the
    lateral positions `joints` [mm], the corner where it has the slope of the side, and the side ends at the
    height `end` [mm], above the rounding of its lower edge.
    """

    radii: tuple[float, float, float]
    joints: tuple[float, float]
    end: float

    def pieces(self) -> tuple[Piece, ...]:
        """Return the pieces from the gauge side to the field side."""
        arcs: list[ArcPiece] = []
        place, inclination = (0.0, 0.0), 0.0
        for radius, end in zip(self.radii, self.inclinations, strict=True):
            arcs.append(ArcPiece(place, inclination, 1 / radius, radius * (end - inclination)))
            y, z = arcs[-1].position(np.array(arcs[-1].length))
            place, inclination = (float(y), float(z)), end
        side = line(place, (place[0] + SIDE_SLOPE * (place[1] - self.end), self.end))
        right = (*arcs[1:], side)
        crown = arc_above((0.0, -self.radii[0]), self.radii[0], (-self.joints[0], self.joints[0]))
        return (*(piece.mirrored for piece in right[::-1]), crown, *right)

    @property
    def inclinations(self) -> tuple[float, float, float]:
        """Inclinations [rad] at which the arcs end, towards the field side."""
        crown = np.arcsin(self.joints[0] / self.radii[0])
        centre = self.joints[0] - self.radii[1] * np.sin(crown)  # of the shoulder, y [mm]
        shoulder = np.arcsin((self.joints[1] - centre) / self.radii[1])
        return float(crown), float(shoulder), float(np.pi / 2 - np.arctan(SIDE_SLOPE))


# EN 13715, S1002: coefficients by rising powers of y, with z downwards as there
ZONE_B = (
    0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8,
    -1.562379023e-8, 5.309217349e-15, -5.957839843e-12, 2.646656573e-13,
)  # fmt: skip
ZONE_C = (
    -4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875,
    -2.054332446e-1, -4.169739389e-3, -4.687195829e-5, -2.252755540e-7,
)  # fmt: skip


def s1002() -> tuple[Piece, ...]:
    """Return zones H to A of wheel S1002."""
    tread = [1.364323640 - 0.066666667 * y for y in (32.15796, 60.0)]
    return (
        *flange(),
        arc_above((-26.210665, -16.446), 13.0, (FACE_END, -35.0)),  # D
        PolynomialPiece(upwards(ZONE_C), (-35.0, -26.0)),
        PolynomialPiece(upwards(ZONE_B), (-26.0, 32.15796)),
        line((32.15796, -tread[0]), (60.0, -tread[1])),  # A
    )


def flange() -> tuple[Piece, ...]:
    """Return zones H, G, F and E, the flange of EN 13715 with a height of 28 mm."""
    return (
        arc_below((-49.5, -9.519259302), 20.5, (-70.0, -62.764705882)),  # H
        arc_below((-55.0, -16.0), 12.0, (-62.764705882, -49.662510381)),  # G
        arc_below((-58.558326413, -8.834924130), 20.0, (-49.662510381, FACE_START)),  # F
        line((FACE_START, face_height(FACE_START)), (FACE_END, face_height(FACE_END))),  # E
    )


def face_height(y: float) -> float:
    """Return z [mm] of the flange face at a lateral position [mm]."""
    return FLANGE_HEIGHT_AT_0 + FLANGE_SLOPE * y


def upwards(coefficients: tuple[float, ...]) -> tuple[float, ...]:
    """Return the coefficients of a polynomial with z upwards."""
    return tuple(-value for value in coefficients)


def cone(slope: float) -> tuple[Piece, ...]:
    """Return a conical tread of a `slope`, with the flange of S1002 and a root radius of 13 mm.

    The arc of the root is tangent to the flange face and to the tread, which runs through the origin.
    """
    root, flange_length, tread_length = 13.0, np.hypot(1, FLANGE_SLOPE), np.hypot(1, slope)
    y = (root * (flange_length - tread_length) - FLANGE_HEIGHT_AT_0) / (FLANGE_SLOPE - slope)
    centre = (float(y), float(slope * y - root * tread_length))
    ends = (
        float(y - root * FLANGE_SLOPE / flange_length),
        float(y - root * slope / tread_length),
    )
    *tip, _ = flange()
    return (
        *tip,
        line((FACE_START, face_height(FACE_START)), (ends[0], face_height(ends[0]))),
        arc_above(centre, root, ends),
        line((ends[1], slope * ends[1]), (60.0, slope * 60.0)),
    )


EN_13674 = "EN 13674-1 (earlier UIC 860)"
IDEAL = "no standard: a cone through the running circle, a root of radius 13 mm, and the flange of EN 13715"
UIC_60 = RailHead((300.0, 80.0, 13.0), (20.456 / 2, 52.053 / 2), -34.0)
UIC_54 = RailHead((300.0, 80.0, 13.0), (20.024 / 2, 49.727 / 2), -33.0)
CHINESE_60 = RailHead((300.0, 80.0, 13.0), (20.0 / 2, 50.7 / 2), -33.0)
STANDARDS: dict[str, Standard] = {
    "S1002": Standard(
        "wheel", "wheel S1002, flange 28 mm high and 32.5 mm thick", "EN 13715, zones A to H", s1002
    ),
    "60E1": Standard("rail", "rail 60E1 (UIC 60)", EN_13674, UIC_60.pieces),
    "54E1": Standard("rail", "rail 54E1 (UIC 54)", EN_13674, UIC_54.pieces),
    "CHN60": Standard(
        "rail", "rail CHN60 (60 kg/m)", "GB/T 2585, whose joints are given to 0.1 mm", CHINESE_60.pieces
    ),
    "cone-1-20": Standard("wheel", "ideal wheel with a cone of 1:20", IDEAL, partial(cone, 1 / 20)),
    "cone-1-40": Standard("wheel", "ideal wheel with a cone of 1:40", IDEAL, partial(cone, 1 / 40)),
}


# --- worn profiles ---

FOLDER = Path(__file__).parent / "worn"
LAW = "the law in docs/theory/wheel-on-rail.md"


@dataclass(frozen=True)
class Worn:
    """A worn profile: what it is, where it comes from, and its file in the package.

    Its origin is that of the standard profile that was worn.
    """

    kind: Kind
    title: str
    source: str
    file: str

    @property
    def path(self) -> Path:
        """Path of the file."""
        return FOLDER / self.file

    @cached_property
    def outline(self) -> Prepared:
        """The curve through the points of the file."""
        return prepare(read_profile(self.path))

    @property
    def origin(self) -> str:
        """A sentence about what the curve is."""
        return f"{self.title}; {self.source}; a spline through points 0.2 mm apart."


WORN: Mapping[str, Worn] = MappingProxyType(
    {
        "S1002-worn": Worn(
            "wheel", "wheel S1002, worn by rail 60E1", f"worn from S1002 by {LAW}", "S1002-worn.prw"
        ),
        "60E1-worn": Worn(
            "rail", "rail 60E1, worn by wheel S1002", f"worn from 60E1 by {LAW}", "60E1-worn.prr"
        ),
    }
)


# --- all by name ---

NAMED: Mapping[str, Standard | Worn] = MappingProxyType({**STANDARDS, **WORN})


def named(name: str) -> Standard | Worn:
    """Return a profile of the package by its name in `NAMED`; raise WrongInput."""
    if name not in NAMED:
        raise WrongInput(f"profile {name!r}: not among those of the package, {', '.join(NAMED)}")
    return NAMED[name]
