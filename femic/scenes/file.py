"""A scene file (TOML): its keys with their units, defaults and limits, and its tables."""

from typing import Annotated

from pydantic import Field, field_validator

from femic.key_types import Length, Several, each_once
from femic.reference.matrix.job import Discount
from femic.scenes.bodies import BodyTable
from femic.scenes.calibration import BodyName, CalibrationTable, Component, EffectiveTable
from femic.scenes.contact import AnyContact, AnyDamage, AnyStresses, ContactTable, DamageTable, StressTable
from femic.scenes.engine import EngineTable
from femic.scenes.ic_names import ICName, VariantName
from femic.scenes.lines import GridTable, Line, PatchTable
from femic.scenes.scene_table import SceneTable


class SceneFile(SceneTable):
    """A scene: two bodies, a loaded patch, the lines where displacements are read."""

    title: str = Field("", description="heading of the report")
    bodies: Several[BodyName] = Field(
        ("combined", "lower", "upper"), min_length=1, description="whose ICs to compute and compare"
    )
    components: Several[Component] = Field(
        ("nn", "ss", "xx", "xs", "xn", "sn"),
        min_length=1,
        description="displacement direction, then traction direction",
    )
    variants: Several[VariantName] = Field(
        ("A", "B", "Bbar", "Bhat", "mix"), min_length=1, description="approximations to compare with C"
    )
    reference_length: Length | None = Field(
        None,
        description="unit of length of the plots [mm]; default: crown radius of the lower body, 10 if flat",
    )
    rotation_reach: Length | None = Field(
        None,
        description="|s| where the rigid rotation is discounted [mm]; default: 2 x reference_length, "
        "at most an eighth of the domain and a sixth of a turn",
    )
    moment_arm: Length | None = Field(
        None,
        description="s of the normal load that fixes M in rotation [mm], needed if patch.s is not 0; "
        "default: reference_length / 2",
    )
    discount: Discount = Field(
        "approach",
        description="what femic matrix, contact and export subtract from C. approach: the rigid part of "
        "the normal approach alone; source: all that [BVSV] discounts to compare single loads with "
        "half-spaces, bending of the section included; none: nothing, so that approaches depend on the "
        "supports, too",
    )
    ics: ICName = Field(
        "C",
        description="ICs to use where one has to be chosen (femic export; with `want` also femic contact): "
        "C, an approximation, or auto: the cheapest that is good enough, as femic advise chooses it",
    )
    ics_tolerance: Annotated[float, Field(gt=0, le=1)] = Field(
        0.02,
        description="largest error that is good enough for ics = 'auto': share of the component itself, or "
        "of what is wanted",
    )
    want: Several[str] = Field(
        (),
        description="numbers of the contact that ICs have to be good for, such as p_max, F_x, F_x/limit: "
        "femic advise and frontier ask for them, and with ics = 'auto' femic contact is solved with the "
        "cheapest ICs that are good enough, instead of contact.ics",
    )
    fields: bool = Field(
        False,
        description="write the displacement and stress fields of the finest model as .vtu, "
        "one per body and load",
    )
    lower: BodyTable = Field(description="lower body (rail), fills n < 0")
    upper: BodyTable = Field(description="upper body (wheel), fills n > 0")
    patch: PatchTable | None = Field(
        None,
        description="loaded element at x = 0; contact needs none; default: half-sides of a hundredth of "
        "rotation_reach",
    )
    grid: GridTable = Field(GridTable(), description="elements of the IC matrix (femic matrix)")
    lines: Annotated[Several[Line], Field(min_length=1)] | None = Field(
        None, description="offset lines; default: s = patch.s + 1.6, s = patch.s, x = 1.6 mm"
    )
    effective: EffectiveTable = Field(
        EffectiveTable(), description="properties that vary with the distance from the load, for Bhat_prime"
    )
    calibration: CalibrationTable = Field(
        CalibrationTable(), description="which properties femic calibrate fits to which points"
    )
    contact: AnyContact = Field(
        ContactTable(), description="contact of both bodies, without or with friction (femic contact)"
    )
    stresses: AnyStresses = Field(
        StressTable(), description="stresses under the contact in both bodies (femic stresses)"
    )
    damage: AnyDamage = Field(
        DamageTable(),
        description="wear and fatigue under the contact (femic stresses): constants of the surfaces, speed; "
        "coefficients of laws have tables of their own",
    )
    engine: EngineTable = Field(EngineTable(), description="how the reference C is computed")

    _distinct = field_validator("bodies", "components", "variants", "want")(each_once)

    @property
    def with_check_engine(self) -> "SceneFile":
        """The scene with the engine that checks others."""
        return self.model_copy(update={"engine": self.engine.check_engine})
