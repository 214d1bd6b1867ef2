"""The scene: bodies, patch, lines, contact, and settings of C."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from approx.effective import EffectiveProperties
from approx.pair import Pair, Solid
from femic.contact.specification import ContactProblem, ContactSpecification
from femic.damage.specification import DamageSpecification
from femic.reference.job import Settings
from femic.reference.matrix.job import Discount
from femic.reference.meshing import Cells
from femic.stresses.resolution import COARSEST, FINEST
from femic.tables.specification import TableSpecification
from geometries.bodies import Body, common_extent
from geometries.patches import Grid, OffsetLine, Patch


@dataclass(frozen=True)
class Calibration:
    """The fit of effective properties: to components of C at the points of lines, x_min < x <= x_max."""

    bodies: tuple[str, ...]  # of "combined", "lower", "upper"
    properties: tuple[str, ...]  # of EffectiveProperties
    components: tuple[str, ...]
    curvature_apart: bool  # whether the combined properties leave out the curvature of wheels
    x_min: float  # mm
    x_max: float  # mm
    lines: tuple[OffsetLine, ...]
    logarithmic: bool  # whether each octave of the distance has the same weight; otherwise each point has


@dataclass(frozen=True)
class StressSpecification:
    """Which contact of a scene loads the bodies, and how their stresses are computed.

    Each key is declared here alone; the table [stresses] of a scene file is made from these declarations.
    """

    friction: Annotated[
        float | None,
        Field(
            gt=0,
            le=1000,
            description="friction coefficient, one of contact.friction; default: the largest",
        ),
    ] = None
    force: Annotated[
        float | None,
        Field(
            gt=-1,
            lt=1,
            description="steady rolling: F_x / (friction load), -1 ... 1; default: contact.equal_force",
        ),
    ] = None
    fineness: Annotated[
        float,
        Field(
            ge=COARSEST,
            le=FINEST,
            description="fineness of the models of both bodies: 2 halves the size of cells and the steps "
            "between wavenumbers, 0.5 doubles them",
        ),
    ] = 1.0
    estimated: Annotated[
        bool,
        Field(description="whether errors of stresses are estimated; this takes 50 % more time"),
    ] = True


@dataclass(frozen=True)
class Scene:
    """A validated scene in terms of `geometries`."""

    name: str
    title: str
    text: str  # TOML
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
    checked_strips: int  # number of columns of its IC matrix that the solid engine computes as a check
    contact: ContactSpecification
    stresses: StressSpecification
    damage: DamageSpecification
    table: TableSpecification
    discount: Discount  # of IC matrices and contact
    support_radius: float  # of the far arc of bodies for IC matrices and contact [mm]
    settings: Settings  # of C
    reference_length: float  # mm
    fields: bool  # whether displacements and stresses are written
    ics: str  # ICs to use: "C", a variant, or "auto"
    ics_tolerance: float  # by which contacts with ICs are judged, and ICs are chosen by "auto"
    want: tuple[str, ...]  # numbers of the contact that ICs have to be good for, of `femic.scenes.wants`
    check: "Scene | None" = None  # the same scene with the solid engine, whose C is drawn beside C

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths [mm] as far as both contours go."""
        return common_extent(self.bodies)

    @property
    def half_turn(self) -> float:
        """Half of the shortest circumference of a rolling circle [mm]; infinite for prismatic bodies."""
        return min(np.pi * body.rolling_radius for body in self.bodies.values())

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
        """Both bodies as a pair for approximations."""
        lower, upper = (
            Solid(body.material, body.surface, self.effective.get(name))
            for name, body in ((name, self.bodies[name]) for name in ("lower", "upper"))
        )
        return Pair(upper, lower, self.effective.get("combined"), self.curvature_apart)

    @property
    def contact_problem(self) -> ContactProblem:
        """The contact of both bodies as a problem of `femic.contact`."""
        return ContactProblem(
            self.name,
            self.bodies,
            self.pair,
            self.contact,
            self.grid,
            self.settings,
            self.discount,
            self.support_radius,
            self.reference_length,
        )

    @property
    def fitted(self) -> tuple[str, ...]:
        """Compared bodies with effective properties, which B-hat-prime needs."""
        return tuple(name for name in self.compared if self.pair.has_effective(name))

    @property
    def reference_E(self) -> float:
        """Young's modulus that makes ICs dimensionless [MPa]: the lower body's."""
        return self.bodies["lower"].material.E
