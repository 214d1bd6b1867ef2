"""The tables [lower] and [upper] of a scene file: contour, outline, material and surface of a body.

Each kind of contour has a table of keys, which makes the contour. To add a kind, write its table, with a key
`kind` and a method `contour`, and register it:

    CONTOURS["parabola"] = Parabola

An outline is the shape and the supports of a section beyond its contour.
"""

from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

import numpy as np
from pydantic import AfterValidator, BaseModel, Field, PlainValidator, model_validator

from femic.key_types import LARGEST_LENGTH, LEAST_LENGTH, Amount, Length, NameOf, Place, Several, TwoOf, Whole
from femic.scenes.errors import BadScene
from femic.scenes.input_files import ExistingFile, Holds, columns
from femic.scenes.profiles import ProfileTable
from femic.scenes.scene_table import SceneTable
from geometries import contours
from geometries.bodies import Body, Domain
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.outlines import RAIL_SECTIONS, SectionOutline
from geometries.surfaces import LOWER

# --- contours -------------------------------------------------------------------------------------------


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

    kind: Literal["arc"] = Field(description="circular arc with straight flanks")
    radius: ArcRadius = Field(description="radius of the arc [mm]; negative: a groove")
    flank_inclination_deg: Flanks = Field(description="inclination of both flanks, or [left, right] [deg]")

    def contour(self) -> Contour:
        """Return the arc with its flanks."""
        return contours.arc(self.radius, *_in_radians(self.flank_inclination_deg))


class EllipseTable(SceneTable):
    """An elliptic arc continued by its tangents."""

    kind: Literal["ellipse"] = Field(description="ellipse with straight flanks")
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
        None, description="text file with two columns y, z [mm], y increasing; # comments"
    )
    points: Several[TwoOf[Place]] = Field(
        (), description="points [[y, z], ...] [mm] instead of a file, y increasing"
    )
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
    """Return the table of a contour, made of the keys of its kind where it is none yet.

    Raises ValidationError.
    """
    if isinstance(value, SceneTable) and isinstance(value, tuple(CONTOURS.values())):
        return value
    return CONTOURS[ContourKind.model_validate(value).kind].model_validate(value)


AnyContour = Annotated[ContourTable, PlainValidator(_table_of_kind), Holds(CONTOURS.values)]


def _in_radians(degrees: float | tuple[float, float]) -> tuple[float, float]:
    """Return the inclinations of the left and the right flank [rad]."""
    left, right = degrees if isinstance(degrees, tuple) else (degrees, degrees)
    return float(np.radians(left)), float(np.radians(right))


# --- outlines -------------------------------------------------------------------------------------------


RailName = Annotated[str, AfterValidator(NameOf(lambda: RAIL_SECTIONS))]
Number = Annotated[Whole, Field(ge=1)]


class OutlineTable(SceneTable):
    """The shape and the supports of a section beyond its contact contour."""

    points: Several[TwoOf[Place]] = Field(
        (),
        description="points [[y, z], ...] [mm] from the end of the contour at s > 0 around the body to "
        "its end at s < 0, in the axes of the contour; with contour.kind = 'profile', in the axes of the "
        "profile",
    )
    file: ExistingFile | None = Field(
        None, description="text file with two columns y, z [mm] instead of points; # comments"
    )
    standard: RailName | None = Field(
        None,
        description="standard rail instead of points: the part below the sides of the head, clamped at "
        "the base of the foot",
    )
    clamped: TwoOf[Number] | None = Field(
        None,
        description="numbers of two points, counted from 1; the edges between them are clamped, all "
        "others are free",
    )

    @model_validator(mode="after")
    def _one_source(self) -> "OutlineTable":
        if (self.file is not None) + bool(self.points) + (self.standard is not None) != 1:
            raise ValueError("give either points, file or standard")
        if (self.clamped is None) == (self.standard is None):
            raise ValueError("give clamped (two numbers) with points or a file, but not with a standard")
        return self

    def outline(self, contour: ContourTable) -> SectionOutline:
        """Return the outline in the axes of a contour; raise WrongInput for one that does not fit it."""
        if self.standard is not None:
            if not isinstance(contour, ProfileTable):
                raise WrongInput(
                    f"outline.standard = {self.standard!r}: its points are in the axes of a profile; give "
                    "contour.kind = 'profile', or points"
                )
            section = RAIL_SECTIONS[self.standard].outline
            return section.at(contour.placed(section.corners))
        assert self.clamped is not None
        try:
            points = np.transpose(self.points if self.file is None else columns(self.file, ("y, z",)))
        except WrongInput as error:
            raise WrongInput(f"outline.file = {self.file}: {error}") from error
        if isinstance(contour, ProfileTable):
            points = contour.placed(points)
        return SectionOutline.through(points, self.clamped)


# --- bodies ---------------------------------------------------------------------------------------------


def _finite_or_prismatic(value: float) -> float:
    """Return a rolling radius; raise ValueError for one that is neither a length nor infinite."""
    if not (value <= LARGEST_LENGTH or value == float("inf")):
        raise ValueError(f"should be at most {LARGEST_LENGTH:g}, or inf for a prismatic body")
    return value


class BodyTable(SceneTable):
    """A body."""

    E: Amount = Field(description="Young's modulus [MPa]")
    nu: float = Field(ge=0, le=0.4999, description="Poisson's ratio, 0 ... 0.4999 (solid engine: 0.49)")
    contour: AnyContour = Field(description="contact contour in (y, z)")
    rolling_radius: Annotated[float, Field(ge=LEAST_LENGTH), AfterValidator(_finite_or_prismatic)] = Field(
        np.inf,
        description="rolling radius at the contact centre [mm]; for C and stresses 20 ... inf (solid "
        "engine: 50 ... inf); inf: prismatic",
    )
    hub_radius: Length | None = Field(
        None,
        description="radius of the clamped hub [mm]; default: 0.2 rolling_radius, the smallest value allowed",
    )
    outline: OutlineTable | None = Field(
        None, description="table with the shape and the supports of the body; default: far arc or hub"
    )

    @property
    def words(self) -> str:
        """The contour in words, for titles: a standard, a file, or a shape with its radius."""
        keys = vars(self.contour)
        if source := keys.get("standard") or keys.get("file"):
            return Path(source).name
        return f"{keys['kind']} of {keys['radius']:g} mm" if "radius" in keys else str(keys["kind"])

    def body(self, name: str, side: int, domain: Domain) -> Body:
        """Return the body; raise BadScene, which has its name, where keys do not fit together."""
        try:
            if isinstance(self.contour, ProfileTable):
                own, other = ("rail", "wheel") if side == LOWER else ("wheel", "rail")
                if self.contour.rail_or_wheel() == other:
                    raise WrongInput(
                        f"contour: profile of a {other}, but this body is the {own}: exchange the profiles"
                    )
                if (turn := self.contour.turn) and np.isfinite(self.rolling_radius):
                    raise WrongInput(
                        f"contour: turned by {np.degrees(turn):.4g} degrees; the axis of a body of "
                        "revolution stays along y: leave out rail_inclination and turn_deg, and turn the "
                        "other body"
                    )
            return Body(
                side,
                self.contour.contour(),
                Material(self.E, self.nu),
                domain,
                self.rolling_radius,
                self.hub_radius,
                self.outline.outline(self.contour) if self.outline else None,
            )
        except WrongInput as error:
            raise BadScene(f"{name}.{error}") from error
