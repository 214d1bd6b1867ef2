"""The scene: bodies, patch, lines, what is compared, and how C is computed."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from approx.effective import EffectiveProperties
from approx.pair import Pair, Solid
from femic.contact.extra_gap import ExtraGap
from femic.reference.job import Settings
from femic.reference.matrix.job import Discount
from femic.reference.meshing.cell_size import Cells
from geometries.bodies import Body
from geometries.grids import Grid
from geometries.patches import OffsetLine, Patch


@dataclass(frozen=True)
class Calibration:
    """How effective properties are fitted: to components of C at the points of lines, x_min < x <= x_max."""

    bodies: tuple[str, ...]  # of "combined", "lower", "upper"
    properties: tuple[str, ...]  # of EffectiveProperties
    components: tuple[str, ...]
    curvature_apart: bool  # whether the combined properties leave out the curvature of wheels
    x_min: float  # mm
    x_max: float  # mm
    lines: tuple[OffsetLine, ...]
    logarithmic: bool  # whether each octave of the distance has the same weight; otherwise each point has


@dataclass(frozen=True)
class FrictionWanted:
    """Which motion with friction is solved."""

    motion: str  # "rolling" or "compression"
    coefficients: tuple[float, ...]
    longitudinal: tuple[float, ...]  # creepages, growing
    lateral: float
    spin: float  # 1/mm
    equal_force: float  # F_x over friction times load at which tractions are compared


@dataclass(frozen=True)
class ContactWanted:
    """Which contact is solved, with which ICs."""

    loads: tuple[float, ...]  # N
    approaches: tuple[float, ...]  # mm, where no loads are given
    ics: tuple[str, ...]  # "C" or names of variants
    shift: float  # of the upper body along y [mm]
    flanks: bool  # whether the bodies may touch on the straight flanks
    exact: bool  # whether the undeformed distance is that of the displaced body, not linearised
    extra_gap: ExtraGap | None  # that is added
    elements: int  # across the smallest patch on an automatic grid
    automatic: bool  # whether the grid is; otherwise it is that of the scene
    shape_load: float | None  # load whose pressures are mapped onto all patches [N]
    lateral_force: float | None = None  # on the upper body [N]; None: its position is given
    supports: bool = True  # whether what supports do to the contact is computed
    friction: FrictionWanted | None = None  # None: without friction

    @property
    def motion(self) -> str:
        """The motion: none, rolling or compression."""
        return self.friction.motion if self.friction else "none"


@dataclass(frozen=True)
class Scene:
    """A validated scene in terms of `geometries`."""

    name: str
    title: str
    text: str  # TOML
    files: Mapping[str, Path]  # files of contour points by body, where a contour has one
    bodies: Mapping[str, Body]  # "lower", "upper"
    compared: tuple[str, ...]  # of "combined", "lower", "upper"
    components: tuple[str, ...]
    variants: tuple[str, ...]
    effective: Mapping[str, EffectiveProperties]  # of "combined", "lower", "upper", where given
    curvature_apart: bool  # whether the properties of "combined" leave out the curvature of wheels
    calibration: Calibration
    patch: Patch
    lines: tuple[OffsetLine, ...]
    grid: Grid
    checked_strips: int  # how many columns of its IC matrix the solid engine computes, too
    contact: ContactWanted
    discount: Discount  # of IC matrices and contact
    support_radius: float  # of the far arc of the bodies of these [mm]
    settings: Settings  # of C
    reference_length: float  # mm
    fields: bool  # whether displacements and stresses are written
    ics: str  # ICs to use: "C", a variant, or "auto"
    ics_tolerance: float  # largest error of the ICs where they are chosen by "auto"
    check: "Scene | None" = None  # the same scene by the solid engine, whose C is drawn beside C

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths [mm] as far as both contours go."""
        return common_extent(self.bodies)

    @property
    def first_cells(self) -> Cells:
        """The cells of the first model of C."""
        return self.settings.first_cells(self.patch)

    @property
    def solved(self) -> tuple[str, ...]:
        """Names of the bodies whose reference ICs the comparison needs."""
        return tuple(name for name in self.bodies if name in self.compared or "combined" in self.compared)

    @property
    def pair(self) -> Pair:
        """Both bodies as the approximations take them."""
        lower, upper = (
            Solid(body.material, body.surface, self.effective.get(name))
            for name, body in ((name, self.bodies[name]) for name in ("lower", "upper"))
        )
        return Pair(upper, lower, self.effective.get("combined"), self.curvature_apart)

    @property
    def fitted(self) -> tuple[str, ...]:
        """Names of what is compared that has effective properties, which B-hat-prime needs."""
        return tuple(name for name in self.compared if self.pair.has_effective(name))

    @property
    def reference_E(self) -> float:
        """Young's modulus that makes ICs dimensionless [MPa]: the lower body's."""
        return self.bodies["lower"].material.E


def common_extent(bodies: Mapping[str, Body]) -> tuple[float, float]:
    """Arc lengths [mm] as far as the contours of all bodies go."""
    starts, ends = zip(*(body.contour.extent for body in bodies.values()), strict=True)
    return max(starts), min(ends)
