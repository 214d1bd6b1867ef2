"""Scenes from a built-in name, a TOML file or a table; errors of a scene are raised together.

Messages have one line per error: field = value: reason; remedy.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from femic.contact.specification import APPROACH_SHARE
from femic.reference.harmonic.request import FAR_RADIUS
from femic.reference.job import Settings
from femic.scenes.bodies import body_of
from femic.scenes.calibration import (
    calibration_misfits,
    calibration_of,
    effective_misfits,
    effective_properties,
)
from femic.scenes.contact import (
    ContactTable,
    StressTable,
    contact_misfits,
    contact_of,
    damage_misfits,
    damage_of,
    stress_misfits,
    stresses_of,
)
from femic.scenes.engine import EngineTable, engine_misfits
from femic.scenes.errors import BadScene, bad_scene, require_none
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute
from femic.scenes.lines import (
    default_lines,
    figure_grid,
    grid_misfits,
    line_of,
    patch_of,
    single_load_misfits,
)
from femic.scenes.scene import Scene
from femic.scenes.scene_table import SceneTable, shared, tables
from femic.scenes.wants import want_misfits
from geometries.bodies import Body, common_extent
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.surfaces import LOWER, UPPER

# --- names, files and tables ----------------------------------------------------------------------------


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
    build = build_scene if scene.engine.engine.has_fields else check_scene
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


# --- the scene of valid tables --------------------------------------------------------------------------


SIDES = {"lower": LOWER, "upper": UPPER}
FLAT_REFERENCE_LENGTH = 10.0  # mm


def build_scene(name: str, text: str, file: SceneFile) -> Scene:
    """Return the scene of a valid file; raise BadScene where its parts do not fit together."""
    bodies = {
        body: body_of(getattr(file, body), body, side, file.engine.domain) for body, side in SIDES.items()
    }
    reference_length = file.reference_length or _crown_radius(bodies["lower"].contour)
    extent, room = common_extent(bodies), _discount_room(bodies)
    rotation_reach = file.rotation_reach or min(2 * reference_length, room)
    patch = patch_of(file.patch, rotation_reach)
    settings = Settings(
        engine=file.engine.engine,
        cells=file.engine.cells(patch),
        rotation_reach=rotation_reach,
        moment_arm=file.moment_arm or min(reference_length / 2, room / 2),
        approach_side=reference_length / APPROACH_SHARE,
        **shared(file.engine, Settings),
    )
    resolved = {
        "name": name,
        "title": file.title or name,
        "text": text,
        "bodies": bodies,
        "compared": file.bodies,
        "effective": effective_properties(file.effective),
        "curvature_apart": file.effective.curvature_apart,
        "calibration": calibration_of(file.calibration, patch, reference_length, extent),
        "patch": patch,
        "lines": tuple(line_of(line, extent) for line in file.lines or default_lines(patch.s)),
        "grid": figure_grid(file.grid, patch),
        "checked_strips": file.grid.check,
        "contact": contact_of(file.contact),
        "stresses": stresses_of(file.stresses),
        "damage": damage_of(file.damage),
        "support_radius": file.engine.far_radius or FAR_RADIUS,
        "settings": settings,
        "reference_length": reference_length,
        "check": check_scene(name, text, file) if file.engine.needs_check else None,
    }
    scene = Scene(**shared(file, Scene) | resolved)
    require_none(name, list(_table_misfits(scene, file)))
    return scene


def check_scene(name: str, text: str, file: SceneFile) -> Scene:
    """Return the scene with the engine that checks others."""
    return build_scene(name, text, file.model_copy(update={"engine": file.engine.check_engine}))


def misfits(scene: Scene) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene that each scene has."""
    yield from engine_misfits(scene)
    yield from contact_misfits(scene)
    yield from stress_misfits(scene)
    yield from want_misfits(scene)
    yield from effective_misfits(scene)


def _table_misfits(scene: Scene, file: SceneFile) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene; of some tables only where they are given.

    A contact without C has no use for the patch and the lines.
    """
    yield from misfits(scene)
    contact = scene.contact
    if {"patch", "lines"} & file.model_fields_set or "C" in contact.ics or not contact.loadings:
        yield from single_load_misfits(scene)
    yield from damage_misfits(scene, file.damage)
    if "grid" in file.model_fields_set:
        yield from grid_misfits(scene)
    if "calibration" in file.model_fields_set:
        yield from calibration_misfits(scene)


def _discount_room(bodies: dict[str, Body]) -> float:
    """Return the distance from the contact centre within which the discount has room [mm]."""
    domain, extent = bodies["lower"].domain, common_extent(bodies)
    turn = min(2 * np.pi * body.rolling_radius for body in bodies.values())
    return float(min(domain.far_radius / 8, domain.half_length / 8, turn / 6, -extent[0], extent[1]))


def _crown_radius(contour: Contour) -> float:
    """Return the radius of curvature at s = 0 [mm]; `FLAT_REFERENCE_LENGTH` where the contour is flat."""
    step = 1e-4
    inclinations = contour.core.inclination(np.array([-step, step]))
    curvature = float(np.ptp(inclinations)) / (2 * step)
    return 1 / abs(curvature) if abs(curvature) > 1e-6 else FLAT_REFERENCE_LENGTH


# --- messages -------------------------------------------------------------------------------------------


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
    value = "" if kind == "missing" else f" = {_value_text(detail['input'])}"
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


def _value_text(value: object) -> str:
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
