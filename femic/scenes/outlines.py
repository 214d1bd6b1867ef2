"""Outlines of bodies in a scene file: the shape and the supports of a section beyond its contour."""

from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from femic.key_types import NameOf, Place, Several, TwoOf, Whole
from femic.scenes.columns import columns
from femic.scenes.contours import ContourTable
from femic.scenes.input_files import ExistingFile
from femic.scenes.profiles import ProfileTable
from femic.scenes.scene_table import SceneTable
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.outlines import SectionOutline
from geometries.rail_sections import RAIL_SECTIONS

RailName = Annotated[str, AfterValidator(NameOf(lambda: RAIL_SECTIONS))]
Number = Annotated[Whole, Field(ge=1)]


class OutlineTable(SceneTable):
    """The shape and the supports of a section beyond its contact contour."""

    points: Several[TwoOf[Place]] = Field(
        (),
        description="[[y, z], ...] [mm] from the contour's end at s > 0 round the body to its end at s < 0, "
        "in the axes of the contour, those of the profile with contour.kind = 'profile'",
    )
    file: ExistingFile | None = Field(
        None, description="instead of points: text file of two columns y, z [mm]; # comments"
    )
    standard: RailName | None = Field(
        None,
        description="instead of points: a rail below the sides of its head, clamped at the base of its foot",
    )
    clamped: TwoOf[Number] | None = Field(
        None,
        description="numbers of two of the points, counted from 1: the edges between them are clamped, the "
        "others are free",
    )

    @model_validator(mode="after")
    def _one_source(self) -> "OutlineTable":
        if (self.file is not None) + bool(self.points) + (self.standard is not None) != 1:
            raise ValueError("give either points, file or standard")
        if (self.clamped is None) == (self.standard is None):
            raise ValueError("give clamped, two numbers, with points or a file; a standard has its own")
        return self

    def outline(self, contour: ContourTable) -> SectionOutline:
        """Return the outline in the axes of a contour; raise WrongInput for one that does not fit it."""
        if self.standard is not None:
            if not isinstance(contour, ProfileTable):
                raise WrongInput(
                    f"outline.standard = {self.standard!r}: is in the axes of a profile: give "
                    "contour.kind = 'profile', or the points"
                )
            section = RAIL_SECTIONS[self.standard].outline
            return section.at(contour.placed(section.corners))
        assert self.clamped is not None
        points = self._points()
        if isinstance(contour, ProfileTable):
            points = contour.placed(points)
        return SectionOutline.of(points, self.clamped)

    def _points(self) -> Array:
        """Return the points as given, (2, n) [mm]; raise WrongInput for a file without."""
        if self.file is None:
            return np.array(self.points).T
        try:
            return columns(self.file, ("y, z",)).T
        except WrongInput as error:
            raise WrongInput(f"outline.file = {self.file}: {error}") from error
