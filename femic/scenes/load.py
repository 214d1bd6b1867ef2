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

from femic.contact.specification import APPROACH_SHARE, ContactSpecification
from femic.reference.harmonic.request import FAR_RADIUS
from femic.reference.job import Settings
from femic.scenes.calibration import calibration_misfits, effective_misfits
from femic.scenes.contact import (
    ContactTable,
    StressTable,
    contact_misfits,
    contact_specification,
    damage_misfits,
    damage_specification,
    stress_misfits,
)
from femic.scenes.engine import EngineTable, engine_misfits
from femic.scenes.errors import BadScene, bad_scene, require_none
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute
from femic.scenes.lines import LineAlongS, LineAlongX, default_lines, grid_misfits, single_load_misfits
from femic.scenes.scene import Scene, StressSpecification
from femic.scenes.scene_table import SceneTable, shared, tables
from femic.scenes.wants import want_misfits
from femic.tables.specification import TableSpecification
from geometries.bodies import common_extent
from geometries.errors import WrongInput
from geometries.patches import OffsetLine, Patch
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

    `changes` takes keys of a scene file; file names in it are relative to the working directory. A table in
    it replaces only the keys that it names; a table that names a `kind` replaces the whole table.
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
    file = parse(table, path)
    return build_scene(name_of(path), text, file if file.engine.engine.has_fields else file.with_check_engine)


def scene_from_table(table: dict[str, Any], name: str) -> Scene:
    """Return the scene of a table with the keys of a scene file; raise BadScene."""
    table = deepcopy(table)
    make_files_absolute(table, SceneFile)
    file = parse(table, Path(name))
    return build_scene(name, tomlkit.dumps(table), file)


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

    def depth(value: Any) -> int:
        """Return how deep tables and lists lie within each other."""
        if not isinstance(value, dict | list):
            return 0
        return 1 + max(map(depth, value.values() if isinstance(value, dict) else value), default=0)

    try:
        text = path.read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
        if depth(table) > DEEPEST:
            raise RecursionError
    except (RecursionError, ValueError) as error:  # no UTF-8, no TOML, or an integer of thousands of digits
        too_deep = f"tables and lists within each other more than {DEEPEST} deep"
        reason = too_deep if isinstance(error, RecursionError) else str(error)[:SHORTENED]
        raise BadScene(
            f"{path}: not valid TOML: {reason}. Compare with `femic scenes --show flat`"
        ) from error
    return text, table


def scene_path(name_or_path: str) -> Path:
    """Return the path of the scene file of a built-in name or of a path; raise BadScene if there is none."""
    builtin = BUILTIN / f"{name_or_path}.toml"
    path = builtin if name_or_path in builtin_names() else Path(name_or_path)
    if not path.is_file():
        similar = get_close_matches(name_or_path, builtin_names(), cutoff=0.7)
        hint = f"did you mean {' or '.join(map(repr, sorted(similar)))}? " if similar else ""
        raise BadScene(
            f"scene {name_or_path!r}: neither a file nor a built-in scene; {hint}Built-in: "
            f"{', '.join(builtin_names())}"
        )
    return path


def name_of(path: Path) -> str:
    """Return the name that results of a file have; raise BadScene for one that no folder can have."""
    name = path.stem
    if not name.strip(" .") or not name.isprintable():
        raise BadScene(
            f"{str(path)!r}: the name without its ending is used for the folder of results, and no folder "
            f"can be called {name!r}: rename it"
        )
    return name


def parse(table: Mapping[str, Any], path: Path) -> SceneFile:
    """Validate the keys and values of a scene; raise BadScene, which names its file."""
    try:
        return SceneFile.model_validate(table)
    except ValidationError as error:
        raise bad_scene(path, messages(error.errors())) from error


# --- the scene of valid keys ----------------------------------------------------------------------------


FLAT_REFERENCE_LENGTH = 10.0  # mm
PATCHES_IN_REACH = 100.0  # rotation_reach over the half-sides of a patch that is not given


def build_scene(
    name: str,
    text: str,
    file: SceneFile,
    lines: Sequence[LineAlongX | LineAlongS | OffsetLine] | None = None,
    contact: ContactSpecification | None = None,
) -> Scene:
    """Return the scene of valid keys; raise BadScene where they do not fit together.

    `lines` and `contact` take the place of those of the file: Python knows points and gaps that no file has.
    """
    engine, domain = file.engine, file.engine.domain
    bodies = {
        "lower": file.lower.body("lower", LOWER, domain),
        "upper": file.upper.body("upper", UPPER, domain),
    }
    extent = common_extent(bodies)
    step = 1e-4  # mm
    crown = float(np.ptp(bodies["lower"].contour.core.inclination(np.array([-step, step])))) / (2 * step)
    crown_radius = 1 / abs(crown) if abs(crown) > 1e-6 else FLAT_REFERENCE_LENGTH
    reference_length = file.reference_length or crown_radius
    turn = min(2 * np.pi * body.rolling_radius for body in bodies.values())
    room = float(min(domain.far_radius / 8, domain.half_length / 8, turn / 6, -extent[0], extent[1]))
    rotation_reach = file.rotation_reach or min(2 * reference_length, room)
    default_side = rotation_reach / PATCHES_IN_REACH
    patch = Patch(**file.patch.model_dump()) if file.patch else Patch(default_side, default_side)
    settings = Settings(
        engine=engine.engine,
        cells=engine.cells(patch),
        rotation_reach=rotation_reach,
        moment_arm=file.moment_arm or min(reference_length / 2, room / 2),
        approach_side=reference_length / APPROACH_SHARE,
        **shared(engine, Settings),
    )
    if lines is None:
        lines = file.lines or default_lines(patch.s)
    resolved = {
        "name": name,
        "title": file.title or f"{name} ({file.upper.words} on {file.lower.words})",
        "text": text,
        "bodies": bodies,
        "compared": file.bodies,
        "effective": file.effective.properties,
        "curvature_apart": file.effective.curvature_apart,
        "calibration": file.calibration.calibration(patch, reference_length, extent),
        "patch": patch,
        "lines": tuple(line if isinstance(line, OffsetLine) else line.line(extent) for line in lines),
        "grid": file.grid.grid(patch),
        "checked_strips": file.grid.check,
        "contact": contact or contact_specification(file.contact),
        "stresses": StressSpecification(**dict(file.stresses)),
        "damage": damage_specification(file.damage),
        "table": TableSpecification(**dict(file.table)),
        "support_radius": engine.far_radius or FAR_RADIUS,
        "settings": settings,
        "reference_length": reference_length,
        "check": build_scene(name, text, file.with_check_engine, lines) if engine.needs_check else None,
    }
    scene = Scene(**shared(file, Scene) | resolved)
    require_none(name, list(_misfits(scene, file)))
    return scene


def _misfits(scene: Scene, file: SceneFile) -> Iterator[str]:
    """Yield what does not fit together in a scene; of some tables only where they are given.

    A contact without C has no use for the patch and the lines.
    """
    yield from engine_misfits(scene)
    yield from contact_misfits(scene)
    yield from stress_misfits(scene)
    yield from want_misfits(scene)
    yield from effective_misfits(scene)
    contact, given = scene.contact, file.model_fields_set
    if {"patch", "lines"} & given or "C" in contact.ics or not contact.loadings:
        yield from single_load_misfits(scene)
    yield from damage_misfits(scene, file.damage)
    if "grid" in given:
        yield from grid_misfits(scene)
    if "calibration" in given:
        yield from calibration_misfits(scene)


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

    Where a value may be of several types, only errors of its own type are listed, or of all types. An error
    about a whole value (of another type, or without enough valid entries) gives way to those within it.
    """
    whole = [detail["type"].endswith("_type") or detail["type"] == "too_short" for detail in details]
    names = [_field(detail) for detail in details]
    typed = [f"{name}." for name, is_whole in zip(names, whole, strict=True) if not is_whole]
    by_field: dict[str, list[ErrorDetails]] = {}
    for name, is_whole, detail in zip(names, whole, details, strict=True):
        if not (is_whole and any(inner.startswith(f"{name}.") for inner in typed)):
            by_field.setdefault(name, []).append(detail)
    return [
        " or ".join([message(first), *(_reason(other).removeprefix("Input should be ") for other in others)])
        for first, *others in by_field.values()
    ]


def message(detail: ErrorDetails) -> str:
    """Return one error as a line: field = value: reason; remedy."""
    field, kind = _field(detail), detail["type"]
    if not field:  # about the whole table: its reason names the keys
        return _reason(detail)
    if kind == "extra_forbidden":
        key = str(detail["loc"][-1])
        known = sorted({key for table in tables() for key in table.model_fields} - {key})
        similar = get_close_matches(key, known, n=1)
        hint = f"did you mean {similar[0]!r}?" if similar else "see `femic scenes --show flat` for all keys"
        return f"{field}: unknown key; {hint}"
    given = detail["input"]
    text = str(given) if isinstance(given, Path) else repr(given)[:80]
    value = "" if kind == "missing" else f" = {text}"
    remedy = f"; {REMEDIES[kind]}" if kind in REMEDIES else ""
    return f"{field}{value}: {_reason(detail)}{remedy}"


def _field(detail: ErrorDetails) -> str:
    """Return the dotted name of a value, without the names of union members that pydantic inserts."""
    location = detail["loc"]
    parts = []
    for part, previous in zip(location, (None, *location), strict=False):
        is_line_kind = isinstance(previous, int) and part in {"x", "s"} and location[0] == "lines"
        is_flank_type = previous == "flank_inclination_deg" and isinstance(part, str)
        if not (is_line_kind or is_flank_type):
            parts.append(str(part))
    return ".".join(parts)


def _reason(detail: ErrorDetails) -> str:
    """Return the reason why a value is wrong."""
    if detail["type"] == "too_short":
        return f"give at least {detail['ctx']['min_length']} entries"
    for limit, words in LIMITS.items():
        if limit in detail.get("ctx", {}):
            return f"Input should be {words} {detail['ctx'][limit]:g}"
    return REASONS.get(detail["type"], detail["msg"].removeprefix("Value error, "))


def in_keys(message: object) -> str:
    """Return a message in which `names` are keys of a scene file or options of commands."""

    def key(match: re.Match[str]) -> str:
        name = match[1]
        if name in OPTIONS:
            return f"--{name}"
        of_tables: dict[str, type[SceneTable]] = {
            "engine": EngineTable,
            "contact": ContactTable,
            "stresses": StressTable,
        }
        return next((f"{key}.{name}" for key, table in of_tables.items() if name in table.model_fields), name)

    return re.sub(r"`(\w+)`", key, re.sub(r"`workers` = (\d+)", r"--workers \1", str(message)))
