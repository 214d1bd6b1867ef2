"""A table of a scene file, and how it becomes a dataclass."""

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

LIMIT_SLACK = 1e-9  # share by which rounding may exceed a limit


class Section(BaseModel):
    """A table of a scene file: unknown keys are errors, and texts and true are not numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def shared(table: Section, noun: "type[DataclassInstance]") -> dict[str, Any]:
    """Return the values of keys that are fields of a dataclass, too, by name."""
    names = {field.name for field in fields(noun)}
    return {key: getattr(table, key) for key in type(table).model_fields if key in names}
