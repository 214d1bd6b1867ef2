"""The tables [effective.*] of a scene file: properties that vary with the distance from the load."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from approx.effective import EffectiveProperties, Transition
from approx.variants import VARIANTS, needs_effective
from femic.key_types import Length, Signed
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene
from femic.scenes.scene_table import SceneTable
from geometries.errors import WrongInput

Exponent = Annotated[float, Field(gt=0, le=1000)]
Curvature = Literal["contained", "apart"]


class TransitionTable(SceneTable):
    """A property that changes with the distance from the load until it has its far value at r_inf."""

    far: Signed = Field(description="its value at r_inf and beyond")
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
        description="of wheels along x. contained: in the properties; apart: added as B-hat has it",
    )


class EffectiveTable(SceneTable):
    """The effective properties that Bhat_prime uses."""

    combined: CombinedTable | None = Field(None, description="of both bodies together")
    lower: PropertiesTable | None = Field(None, description="of the lower body")
    upper: PropertiesTable | None = Field(None, description="of the upper body")

    @property
    def curvature_apart(self) -> bool:
        """Whether the properties of both bodies leave out the curvature of wheels."""
        return self.combined is not None and self.combined.curvature == "apart"


def effective_properties(table: EffectiveTable) -> dict[str, EffectiveProperties]:
    """Return effective properties by "combined", "lower", "upper", where given; raise BadScene."""
    return {name: _properties(name, properties) for name, properties in table if properties is not None}


def _properties(name: str, table: PropertiesTable) -> EffectiveProperties:
    """Return the properties of a table by its name; raise BadScene."""
    values = {key: getattr(table, key) for key in PropertiesTable.model_fields}
    transitions = {key: Transition(**dict(value)) for key, value in values.items() if value is not None}
    if not transitions:
        raise BadScene(
            f"effective.{name}: names no property; give one of {', '.join(values)}, or leave it out"
        )
    try:
        return EffectiveProperties(**transitions)
    except WrongInput as error:
        raise BadScene(f"effective.{name}: {error}") from error


def effective_misfits(scene: Scene) -> Iterator[str]:
    """Yield where effective properties are missing."""
    if needing := [] if scene.fitted else [name for name in scene.variants if needs_effective(name)]:
        yield (
            f"variants: {needing[0]} needs effective properties of what is compared: add a table "
            "[effective.combined.mismatch_k] with far, r_inf, m, n (or of lower, upper; of G, nu)"
        )
    if scene.ics in VARIANTS and needs_effective(scene.ics) and not scene.fitted:
        yield f"ics = {scene.ics!r}: the scene has no effective properties; femic calibrate finds some"
