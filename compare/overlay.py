"""Overlay of the results of several scenes: what they have in common, curves, errors, differences."""

import csv
import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from compare import scene_file as files
from compare.scene import Scene
from compare.scenes import build_scene, builtin_names, parse, read_scene, scene_path
from femic.provenance import code_digest
from geometries.errors import WrongInput

Array = NDArray[np.float64]

MOST = 5  # scenes in one overlay: line styles that the eye can tell apart
MIRRORED = 1e-6  # of the largest value on a line
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
class Content:
    """What results have curves and errors of."""

    bodies: tuple[str, ...]
    components: tuple[str, ...]
    variants: tuple[str, ...]
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Source:
    """One of the scenes to overlay, and the folder of its results."""

    name: str
    folder: Path
    content: Content
    scene: Scene | None  # None: a result folder, taken as it is
    text: str
    files: tuple[Path, ...] = ()  # of points, that the scene reads


@dataclass(frozen=True)
class Result:
    """The results of one scene."""

    name: str
    ics: xr.Dataset
    errors: xr.Dataset

    @property
    def reference_length(self) -> float:
        """Unit of length L of the scene [mm]."""
        return float(self.ics.attrs["reference_length"])

    @property
    def unit(self) -> float:
        """E · L [N/mm]: makes the scene's ICs dimensionless."""
        return float(self.ics.attrs["reference_E"]) * self.reference_length


@dataclass(frozen=True)
class Overlay:
    """Results of two or more scenes, and what all of them have."""

    common: Content
    results: tuple[Result, ...]


@dataclass(frozen=True)
class Curve:
    """One component of one body on a line, dimensionless: coordinate / L, IC · E · L; (n,) each."""

    along: Literal["x", "s"]
    at: Array
    values: Mapping[str, Array]  # by variant, C among them
    estimate: Array


@dataclass(frozen=True)
class Difference:
    """A key of the scene file that is not the same in all scenes."""

    key: str
    meaning: str
    values: list[str]


def sources(arguments: Sequence[str], results: Path) -> tuple[Source, ...]:
    """The scenes that names, TOML files and result folders mean; raises WrongInput."""
    if not 2 <= len(arguments) <= MOST:
        given = ", ".join(arguments) or "none"
        raise WrongInput(f"scenes = {given}: {len(arguments)} of them; give 2 to {MOST}")
    found = tuple(_source(argument, results) for argument in arguments)
    for k, source in enumerate(found):
        for other, argument in zip(found[:k], arguments, strict=False):
            if source.name == other.name:
                raise WrongInput(
                    f"scenes = {argument}, {arguments[k]}: {source.name!r} twice; "
                    "give different scenes, or rename one of them"
                )
    return found


def _source(argument: str, results: Path) -> Source:
    if argument not in builtin_names() and Path(argument).is_dir():
        return _of_folder(Path(argument))
    path = scene_path(argument)
    text, table = read_scene(path)
    parsed = parse(deepcopy(table), path)
    scene = build_scene(path.stem, text, parsed)
    content = _content(parsed, [line.name for line in scene.lines])
    contours = (parsed.lower.contour, parsed.upper.contour)
    read = tuple(c.file for c in contours if isinstance(c, files.PointsFile) and c.file is not None)
    return Source(scene.name, results / scene.name, content, scene, text, read)


def _of_folder(folder: Path) -> Source:
    try:
        ics, _ = _read(folder)
        text, lines = ics.attrs["scene"], list(dict.fromkeys(ics.line.values.tolist()))
    except (OSError, KeyError) as error:
        raise WrongInput(
            f"{folder}: no ics.nc and errors.nc of femic in this folder ({error}); "
            "give one that `femic run` finished, or a scene"
        ) from error
    return Source(folder.resolve().name, folder, _content(_parsed(text, folder), lines), None, text)


def _parsed(text: str, folder: Path) -> files.SceneFile:
    """The scene that a text describes; the files of points that it names need not be there."""
    table = tomllib.loads(text)
    for body in ("lower", "upper"):
        if "file" in table[body]["contour"]:
            table[body]["contour"]["file"] = __file__
    return parse(table, folder / "scene.toml")


def _content(parsed: files.SceneFile, lines: Sequence[str]) -> Content:
    return Content(parsed.bodies, parsed.components, parsed.variants, tuple(lines))


def common(found: Sequence[Source]) -> Content:
    """What all scenes have, in the order of the first; raises WrongInput where that is not enough."""
    contents = {source.name: asdict(source.content) for source in found}
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
    """Whether the folder has the results of the scene and of the code as they are now."""
    try:
        ics, _ = _read(source.folder)
    except OSError:  # missing, or no NetCDF file
        return False
    written = (source.folder / "ics.nc").stat().st_mtime
    points_changed = any(path.stat().st_mtime > written for path in source.files)
    same_code = ics.attrs.get("code") == code_digest()
    return ics.attrs.get("scene") == source.text and same_code and not points_changed


def load(found: Sequence[Source]) -> Overlay:
    """Read the results of all scenes from their folders."""
    return Overlay(common(found), tuple(Result(source.name, *_read(source.folder)) for source in found))


def _read(folder: Path) -> tuple[xr.Dataset, xr.Dataset]:
    """ICs and errors."""
    ics, errors = (xr.load_dataset(folder / name, engine="h5netcdf") for name in ("ics.nc", "errors.nc"))
    return ics, errors


def curve(result: Result, line: str, body: str, component: str) -> Curve:
    """All curves of one scene in one panel."""
    on_line = result.ics.isel(point=np.flatnonzero(result.ics.line.values == line))
    found = on_line.sel(body=body, i=component[0], j=component[1])
    along: Literal["x", "s"] = "x" if np.ptp(on_line.s.values) == 0 else "s"
    values = {str(v): found.ic.sel(variant=v).values * result.unit for v in found.variant.values}
    at = on_line[along].values / result.reference_length
    return Curve(along, at, values, found.estimate.values * result.unit)


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether every curve of every scene repeats itself, up to its sign, on the other half of a line."""
    return all(
        _repeats(curve(result, line, body, component))
        for result, body, component in product(
            overlay.results, overlay.common.bodies, overlay.common.components
        )
    )


def _repeats(drawn: Curve) -> bool:
    if drawn.along == "x":
        return True  # all bodies and loads are symmetric in x
    sizes = np.abs(list(drawn.values.values()))
    asymmetry = np.max(np.abs(sizes - sizes[:, ::-1]))
    return np.allclose(drawn.at, -drawn.at[::-1]) and bool(asymmetry <= MIRRORED * np.max(sizes))


def worst(overlay: Overlay, result: Result, body: str, component: str) -> dict[str, float]:
    """Worst error over the common lines of each common variant, and that estimated of C under "C"."""
    of_component = result.errors["max"].sel(
        body=body, i=component[0], j=component[1], line=list(overlay.common.lines)
    )
    largest = of_component.max("line", skipna=False)
    return {variant: largest.sel(variant=variant).item() for variant in (*overlay.common.variants, "C")}


def write_curves(overlay: Overlay, folder: Path) -> None:
    """One CSV per line: a row per scene, body, component and point, a column per variant [-]."""
    variants = (*overlay.common.variants, "C")
    for line in overlay.common.lines:
        along = curve(overlay.results[0], line, overlay.common.bodies[0], overlay.common.components[0]).along
        name = line.replace(" ", "").replace("=", "")
        with (folder / f"curves_{name}.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{along}/L", *variants, "estimate"])
            for result, body, component in product(
                overlay.results, overlay.common.bodies, overlay.common.components
            ):
                drawn = curve(result, line, body, component)
                columns = [drawn.at, *(drawn.values[variant] for variant in variants), drawn.estimate]
                for row in np.column_stack(columns):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])


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
    chosen = {key: settings[name] for name, key in FILLED_IN.items()}
    programs = {"code": attributes.get("code", ABSENT)} | json.loads(attributes["versions"])
    return (
        _flat(_parsed(text, Path(result.name)).model_dump())
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
