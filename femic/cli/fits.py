"""The command `calibrate`, which fits B-hat-prime to C."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cache import folders
from femic.cli.work import DEFAULT_WORK, Work
from femic.late import Late
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

calibrate_scene = Late("compare.calibration.compute:calibrate")
require_calibration = Late("compare.calibration.compute:require_calibration")
write_fit = Late("compare.calibration.page:write_fit")
MOST_SCENES = Late("compare.overlay.sources:MOST_SCENES")
write_report = Late("compare.calibration.page:write_report")


def calibrate(
    *scene: Annotated[
        str,
        Parameter(help="built-in name (see `femic scenes`) or TOML file; with several one report shows all"),
    ],
    work: Work = DEFAULT_WORK,
) -> None:
    """Fit the effective properties of B-hat-prime to C; write the fits, scenes with them and one report."""
    loaded, most = [load_scene(name) for name in scene], MOST_SCENES.resolved
    if not 1 <= len(scene) <= most:
        raise WrongInput(f"scenes: {len(scene)} of them; give 1 to {most}")
    names = [loaded_scene.name for loaded_scene in loaded]
    if len(set(names)) < len(names):
        raise WrongInput(f"scenes = {', '.join(scene)}: two of the same name; rename one of them")
    for loaded_scene in loaded:
        require_calibration(loaded_scene)
    console, calibrated = Console(), []
    of_each = [work.folder_among(one, loaded) for one in loaded]
    of_all = of_each[0] if len(loaded) == 1 else work.joint_folder(names)
    for folder in (*of_each, of_all):
        folders.require_usable(folder)
    for loaded_scene, folder in zip(loaded, of_each, strict=True):
        with work.options(folder, console) as options:
            console.print(f"{loaded_scene.name}:", markup=False)
            calibrated.append(calibrate_scene(loaded_scene, options))
            fit = write_fit(calibrated[-1], folder)
        console.print(f"Scene with the fit: {fit}", soft_wrap=True)
    with folders.locked(of_all):
        report = write_report(calibrated, of_all)
    console.print(f"Report: {report}", soft_wrap=True)
