"""Tables of scene files, and their conversion to dataclasses."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Annotated, Any, get_type_hints

from pydantic import BaseModel, ConfigDict

LIMIT_SLACK = 1e-9  # share by which rounding may exceed a limit


class SceneTable(BaseModel):
    """A table of a scene file: unknown keys are errors; text and booleans are no numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def shared(table: SceneTable, noun: type[Any]) -> dict[str, Any]:
    """Return the values of keys that are fields of a dataclass, too, by name."""
    names = {field.name for field in fields(noun)}
    return {key: getattr(table, key) for key in type(table).model_fields if key in names}


def declared_keys(noun: type[Any], types: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the keys that a dataclass declares, by name: type and default, as pydantic makes models of them.

    Descriptions and limits are `Annotated` there; `types` are other types of the values of some keys.
    """
    hints = get_type_hints(noun, include_extras=True)
    for key, other in (types or {}).items():
        hints[key] = Annotated[other, *hints[key].__metadata__]
    return {field.name: (hints[field.name], field.default) for field in fields(noun)}


def tables(base: type[SceneTable] = SceneTable) -> Iterator[type[SceneTable]]:
    """Yield all tables that scene and campaign files may have."""
    for table in base.__subclasses__():
        yield table
        yield from tables(table)
