"""What is wrong with a scene file, as one line per error: field = value: what is wrong; remedy."""

import re
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from compare.scenes import file as files

REMEDIES: Mapping[str, str] = {
    "missing": "add the key",
    "file_not_file": "give a path to an existing file, relative to the scene file",
    "path_not_file": "give a path to an existing file, relative to the scene file",
}


def messages(details: Sequence[ErrorDetails]) -> list[str]:
    """Errors as lines; where a value may be of several types, only of that which it has."""
    of_right_type = [f"{_field(one)}." for one in details if not one["type"].endswith("_type")]
    return [
        message(one)
        for one in details
        if not (one["type"].endswith("_type") and any(f.startswith(f"{_field(one)}.") for f in of_right_type))
    ]


def in_keys(message: object) -> str:
    """A message of `femic` in the words of a scene file: its `names` as keys, or options of the commands."""
    return re.sub("`(\\w+)`", lambda found: _key_of(found[1]), str(message))


def _key_of(name: str) -> str:
    if name in files.EngineTable.model_fields:
        return f"engine.{name}"
    return f"--{name}" if name == "workers" else name


def _field(detail: ErrorDetails) -> str:
    return ".".join(str(part) for part in _without_tags(detail["loc"]))


def message(detail: ErrorDetails) -> str:
    """One error as: field = value: what is wrong; remedy."""
    field = _field(detail)
    kind = detail["type"]
    if kind == "extra_forbidden":
        key = str(detail["loc"][-1])
        near = get_close_matches(key, sorted(_keys(files.SceneFile) - {key}), n=1)
        hint = f"did you mean {near[0]!r}?" if near else "see `femic scenes --show flat` for all keys"
        return f"{field}: unknown key; {hint}"
    value = "" if kind == "missing" else f" = {_shown(detail['input'])}"
    remedy = f"; {REMEDIES[kind]}" if kind in REMEDIES else ""
    message = detail["msg"].removeprefix("Value error, ")
    return f"{field}{value}: {message}{remedy}"


def _shown(value: object) -> str:
    return str(value) if isinstance(value, Path) else repr(value)[:80]


def _without_tags(location: tuple[int | str, ...]) -> Iterator[int | str]:
    """The location without the names of union members that pydantic inserts."""
    tags = {"plane", "arc", "ellipse", "points"}
    for k, part in enumerate(location):
        previous = location[k - 1] if k else None
        of_contour = previous == "contour" and part in tags
        of_line = isinstance(previous, int) and part in {"x", "s"} and location[0] == "lines"
        of_flanks = previous == "flank_inclination_deg" and isinstance(part, str)
        if not (of_contour or of_line or of_flanks):
            yield part


def _keys(model: type[BaseModel]) -> set[str]:
    """All keys that any table of a scene file may have."""
    tables = [model, *files.Section.__subclasses__()]
    return {key for table in tables for key in table.model_fields}
