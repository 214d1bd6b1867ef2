"""A scene file with every key, unit and default spelled out, ready to copy."""

import types
from collections.abc import Iterator
from copy import deepcopy
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import tomlkit
from pydantic import AfterValidator, BaseModel
from pydantic.fields import FieldInfo

from femic.key_types import NameOf
from femic.scenes.bodies import CONTOURS
from femic.scenes.calibration import CombinedTable, EffectiveTable, PropertiesTable, TransitionTable
from femic.scenes.file import SceneFile
from femic.scenes.lines import LineAlongS, LineAlongX, default_lines
from femic.scenes.load import parse, read_scene, scene_path

TABLES = (
    "lower",
    "upper",
    "patch",
    "grid",
    "calibration",
    "contact",
    "stresses",
    "damage",
    "table",
    "engine",
)


def listing(name_or_path: str) -> str:
    """Return the scene as TOML: keys that it sets, and as comments those that it leaves at their defaults."""
    path = scene_path(name_or_path)
    _, table = read_scene(path)
    parse(deepcopy(table), path)
    fields = SceneFile.model_fields
    plain_keys = [key for key in fields if key not in (*TABLES, "effective", "lines")]
    lines = list(_entries(SceneFile, table, only=plain_keys))
    for name in TABLES:
        model, given = table_in(fields[name]), table.get(name, {})
        lines += ["", f"# {fields[name].description}", f"{'' if name in table else '# '}[{name}]"]
        lines += _entries(model, given)
        for key, field in inner_tables(model).items():
            lines.append(f"{'' if key in given else '# '}[{name}.{key}]  # {field.description}")
            lines += _entries(table_in(field), given.get(key, {}))
        if name == "lower":
            lines.append("#   contours:")
        for kind, contour in CONTOURS.items() if name == "lower" else ():
            keys = contour.model_fields
            lines.append(f'#   kind = "{kind}": {keys["kind"].description}')
            lines += [f"#     {key}: {field.description}" for key, field in keys.items() if key != "kind"]
    lines += ["", f"# {fields['effective'].description}"]
    effective = table.get("effective", {})
    for name, field in EffectiveTable.model_fields.items():
        lines.append(f"{'' if name in effective else '# '}[effective.{name}]  # {field.description}")
        lines += _entries(PropertiesTable, effective[name]) if name in effective else ()
        if name == "combined":
            lines += _entries(CombinedTable, effective.get(name, {}), only=["curvature"])
    transition = TransitionTable.model_fields
    lines.append(f"#   mismatch_k, G or nu = {{ {', '.join(f'{key} = ...' for key in transition)} }}")
    lines += [f"#     {key}: {field.description}" for key, field in transition.items()]
    lines += ["", f"# {fields['lines'].description}"]
    default = default_lines(table.get("patch", {}).get("s", 0.0))
    for entry in table.get("lines", [line.model_dump() for line in default]):
        lines += ["[[lines]]", *_entries(LineAlongX if entry["along"] == "x" else LineAlongS, entry)]
    return "\n".join(lines) + "\n"


def inner_tables(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the keys of a table whose values are tables with defaults of their own."""
    fields = model.model_fields.items()
    return {key: field for key, field in fields if isinstance(field.default, BaseModel)}


def table_in(field: FieldInfo) -> type[BaseModel]:
    """Return the table that a key holds, or may hold."""
    if isinstance(field.default, BaseModel):
        return type(field.default)
    annotation: Any = field.annotation
    return next((part for part in get_args(annotation) if part is not types.NoneType), annotation)


def _entries(model: type[BaseModel], table: dict[str, Any], only: list[str] | None = None) -> Iterator[str]:
    for key, field in model.model_fields.items():
        if key in inner_tables(model) or (only is not None and key not in only):
            continue
        if key in table:
            yield f"{key} = {as_toml(table[key])}  # {field.description}"
        else:
            default = None if field.is_required() else field.get_default()
            shown = "..." if default is None else as_toml(default)
            yield f"# {key} = {shown}  # {field.description}"
        if allowed := [*choices(field.annotation), *choices(*field.metadata)]:
            number = "one or more" if "tuple" in str(field.annotation) else "one"
            yield f"#   {number} of: {', '.join(allowed)}"


def choices(*annotations: Any) -> Iterator[str]:
    """Yield the names that a key may take, in quotes."""
    for annotation in annotations:
        if get_origin(annotation) in (tuple, types.UnionType, Union, Annotated):
            yield from choices(*get_args(annotation))
        elif isinstance(annotation, AfterValidator) and isinstance(annotation.func, NameOf):
            yield from (f'"{name}"' for name in annotation.func.names())
        elif get_origin(annotation) is Literal and len(get_args(annotation)) > 1:
            yield from (f'"{value}"' for value in get_args(annotation))


def as_toml(value: Any) -> str:
    """Return a value as TOML; a table in a single line."""
    if not isinstance(value, dict):
        return tomlkit.item(value).as_string()
    table = tomlkit.inline_table()
    table.update(value)
    return table.as_string()
