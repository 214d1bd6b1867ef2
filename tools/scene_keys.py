"""The keys of scenes, campaigns and wheelsets as rows of tables, from what checks these files."""

import re
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import BaseModel, TypeAdapter
from pydantic.fields import FieldInfo

from compare.campaigns.keys import AxisTable, CampaignFile
from compare.campaigns.kinds import KINDS
from femic.contact.motions import MOTIONS
from femic.key_types import LARGEST, LARGEST_LENGTH, LEAST_LENGTH
from femic.scenes.bodies import CONTOURS, OutlineTable
from femic.scenes.calibration import CombinedTable, TransitionTable
from femic.scenes.file import SceneFile
from femic.scenes.lines import LineAlongS, LineAlongX
from femic.scenes.listing import TABLES, as_toml, choices, inner_tables, table_in
from femic.scenes.load import builtin_names, load_scene
from femic.scenes.profiles import OF_FILES
from femic.shifts.specification import (
    ContactTable,
    RollingTable,
    ShiftsFile,
    TrackTable,
    WheelsetTable,
    WheelTable,
)

UNITS = (
    *("mm", "MPa", "N", "deg", "1/mm", "m/s", "kg/m^3", "W/mm^2", "N/mm^2"),
    *("µg/J", "µg/m/N", "µg/m/mm^2"),
)
UNIT = re.compile(rf" ?\[({'|'.join(map(re.escape, UNITS))})\]")
DEFAULT = re.compile(r"(?:^|[;,] )default: (.*)$")
OF_MOTION = re.compile(r"^(?:steady|transient|steady or transient) rolling: ")
PAGE = re.compile(r"docs/([\w/-]+)\.md")
RANGES = {
    (LEAST_LENGTH, LARGEST_LENGTH): "length",
    (-LARGEST_LENGTH, LARGEST_LENGTH): "place",
    (1 / LARGEST, LARGEST): "amount",
    (-LARGEST, LARGEST): "signed amount",
}
SHIFT_TABLES: dict[str, Any] = {  # of a specification of femic shifts
    "wheel": WheelTable,
    "track": TrackTable,
    "wheelset": WheelsetTable,
    "rolling": RollingTable,
    "contact": ContactTable,
}
CONTAINERS = ("effective", "lines")  # keys of a scene with tables of several kinds
SHARED_BY_LINES = ("along", "reach", "points")  # keys of lines along x and along s


def scene_keys() -> dict[str, Any]:
    """Return what the page on keys shows, by the names of its template."""
    fields = SceneFile.model_fields
    simple = [key for key in fields if key not in (*TABLES, *CONTAINERS)]
    return {
        "scene": rows(SceneFile, only=simple),
        "tables": {key: part for name in TABLES for key, part in tables_of(name, fields[name]).items()},
        "contours": {name: (told(table, "kind"), rows(table, "kind")) for name, table in CONTOURS.items()},
        "effective": (fields["effective"].description, rows(CombinedTable), rows(TransitionTable)),
        "outline": rows(OutlineTable),
        "lines": (fields["lines"].description, rows(LineAlongX), rows(LineAlongS, *SHARED_BY_LINES)),
        "campaign": rows(CampaignFile),
        "axis": rows(AxisTable),
        "kinds": list(KINDS),
        "shifts": rows(ShiftsFile, "rail", "right_rail", "right_wheel", *SHIFT_TABLES),
        "shift_tables": {name: rows(table, *OF_FILES) for name, table in SHIFT_TABLES.items()},
        "of_files": [key for key in OF_FILES if key in WheelTable.model_fields],
        "builtin": {name: load_scene(name).title for name in builtin_names()},
    }


def tables_of(name: str, field: FieldInfo) -> dict[str, tuple[str, list[dict[str, str]]]]:
    """Return description and rows of a table, and of the tables in it, by their names."""
    table = table_in(field)
    inner = inner_tables(table)
    found = {name: (field.description or "", rows(table, *inner))}
    for key, part in inner.items():
        found |= tables_of(f"{name}.{key}", part)
    return found


def told(table: type[BaseModel], key: str) -> str:
    return table.model_fields[key].description or ""


def rows(table: type[BaseModel], *without: str, only: list[str] | None = None) -> list[dict[str, str]]:
    """Return a row for each key of a table."""
    fields = {key: field for key, field in table.model_fields.items() if key not in without}
    return [row(table, key, field) for key, field in fields.items() if only is None or key in only]


def row(table: type[BaseModel], key: str, field: FieldInfo) -> dict[str, str]:
    """Return name, type with limits, unit, default and meaning of a key."""
    text = PAGE.sub(r"[\1](../\1.md)", field.description or "")
    units, explained = UNIT.findall(text), DEFAULT.search(text)
    meaning = DEFAULT.sub("", text)
    if len(units) == 1:
        meaning = UNIT.sub("", meaning)
    if table is table_in(SceneFile.model_fields["contact"]) and (motions := motions_of(key)):
        meaning = f"*{motions}*: {OF_MOTION.sub('', meaning)}"
    return {
        "key": field.alias or key,
        "type": "table" if key == "outline" else type_of(field),
        "unit": units[0] if units else "",
        "default": explained[1] if explained else default_of(field),
        "meaning": meaning,
    }


def motions_of(key: str) -> str:
    """Return the motions that use a key of [contact], "" where all do."""
    return ", ".join(name for name, motion in MOTIONS.items() if key in motion.keys)


def default_of(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.get_default()
    if default is None or isinstance(default, BaseModel):
        return "none"
    return f"`{as_toml(default)}`"


def type_of(field: FieldInfo) -> str:
    """Return the type of the values of a key, with its limits."""
    names = [f"`{name[1:-1]}`" for name in (*choices(field.annotation), *choices(*field.metadata))]
    annotated: Any = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
    parts = described(TypeAdapter(annotated).json_schema(), ", ".join(names))
    return " or ".join(dict.fromkeys(parts))


def described(schema: dict[str, Any], names: str) -> Iterator[str]:
    """Yield the types that a schema allows; `names` are those of the values, where only some are allowed."""
    if "anyOf" in schema:
        for part in schema["anyOf"]:
            yield from described(part, names)
    elif schema.get("format") == "file-path":
        yield "file"
    elif "const" in schema:
        yield f"`{schema['const']}`"
    elif schema.get("type") == "string":
        yield ", ".join(f"`{name}`" for name in schema.get("enum", ())) or names or "text"
    elif schema.get("type") == "boolean":
        yield "true or false"
    elif schema.get("type") in ("number", "integer"):
        yield number(schema)
    elif schema.get("type") == "array":
        yield from list_of(schema, names)
    elif schema.get("type") != "null":
        yield "table"


def list_of(schema: dict[str, Any], names: str) -> Iterator[str]:
    """Yield the type of a list, or of a pair of the same type."""
    pair = schema.get("prefixItems")
    items = (
        " or ".join(described(pair[0] if pair else schema["items"], names)) if pair or schema["items"] else ""
    )
    kind = "pair" if pair else "list"
    yield f"{kind} of {items}" if items else kind


def number(schema: dict[str, Any]) -> str:
    """Return the type of a number, with its limits."""
    low, above = (schema.get(key) for key in ("minimum", "exclusiveMinimum"))
    high, below = (schema.get(key) for key in ("maximum", "exclusiveMaximum"))
    low, high = schema.get("ge", low), schema.get("le", high)  # of whole numbers
    if (low, high) in RANGES:
        return RANGES[low, high]
    words = {"at least": low, "above": above, "at most": high, "below": below}
    limits = ", ".join(f"{word} {limit:g}" for word, limit in words.items() if limit is not None)
    if low is not None and high is not None:
        limits = f"{low:g} … {high:g}"
    kind = "whole number" if schema["type"] == "integer" else "number"
    return f"{kind} ({limits})" if limits else kind
