"""A scene file with every key, unit and default spelled out, ready to copy."""

import json
import types
from collections.abc import Iterator
from copy import deepcopy
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from compare.scenes import file as files
from compare.scenes.load import parse, read_scene, scene_path


def listing(name_or_path: str) -> str:
    """The scene as TOML: keys that it sets, and as comments those that it leaves at their defaults."""
    path = scene_path(name_or_path)
    _, table = read_scene(path)
    parse(deepcopy(table), path)
    plain_keys = [key for key, field in files.SceneFile.model_fields.items() if not _is_table(field)]
    lines = list(_entries(files.SceneFile, table, only=plain_keys))
    for name in ("lower", "upper", "patch", "grid", "calibration", "engine"):
        field = files.SceneFile.model_fields[name]
        lines += ["", f"# {field.description}", f"[{name}]"]
        lines += _entries(_model(field.annotation), table.get(name, {}))
        lines += _contour_kinds() if name == "lower" else []
    lines += ["", f"# {files.SceneFile.model_fields['effective'].description}"]
    lines += _effective(table.get("effective", {}))
    lines += ["", f"# {files.SceneFile.model_fields['lines'].description}"]
    default = files.default_lines(table["patch"].get("s", 0.0))
    for entry in table.get("lines", [line.model_dump() for line in default]):
        kind = files.LineAlongX if entry["along"] == "x" else files.LineAlongS
        lines += ["[[lines]]", *_entries(kind, entry)]
    return "\n".join(lines) + "\n"


def _effective(table: dict[str, Any]) -> Iterator[str]:
    """Yield the effective properties that are given, and as comments how to give the others."""
    for name, field in files.EffectiveTable.model_fields.items():
        given = name in table
        yield f"{'' if given else '# '}[effective.{name}]  # {field.description}"
        yield from _entries(files.PropertiesTable, table[name]) if given else ()
        if name == "combined":
            yield from _entries(files.CombinedTable, table.get(name, {}), only=["curvature"])
    keys = files.TransitionTable.model_fields.items()
    yield "#   mismatch_k, G or nu = { " + ", ".join(f"{key} = ..." for key, _ in keys) + " }"
    yield from (f"#     {key}: {field.description}" for key, field in keys)


def _contour_kinds() -> Iterator[str]:
    """Yield all kinds of contours with their keys, as comments."""
    yield "#   contours:"
    for kind in (files.Plane, files.Arc, files.Ellipse, files.PointsFile):
        name = get_args(kind.model_fields["kind"].annotation)[0]
        keys = [f"{key}: {field.description}" for key, field in kind.model_fields.items() if key != "kind"]
        yield f'#   kind = "{name}": {kind.model_fields["kind"].description}'
        yield from (f"#     {key}" for key in keys)


def _is_table(field: FieldInfo) -> bool:
    return _model(field.annotation) is not None or "Line" in str(field.annotation)


def _model(annotation: Any) -> Any:
    return annotation if isinstance(annotation, type) and issubclass(annotation, BaseModel) else None


def _entries(model: type[BaseModel], table: dict[str, Any], only: list[str] | None = None) -> Iterator[str]:
    for key, field in model.model_fields.items():
        if only is not None and key not in only:
            continue
        if key in table:
            yield f"{key} = {_toml(table[key])}  # {field.description}"
        else:
            default = field.get_default()
            shown = "..." if default is None else _toml(default)
            yield f"# {key} = {shown}  # {field.description}"
        choices = _choices(field.annotation)
        if choices:
            yield (
                f"#   one or more of: {', '.join(choices)}"
                if "tuple" in str(field.annotation)
                else (f"#   one of: {', '.join(choices)}")
            )


def _choices(annotation: Any) -> list[str]:
    """The literal values that a key may take."""
    if get_origin(annotation) in (tuple, types.UnionType):
        return [choice for part in get_args(annotation) for choice in _choices(part)]
    values = get_args(annotation) if str(annotation).startswith("typing.Literal") else ()
    return [f'"{value}"' for value in values] if len(values) > 1 else []


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else str(value)
