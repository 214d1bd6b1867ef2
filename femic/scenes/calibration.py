"""The tables [effective.*] and [calibration] of a scene file: effective properties, and their fit.

Effective properties vary with the distance from the load. A calibration says which properties are fitted, to
what, and where.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from approx.effective import EffectiveProperties, Transition
from approx.variants import VARIANTS, needs_effective
from femic.key_types import Length, Place, Several, Signed, Whole, each_once
from femic.scenes.errors import BadScene
from femic.scenes.lines import line_misfits, patch_ratio_misfits
from femic.scenes.scene import Calibration, Scene
from femic.scenes.scene_table import SceneTable
from geometries.errors import WrongInput
from geometries.patches import OffsetLine, Patch, line_along_s

# --- [effective.*] --------------------------------------------------------------------------------------


Exponent = Annotated[float, Field(gt=0, le=1000)]
Curvature = Literal["contained", "apart"]


class TransitionTable(SceneTable):
    """A property that changes with the distance from the load until it has its far value at r_inf."""

    far: Signed = Field(description="value at r_inf and beyond")
    r_inf: Length = Field(description="distance from the load [mm]")
    m: Exponent = Field(description="exponent near the load")
    n: Exponent = Field(description="exponent near r_inf")


class PropertiesTable(SceneTable):
    """Effective properties of one body, or of both."""

    G: TransitionTable | None = Field(None, description="shear modulus [MPa]")
    nu: TransitionTable | None = Field(None, description="Poisson's ratio")
    mismatch_k: TransitionTable | None = Field(None, description="mismatch constant K")


class CombinedTable(PropertiesTable):
    """Effective properties of both bodies together."""

    curvature: Curvature = Field(
        "contained",
        description="curvature of wheels along x. contained: included in the properties; apart: added as "
        "in B-hat",
    )


class EffectiveTable(SceneTable):
    """The effective properties that Bhat_prime uses."""

    combined: CombinedTable | None = Field(None, description="of the two bodies combined")
    lower: PropertiesTable | None = Field(None, description="of the lower body")
    upper: PropertiesTable | None = Field(None, description="of the upper body")

    @property
    def curvature_apart(self) -> bool:
        """Whether the properties of both bodies leave out the curvature of wheels."""
        return self.combined is not None and self.combined.curvature == "apart"

    @property
    def properties(self) -> dict[str, EffectiveProperties]:
        """The properties by "combined", "lower", "upper", where given; raises BadScene."""
        given, names = dict[str, EffectiveProperties](), tuple(PropertiesTable.model_fields)
        for body, table in self:
            if table is None:
                continue
            values = {name: getattr(table, name) for name in names}
            transitions = {name: Transition(**dict(value)) for name, value in values.items() if value}
            if not transitions:
                raise BadScene(
                    f"effective.{body}: no property given; name one of {', '.join(names)}, or leave it out"
                )
            try:
                given[body] = EffectiveProperties(**transitions)
            except WrongInput as error:
                raise BadScene(f"effective.{body}: {error}") from error
        return given


def effective_misfits(scene: Scene) -> Iterator[str]:
    """Yield where effective properties are missing."""
    if needing := [] if scene.fitted else [name for name in scene.variants if needs_effective(name)]:
        yield (
            f"variants: {needing[0]} needs effective properties of the compared bodies; add a table "
            "[effective.combined.mismatch_k] with far, r_inf, m, n (or of lower, upper; of G, nu)"
        )
    if scene.ics in VARIANTS and needs_effective(scene.ics) and not scene.fitted:
        yield (f"ics = {scene.ics!r}: the scene has no effective properties; run femic calibrate to fit them")


# --- [calibration] --------------------------------------------------------------------------------------


BodyName = Literal["combined", "lower", "upper"]
Component = Literal["xx", "xs", "xn", "sx", "ss", "sn", "nx", "ns", "nn"]
PropertyName = Literal["mismatch_k", "G", "nu"]


class CalibrationTable(SceneTable):
    """Fit by `femic calibrate`: Bhat_prime to C at the points of lines with x_min < x <= x_max."""

    bodies: Several[BodyName] = Field(
        ("combined",), min_length=1, description="bodies whose properties are fitted"
    )
    properties: Several[PropertyName] = Field(
        ("mismatch_k",), min_length=1, description="properties that vary with the distance"
    )
    components: Several[Component] = Field(
        ("xn",), min_length=1, description="components to fit, with equal weights"
    )
    curvature: Curvature = Field(
        "contained",
        description="curvature of wheels along x, for the combined bodies. contained: part of the fit; "
        "apart: subtracted before the fit and added by Bhat_prime as in B-hat",
    )
    s: Several[Place] | None = Field(
        None, description="arc lengths of lines along x [mm]; default: patch.s and patch.s + 1.6"
    )
    x: Several[Length] = Field((), description="distances of lines along s [mm]")
    x_min: Length | None = Field(None, description="nearest points [mm]; default: 2 patch.a")
    x_max: Length | None = Field(
        None, description="furthest points [mm], also along s; default: 2.5 reference_length"
    )
    points: Annotated[Whole, Field(ge=8, le=5000)] = Field(200, description="number of points per line")
    weights: Literal["uniform", "logarithmic"] = Field(
        "uniform",
        description="uniform: equal weight for each point; logarithmic: equal weight for each "
        "octave of the distance",
    )

    _distinct = field_validator("bodies", "properties", "components")(each_once)

    @model_validator(mode="after")
    def _some_line(self) -> "CalibrationTable":
        if self.s == () and not self.x:
            raise ValueError("s and x: no line given; give at least one")
        return self

    def calibration(self, patch: Patch, reference_length: float, extent: tuple[float, float]) -> Calibration:
        """Return the calibration beside a patch on contours of an extent; lengths in mm."""
        nearest, furthest = self.x_min or 2 * patch.a, self.x_max or 2.5 * reference_length
        x = np.linspace(nearest, furthest, self.points + 1)[1:]
        along_x = [
            OffsetLine(f"fit s = {s:g} mm", "x", x, np.full_like(x, s))
            for s in ((patch.s, patch.s + 1.6) if self.s is None else self.s)
        ]
        s_range = max(extent[0], patch.s - furthest), min(extent[1], patch.s + furthest)
        along_s = [
            replace(line_along_s(distance, s_range, self.points), name=f"fit x = {distance:g} mm")
            for distance in self.x
        ]
        return Calibration(
            bodies=self.bodies,
            properties=self.properties,
            components=self.components,
            curvature_apart=self.curvature == "apart",
            x_min=nearest,
            x_max=furthest,
            lines=(*along_x, *along_s),
            logarithmic=self.weights == "logarithmic",
        )


def calibration_misfits(scene: Scene) -> Iterator[str]:
    """Yield the errors of the points and components that effective properties are fitted to."""
    calibration, extent = scene.calibration, scene.extent
    if not calibration.x_min < calibration.x_max:
        yield "calibration.x_min, x_max: x_max must be larger than x_min"
    for line in calibration.lines:
        yield from line_misfits(f"calibration ({line.name})", line, scene.bodies, extent)
        if line.along == "s" and line.x[0] <= calibration.x_min:
            yield f"calibration.x ({line.name}): not beyond x_min = {calibration.x_min:g} mm: move it away"
    if len({line.name for line in calibration.lines}) < len(calibration.lines):
        yield "calibration.s, calibration.x: two of the lines are the same: remove one"
    domain_size = min(scene.half_turn, *(body.domain.far_radius for body in scene.bodies.values()))
    furthest = max(float(np.max(np.hypot(line.x, line.s))) for line in calibration.lines)
    if 2 * furthest > domain_size:
        yield (
            f"calibration.x_max: points {furthest:g} mm away, more than half of {domain_size:g} mm: reduce it"
        )
    yield from patch_ratio_misfits({f"calibration ({line.name})": line for line in calibration.lines}, scene)
    if calibration.curvature_apart and "combined" not in calibration.bodies:
        yield "calibration.curvature = 'apart': only of the combined bodies; leave it out"
    missing = [name for name in calibration.bodies if name not in scene.compared]
    if missing:
        yield f"calibration.bodies: {', '.join(missing)} not in bodies = {', '.join(scene.compared)}: add it"
