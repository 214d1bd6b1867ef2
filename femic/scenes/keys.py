"""Keys of the table of a scene, such as lower.contour.radius and lines.0.s."""

from collections.abc import Mapping, Sequence
from typing import Any

from femic.scenes.errors import BadScene


def set_key(table: Any, key: str, entry: Any, axis: str) -> None:
    """Set a key such as lower.contour.radius or lines.0.s of a table, for an axis; raise BadScene."""
    *path, last = key.split(".")
    for part in path:
        if isinstance(table, list):
            table = table[_index(table, part, key, axis)]
        else:
            table = table.setdefault(part, {})
        if not isinstance(table, (dict, list)):
            raise BadScene(f"sweep.{axis}: {key}: {part} is a value, not a table")
    if isinstance(table, list):
        table[_index(table, last, key, axis)] = entry
    else:
        table[last] = entry


def key_of(table: Any, key: str, axis: str) -> Any:
    """Return the value of a key such as lower.contour.radius of a table, for an axis; raise BadScene."""
    for part in key.split("."):
        if isinstance(table, list):
            table = table[_index(table, part, key, axis)]
        elif isinstance(table, Mapping) and part in table:
            table = table[part]
        else:
            raise BadScene(f"{key}: not in the scene, which has to give it: it is swept as {axis}")
    return table


def _index(entries: Sequence[Any], part: str, key: str, axis: str) -> int:
    if not (part.isdigit() and int(part) < len(entries)):
        raise BadScene(f"sweep.{axis}: {key}: {part}: a number from 0 to {len(entries) - 1} is needed there")
    return int(part)
