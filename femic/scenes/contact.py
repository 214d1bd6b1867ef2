"""The table [contact] of a scene file: which contact is solved, and with which ICs."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, field_validator, model_validator

from approx.variants import VARIANTS
from femic.contact.extra_gap import ExtraGap, extra_gap
from femic.contact.motions import MOTIONS
from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.key_types import Amount, Length, NameOf, Place, Several, Signed, Whole, each_distinct, each_once
from femic.scenes.columns import columns
from femic.scenes.contours import ExistingFile
from femic.scenes.errors import BadScene
from femic.scenes.ic_names import ContactICName
from femic.scenes.scene import Scene
from femic.scenes.section import LIMIT_SLACK, Section, shared
from geometries.errors import WrongInput

Creepage = Annotated[float, Field(gt=-1, lt=1)]
GAPS_IN_LENGTH = 10  # reference lengths over the largest gap that raises a surface
CREEPAGES = (0.0005, 0.001, 0.0015, 0.002, 0.003, 0.004, 0.006, 0.008, 0.012)  # and 0, and these below 0


class ContactTable(Section):
    """Contact of both bodies (femic contact)."""

    motion: Annotated[str, AfterValidator(NameOf(lambda: MOTIONS))] = Field(
        "none",
        description="none: frictionless; rolling: steady rolling along x with friction, at one load; "
        "compression: with friction, loaded in steps",
    )
    loads: Several[Amount] = Field((), description="vertical loads [N]; of a compression they grow")
    approaches: Several[Length] = Field((), description="instead of loads: vertical approaches [mm]")
    ics: Several[ContactICName] = Field(
        ("A", "B", "Bhat", "C"),
        min_length=1,
        description=f"ICs to solve it with: C, {', '.join(VARIANTS)}, or one of these with components of "
        "others: Bhat+sn:B is Bhat with sn of B, and ns by reciprocity; map:FILE is C from the file of a "
        "campaign that kept matrix, without friction, on the grid of that",
    )
    friction: Several[Annotated[float, Field(gt=0, le=1000)]] = Field(
        (0.2, 0.4, 0.6), min_length=1, description="coefficients of friction, each solved, 0 ... 1000"
    )
    longitudinal: Several[Creepage] = Field(
        (*(-xi for xi in reversed(CREEPAGES)), 0.0, *CREEPAGES),
        min_length=2,
        description="of rolling: longitudinal creepages omega R / V - 1, growing, for the creep-force curve",
    )
    lateral: Creepage = Field(0.0, description="of rolling: lateral velocity of the wheel over V")
    spin: Annotated[float, Field(ge=-1, le=1)] = Field(
        0.0, description="of rolling: angular velocity of the wheel about z over V [1/mm]"
    )
    equal_force: Annotated[float, Field(gt=-1, lt=1)] = Field(
        0.5,
        description="of rolling: F_x / (friction load) at which tractions by all ICs are compared, -1 ... 1",
    )
    shift: Place = Field(0.0, description="the upper body is moved by this along y [mm]")
    flanks: bool = Field(
        True,
        description="whether the bodies may touch on the straight flanks beyond the contours; false where "
        "flanks only stand for the rest of a body",
    )
    gap: Literal["linear", "exact"] = Field(
        "linear",
        description="undeformed distance. linear: at first touch, less approach times cos(delta); exact: of "
        "the displaced body",
    )
    extra_gap: ExistingFile | None = Field(
        None,
        description="text file of columns x, s, gap, or of s, gap for all x [mm]: a gap that is added, "
        "linear between the points, 0 beyond; # comments",
    )
    elements: Annotated[Whole, Field(ge=8, le=64)] = Field(
        20, description="elements across the smallest patch on an automatic grid, along x and s"
    )
    grid: Literal["automatic", "scene"] = Field(
        "automatic", description="automatic: as large as the patches; scene: that of [grid], centred at x = 0"
    )
    lateral_force: Signed | None = Field(
        None,
        description="without friction: lateral force F_y on the upper body [N]; its lateral position "
        "follows, and `shift` is where it is sought first",
    )
    supports: bool = Field(
        True,
        description="whether the page shows what supports do to the contact by C: far arc of half the radius "
        "and, where the contact is not symmetric, flanks 5 degrees flatter (C once more)",
    )
    shape_load: Amount | None = Field(
        None,
        description="load whose B-hat pressures are mapped onto all patches, to see where A and B-hat differ "
        "[N]; default: the largest",
    )

    _distinct = field_validator("ics", "friction")(each_once)
    _distinct_cases = field_validator("loads", "approaches")(each_distinct)

    @model_validator(mode="after")
    def _loads_or_approaches(self) -> "ContactTable":
        if self.loads and self.approaches:
            raise ValueError("give either loads or approaches")
        return self

    @model_validator(mode="after")
    def _of_this_motion(self) -> "ContactTable":
        for key in dict.fromkeys(key for motion in MOTIONS.values() for key in motion.keys):
            if key in self.model_fields_set and key not in MOTIONS[self.motion].keys:
                of = " or ".join(repr(name) for name, motion in MOTIONS.items() if key in motion.keys)
                raise ValueError(f"{key} is only of motion = {of}, not {self.motion!r}: leave it out")
        return self

    @model_validator(mode="after")
    def _growing(self) -> "ContactTable":
        for key in MOTIONS[self.motion].growing:
            values = getattr(self, key)
            if any(after <= before for before, after in pairwise(values)):
                raise ValueError(f"{key} must grow: sort them, each once")
        return self


def contact_of(table: ContactTable) -> ContactSpecification:
    """Return the specification of a table; raise BadScene for a file that has no extra gap."""
    resolved = {
        "exact": table.gap == "exact",
        "extra_gap": _extra_gap(table.extra_gap),
        "automatic": table.grid == "automatic",
        "friction": _friction(table) if MOTIONS[table.motion].has_friction else None,
    }
    return ContactSpecification(**shared(table, ContactSpecification) | resolved)


def _friction(table: ContactTable) -> FrictionSpecification:
    return FrictionSpecification(coefficients=table.friction, **shared(table, FrictionSpecification))


def _extra_gap(path: Path | None) -> ExtraGap | None:
    """The gap of a file; raises BadScene for other files."""
    if path is None:
        return None
    try:
        return extra_gap(columns(path, ("s, gap", "x, s, gap")))
    except WrongInput as error:
        raise BadScene(f"contact.extra_gap = {path}: {error}") from error


def contact_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the contact of a scene."""
    yield from _gap_misfits(scene)
    yield from _friction_misfits(scene)


def _gap_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the extra gap: it has to be small beside the bodies where it raises them."""
    gap, limit = scene.contact.extra_gap, scene.reference_length / GAPS_IN_LENGTH
    if gap is not None and (least := float(np.min(gap.gap))) < -limit * (1 + LIMIT_SLACK):
        yield (
            f"contact.extra_gap: {least:g} mm raises the surface along its normals by more than "
            f"{1 / GAPS_IN_LENGTH:.0%} of reference_length, {limit:g} mm: add a constant to all gaps, or "
            "change the contours"
        )


def _friction_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the bodies and loads of a contact with friction."""
    loads, name = scene.contact.loads, scene.contact.motion
    motion = MOTIONS[name]
    if motion.has_friction and not loads:
        yield f"contact.loads = []: motion = {name!r} needs a load: give loads = [...] in N"
    if motion.one_load and len(loads) > 1:
        yield (
            f"contact.loads = {list(loads)}: motion = {name!r} has one load: give one, and a scene each for "
            "others"
        )
    if motion.wheel_rolls and np.isinf(scene.bodies["upper"].rolling_radius):
        others = [repr(other) for other, of in MOTIONS.items() if of.has_friction and not of.wheel_rolls]
        yield (
            f"upper.rolling_radius = inf: motion = {name!r} needs a wheel: give upper.rolling_radius in mm, "
            f"or motion = {' or '.join(others)}"
        )
