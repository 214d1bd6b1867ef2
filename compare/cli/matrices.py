"""Commands about IC matrices: `matrix`, `export`."""

from typing import Annotated, Literal

from cyclopts import Parameter
from rich.console import Console

from compare.cli.work import DEFAULT, Work
from compare.reports.frontier.advice import Question
from compare.reports.frontier.choice import AUTO, choose
from compare.reports.matrix import export as exporting
from compare.reports.matrix.export import Wanted
from compare.reports.matrix.page import Asked, write_matrix
from compare.scenes.file import ICName
from compare.scenes.load import load_scene
from geometries.patches import COMPONENTS


def matrix(
    scene: str,
    /,
    *,
    strip: Annotated[int | None, Parameter(help="loaded strip of the maps; default: the patch's")] = None,
    work: Work = DEFAULT,
) -> None:
    """Compute the IC matrix of a scene on its grid, all lags and strips; write matrix.nc and a report.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    loaded = load_scene(scene)
    folder = work.folder(loaded)
    console = Console()
    with work.means(folder, console) as means:
        report = write_matrix(loaded, Asked(folder, strip), means)
    console.print(f"Matrix: {folder / 'matrix.nc'}", soft_wrap=True)
    console.print(f"Report: {report}", soft_wrap=True)


def export(
    scene: str,
    /,
    *,
    to: Annotated[
        Literal["contact"], Parameter(name="--format", help="contact: of the program CONTACT, C3 = 9")
    ] = "contact",
    ics: Annotated[
        ICName | None,
        Parameter(help="C, an approximation, or auto: the cheapest good enough; default: the scene's"),
    ] = None,
    discount: Annotated[
        exporting.Discount,
        Parameter(help="rule: C without the far body's rigid give; none: raw C, clamped far away"),
    ] = "rule",
    work: Work = DEFAULT,
) -> None:
    """Write the IC matrix of both bodies on the scene's grid as a file that a contact program reads.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    loaded = load_scene(scene, {"ics": ics} if ics else None)
    console = Console()
    folder, named = work.folder(loaded), loaded.ics
    with work.means(folder, console) as means:
        exporting.checked(loaded, Wanted(named, discount))
        if named == AUTO:
            all_of_both = Question("combined", COMPONENTS, loaded.ics_tolerance)
            chosen = choose(scene, all_of_both, means)
            named, changes = chosen.ics, {"engine": dict(chosen.engine)} if chosen.engine else {}
            loaded = load_scene(scene, changes)
            console.print(chosen.told, soft_wrap=True, markup=False, highlight=False)
        written = exporting.FORMATS[to](loaded, Wanted(named, discount), folder, means)
    console.print(exporting.told(written), soft_wrap=True, markup=False, highlight=False)
