"""What is to be compared: bodies, patch, lines, and how C is to be computed."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from approx.effective import EffectiveProperties
from approx.pair import Pair, Solid
from femic.job import Settings
from femic.meshing.cell_size import Cells
from geometries.bodies import Body
from geometries.grids import Grid
from geometries.patches import OffsetLine, Patch


@dataclass(frozen=True)
class Calibration:
    """What effective properties are fitted to: components of C at the points of lines, x_min < x <= x_max."""

    bodies: tuple[str, ...]  # of "combined", "lower", "upper"
    properties: tuple[str, ...]  # of EffectiveProperties
    components: tuple[str, ...]
    curvature_apart: bool  # whether the combined properties leave out the curvature of wheels
    x_min: float  # mm
    x_max: float
    lines: tuple[OffsetLine, ...]
    logarithmic: bool  # whether each octave of the distance counts alike, else each point


@dataclass(frozen=True)
class Scene:
    """A validated scene in terms of `geometries`."""

    name: str
    title: str
    text: str  # the TOML it came from
    files: Mapping[str, Path]  # of points, of the bodies whose contours have one
    bodies: Mapping[str, Body]  # "lower", "upper"
    compared: tuple[str, ...]  # of "combined", "lower", "upper"
    components: tuple[str, ...]
    variants: tuple[str, ...]
    effective: Mapping[str, EffectiveProperties]  # of "combined", "lower", "upper", where given
    curvature_apart: bool  # whether those of "combined" leave out the curvature of wheels
    calibration: Calibration
    patch: Patch
    lines: tuple[OffsetLine, ...]
    grid: Grid
    checked_strips: int  # how many of its columns the solid engine computes, too
    settings: Settings  # of C
    reference_length: float  # mm
    fields: bool
    ics: str  # "C", a variant, or "auto"
    ics_tolerance: float  # largest error where they are chosen
    check: "Scene | None" = None  # the same scene by the solid engine, whose C is to be drawn beside

    @property
    def first_cells(self) -> Cells:
        """The cells that C starts with."""
        return self.settings.first_cells(self.patch)

    @property
    def solved(self) -> tuple[str, ...]:
        """Names of the bodies whose reference ICs the comparison needs."""
        return tuple(name for name in self.bodies if name in self.compared or "combined" in self.compared)

    @property
    def pair(self) -> Pair:
        """The bodies as approximations see them."""
        lower, upper = (
            Solid(body.material, body.surface, self.effective.get(name))
            for name, body in ((name, self.bodies[name]) for name in ("lower", "upper"))
        )
        return Pair(upper, lower, self.effective.get("combined"), self.curvature_apart)

    @property
    def reference_E(self) -> float:
        """Young's modulus that makes ICs dimensionless [MPa]: the lower body's."""
        return self.bodies["lower"].material.E
