"""The scenes of an overlay: the folders of their results, their common content, and their state."""

import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import xarray as xr

from compare.ics import run
from compare.ics.dataset import ERRORS
from femic.scenes import receipts
from femic.scenes.file import SceneFile
from femic.scenes.input_files import replace_files
from femic.scenes.load import builtin_names, load_scene, parse
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

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
