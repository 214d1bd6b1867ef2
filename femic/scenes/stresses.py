"""The tables [stresses] and [damage] of a scene file: stresses under its contact, wear and fatigue."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field, PlainValidator, SerializeAsAny, create_model

from femic.contact.motions import MOTIONS
from femic.damage.dang_van import DangVan
from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw
from femic.damage.specification import DamageSpecification
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene, StressSpecification
from femic.scenes.scene_table import SceneTable, keys_of, shared
from geometries.errors import WrongInput

ROLLING, WITHOUT_PASSAGE = "rolling", "compression"
LAWS: Mapping[str, tuple[type[Any], str]] = {
    "energy": (EnergyLaw, "wear by the work of friction, mild or severe"),
    "twin_disc": (TwinDiscLaw, "wear by T-gamma over area, from twin discs"),
    "archard": (ArchardMap, "wear by Archard, the map of KTH; needs damage.hardness"),
    "dang_van": (DangVan, "fatigue below the surface by Dang Van"),
}
ELSEWHERE = {"archard": {"hardness"}}  # fields of laws that are keys of [damage]
OF_WORN = ("steps", "spread")  # keys of [damage] that have no effect without passages or revolutions
OF_SPEED = ("severe", "transition")  # keys of [damage.energy] that have no effect without a speed

StressTable = create_model("StressTable", __base__=SceneTable, **keys_of(StressSpecification))
AnyStresses = Annotated[SerializeAsAny[SceneTable], PlainValidator(StressTable.model_validate)]


def _table_of(name: str) -> type[SceneTable]:
    """Return the table of a law: its fields, without those that are keys of [damage]."""
    keys = keys_of(LAWS[name][0])
    own = {key: declared for key, declared in keys.items() if key not in ELSEWHERE.get(name, ())}
    return create_model(f"{name.title().replace('_', '')}Table", __base__=SceneTable, **own)


def _declared() -> dict[str, Any]:
    """Return the keys of [damage]: those of the specification, with a table in place of each law."""
    tables = {name: _table_of(name) for name in LAWS}
    of_laws = {name: (table, Field(table(), description=LAWS[name][1])) for name, table in tables.items()}
    return keys_of(DamageSpecification) | of_laws


DamageTable = create_model("DamageTable", __base__=SceneTable, **_declared())
AnyDamage = Annotated[SerializeAsAny[SceneTable], PlainValidator(DamageTable.model_validate)]


def stresses_of(table: SceneTable) -> StressSpecification:
    """Return the specification of a table."""
    return StressSpecification(**shared(table, StressSpecification))


def damage_of(table: SceneTable) -> DamageSpecification:
    """Return the specification of a table; raise BadScene for keys that do not fit together."""
    keys = dict(table)
    laws = {name: _law(name, keys[name]) for name in LAWS}
    try:
        return DamageSpecification(**shared(table, DamageSpecification) | laws)
    except WrongInput as error:
        raise BadScene(f"damage.{error}") from error


def _law(name: str, table: SceneTable) -> Any:
    """Return the law of a table by its name; raise BadScene."""
    try:
        return LAWS[name][0](**dict(table))
    except WrongInput as error:
        raise BadScene(f"damage.{name}.{error}") from error


def stress_misfits(scene: Scene) -> Iterator[str]:
    """Yield the errors of the contact whose stresses are computed."""
    motion, friction, force = scene.contact.motion, scene.stresses.friction, scene.stresses.force
    of_contact = scene.contact.friction
    if friction is not None and of_contact is None:
        with_friction = [name for name, other in MOTIONS.items() if other.has_friction]
        yield f"stresses.friction = {friction:g}: {_only_of(with_friction, motion)}"
    elif friction is not None and of_contact and friction not in of_contact.coefficients:
        known = list(of_contact.coefficients)
        yield (
            f"stresses.friction = {friction:g}: not among contact.friction = {known}: give one of "
            "these, or add it there"
        )
    if force is not None and motion != ROLLING:
        yield f"stresses.force = {force:g}: {_only_of([ROLLING], motion)}"


def damage_misfits(scene: Scene, table: SceneTable) -> Iterator[str]:
    """Yield the keys of the table [damage] that have no effect on numbers of a scene."""
    motion, keys = scene.contact.motion, dict(table)
    given = {name for name in table.model_fields_set if name not in LAWS or keys[name].model_fields_set}
    passing = [name for name in MOTIONS if name != WITHOUT_PASSAGE]
    for name in DamageTable.model_fields:
        motions = passing if name == "dang_van" else [ROLLING]
        if name in given and motion not in motions:
            value = "" if name in LAWS else f" = {keys[name]:g}"
            yield f"damage.{name}{value}: {_only_of(motions, motion)}"
    if motion == ROLLING:
        yield from _without_effect(scene.damage, table)


def _without_effect(damage: DamageSpecification, table: SceneTable) -> Iterator[str]:
    """Yield keys that need another one which is not given."""
    tables = dict(table)
    if damage.speed is None:
        for key in OF_SPEED:
            if key in tables["energy"].model_fields_set:
                yield (
                    f"damage.energy.{key}: without a speed wear is mild everywhere: give damage.speed in "
                    "m/s, or leave it out"
                )
    for key in OF_WORN:
        if key in table.model_fields_set and not damage.wears:
            yield (
                f"damage.{key} = {getattr(damage, key):g}: nothing wears: give damage.passages or "
                "damage.revolutions, or leave it out"
            )
    if damage.hardness is None and tables["archard"].model_fields_set:
        yield (
            "damage.archard: without a hardness there is no wear by Archard: give damage.hardness in MPa, "
            "and damage.speed in m/s, or leave it out"
        )


def _only_of(motions: Iterable[str], motion: str) -> str:
    """Return that a key is only of some motions of contact, and not of another."""
    return f"only of contact.motion = {' or '.join(map(repr, motions))}, not {motion!r}: leave it out"
