"""The tables [contact], [stresses] and [damage] of a scene file.

They have loads, motion and ICs of the contact; and the stresses under it, wear and fatigue.
"""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, PlainValidator, SerializeAsAny, create_model, model_validator

from femic.contact.motions import MOTIONS
from femic.contact.specification import (
    WITHOUT_FRICTION,
    ContactSpecification,
    ExtraGap,
    FrictionSpecification,
    extra_gap,
)
from femic.damage.dang_van import DangVan
from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw
from femic.damage.specification import DamageSpecification
from femic.key_types import NameOf
from femic.scenes.errors import BadScene
from femic.scenes.ic_names import ContactICName
from femic.scenes.input_files import ExistingFile, Holds, columns
from femic.scenes.scene import Scene, StressSpecification
from femic.scenes.scene_table import LIMIT_SLACK, SceneTable, keys_of, shared
from geometries.errors import WrongInput

# --- [contact] ------------------------------------------------------------------------------------------


GAPS_IN_LENGTH = 10  # reference lengths over the largest gap that raises a surface


class ContactKeys(SceneTable):
    """Contact of both bodies (femic contact): rules for the keys of `ContactTable`."""

    @model_validator(mode="after")
    def _consistent(self) -> "ContactKeys":
        keys = dict(self)
        name, motion = keys["motion"], MOTIONS[keys["motion"]]
        if keys["loads"] and keys["approaches"]:
            raise ValueError("give either loads or approaches")
        for key in dict.fromkeys(key for other in MOTIONS.values() for key in other.keys):
            if key in self.model_fields_set and key not in motion.keys:
                others = " or ".join(repr(other) for other in MOTIONS if key in MOTIONS[other].keys)
                raise ValueError(f"{key} is only of motion = {others}, not {name!r}: leave it out")
        for key in motion.growing:
            if any(after <= before for before, after in pairwise(keys[key])):
                raise ValueError(f"{key} must grow: sort them, each once")
        return self


def _declared_keys() -> dict[str, Any]:
    """Return the keys that the specifications declare, with the keys of friction in place of `friction`."""
    files = {"ics": tuple[ContactICName, ...], "extra_gap": ExistingFile | None}  # as scene files have them
    friction_keys = keys_of(FrictionSpecification)
    friction_keys = {"friction": friction_keys.pop("coefficients"), **friction_keys}
    motions = "; ".join(f"{name}: {motion.description}" for name, motion in MOTIONS.items())
    motion = Annotated[str, AfterValidator(NameOf(lambda: MOTIONS)), Field(description=motions)]
    keys = keys_of(ContactSpecification, files) | {"motion": (motion, WITHOUT_FRICTION)}
    parts = (friction_keys if key == "friction" else {key: declared} for key, declared in keys.items())
    return {key: declared for part in parts for key, declared in part.items()}


ContactTable = create_model("ContactTable", __base__=ContactKeys, **_declared_keys())
AnyContact = Annotated[
    SerializeAsAny[ContactKeys],
    PlainValidator(ContactTable.model_validate),
    Holds(lambda: (ContactTable,)),
]


def contact_of(table: ContactKeys) -> ContactSpecification:
    """Return the specification of a table; raise BadScene for a file that has no extra gap."""
    keys = dict(table)
    friction = FrictionSpecification(keys["friction"], **shared(table, FrictionSpecification))
    resolved = {
        "extra_gap": _extra_gap(keys["extra_gap"]),
        "friction": friction if MOTIONS[keys["motion"]].has_friction else None,
    }
    return ContactSpecification(**shared(table, ContactSpecification) | resolved)


def _extra_gap(path: Path | None) -> ExtraGap | None:
    """Return the gap of a file; raise BadScene for other files."""
    if path is None:
        return None
    try:
        return extra_gap(columns(path, ("s, gap", "x, s, gap")))
    except WrongInput as error:
        raise BadScene(f"contact.extra_gap = {path}: {error}") from error


def contact_misfits(scene: Scene) -> Iterator[str]:
    """Yield the errors of the contact of a scene."""
    yield from _gap_misfits(scene)
    yield from _friction_misfits(scene)


def _gap_misfits(scene: Scene) -> Iterator[str]:
    """Yield the error of an extra gap that is not small beside the bodies where it raises them."""
    gap, limit = scene.contact.extra_gap, scene.reference_length / GAPS_IN_LENGTH
    if gap is not None and (least := float(np.min(gap.gap))) < -limit * (1 + LIMIT_SLACK):
        yield (
            f"contact.extra_gap: {least:g} mm raises the surface along its normals by more than "
            f"{1 / GAPS_IN_LENGTH:.0%} of reference_length, {limit:g} mm: add a constant to all gaps, or "
            "change the contours"
        )


def _friction_misfits(scene: Scene) -> Iterator[str]:
    """Yield the errors of the bodies and loads of a contact with friction."""
    loads, name = scene.contact.loads, scene.contact.motion
    motion = MOTIONS[name]
    if motion.has_friction and not loads:
        yield f"contact.loads = []: motion = {name!r} needs a load: give loads = [...] in N"
    if motion.wheel_rolls and len(loads) > 1:
        yield (
            f"contact.loads = {list(loads)}: motion = {name!r} has one load: give one, and a scene each for "
            "others"
        )
    if motion.wheel_rolls and np.isinf(scene.bodies["upper"].rolling_radius):
        others = [repr(key) for key, other in MOTIONS.items() if other.has_friction and not other.wheel_rolls]
        yield (
            f"upper.rolling_radius = inf: motion = {name!r} needs a wheel: give upper.rolling_radius in mm, "
            f"or motion = {' or '.join(others)}"
        )


# --- [stresses] and [damage] ----------------------------------------------------------------------------


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


def _damage_keys() -> dict[str, Any]:
    """Return the keys of [damage]: those of the specification, with a table in place of each law."""
    tables = {name: _table_of(name) for name in LAWS}
    of_laws = {name: (table, Field(table(), description=LAWS[name][1])) for name, table in tables.items()}
    return keys_of(DamageSpecification) | of_laws


DamageTable = create_model("DamageTable", __base__=SceneTable, **_damage_keys())
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
