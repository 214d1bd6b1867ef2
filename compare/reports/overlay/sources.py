"""The scenes of an overlay: where their results are, what all have, whether they are up to date."""

import tomllib
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass
from pathlib import Path

import xarray as xr

from compare.results.dataset import ERRORS
from compare.results.provenance import results_digest
from compare.scenes import file as files
from compare.scenes.load import build_scene, builtin_names, parse, read_scene, scene_path
from compare.scenes.scene import Scene
from geometries.errors import WrongInput

MOST = 5  # scenes in one overlay: line styles that the eye can tell apart


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
    return Source(scene.name, results / scene.name, content, scene, text, tuple(scene.files.values()))


def _of_folder(folder: Path) -> Source:
    try:
        ics, errors = read(folder)
        errors[list(ERRORS)]  # what another femic wrote may have others
        text, lines = ics.attrs["scene"], list(dict.fromkeys(ics.line.values.tolist()))
    except (OSError, KeyError) as error:
        raise WrongInput(
            f"{folder}: no ics.nc and errors.nc of femic in this folder ({error}); "
            "give one that `femic run` finished, or a scene"
        ) from error
    return Source(folder.resolve().name, folder, _content(scene_of_text(text, folder), lines), None, text)


def scene_of_text(text: str, folder: Path) -> files.SceneFile:
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
        ics, errors = read(source.folder)
    except OSError:  # missing, or no NetCDF file
        return False
    written = (source.folder / "ics.nc").stat().st_mtime
    points_changed = any(path.stat().st_mtime > written for path in source.files)
    same_code = all(dataset.attrs.get("code") == results_digest() for dataset in (ics, errors))
    return ics.attrs.get("scene") == source.text and same_code and not points_changed


def read(folder: Path) -> tuple[xr.Dataset, xr.Dataset]:
    """ICs and errors."""
    ics, errors = (xr.load_dataset(folder / name, engine="h5netcdf") for name in ("ics.nc", "errors.nc"))
    return ics, errors
