"""Messages about a scene file, one line per error: field = value: reason; remedy."""

import re
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from pydantic_core import ErrorDetails

from femic.scenes.contact import ContactTable
from femic.scenes.engine import EngineTable
from femic.scenes.scene_table import SceneTable, tables
from femic.scenes.stresses import StressTable

REASONS: Mapping[str, str] = {
    "tuple_type": "Input should be a list",
    "bool_type": "Input should be true or false",
}
LIMITS: Mapping[str, str] = {"ge": "at least", "le": "at most", "gt": "greater than", "lt": "less than"}
OPTIONS = ("workers", "cells")  # of commands
REMEDIES: Mapping[str, str] = {
    "missing": "add the key",
    "path_not_file": "give a path to an existing file, relative to the scene file",
}


def messages(details: Sequence[ErrorDetails]) -> list[str]:
    """Return errors of validation as lines, one per value.

    Where a value may be of several types, only errors of its own type are listed, or of all types.
    """
    typed_fields = [f"{_field(detail)}." for detail in details if not _is_about_container(detail)]
    by_field: dict[str, list[ErrorDetails]] = {}
    for detail in details:
        field = _field(detail)
        has_inner_error = any(inner.startswith(f"{field}.") for inner in typed_fields)
        if not (_is_about_container(detail) and has_inner_error):
            by_field.setdefault(field, []).append(detail)
    return [
        " or ".join([message(first), *(_reason(other).removeprefix("Input should be ") for other in others)])
        for first, *others in by_field.values()
    ]


def _is_about_container(detail: ErrorDetails) -> bool:
    """Whether an error is about a whole value: of another type, or without enough valid entries."""
    return detail["type"].endswith("_type") or detail["type"] == "too_short"


def in_keys(message: object) -> str:
    """Return a message in which `names` are keys of a scene file or options of commands."""
    text = re.sub(r"`workers` = (\d+)", r"--workers \1", str(message))
    return re.sub(r"`(\w+)`", lambda match: _key_of(match[1]), text)


def _key_of(name: str) -> str:
    if name in OPTIONS:
        return f"--{name}"
    tables: dict[str, type[SceneTable]] = {
        "engine": EngineTable,
        "contact": ContactTable,
        "stresses": StressTable,
    }
    return next((f"{key}.{name}" for key, table in tables.items() if name in table.model_fields), name)


def _field(detail: ErrorDetails) -> str:
    return ".".join(str(part) for part in _without_tags(detail["loc"]))


def message(detail: ErrorDetails) -> str:
    """Return one error as a line: field = value: reason; remedy."""
    field = _field(detail)
    kind = detail["type"]
    if not field:  # about the whole table: its reason names the keys
        return _reason(detail)
    if kind == "extra_forbidden":
        key = str(detail["loc"][-1])
        similar = get_close_matches(key, sorted(_keys() - {key}), n=1)
        hint = f"did you mean {similar[0]!r}?" if similar else "see `femic scenes --show flat` for all keys"
        return f"{field}: unknown key; {hint}"
    value = "" if kind == "missing" else f" = {_shown(detail['input'])}"
    remedy = f"; {REMEDIES[kind]}" if kind in REMEDIES else ""
    return f"{field}{value}: {_reason(detail)}{remedy}"


def _reason(detail: ErrorDetails) -> str:
    """Return the reason why a value is wrong."""
    if detail["type"] == "too_short":
        return f"give at least {detail['ctx']['min_length']} entries"
    for limit, words in LIMITS.items():
        if limit in detail.get("ctx", {}):
            return f"Input should be {words} {detail['ctx'][limit]:g}"
    return REASONS.get(detail["type"], detail["msg"].removeprefix("Value error, "))


def _shown(value: object) -> str:
    return str(value) if isinstance(value, Path) else repr(value)[:80]


def _without_tags(location: tuple[int | str, ...]) -> Iterator[int | str]:
    """Yield the location without the names of union members that pydantic inserts."""
    for k, part in enumerate(location):
        previous = location[k - 1] if k else None
        is_line_kind = isinstance(previous, int) and part in {"x", "s"} and location[0] == "lines"
        is_flank_type = previous == "flank_inclination_deg" and isinstance(part, str)
        if not (is_line_kind or is_flank_type):
            yield part


def _keys() -> set[str]:
    """Return all keys that any table of a scene file may have."""
    return {key for table in tables() for key in table.model_fields}
