"""The command `calibrate`, which fits B-hat-prime to C."""

from typing import Annotated

from cyclopts import Parameter

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, Work, announce
from femic.lazy import lazy_imports
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.pages import calibration as page
    from compare.pages import ics_results
    from femic.results import calibration as compute


def calibrate(
    *scene: Annotated[
        str,
        Parameter(help="built-in name (see `femic scenes`) or TOML file; with several one report shows all"),
    ],
    work: Work = DEFAULT_WORK,
) -> None:
    """Fit the effective properties of B-hat-prime to C; write the fits, scenes with them and one report."""
    scenes, most = [load_scene(name) for name in scene], ics_results.MOST_SCENES
    if not 1 <= len(scenes) <= most:
        raise WrongInput(f"scenes: {len(scenes)} of them; give 1 to {most}")
    for loaded in scenes:
        compute.require_calibration(loaded)
    joint = [work.joint_folder([loaded.name for loaded in scenes])] if len(scenes) > 1 else []
    scene_folders = work.scene_folders(scenes, joint)
    console, calibrated = terminal(), []
    for loaded, folder in zip(scenes, scene_folders, strict=True):
        with work.options(folder, console) as options:
            console.print(f"{loaded.name}:")
            calibrated.append(compute.calibrate(loaded, options))
            fit = page.write_fit(calibrated[-1], folder)
        console.print(f"Scene with the fit: {fit}", soft_wrap=True)
    report_folder = (*joint, *scene_folders)[0]
    with folders.locked(report_folder):
        report = page.write_report(calibrated, report_folder)
    announce(report, console)
