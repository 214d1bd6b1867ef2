"""Profiles of rails and wheels in a scene file: a file or a standard, its contact centre and its turn."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from femic.key_types import LARGEST_LENGTH, NameOf, Place, Whole
from femic.scenes.input_files import ExistingFile
from femic.scenes.scene_table import SceneTable
from geometries.arrays import Array
from geometries.contours import Contour
from geometries.errors import Failure, WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.pieces import Outline
from geometries.profiles.placement import arc_length_at, spline_contour
from geometries.profiles.preparation import Prepared, prepare
from geometries.profiles.profile import UNITS, Kind
from geometries.profiles.sections import LISTS, SectionChoice, read_section
from geometries.profiles.standards import NAMED, named

Unit = Annotated[str, AfterValidator(NameOf(lambda: UNITS))]
StandardName = Annotated[str, AfterValidator(NameOf(lambda: NAMED))]
Tolerance = Annotated[float, Field(ge=0, le=1)] | Literal["cross-validation"]
OF_FILES = ("profile_kind", "axes", "unit", "surface", "section", "section_at", "tolerance")  # keys
READ = 8  # files that are kept
NO_SECTION = SectionChoice()  # of a file that is no list
KIND = re.compile(r"\bkind\b")  # an argument; as a key it says what a contour is
ARGUMENTS = {  # by which functions ask for a place
    "turn the contour (turn)": "turn the section (turn_deg)",
    "give the arc length of the contact centre": "give s_centre instead, one of them",
}


class ProfileTable(SceneTable):
    """A profile of a rail or a wheel."""

    kind: Literal["profile"] = Field(
        description="profile of a rail or wheel, with y to the field side and z up"
    )
    file: ExistingFile | None = Field(
        None, description="file of the profile (docs/reference/profiles.md has the formats)"
    )
    standard: StandardName | None = Field(
        None,
        description="built-in profile instead of a file (femic profiles lists them)",
    )
    profile_kind: Kind | None = Field(None, description="rail or wheel, if the file does not state it")
    axes: str | None = Field(
        None,
        description="directions of y and z in the file: field or centre (of the track), up or down, or "
        "one of each, such as 'centre down'; needed if the file does not show them",
    )
    unit: Unit | None = Field(None, description="unit of the file, if the file does not state it")
    surface: Annotated[Whole, Field(ge=1)] | None = Field(
        None, description="number of the running surface, if the file has several"
    )
    section: Annotated[Whole, Field(ge=1)] | None = Field(
        None, description="number of the section, counted from 1, for a list of sections (.slcs, .slcw)"
    )
    section_at: float | None = Field(
        None, description="position of the section instead of its number, in the unit of the list"
    )
    tolerance: Tolerance = Field(
        0.0,
        description="smoothing: rms distance of the points from the curve [mm], or 'cross-validation' to "
        "find it; 0: the curve passes through all points, including their errors",
    )
    y_centre: Place | None = Field(
        None, description="y of the contact centre [mm], in the axes of the profile before rotation"
    )
    s_centre: Annotated[float, Field(gt=0, le=LARGEST_LENGTH)] | None = Field(
        None,
        description="arc length of the contact centre from the gauge-side end of the profile [mm], "
        "instead of y_centre",
    )
    rail_inclination: Annotated[float, Field(gt=-0.5, lt=0.5)] = Field(
        0.0,
        description="inclination of the rail towards the track centre, 0.025 for 1:40; the section turns "
        "about its contact centre with the field side up; 0 if the points are already inclined",
    )
    turn_deg: Annotated[float, Field(ge=-90, le=90)] = Field(
        0.0,
        description="further rotation of the section [deg], positive from y to z (field side up); not "
        "possible with a rolling_radius",
    )
    steepest_deg: Annotated[float, Field(gt=0, le=85)] = Field(
        85.0,
        description="largest inclination [deg]; where the contour is steeper it continues along its "
        "tangent (solid engine: 75)",
    )

    @model_validator(mode="after")
    def _consistent(self) -> "ProfileTable":
        if (self.file is None) == (self.standard is None):
            raise ValueError("give either file or standard")
        if (self.y_centre is None) == (self.s_centre is None):
            raise ValueError(
                "give either y_centre or s_centre: where on the profile the contact centre is [mm]"
            )
        of_files = [key for key in OF_FILES if key in self.model_fields_set]
        if self.standard is not None and of_files:
            raise ValueError(f"{', '.join(of_files)}: only of a file, not of a standard: leave it out")
        return self

    @property
    def turn(self) -> float:
        """Turn of the section [rad], from y to z."""
        return float(np.arctan(self.rail_inclination) + np.radians(self.turn_deg))

    def rail_or_wheel(self) -> Kind:
        """Return whether it is a rail or a wheel; raise WrongInput for a file that cannot be read."""
        return named(self.standard).kind if self.standard is not None else self._prepared().kind

    def contour(self) -> Contour:
        """Return the contour at the contact centre; raise WrongInput for files and keys that have none."""
        steepest = float(np.radians(self.steepest_deg))
        with self._at_centre() as (curve, centre):
            return spline_contour(curve, centre, turn=self.turn, steepest=steepest)

    def placed(self, points: Array) -> Array:
        """Return points (2, n) [mm], given in the axes of the profile, in those of the contour."""
        cos, sin = np.cos(self.turn), np.sin(self.turn)
        with self._at_centre() as (curve, centre):
            origin = curve.position(np.array(centre))
        return np.array([[cos, -sin], [sin, cos]]) @ (points - origin[:, None])

    @contextmanager
    def _at_centre(self) -> "Iterator[tuple[Prepared | Outline, float]]":
        """A context with the curve, in its axes, and the arc length of the contact centre on it [mm].

        Messages in it have the keys of a contour in place of the arguments of functions.
        """
        curve = named(self.standard).outline if self.standard is not None else self._prepared()
        by_y = self.y_centre is not None
        key = f"y_centre = {self.y_centre}" if by_y else f"s_centre = {self.s_centre}"
        try:
            centre = self.s_centre if self.y_centre is None else arc_length_at(curve, self.y_centre)
            assert centre is not None
            yield curve, centre
        except WrongInput as error:
            _, _, reason = str(error).partition(": ")
            for argument, own in ARGUMENTS.items():
                reason = reason.replace(argument, own)
            raise WrongInput(f"contour.{key}: {reason}") from error

    def _prepared(self) -> Prepared:
        """Return the smooth curve of the file; raise WrongInput with the keys to add."""
        assert self.file is not None
        choice = SectionChoice(self.section, self.section_at)
        reading = Reading(self.profile_kind, self.axes, self.unit, self.surface, self.tolerance, choice)
        try:
            return prepared_file(self.file, reading)
        except WrongInput as error:
            path, separator, reason = str(error).partition(": ")
            text = f"contour.file = {path}{separator}{KIND.sub('profile_kind', reason)}"
            raise WrongInput(text) from error


@dataclass(frozen=True)
class Reading:
    """How a file is read and smoothed: the arguments of `read_profile`, `read_section` and `prepare`."""

    kind: Kind | None = None
    axes: str | None = None
    unit: str | None = None
    surface: int | None = None
    tolerance: float | Literal["cross-validation"] = 0.0
    section: SectionChoice = NO_SECTION


def prepared_file(path: Path, reading: Reading) -> Prepared:
    """Return the smooth curve of a file; raise WrongInput, with the path, where there is none.

    A file is read again where it has changed. Of a list of sections the profiles may have, and not the list.
    """
    try:
        stat = None if path.suffix.lower() in LISTS else path.stat()
    except OSError:
        stat = None  # reading it says why
    if stat is None:
        return _prepare.__wrapped__(path, reading, ())
    return _prepare(path, reading, (path.resolve(), stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=READ)
def _prepare(path: Path, reading: Reading, seen: tuple[object, ...]) -> Prepared:  # noqa: ARG001
    """Return the smooth curve of a file, or of a section of a list; `seen`: which file, its time and size."""
    kind, section, lists = reading.kind, reading.section, ", ".join(LISTS)
    options = {"axes": reading.axes, "unit": reading.unit}
    if path.suffix.lower() in LISTS:
        profile = read_section(path, section, **options, surface=reading.surface)
        if kind not in {None, profile.kind}:
            raise WrongInput(f"{path}: kind = '{kind}': it is a list of {profile.kind}s; leave it out")
    elif section != NO_SECTION:
        raise WrongInput(f"{path}: section and section_at are of lists of sections ({lists})")
    else:
        profile = read_profile(path, kind, **options, surface=reading.surface)
    try:
        return prepare(profile, reading.tolerance)
    except (WrongInput, Failure) as error:
        raise WrongInput(f"{path}: {error}") from error
