"""The settings in which the scenes of an overlay differ."""

import json
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compare.overlay.results import Overlay, SceneResults
from compare.overlay.sources import scene_of_text
from femic.scenes.file import SceneFile
from femic.scenes.input_files import replace_files
from femic.scenes.scene_table import tables

ABSENT_TEXT, DEFAULT_TEXT = "–", "default"  # shown for a missing key and for a value of None
FILLED_IN = {  # settings of results that have computed defaults, and the scene file's keys for them
    "reference_length [mm]": "reference_length",
    "rotation_reach [mm]": "rotation_reach",
    "moment_arm [mm]": "moment_arm",
    "first smallest_cell [mm]": "engine.smallest_cell",
    "first growth": "engine.growth",
    "first line_growth": "engine.line_growth",
}


@dataclass(frozen=True)
class Difference:
    """A key of the scene file whose value is not the same in all scenes, with the value of each scene."""

    key: str
    meaning: str
    values: list[str]


def differences(overlay: Overlay) -> Iterator[Difference]:
    """Yield all keys that scenes set differently, defaults filled in, and programs that differ."""
    settings = [_settings(result) for result in overlay.results]
    meanings = _meanings()
    keys = dict.fromkeys(key for setting in settings for key in setting)
    tables = list(dict.fromkeys(key.rpartition(".")[0] for key in keys))
    for key in sorted(keys, key=lambda key: tables.index(key.rpartition(".")[0])):
        values = [_shown(setting.get(key, ABSENT_TEXT)) for setting in settings]
        if len(set(values)) > 1:
            yield Difference(key, meanings.get(key.rpartition(".")[2], ""), values)


def _settings(result: SceneResults) -> dict[str, Any]:
    """Return all keys of a scene by dotted name, and "computed with ..." for its code and versions."""
    attributes = result.ics.attrs
    text = attributes["scene"]
    given, nameless = tomllib.loads(text), tomllib.loads(text)
    replace_files(nameless, SceneFile, lambda _: "")
    replaced = _flat(nameless)
    file_names = {key: value for key, value in _flat(given).items() if value != replaced[key]}
    settings = json.loads(attributes["settings"])
    computed_defaults = {key: settings[name] for name, key in FILLED_IN.items() if name in settings}
    programs = {"code": attributes.get("code", ABSENT_TEXT)} | json.loads(attributes["versions"])
    return (
        _flat(scene_of_text(text, Path(result.name)).model_dump())
        | file_names
        | computed_defaults
        | {"title": attributes["title"]}
        | {f"computed with {program}": version for program, version in programs.items()}
    )


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """Flatten nested tables and lists of tables into one table with dotted keys."""
    if isinstance(value, dict):
        entries = dict(value)
    elif isinstance(value, list | tuple) and any(isinstance(entry, dict) for entry in value):
        entries = dict(enumerate(value))
    else:
        return {key: value}
    parts = (_flat(entry, f"{key}.{name}" if key else str(name)) for name, entry in entries.items())
    return {name: entry for part in parts for name, entry in part.items()}


def _meanings() -> dict[str, str]:
    """Return descriptions of the scene file's keys, without keys whose description depends on the table."""
    descriptions: dict[str, set[str]] = {}
    for section in tables():
        for key, field in section.model_fields.items():
            descriptions.setdefault(key, set()).add(field.description or "")
    return {key: next(iter(texts)) for key, texts in descriptions.items() if len(texts) == 1}


def _shown(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_shown(entry) for entry in value)
    return DEFAULT_TEXT if value is None else f"{value:g}" if isinstance(value, float) else str(value)
