"""Commands that fit B-hat-prime to C: `calibrate`, `calibrate-map`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.cli.work import DEFAULT, WIDE, Work
from compare.reports.calibration import map_page, maps, page
from compare.reports.calibration.fits import calibrate as calibrate_scene
from compare.reports.calibration.fits import checked
from compare.reports.overlay.sources import MOST
from compare.results import folders
from compare.scenes.load import load_scene
from geometries.errors import WrongInput


def calibrate(*scene: str, work: Work = DEFAULT) -> None:
    """Fit the effective properties of B-hat-prime to C; write the fits, the scenes with them and one report.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file; with several one report shows all
    """
    if not 1 <= len(scene) <= MOST:
        raise WrongInput(f"scenes: {len(scene)} of them; give 1 to {MOST}")
    loaded = [load_scene(name) for name in scene]
    names = [asked.name for asked in loaded]
    if len(set(names)) < len(names):
        raise WrongInput(f"scenes = {', '.join(scene)}: two of the same name; rename one of them")
    for asked in loaded:
        checked(asked)
    console, out = Console(), work.out or Path("out")
    calibrated = []
    for asked in loaded:
        folder = folders.made(work.folder(asked) if len(loaded) == 1 else out / asked.name)
        with work.means(folder, console) as means:
            console.print(f"{asked.name}:", markup=False)
            calibrated.append(calibrate_scene(asked, means))
        console.print(f"Scene with the fit: {page.write_fit(calibrated[-1], folder)}", soft_wrap=True)
    together = folder if len(loaded) == 1 else (work.out or out / "_".join(names))
    console.print(f"Report: {page.write_report(calibrated, together)}", soft_wrap=True)


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
    work: Work = DEFAULT,
) -> None:
    """Fit B-hat-prime over flank inclination and radius ratio, and try it on geometries between them.

    Parameters
    ----------
    scene
        its materials, patch, rolling radius and calibration are those of all geometries
    """
    axes, base = maps.Axes(flanks, ratios), load_scene(scene)
    folder = folders.made(work.out or Path("out") / f"{base.name}_map")
    console = Console(width=WIDE, highlight=False)
    with work.means(folder, console) as means:
        computed = maps.compute_map(scene, axes, means)
    console.print(map_page.table(computed))
    console.print(f"Map: {map_page.write_map(computed, folder)}", soft_wrap=True)
