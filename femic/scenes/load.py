"""Scenes from a built-in name, a TOML file or a table; errors of a scene are raised together."""

from collections.abc import Mapping
from copy import deepcopy
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import tomlkit
from pydantic import ValidationError

from femic.scenes.build import build_scene, check_scene
from femic.scenes.errors import BadScene, bad_scene
from femic.scenes.file import SceneFile
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.messages import messages
from femic.scenes.names import name_of
from femic.scenes.scene import Scene
from femic.scenes.toml import NotToml, table_of

BUILTIN = Path(__file__).parent / "builtin"


def builtin_names() -> list[str]:
    """Return the names of the built-in scenes."""
    return sorted(path.stem for path in BUILTIN.glob("*.toml"))


def load_scene(name_or_path: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """Return the scene of a built-in name or a TOML file, with some keys changed; raise WrongInput.

    `changes` has the keys of a scene file. A table in it replaces only those keys that it names; one that
    names a `kind` replaces the whole table.
    """
    path = scene_path(name_or_path)
    text, table = read_scene(path)
    if changes:
        table = merged(table, changes)
        text = tomlkit.dumps(table)
    return build_scene(name_of(path), text, parse(table, path))


def merged(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with some keys changed, as of `load_scene`."""
    changed = dict(table)
    for key, value in changes.items():
        old = table.get(key)
        if isinstance(value, Mapping) and isinstance(old, Mapping) and "kind" not in value:
            changed[key] = merged(old, value)
        else:
            changed[key] = deepcopy(value)
    return changed


def load_solid_scene(name_or_path: str) -> Scene:
    """Return the scene of a name or TOML file with an engine that has fields in 3D: its own or the solid one.

    Raises BadScene.
    """
    path = scene_path(name_or_path)
    text, table = read_scene(path)
    scene = parse(table, path)
    build = build_scene if scene.engine.engine.fields else check_scene
    return build(name_of(path), text, scene)


def scene_from_table(table: dict[str, Any], name: str) -> Scene:
    """Return the scene of a table with the keys of a scene file, for use from Python; raise BadScene.

    Names of files in it are relative to the working directory.
    """
    return build_scene(name, tomlkit.dumps(table), parse(deepcopy(table), Path(name)))


def read_scene(path: Path) -> tuple[str, dict[str, Any]]:
    """Return the text and the table of a TOML file; raise BadScene for other files."""
    try:
        text = path.read_text(encoding="utf-8")
        return text, table_of(text)
    except (NotToml, UnicodeDecodeError) as error:
        raise BadScene(f"{path}: not TOML: {error}. Compare with `femic scenes --show flat`") from error


def scene_path(name_or_path: str) -> Path:
    """Return the path of the scene file of a built-in name or of a path; raise BadScene if there is none."""
    builtin = BUILTIN / f"{name_or_path}.toml"
    path = builtin if name_or_path in builtin_names() else Path(name_or_path)
    if not path.is_file():
        similar = get_close_matches(name_or_path, builtin_names(), cutoff=0.7)
        hint = f"did you mean {' or '.join(map(repr, sorted(similar)))}? " if similar else ""
        raise BadScene(
            f"scene {name_or_path!r}: no such file and no built-in scene; {hint}"
            f"Built-in: {', '.join(builtin_names())}"
        )
    return path


def parse(table: dict[str, Any], path: Path) -> SceneFile:
    """Validate the keys and values of a scene table; raise BadScene.

    Names of files in it are relative to the scene file, `path`.
    """
    resolve_files(table, path.parent)
    try:
        return SceneFile.model_validate(table)
    except ValidationError as error:
        raise bad_scene(path, messages(error.errors())) from error


def resolve_files(table: dict[str, Any], folder: Path) -> None:
    """Make names of files in a scene table relative to a folder instead of the working directory."""
    places = [(table.get(body, {}), "contour", "file") for body in ("lower", "upper")]
    for of_body, *keys in [*places, (table, "contact", "extra_gap")]:
        inner = of_body.get(keys[0], {}) if isinstance(of_body, dict) else {}
        if isinstance(inner, dict) and isinstance(inner.get(keys[1]), str):
            inner[keys[1]] = str(folder / inner[keys[1]])
    contact = table.get("contact", {})
    ics = contact.get("ics") if isinstance(contact, dict) else None
    if isinstance(ics, list):
        contact["ics"] = [_with_folder(name, folder) for name in ics]


def _with_folder(ics: Any, folder: Path) -> Any:
    """Return the name of ICs; of a map with its folder."""
    if not (isinstance(ics, str) and is_map(ics)):
        return ics
    return MAP + str(folder / ics.removeprefix(MAP))
