"""The tables [contact], [stresses], [damage] and [table] of a scene file.

They have loads, motion and ICs of the contact; the stresses under it, wear and fatigue; tables of contacts.
"""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, PlainValidator, SerializeAsAny, create_model, model_validator

from femic.contact.motions import MOTIONS
from femic.contact.specification import (
    WITHOUT_FRICTION,
    ContactSpecification,
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
from femic.scenes.scene_table import LIMIT_SLACK, SceneTable, declared_keys, shared
from femic.tables.specification import TableSpecification
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
                raise ValueError(f"{key} must increase; sort the values and give each once")
        return self


_FILES = {"ics": tuple[ContactICName, ...], "extra_gap": ExistingFile | None}  # as scene files have them
_MOTION = Annotated[
    str,
    AfterValidator(NameOf(lambda: MOTIONS)),
    Field(description="; ".join(f"{name}: {motion.description}" for name, motion in MOTIONS.items())),
]
_KEYS = declared_keys(ContactSpecification, _FILES) | {"motion": (_MOTION, WITHOUT_FRICTION)}
_FRICTION_KEYS = declared_keys(FrictionSpecification)
_FRICTION_KEYS = {"friction": _FRICTION_KEYS.pop("coefficients"), **_FRICTION_KEYS}
_PARTS = (_FRICTION_KEYS if key == "friction" else {key: declared} for key, declared in _KEYS.items())
ContactTable = create_model(
    "ContactTable",
    __base__=ContactKeys,
    **{key: declared for part in _PARTS for key, declared in part.items()},
)
AnyContact = Annotated[
    SerializeAsAny[ContactKeys],
    PlainValidator(ContactTable.model_validate),
    Holds(lambda: (ContactTable,)),
]


def contact_specification(table: ContactKeys) -> ContactSpecification:
    """Return the specification of a table; raise BadScene for a file that has no extra gap."""
    keys, gap = dict(table), None
    if (path := keys["extra_gap"]) is not None:
        try:
            gap = extra_gap(columns(path, ("s, gap", "x, s, gap")))
        except WrongInput as error:
            raise BadScene(f"contact.extra_gap = {path}: {error}") from error
    friction = FrictionSpecification(keys["friction"], **shared(table, FrictionSpecification))
    resolved = {"extra_gap": gap, "friction": friction if MOTIONS[keys["motion"]].has_friction else None}
    return ContactSpecification(**shared(table, ContactSpecification) | resolved)


def contact_misfits(scene: Scene) -> Iterator[str]:
    """Yield the errors of the contact of a scene: of a gap that raises bodies, of loads with friction."""
    gap, limit = scene.contact.extra_gap, scene.reference_length / GAPS_IN_LENGTH
    if gap is not None and (least := float(np.min(gap.gap))) < -limit * (1 + LIMIT_SLACK):
        yield (
            f"contact.extra_gap: {least:g} mm raises the surface along its normals by more than "
            f"{1 / GAPS_IN_LENGTH:.0%} of reference_length, {limit:g} mm: add a constant to all gaps, or "
            "change the contours"
        )
    loads, name = scene.contact.loads, scene.contact.motion
    motion = MOTIONS[name]
    if motion.has_friction and not loads:
        yield f"contact.loads = []: motion = {name!r} needs a load; give loads = [...] in N"
    if motion.wheel_rolls and len(loads) > 1:
        yield (
            f"contact.loads = {list(loads)}: motion = {name!r} takes one load; use a separate scene for "
            "each further load"
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
    "energy": (EnergyLaw, "wear law by work of friction, mild or severe"),
    "twin_disc": (TwinDiscLaw, "wear law by T-gamma/area, from twin-disc tests"),
    "archard": (ArchardMap, "Archard's wear law with the KTH wear map; needs damage.hardness"),
    "dang_van": (DangVan, "fatigue below the surface by Dang Van"),
}
ELSEWHERE = {"archard": {"hardness"}}  # fields of laws that are keys of [damage]
OF_WORN = ("steps", "spread")  # keys of [damage] that have no effect without passages or revolutions
OF_SPEED = ("severe", "transition")  # keys of [damage.energy] that have no effect without a speed

StressTable = create_model("StressTable", __base__=SceneTable, **declared_keys(StressSpecification))
AnyStresses = Annotated[SerializeAsAny[SceneTable], PlainValidator(StressTable.model_validate)]
_ONE_NAME = {"ics": ContactICName}  # as scene files have it
CreepTable = create_model("CreepTable", __base__=SceneTable, **declared_keys(TableSpecification, _ONE_NAME))
AnyCreepTable = Annotated[SerializeAsAny[SceneTable], PlainValidator(CreepTable.model_validate)]


_DAMAGE_KEYS = declared_keys(DamageSpecification)
for _name, (_law, _meaning) in LAWS.items():  # a table in place of each law
    _own = {
        key: declared for key, declared in declared_keys(_law).items() if key not in ELSEWHERE.get(_name, ())
    }
    _table = create_model(f"{_name.title().replace('_', '')}Table", __base__=SceneTable, **_own)
    _DAMAGE_KEYS[_name] = _table, Field(_table(), description=_meaning)
DamageTable = create_model("DamageTable", __base__=SceneTable, **_DAMAGE_KEYS)
AnyDamage = Annotated[SerializeAsAny[SceneTable], PlainValidator(DamageTable.model_validate)]


def damage_specification(table: SceneTable) -> DamageSpecification:
    """Return the specification of a table; raise BadScene for keys that do not fit together."""
    keys, place = dict(table), ""
    try:
        for name, (law, _) in LAWS.items():
            place = f"{name}."
            keys[name] = law(**dict(keys[name]))
        place = ""
        return DamageSpecification(**keys)
    except WrongInput as error:
        raise BadScene(f"damage.{place}{error}") from error


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
            f"stresses.friction = {friction:g}: this value is not in contact.friction = {known}: give one "
            "of these, or add it there"
        )
    if force is not None and motion != ROLLING:
        yield f"stresses.force = {force:g}: {_only_of([ROLLING], motion)}"


def damage_misfits(scene: Scene, table: SceneTable) -> Iterator[str]:
    """Yield the keys of the table [damage] that have no effect on numbers of a scene."""
    motion, keys = scene.contact.motion, dict(table)
    given = {name for name in table.model_fields_set if name not in LAWS or keys[name].model_fields_set}
    passing = [name for name in MOTIONS if name != WITHOUT_PASSAGE]
    for name in DamageTable.model_fields:
        motions = {"dang_van": passing, "yield_stress": list(MOTIONS)}.get(name, [ROLLING])
        if name in given and motion not in motions:
            value = "" if name in LAWS else f" = {keys[name]:g}"
            yield f"damage.{name}{value}: {_only_of(motions, motion)}"
    if motion != ROLLING:
        return
    damage = scene.damage
    if damage.speed is None:
        for key in OF_SPEED:
            if key in keys["energy"].model_fields_set:
                yield (
                    f"damage.energy.{key}: without a speed, wear is mild everywhere; give damage.speed in "
                    "m/s, or leave this key out"
                )
    for key in OF_WORN:
        if key in table.model_fields_set and not damage.wears:
            yield (
                f"damage.{key} = {getattr(damage, key):g}: there is no wear; give damage.passages or "
                "damage.revolutions, or leave this key out"
            )
    if damage.hardness is None and keys["archard"].model_fields_set:
        yield (
            "damage.archard: without a hardness there is no wear by Archard: give damage.hardness in MPa, "
            "and damage.speed in m/s, or leave it out"
        )


def _only_of(motions: Iterable[str], motion: str) -> str:
    """Return that a key is only of some motions of contact, and not of another."""
    return f"only of contact.motion = {' or '.join(map(repr, motions))}, not {motion!r}: leave it out"
