"""Commands that fit B-hat-prime to C: `calibrate`, `calibrate-map`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.cli.work import DEFAULT_WORK, TABLE_WIDTH, Work
from compare.reports.calibration import map_page, maps, page
from compare.reports.overlay.sources import MOST_SCENES
from compare.results import folders
from compare.results.calibration import calibrate as calibrate_scene
from compare.results.calibration import require_calibration
from compare.scenes.load import load_scene
from geometries.errors import WrongInput


def calibrate(
    *scene: Annotated[
        str,
        Parameter(help="built-in name (see `femic scenes`) or TOML file; with several one report shows all"),
    ],
    work: Work = DEFAULT_WORK,
) -> None:
    """Fit the effective properties of B-hat-prime to C; write the fits, scenes with them and one report."""
    if not 1 <= len(scene) <= MOST_SCENES:
        raise WrongInput(f"scenes: {len(scene)} of them; give 1 to {MOST_SCENES}")
    loaded = [load_scene(name) for name in scene]
    names = [loaded_scene.name for loaded_scene in loaded]
    if len(set(names)) < len(names):
        raise WrongInput(f"scenes = {', '.join(scene)}: two of the same name; rename one of them")
    for loaded_scene in loaded:
        require_calibration(loaded_scene)
    console, out = Console(), work.out or Path("out")
    calibrated = []
    for loaded_scene in loaded:
        folder = folders.made(work.folder(loaded_scene) if len(loaded) == 1 else out / loaded_scene.name)
        with work.means(folder, console) as means:
            console.print(f"{loaded_scene.name}:", markup=False)
            calibrated.append(calibrate_scene(loaded_scene, means))
        console.print(f"Scene with the fit: {page.write_fit(calibrated[-1], folder)}", soft_wrap=True)
    report_folder = folder if len(loaded) == 1 else (work.out or out / "_".join(names))
    console.print(f"Report: {page.write_report(calibrated, report_folder)}", soft_wrap=True)


def calibrate_map(
    scene: str = "geometry1",
    /,
    *,
    flanks: Annotated[
        tuple[float, ...], Parameter(help="flank inclinations of both arcs [deg]", consume_multiple=True)
    ] = (10.0, 25.0, 40.0, 55.0, 70.0),
    ratios: Annotated[
        tuple[float, ...], Parameter(help="radii of the upper over the lower arc", consume_multiple=True)
    ] = (1.0, 1.1, 1.3, 2.0),
    work: Work = DEFAULT_WORK,
) -> None:
    """Fit B-hat-prime over flank inclination and radius ratio, and try it on geometries between them.

    Parameters
    ----------
    scene
        its materials, patch, rolling radius and calibration are those of all geometries
    """
    axes, base = maps.Axes(flanks, ratios), load_scene(scene)
    folder = folders.made(work.out or Path("out") / f"{base.name}_map")
    console = Console(width=TABLE_WIDTH, highlight=False)
    with work.means(folder, console) as means:
        computed = maps.compute_map(scene, axes, means)
    console.print(map_page.table(computed))
    console.print(f"Map: {map_page.write_map(computed, folder)}", soft_wrap=True)
