"""Scenes from a built-in name, a TOML file or a table; errors of a scene are raised together."""

import tomllib
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
from femic.scenes.input_files import make_files_absolute
from femic.scenes.messages import messages
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

BUILTIN = Path(__file__).parent / "builtin"
DEEPEST = 30  # tables and lists within each other; a scene has 5
SHORTENED = 200  # characters of a reason that are shown


def builtin_names() -> list[str]:
    """Return the names of the built-in scenes."""
    return sorted(path.stem for path in BUILTIN.glob("*.toml"))


def load_scene(name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> Scene:
    """Return the scene of a built-in name or a TOML file, with some keys changed; raise WrongInput.

    `changes` has the keys of a scene file; names of files in it are relative to the working directory, as in
    `scene_from_table`. A table in it replaces only those keys that it names; one that
    names a `kind` replaces the whole table.
    """
    if not isinstance(name_or_path, str | Path):
        raise WrongInput(f"name_or_path = {name_or_path!r}: give text or a pathlib.Path")
    if not isinstance(changes, Mapping | None):
        raise WrongInput(f"changes = {changes!r}: give a mapping (dict) or None")
    path = scene_path(str(name_or_path))
    text, table = read_scene(path)
    if changes:
        table = merged(table, changes)
        make_files_absolute(table, SceneFile)
    file = parse(table, path)
    return build_scene(name_of(path), tomlkit.dumps(table) if changes else text, file)


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
    """Return the scene of a table with the keys of a scene file, for use from Python; raise BadScene."""
    table = deepcopy(table)
    make_files_absolute(table, SceneFile)
    return build_scene(name, tomlkit.dumps(table), parse(table, Path(name)))


def read_scene(path: Path) -> tuple[str, dict[str, Any]]:
    """Return the text and the table of a scene file, with absolute paths of the files that it names.

    Raises BadScene for files that are no TOML.
    """
    text, table = read_toml(path)
    relative = deepcopy(table)
    make_files_absolute(table, SceneFile, path.parent)
    if table != relative:
        document = tomlkit.parse(text)  # with its comments
        make_files_absolute(document, SceneFile, path.parent)
        text = tomlkit.dumps(document)
    return text, table


def read_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """Return the text and the table of a TOML file; raise BadScene for other files."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
        if _depth(table) > DEEPEST:
            raise RecursionError
    except RecursionError as error:
        reason = f"tables and lists within each other more than {DEEPEST} deep"
        raise _not_toml(path, reason) from error
    except ValueError as error:  # neither UTF-8 nor TOML, or an integer of thousands of digits
        raise _not_toml(path, str(error)[:SHORTENED]) from error
    return text, table


def _depth(value: Any) -> int:
    """Return how deep tables and lists lie within each other."""
    if not isinstance(value, dict | list):
        return 0
    entries = value.values() if isinstance(value, dict) else value
    return 1 + max((_depth(entry) for entry in entries), default=0)


def _not_toml(path: Path, reason: str) -> BadScene:
    return BadScene(f"{path}: not TOML: {reason}. Compare with `femic scenes --show flat`")


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


def name_of(path: Path) -> str:
    """Return the name that results of a file have; raise BadScene for one that no folder can have."""
    name = path.stem
    if not name.strip(" .") or not name.isprintable():
        raise BadScene(
            f"{str(path)!r}: its name without ending names the folder of results, and no folder can be "
            f"called {name!r}: rename it"
        )
    return name


def parse(table: dict[str, Any], path: Path) -> SceneFile:
    """Validate the keys and values of a scene table; raise BadScene, which names its file."""
    try:
        return SceneFile.model_validate(table)
    except ValidationError as error:
        raise bad_scene(path, messages(error.errors())) from error
