"""The scenes of an overlay: the folders of their results, their common content, and settings that differ."""

import json
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from compare.pages import ics as run
from femic.results.ics_dataset import ERRORS
from femic.scenes import receipts
from femic.scenes.file import SceneFile
from femic.scenes.input_files import replace_files
from femic.scenes.load import builtin_names, load_scene, parse
from femic.scenes.scene import Scene
from femic.scenes.scene_table import tables
from geometries.errors import WrongInput

# --- folders --------------------------------------------------------------------------------------------


MOST_SCENES = 5  # in one overlay: as many as there are line styles that the eye can tell apart


@dataclass(frozen=True)
class Content:
    """The bodies, components, variants and lines that results have curves and errors for."""

    bodies: tuple[str, ...]
    components: tuple[str, ...]
    variants: tuple[str, ...]
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Source:
    """A scene to overlay, or a folder of results, with the folder that its results are in."""

    name: str
    folder: Path
    content: Content
    scene: Scene | None  # None: a folder of results, which is not computed again


def sources(arguments: Sequence[str], results: Path) -> tuple[Source, ...]:
    """Return the sources that names, TOML files and folders of results stand for.

    Raises WrongInput if there are fewer than 2 or more than `MOST_SCENES`, or if a name occurs twice.
    """
    if not 2 <= len(arguments) <= MOST_SCENES:
        given = ", ".join(arguments) or "none"
        raise WrongInput(f"scenes = {given}: {len(arguments)} of them; give 2 to {MOST_SCENES}")
    overlaid = tuple(_source(argument, results) for argument in arguments)
    for k, source in enumerate(overlaid):
        for earlier, argument in zip(overlaid[:k], arguments, strict=False):
            if source.name == earlier.name:
                raise WrongInput(
                    f"scenes = {argument}, {arguments[k]}: {source.name!r} twice; "
                    "give different scenes, or rename one of them"
                )
    return overlaid


def _source(argument: str, results: Path) -> Source:
    if argument not in builtin_names() and Path(argument).is_dir():
        return _folder_source(Path(argument))
    scene = load_scene(argument)
    lines = tuple(line.name for line in scene.lines)
    content = Content(scene.compared, scene.components, scene.variants, lines)
    return Source(scene.name, results / scene.name, content, scene)


def _folder_source(folder: Path) -> Source:
    try:
        ics, errors = read(folder)
        errors[list(ERRORS)]  # raises KeyError for a file of another version with other variables
        text, lines = ics.attrs["scene"], tuple(dict.fromkeys(ics.line.values.tolist()))
    except (OSError, KeyError) as error:
        raise WrongInput(
            f"{folder}: no ics.nc and errors.nc of femic in this folder ({error}); "
            "give one that `femic run` finished, or a scene"
        ) from error
    if altered := receipts.changed(folder, run.COMMAND):
        raise WrongInput(
            f"{folder}: {', '.join(altered)}: not as `femic run` has written it: run that scene again"
        )
    parsed = scene_of_text(text, folder)
    content = Content(parsed.bodies, parsed.components, parsed.variants, lines)
    return Source(folder.resolve().name, folder, content, None)


def scene_of_text(text: str, folder: Path) -> SceneFile:
    """Return the scene that a text describes; the files that it names need not exist any more."""
    table = tomllib.loads(text)
    replace_files(table, SceneFile, lambda _: __file__)
    return parse(table, folder / "scene.toml")


def common(overlaid: Sequence[Source]) -> Content:
    """Return the content that all scenes have in common, in the order of the first scene.

    Raises WrongInput if they have no body, no component or no line in common.
    """
    contents = {source.name: asdict(source.content) for source in overlaid}
    first, *others = contents.values()
    shared = {kind: tuple(v for v in first[kind] if all(v in o[kind] for o in others)) for kind in first}
    misfits = [
        f"{kind} = "
        + " against ".join(f"[{', '.join(content[kind])}] of {name}" for name, content in contents.items())
        + f": none in common; add one of them to all scenes ({kind})"
        for kind in ("bodies", "components", "lines")
        if not shared[kind]
    ]
    if misfits:
        raise WrongInput("\n  ".join(misfits))
    return Content(**shared)


def up_to_date(source: Source) -> bool:
    """Whether the folder has unchanged results of the present scene, its present files and this code."""
    return source.scene is not None and receipts.holds(source.folder, run.COMMAND, run.key_of(source.scene))


def read(folder: Path) -> tuple[xr.Dataset, xr.Dataset]:
    """Read the ICs [mm/N] and the errors [-] from a folder of results."""
    ics, errors = (xr.load_dataset(folder / name, engine="h5netcdf") for name in ("ics.nc", "errors.nc"))
    return ics, errors


# --- results --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SceneResults:
    """The ICs and errors of one scene, under its name."""

    name: str
    ics: xr.Dataset
    errors: xr.Dataset


@dataclass(frozen=True)
class Overlay:
    """The results of two or more scenes, and the content that all of them have in common."""

    common: Content
    results: tuple[SceneResults, ...]


def load(sources: Sequence[Source]) -> Overlay:
    """Read the results of all sources from their folders; raises WrongInput without common content."""
    return Overlay(
        common(sources), tuple(SceneResults(source.name, *read(source.folder)) for source in sources)
    )


def worst(overlay: Overlay, result: SceneResults, body: str, component: str) -> xr.Dataset:
    """Return the worst error and weight of a component over the common lines [-], by variant; C: estimate.

    Where the component `vanishes`, errors are shares of 0.05 max |C_nn|.
    """
    line_errors = result.errors[["error", "weight", "vanishes"]].sel(
        body=body, i=component[0], j=component[1], line=list(overlay.common.lines)
    )
    return line_errors.max("line", skipna=False)


# --- settings -------------------------------------------------------------------------------------------


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
        values = [_value_text(setting.get(key, ABSENT_TEXT)) for setting in settings]
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


def _value_text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_value_text(entry) for entry in value)
    return DEFAULT_TEXT if value is None else f"{value:g}" if isinstance(value, float) else str(value)
