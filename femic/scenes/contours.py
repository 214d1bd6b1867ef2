"""Contours in a scene file: a table of keys for each kind, which makes the contour.

To add a kind, write its table, with a key `kind` and a method `contour`, and register it:

    CONTOURS["parabola"] = Parabola
"""

from typing import Annotated, Any, Literal, Protocol

import numpy as np
from pydantic import AfterValidator, BaseModel, Field, PlainValidator, model_validator

from femic.key_types import LARGEST_LENGTH, LEAST_LENGTH, Length, NameOf, Place, Several, TwoOf
from femic.scenes.columns import columns
from femic.scenes.input_files import ExistingFile, Holds
from femic.scenes.profiles import ProfileTable
from femic.scenes.scene_table import SceneTable
from geometries import contours
from geometries.contours import Contour
from geometries.errors import WrongInput


class ContourTable(Protocol):
    """The keys of a kind of contour."""

    def contour(self) -> Contour:
        """Return the contour; raise WrongInput for keys that do not fit together."""


def _radius(value: float) -> float:
    """Return the radius of an arc; raise ValueError unless its amount is a length."""
    if not LEAST_LENGTH <= abs(value) <= LARGEST_LENGTH:
        raise ValueError(f"its amount should be {LEAST_LENGTH:g} ... {LARGEST_LENGTH:g}")
    return value


ArcRadius = Annotated[float, AfterValidator(_radius)]
Flank = Annotated[float, Field(ge=0, le=85)]
Flanks = Flank | TwoOf[Flank]


class PlaneTable(SceneTable):
    """A flat surface."""

    kind: Literal["plane"] = Field(description="a plane")

    def contour(self) -> Contour:
        """Return the plane."""
        return contours.plane()


class ArcTable(SceneTable):
    """A circular arc continued by its tangents."""

    kind: Literal["arc"] = Field(description="circular arc + straight flanks")
    radius: ArcRadius = Field(description="radius of the arc [mm]; negative: a groove")
    flank_inclination_deg: Flanks = Field(description="inclination of both flanks, or [left, right] [deg]")

    def contour(self) -> Contour:
        """Return the arc with its flanks."""
        return contours.arc(self.radius, *_in_radians(self.flank_inclination_deg))


class EllipseTable(SceneTable):
    """An elliptic arc continued by its tangents."""

    kind: Literal["ellipse"] = Field(description="ellipse + straight flanks")
    b_el: Length = Field(description="lateral semi-axis [mm]")
    d_el: Length = Field(description="vertical semi-axis [mm]")
    flank_inclination_deg: Flanks = Field(
        75.0, description="inclination of both flanks, or [left, right] [deg]"
    )

    def contour(self) -> Contour:
        """Return the ellipse with its flanks."""
        return contours.ellipse(self.b_el, self.d_el, *_in_radians(self.flank_inclination_deg))


class PointsTable(SceneTable):
    """A smooth curve through points, continued by its end tangents."""

    kind: Literal["points"] = Field(description="smooth curve through points")
    file: ExistingFile | None = Field(
        None, description="text file of two columns y, z [mm], y growing; # comments"
    )
    points: Several[TwoOf[Place]] = Field((), description="instead of a file: [[y, z], ...] [mm], y growing")
    y_centre: Place = Field(0.0, description="y of the contact centre [mm]")

    @model_validator(mode="after")
    def _one_source(self) -> "PointsTable":
        if (self.file is None) == (not self.points):
            raise ValueError("give either file or points")
        return self

    def contour(self) -> Contour:
        """Return the curve; raise WrongInput for points that have none through them."""
        try:
            y, z = np.transpose(self.points if self.file is None else columns(self.file, ("y, z",)))
            return contours.through_points(y, z, self.y_centre)
        except WrongInput as error:
            source = "contour.points" if self.file is None else f"contour.file = {self.file}"
            raise WrongInput(f"{source}: {error}") from error


CONTOURS: dict[str, type[SceneTable]] = {
    "plane": PlaneTable,
    "arc": ArcTable,
    "ellipse": EllipseTable,
    "points": PointsTable,
    "profile": ProfileTable,
}


class ContourKind(BaseModel):
    """The kind of a contour, which has further keys."""

    kind: Annotated[str, AfterValidator(NameOf(lambda: CONTOURS))]


def _table_of_kind(value: Any) -> SceneTable:
    """Return the table of a contour with the keys of its kind; raise ValidationError."""
    return CONTOURS[ContourKind.model_validate(value).kind].model_validate(value)


AnyContour = Annotated[ContourTable, PlainValidator(_table_of_kind), Holds(CONTOURS.values)]


def _in_radians(degrees: float | tuple[float, float]) -> tuple[float, float]:
    """Return the inclinations of the left and the right flank [rad]."""
    left, right = degrees if isinstance(degrees, tuple) else (degrees, degrees)
    return float(np.radians(left)), float(np.radians(right))
