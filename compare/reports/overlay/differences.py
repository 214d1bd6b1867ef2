"""What the scenes of an overlay set differently."""

import json
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compare.reports.overlay.curves import Overlay, Result
from compare.reports.overlay.sources import scene_of_text
from compare.scenes import file as files

ABSENT, DEFAULT = "–", "default"
FILLED_IN = {  # keys of a scene file with computed defaults, by their names in the settings of results
    "reference_length [mm]": "reference_length",
    "rotation_reach [mm]": "rotation_reach",
    "moment_arm [mm]": "moment_arm",
    "first smallest_cell [mm]": "engine.smallest_cell",
    "first growth": "engine.growth",
    "first line_growth": "engine.line_growth",
}


@dataclass(frozen=True)
class Difference:
    """A key of the scene file that is not the same in all scenes."""

    key: str
    meaning: str
    values: list[str]


def differences(overlay: Overlay) -> Iterator[Difference]:
    """What the scenes set differently, defaults filled in; and the programs that computed them."""
    settings = [_settings(result) for result in overlay.results]
    meanings = _meanings()
    keys = dict.fromkeys(key for setting in settings for key in setting)
    tables = list(dict.fromkeys(key.rpartition(".")[0] for key in keys))
    for key in sorted(keys, key=lambda key: tables.index(key.rpartition(".")[0])):
        values = [_shown(setting.get(key, ABSENT)) for setting in settings]
        if len(set(values)) > 1:
            yield Difference(key, meanings.get(key.rpartition(".")[2], ""), values)


def _settings(result: Result) -> dict[str, Any]:
    """Every key of a scene file under its dotted name, and "computed with" its code and versions."""
    attributes = result.ics.attrs
    text = attributes["scene"]
    named = {key: value for key, value in _flat(tomllib.loads(text)).items() if key.endswith(".file")}
    settings = json.loads(attributes["settings"])
    chosen = {key: settings[name] for name, key in FILLED_IN.items() if name in settings}
    programs = {"code": attributes.get("code", ABSENT)} | json.loads(attributes["versions"])
    return (
        _flat(scene_of_text(text, Path(result.name)).model_dump())
        | named
        | chosen
        | {"title": attributes["title"]}
        | {f"computed with {program}": version for program, version in programs.items()}
    )


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """Nested tables and lists of tables as one, under dotted keys."""
    if isinstance(value, dict):
        entries = dict(value)
    elif isinstance(value, list | tuple) and any(isinstance(entry, dict) for entry in value):
        entries = dict(enumerate(value))
    else:
        return {key: value}
    parts = (_flat(entry, f"{key}.{name}" if key else str(name)) for name, entry in entries.items())
    return {name: entry for part in parts for name, entry in part.items()}


def _meanings() -> dict[str, str]:
    """What the keys of a scene file mean, where a key means the same in every table."""
    said: dict[str, set[str]] = {}
    for section in files.Section.__subclasses__():
        for key, field in section.model_fields.items():
            said.setdefault(key, set()).add(field.description or "")
    return {key: next(iter(texts)) for key, texts in said.items() if len(texts) == 1}


def _shown(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_shown(entry) for entry in value)
    return DEFAULT if value is None else f"{value:g}" if isinstance(value, float) else str(value)
