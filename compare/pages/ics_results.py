"""`femic run` computes a scene and writes its results; `femic compare` reads those of several scenes."""

import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from compare.pages import ics as pages
from compare.pages import ics_details
from compare.pages.body_fields import write_fields
from compare.pages.ics import Scenes
from compare.pages.ics_details import SceneICs
from compare.pages.ics_figures import along_line, components_in, lines_in
from compare.pages.scene_pictures import pictures
from compare.report import files
from compare.report.parts import Folded, Items, Section, Verbatim, write_page
from compare.report.tables import Row, Table, texts
from femic.cache import folders
from femic.cache.digests import PAGE_FOLDERS, results_digest
from femic.cache.files import replacing, write_dataset, write_text
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results import ics_dataset as data
from femic.results.ics import compute
from femic.results.ics_dataset import ERRORS, curves_file
from femic.scenes import receipts
from femic.scenes.file import SceneFile
from femic.scenes.input_files import replace_files
from femic.scenes.load import builtin_names, load_scene, parse
from femic.scenes.scene import Scene
from femic.scenes.scene_table import tables
from geometries.errors import WrongInput

# --- one scene ------------------------------------------------------------------------------------------


COMMAND = "run"
FILES = ("ics.nc", "errors.nc", "report.html")


def run_scene(scene: Scene, out: Path, options: RunOptions = DEFAULT) -> Path:
    """Compute the scene; write `ics.nc`, `errors.nc`, CSV files, figures and `report.html`; return its path.

    Solved models are stored, so that an interrupted run continues after the last of them. Nothing is computed
    if the folder has the same results already, unless pictures or fields have to be written.
    """
    path, key = out / "report.html", results_key(scene)
    only_results = not (files.figures_wanted() or scene.settings.engine.has_fields)
    if only_results and receipts.holds(out, COMMAND, key):
        options.watch.on_stage("  already in the folder")
        return path
    curves = [curves_file(line.name) for line in scene.lines]
    with receipts.renewed(out, COMMAND, key, [*FILES, *curves, "scene.toml"]):
        results = compute(scene, options)
        ics = data.to_dataset(results)
        errors = data.errors(results, ics)
        write_dataset(ics, out / "ics.nc")
        write_dataset(errors, out / "errors.nc")
        data.write_curves(ics, scene.components, out)
        write_text(scene.text, out / "scene.toml")
        shown = SceneICs(ics, errors)
        drawn = list(pictures(results, out / "figures"))
        page = pages.page(scene.title, {scene.name: shown}, ics_details.details(shown, drawn))
        write_page(page, path)
        if scene.fields:
            write_fields(results, out / "fields", options.watch)
    return path


def results_key(scene: Scene) -> str:
    """Return the key of all inputs of the ICs and errors of a scene."""
    return receipts.key_of(scene, results_digest(*PAGE_FOLDERS))


# --- several scenes -------------------------------------------------------------------------------------


MOST_SCENES = 5  # in one overlay: as many as there are line styles that the eye can tell apart
Content = Mapping[str, tuple[str, ...]]  # bodies, components, variants and lines of results


class Source(NamedTuple):
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
        raise WrongInput(f"scenes = {given}: {len(arguments)} given; give 2 to {MOST_SCENES}")
    overlaid: dict[str, tuple[str, Source]] = {}
    for argument in arguments:
        source = _source(argument, results)
        if source.name in overlaid:
            raise WrongInput(
                f"scenes = {overlaid[source.name][0]}, {argument}: {source.name!r} twice; "
                "give different scenes, or rename one of them"
            )
        overlaid[source.name] = argument, source
    return tuple(source for _, source in overlaid.values())


def _source(argument: str, results: Path) -> Source:
    folder = Path(argument)
    if argument in builtin_names() or not folder.is_dir():
        scene = load_scene(argument)
        content = {
            "bodies": scene.compared,
            "components": scene.components,
            "variants": scene.variants,
            "lines": tuple(line.name for line in scene.lines),
        }
        return Source(scene.name, results / scene.name, content, scene)
    try:
        ics, errors = read(folder)
        errors[list(ERRORS)]  # raises KeyError for a file of another version with other variables
        content = {
            "bodies": tuple(map(str, ics.body.values)),
            "components": tuple(components_in(ics)),
            "variants": tuple(v for v in map(str, ics.variant.values) if v not in ("C", "C_solid")),
            "lines": tuple(lines_in(ics)),
        }
    except (OSError, KeyError) as error:
        raise WrongInput(
            f"{folder}: no ics.nc and errors.nc of femic in this folder ({error}); "
            "give one that `femic run` finished, or a scene"
        ) from error
    if altered := receipts.changed(folder, COMMAND):
        raise WrongInput(
            f"{folder}: {', '.join(altered)}: changed since `femic run` wrote it; run that scene again"
        )
    return Source(folder.resolve().name, folder, content, None)


def read(folder: Path) -> SceneICs:
    """Read the ICs [mm/N] and the errors [-] from a folder of results."""
    return SceneICs(*(xr.load_dataset(folder / name, engine="h5netcdf") for name in FILES[:2]))


def up_to_date(source: Source) -> bool:
    """Whether the folder has unchanged results of the present scene, its present files and this code."""
    return source.scene is not None and receipts.holds(source.folder, COMMAND, results_key(source.scene))


def common(overlaid: Sequence[Source]) -> Content:
    """Return the content that all scenes have in common, in the order of the first scene.

    Raises WrongInput if they have no body, no component or no line in common.
    """
    first, *others = (source.content for source in overlaid)
    shared = {kind: tuple(v for v in first[kind] if all(v in o[kind] for o in others)) for kind in first}
    misfits = [
        f"{kind} = "
        + " against ".join(f"[{', '.join(source.content[kind])}] of {source.name}" for source in overlaid)
        + f": nothing in common; add one of them to all scenes ({kind})"
        for kind in ("bodies", "components", "lines")
        if not shared[kind]
    ]
    if misfits:
        raise WrongInput("\n  ".join(misfits))
    return shared


def load(overlaid: Sequence[Source]) -> Scenes:
    """Read the results of all sources, as far as all have them; raises WrongInput without common content."""
    shared, scenes = common(overlaid), {}
    for source in overlaid:
        ics, errors = read(source.folder)
        part = {"body": list(shared["bodies"]), "variant": [*shared["variants"], "C"]}
        points = [np.flatnonzero(ics.line.values == line) for line in shared["lines"]]
        ics = ics.sel(part).isel(point=np.concatenate(points))
        ics = ics.assign_attrs(components=json.dumps(shared["components"]))
        scenes[source.name] = SceneICs(ics, errors.sel(part | {"line": list(shared["lines"])}))
    return scenes


def overlay_folder(overlaid: Sequence[Source], out: Path | None, results: Path) -> Path:
    """Return the folder of the overlay; raises WrongInput if it holds the results of a scene."""
    folder = folders.check(out or results / "_".join(source.name for source in overlaid))
    if (folder / "ics.nc").exists() or folder.resolve() in [source.folder.resolve() for source in overlaid]:
        raise WrongInput(f"--out {folder}: this folder holds the results of a scene; name another folder")
    return folder


def write_overlay(scenes: Scenes, folder: Path) -> Path:
    """Write figures, a CSV file per line and `report.html` into a folder; returns the report's path.

    CSV files have a row per scene, body, component and point, a column per variant, dimensionless.
    """
    folders.make(folder)
    ics = {name: scene.ics for name, scene in scenes.items()}
    first = next(iter(ics.values()))
    for line in lines_in(first):
        parts = []
        for (name, one), body, component in product(
            ics.items(), map(str, first.body.values), components_in(first)
        ):
            part = along_line(one, line, body, component, dimensionless=True)
            named = {"scene": name, "body": body, "component": component}
            columns = {head: np.full(part.sizes["point"], text) for head, text in named.items()}
            columns[f"{part.across[0]}/L"] = part["at"].values
            columns |= {str(v): part.ic.sel(variant=v).values for v in part.variant.values}
            columns["estimate"] = part.estimate.values
            parts.append(xr.Dataset({head: ("row", column) for head, column in columns.items()}))
        with replacing(folder / curves_file(line)) as unfinished:
            table = xr.concat(parts, "row").to_pandas()
            table.to_csv(unfinished, index=False, float_format="%.8g", na_rep="nan")
    titles = Items([f"{name}: {one.attrs['title']}" for name, one in ics.items()])
    scene_files = [Folded(name, [Verbatim(one.attrs["scene"])]) for name, one in ics.items()]
    rows = [
        Row("" if k else key, [name, value])
        for key, values in differences(ics).items()
        for k, (name, value) in enumerate(zip(ics, values, strict=True))
    ]
    listed = Table("key" if rows else "key (nothing differs)", texts("scene", "value"), rows)
    details: list[Section | Folded] = [
        Section("", [titles]),
        Folded("Differences between the scenes", [listed]),
        Folded("Scene files", scene_files),
    ]
    return write_page(pages.page(", ".join(scenes), scenes, details), folder / "report.html")


# --- settings that differ -------------------------------------------------------------------------------


ABSENT_TEXT, DEFAULT_TEXT = "–", "default"  # shown for a missing key and for a value of None
FILLED_IN = {  # settings of results that have computed defaults, and the scene file's keys for them
    "reference_length [mm]": "reference_length",
    "rotation_reach [mm]": "rotation_reach",
    "moment_arm [mm]": "moment_arm",
    "first smallest_cell [mm]": "engine.smallest_cell",
    "first growth": "engine.growth",
    "first line_growth": "engine.line_growth",
}


def differences(ics: Mapping[str, xr.Dataset]) -> dict[str, list[str]]:
    """Return keys that scenes set differently, defaults filled in, with their meaning and all values.

    Programs that computed the results are among them.
    """
    settings = [_settings(name, one.attrs) for name, one in ics.items()]
    descriptions: dict[str, set[str]] = {}  # of keys; those that depend on the table are not shown
    for section in tables():
        for key, field in section.model_fields.items():
            descriptions.setdefault(key, set()).add(field.description or "")
    keys = dict.fromkeys(key for setting in settings for key in setting)
    sections = list(dict.fromkeys(key.rpartition(".")[0] for key in keys))
    found = {}
    for key in sorted(keys, key=lambda key: sections.index(key.rpartition(".")[0])):
        values = [_value_text(setting.get(key, ABSENT_TEXT)) for setting in settings]
        if len(set(values)) > 1:
            meanings = descriptions.get(key.rpartition(".")[2], set())
            found[": ".join([key, *filter(None, meanings)]) if len(meanings) == 1 else key] = values
    return found


def _settings(name: str, attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return all keys of a scene by dotted name, and "computed with ..." for its code and versions."""
    text = attributes["scene"]
    nameless = tomllib.loads(text)
    replace_files(nameless, SceneFile, lambda _: "")
    replaced = dict(_flat(nameless))
    settings = json.loads(attributes["settings"])
    programs = {"code": attributes.get("code", ABSENT_TEXT)} | json.loads(attributes["versions"])
    return {
        **dict(_flat(scene_from_text(text, Path(name)).model_dump())),
        **{key: value for key, value in _flat(tomllib.loads(text)) if value != replaced[key]},  # files
        **{key: settings[name] for name, key in FILLED_IN.items() if name in settings},
        "title": attributes["title"],
        **{f"computed with {program}": version for program, version in programs.items()},
    }


def scene_from_text(text: str, folder: Path) -> SceneFile:
    """Return the scene that a text describes; the files that it names need not exist any more."""
    table = tomllib.loads(text)
    replace_files(table, SceneFile, lambda _: __file__)
    return parse(table, folder / "scene.toml")


def _flat(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables and lists of tables with dotted keys."""
    if isinstance(value, dict):
        entries = value.items()
    elif isinstance(value, list | tuple) and any(isinstance(entry, dict) for entry in value):
        entries = dict(enumerate(value)).items()
    else:
        yield key, value
        return
    for name, entry in entries:
        yield from _flat(entry, f"{key}.{name}" if key else str(name))


def _value_text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_value_text(entry) for entry in value)
    return DEFAULT_TEXT if value is None else f"{value:g}" if isinstance(value, float) else str(value)
