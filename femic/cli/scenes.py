"""Commands about scenes: `run`, `compare`, `show`, `scenes`."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from rich.console import Console

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import (
    AT,
    DEFAULT_WORK,
    SceneName,
    StoreAt,
    Work,
    Workers,
    announce,
    print_warnings,
)
from femic.lazy import lazy_imports
from femic.scenes.ic_names import AUTO
from femic.scenes.listing import listing
from femic.scenes.load import builtin_names, load_scene
from femic.scenes.scene import Scene
from geometries.patches import DirectionName

FIELDS = ".vtu"  # suffix of files of displacements and stresses
SolidName = Literal["lower", "upper"]

with lazy_imports():
    from compare.pages import body_fields, ics_results
    from compare.studies import frontier
    from femic.cli import sweep


def run(scene: SceneName, /, *, work: Work = DEFAULT_WORK) -> None:
    """Compute and compare the influence coefficients of a scene; write a report.

    Nothing is computed if the folder has the same results already.
    """
    loaded = load_scene(scene)
    console = terminal()
    report = _computed(loaded, work.folder(loaded), work, console)
    announce(report, console)
    if loaded.ics == AUTO:
        with work.options(work.folder(loaded), console) as options:
            chosen = frontier.choose(scene, frontier.question_of(loaded), options)
        console.print(chosen.text, soft_wrap=True)


def _computed(scene: Scene, folder: Path, work: Work, console: Console) -> Path:
    """Compute a scene, with warnings and progress on the console; return the path of its report."""
    print_warnings(scene, console, of_contact=False)
    with work.options(folder, console) as options:
        return ics_results.run_scene(scene, folder, options)


def compare(
    *scene: Annotated[
        str,
        Parameter(
            help="built-in name (see `femic scenes`), TOML file, folder with results of `femic run`, or "
            "scenes of a campaign, such as CAMPAIGN.toml@flank=30"
        ),
    ],
    results: Annotated[Path, Parameter(help="folder that has the results of each scene in SCENE/")] = Path(
        "out"
    ),
    out: Annotated[Path | None, Parameter(help="folder for the overlay; default RESULTS/SCENE_SCENE")] = None,
    workers: Workers = None,
    store: StoreAt = None,
) -> None:
    """Show the results of two or more scenes in the same figures and tables; write a report.

    Scenes without results are computed first, as by `femic run`; also scenes that changed since.
    """
    for argument in scene:  # wrong files are refused before anything heavy is loaded
        path = Path(argument)
        if not path.is_dir() and (path.exists() or AT not in argument):
            load_scene(argument)
    stores = [item for argument in scene for item in sweep.find_scenes(argument, results).items()]
    scene_sources = ics_results.sources([path for path, _ in stores], results)
    ics_results.common(scene_sources)  # raises before any work starts
    folder = ics_results.overlay_folder(scene_sources, out, results)
    console = terminal()
    for used in (folder, *(source.folder for source in scene_sources if source.scene is not None)):
        folders.require_usable(used)
    for source, (_, own_store) in zip(scene_sources, stores, strict=True):
        if source.scene is not None and not ics_results.up_to_date(source):
            console.print(f"{source.name}: no results by this version of femic yet; computing")
            work = Work(source.folder, workers, store or own_store)
            _computed(source.scene, source.folder, work, console)
    with folders.locked(folder):
        report = ics_results.write_overlay(ics_results.load(scene_sources), folder)
    announce(report, console)


def show(
    target: str,
    /,
    *,
    body: Annotated[
        SolidName | None, Parameter(help="body; default: the first that the scene compares")
    ] = None,
    load: Annotated[DirectionName | None, Parameter(help="direction of the load; default n")] = None,
    out: Annotated[
        Path | None, Parameter(help="PNG file; default: next to the .vtu file in out/SCENE/show/")
    ] = None,
    window: Annotated[bool | None, Parameter(help="open a window; default: yes if there is a screen")] = None,
) -> None:
    """Draw a body under a unit load: its cells, displacements and stresses.

    A scene is solved with coarse cells: a preview in seconds.

    Parameters
    ----------
    target
        built-in name (see `femic scenes`), TOML file, or .vtu file of displacements and stresses
    """
    if Path(target).suffix != FIELDS:
        load_scene(target)  # raises before anything heavy is loaded
    console = terminal(soft_wrap=True)
    for message in body_fields.show(target, body, load, out, window):
        console.print(message)


def scenes(
    *, show: Annotated[str | None, Parameter(help="print this scene with every key, ready to copy")] = None
) -> None:
    """List the built-in scenes, or print one with every key, unit and default."""
    console = terminal(soft_wrap=True)
    if show is not None:
        console.print(listing(show), end="")
        return
    for name in builtin_names():
        console.print(f"{name:14} {load_scene(name).title}")
