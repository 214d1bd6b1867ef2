"""A scene file (TOML): its keys with their units, defaults and limits, and its tables."""

from typing import Annotated

from pydantic import Field, field_validator

from femic.key_types import Length, Several, each_once
from femic.reference.matrix.job import Discount
from femic.scenes.bodies import BodyTable
from femic.scenes.calibration import BodyName, CalibrationTable, Component, EffectiveTable
from femic.scenes.contact import (
    AnyContact,
    AnyCreepTable,
    AnyDamage,
    AnyStresses,
    ContactTable,
    CreepTable,
    DamageTable,
    StressTable,
)
from femic.scenes.engine import EngineTable
from femic.scenes.ic_names import ICName, VariantName
from femic.scenes.lines import GridTable, Line, PatchTable
from femic.scenes.scene_table import SceneTable


class SceneFile(SceneTable):
    """A scene: two bodies, a loaded patch, the lines where displacements are read."""

    title: str = Field("", description="title of the report")
    bodies: Several[BodyName] = Field(
        ("combined", "lower", "upper"), min_length=1, description="bodies whose ICs are computed and compared"
    )
    components: Several[Component] = Field(
        ("nn", "ss", "xx", "xs", "xn", "sn"),
        min_length=1,
        description="components to compare; each names the direction of displacement, then the direction "
        "of traction",
    )
    variants: Several[VariantName] = Field(
        ("A", "B", "Bbar", "Bhat", "mix"), min_length=1, description="approximations to compare with C"
    )
    reference_length: Length | None = Field(
        None,
        description="reference length of dimensionless plots [mm]; default: crown radius of the lower "
        "body, 10 if flat",
    )
    rotation_reach: Length | None = Field(
        None,
        description="|s| at which the rigid rotation is read [mm]; default: 2 x reference_length, at most "
        "an eighth of the domain and a sixth of a turn",
    )
    moment_arm: Length | None = Field(
        None,
        description="s of the normal load that determines the rotation part of M [mm], needed if patch.s "
        "is not 0; default: reference_length / 2",
    )
    discount: Discount = Field(
        "approach",
        description="what femic matrix, contact and export subtract from C. approach: only the rigid part "
        "of the normal approach; source: everything that [BVSV] subtracts to compare single loads with "
        "half-spaces, including the bending of the section; none: nothing, so that approaches also depend "
        "on the supports",
    )
    ics: ICName = Field(
        "C",
        description="ICs that femic export uses (with `want`, also femic contact): C, an approximation, "
        "or auto, the cheapest that meet the tolerance, as chosen by femic advise",
    )
    ics_tolerance: Annotated[float, Field(gt=0, le=1)] = Field(
        0.02,
        description="largest accepted error of ICs, relative to the component or the number. Pages say "
        "which ICs are within it (femic contact: creep forces relative to friction times load, sliding "
        "areas to the contact area); ics = 'auto' chooses by it",
    )
    want: Several[str] = Field(
        (),
        description="contact numbers that must meet the tolerance, such as p_max, F_x, F_x/limit. femic "
        "advise and frontier use them; with ics = 'auto', femic contact uses the cheapest ICs that meet "
        "the tolerance instead of contact.ics",
    )
    fields: bool = Field(
        False,
        description="write displacement and stress fields of the finest model as .vtu files, one per body "
        "and load",
    )
    lower: BodyTable = Field(description="lower body (rail), fills n < 0")
    upper: BodyTable = Field(description="upper body (wheel), fills n > 0")
    patch: PatchTable | None = Field(
        None,
        description="loaded element at x = 0, not needed for contact; default: half-sides of "
        "rotation_reach / 100",
    )
    grid: GridTable = Field(GridTable(), description="elements of the IC matrix (femic matrix)")
    lines: Annotated[Several[Line], Field(min_length=1)] | None = Field(
        None, description="offset lines; default: s = patch.s + 1.6, s = patch.s, x = 1.6 mm"
    )
    effective: EffectiveTable = Field(
        EffectiveTable(),
        description="elastic properties that vary with the distance from the load, for Bhat_prime",
    )
    calibration: CalibrationTable = Field(
        CalibrationTable(), description="fit of Bhat_prime by femic calibrate: properties and points"
    )
    contact: AnyContact = Field(
        ContactTable(), description="contact of the two bodies, with or without friction (femic contact)"
    )
    stresses: AnyStresses = Field(
        StressTable(), description="stresses in both bodies under the contact (femic stresses)"
    )
    damage: AnyDamage = Field(
        DamageTable(),
        description="wear and fatigue (femic stresses): properties of the surfaces, and speed; the "
        "coefficients of the laws have separate tables",
    )
    table: AnyCreepTable = Field(
        CreepTable(), description="table of creep forces over shift, load and creepages (femic table)"
    )
    engine: EngineTable = Field(EngineTable(), description="how the reference C is computed")

    _distinct = field_validator("bodies", "components", "variants", "want")(each_once)

    @property
    def with_check_engine(self) -> "SceneFile":
        """The scene with the engine that checks others."""
        return self.model_copy(update={"engine": self.engine.check_engine})
