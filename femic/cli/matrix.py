"""Commands that compute C for others: `matrix`, `export`, `calibrate`."""

from typing import Annotated, Literal

from cyclopts import Parameter

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce, whole_number
from femic.lazy import lazy_imports
from femic.reference.matrix.job import Discount
from femic.scenes.ic_names import AUTO, ICName
from femic.scenes.load import load_scene
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS

with lazy_imports():
    from compare.pages import calibration as calibration_page
    from compare.pages import ics_results
    from compare.pages import matrix as page
    from compare.studies import frontier
    from femic.results import calibration, matrices
    from femic.results import export as exports


def matrix(
    scene: SceneName,
    /,
    *,
    strip: Annotated[
        int | None,
        Parameter(
            help="loaded strip shown in the maps; default: the strip of the patch", converter=whole_number
        ),
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the IC matrix of a scene on its grid, all lags and strips; write matrix.nc and a report."""
    loaded = load_scene(scene)
    matrices.require_matrices(loaded)
    folder = work.folder(loaded)
    console = terminal()
    with work.options(folder, console) as options:
        report = page.write_matrix(loaded, folder, strip, options)
    console.print(f"Matrix: {folder / 'matrix.nc'}", soft_wrap=True)
    announce(report, console)


def export(
    scene: SceneName,
    /,
    *,
    to: Annotated[
        Literal["contact"], Parameter(name="--format", help="contact: file for the program CONTACT, C3 = 9")
    ] = "contact",
    ics: Annotated[
        ICName | None,
        Parameter(
            help="C, an approximation, or auto (the cheapest that meets the tolerance); default: "
            "those of the scene"
        ),
    ] = None,
    discount: Annotated[
        Discount | None,
        Parameter(
            help="rigid part to subtract from C: approach (M_zz only, as in contact), source (as in "
            "[BVSV]) or none; default: the scene's"
        ),
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Write ICs of both bodies and their distances, on the grid of their contact, for a contact program."""
    loaded = load_scene(scene, {"ics": ics} if ics else None)
    console = terminal()
    folder, ics_name = work.folder(loaded), loaded.ics
    exports.require_exportable(loaded, ics_name, discount)
    with work.options(folder, console) as options:
        if ics_name == AUTO:
            question = frontier.Question(COMPONENTS, loaded.ics_tolerance, "combined")
            chosen = frontier.choose(scene, question, options)
            ics_name = chosen.ics
            loaded = load_scene(scene, chosen.changes)
            console.print(chosen.text, soft_wrap=True)
        settings = exports.FORMATS[to](loaded, ics_name, discount, folder, options)
    console.print(settings, soft_wrap=True)


def calibrate(
    *scene: Annotated[
        str,
        Parameter(help="built-in name (see `femic scenes`) or TOML file; several scenes share one report"),
    ],
    work: Work = DEFAULT_WORK,
) -> None:
    """Fit the effective properties of B-hat-prime to C; write the fits, scenes with them and one report."""
    scenes, most = [load_scene(name) for name in scene], ics_results.MOST_SCENES
    if not 1 <= len(scenes) <= most:
        raise WrongInput(f"scenes: {len(scenes)} given; give 1 to {most}")
    for loaded in scenes:
        calibration.require_calibration(loaded)
    joint = [work.joint_folder([loaded.name for loaded in scenes])] if len(scenes) > 1 else []
    scene_folders = work.scene_folders(scenes, joint)
    console, calibrated = terminal(), []
    for loaded, folder in zip(scenes, scene_folders, strict=True):
        with work.options(folder, console) as options:
            console.print(f"{loaded.name}:")
            calibrated.append(calibration.calibrate(loaded, options))
            fit = calibration_page.write_fit(calibrated[-1], folder)
        console.print(f"Scene with the fit: {fit}", soft_wrap=True)
    report_folder = (*joint, *scene_folders)[0]
    with folders.locked(report_folder):
        report = calibration_page.write_report(calibrated, report_folder)
    announce(report, console)
