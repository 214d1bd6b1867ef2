"""The table [contact] of a scene file: loads, motion and ICs of the contact."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator, SerializeAsAny, create_model, model_validator

from femic.contact.extra_gap import ExtraGap, extra_gap
from femic.contact.motions import MOTIONS
from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.scenes.columns import columns
from femic.scenes.errors import BadScene
from femic.scenes.ic_names import ContactICName
from femic.scenes.input_files import ExistingFile, Holds
from femic.scenes.scene import Scene
from femic.scenes.scene_table import LIMIT_SLACK, SceneTable, keys_of, shared
from geometries.errors import WrongInput

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


def _declared() -> dict[str, Any]:
    """Return the keys that the specifications declare, with the keys of friction in place of `friction`."""
    files = {"ics": tuple[ContactICName, ...], "extra_gap": ExistingFile | None}  # as scene files have them
    friction_keys = keys_of(FrictionSpecification)
    friction_keys = {"friction": friction_keys.pop("coefficients"), **friction_keys}
    keys = keys_of(ContactSpecification, files).items()
    parts = (friction_keys if key == "friction" else {key: declared} for key, declared in keys)
    return {key: declared for part in parts for key, declared in part.items()}


ContactTable = create_model("ContactTable", __base__=ContactKeys, **_declared())
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
