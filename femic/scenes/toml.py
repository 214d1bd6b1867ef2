"""Reading TOML: any text gives a table or raises `NotToml`."""

import tomllib
from typing import Any

DEEPEST = 30  # tables and lists within each other; a scene has 5
SHORTENED = 200  # characters of a reason that are shown


class NotToml(ValueError):
    """A text that is not TOML, or too large."""


def table_of(text: str) -> dict[str, Any]:
    """Return the table of a text; raise NotToml."""
    try:
        table = tomllib.loads(text)
    except RecursionError as error:
        raise _too_deep() from error
    except ValueError as error:  # not TOML, or an integer of thousands of digits
        raise NotToml(str(error)[:SHORTENED]) from error
    _require_shallow(table)
    return table


def _require_shallow(table: dict[str, Any]) -> None:
    """Raise NotToml where tables and lists lie deeper within each other than `DEEPEST`."""
    layer: list[Any] = [table]
    for _ in range(DEEPEST):
        layer = [inner for outer in layer for inner in _entries(outer)]
        if not layer:
            return
    raise _too_deep()


def _entries(outer: Any) -> list[Any]:
    """Return the tables and lists in a table or list."""
    inside = outer.values() if isinstance(outer, dict) else outer
    return [inner for inner in inside if isinstance(inner, dict | list)]


def _too_deep() -> NotToml:
    return NotToml(f"tables and lists within each other more than {DEEPEST} deep")
