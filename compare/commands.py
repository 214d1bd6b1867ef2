"""What the commands of `femic` do: scenes in, files and messages out."""

import os
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from rich.console import Console

from compare import fields, folders, progress
from compare import plan as planning
from compare.calibration import fits as calibration
from compare.calibration import maps as calibration_map
from compare.calibration import maps_report as calibration_map_report
from compare.calibration import report as calibration_report
from compare.extremes.found import available as extremes_available
from compare.frontier import advice as advising
from compare.frontier import report as frontier_report
from compare.frontier import trade
from compare.frontier.advice import Question
from compare.frontier.choice import AUTO, Choice, choose, question_of
from compare.matrix import export as exporting
from compare.matrix import report as matrix_report
from compare.matrix.export import Wanted
from compare.overlay import curves as overlay
from compare.overlay import report as overlay_report
from compare.overlay import sources as overlay_sources
from compare.run import run_scene
from compare.scenes import plausibility
from compare.scenes.file import ICName
from compare.scenes.listing import listing
from compare.scenes.load import builtin_names, load_scene
from compare.scenes.scene import Scene
from compare.validation import report as validation_report
from compare.validation import runs as validation_runs
from compare.validation import verdicts
from femic.store import Store
from geometries.errors import WrongInput
from geometries.patches import DIRECTIONS, DirectionName

NINE = tuple(i + j for i, j in product(DIRECTIONS, repeat=2))
WIDE = 130  # columns of a table

SolidName = Literal["lower", "upper"]
BodyName = Literal["combined", "lower", "upper"]
Workers = Annotated[int | None, Parameter(help="parallel processes or threads; default: one per core")]
StoreAt = Annotated[
    str | None,
    Parameter(help="folder or URL where solved models are kept, for all scenes; default OUT/store"),
]


@Parameter(name="*")
@dataclass(frozen=True)
class Work:
    """Where the results of a scene go, and how they are computed."""

    out: Annotated[Path | None, Parameter(help="folder for the results; default out/SCENE")] = None
    workers: Workers = None
    store: StoreAt = None

    def folder(self, scene: Scene) -> Path:
        """Where the results of a scene go."""
        return self.out or Path("out") / scene.name

    @property
    def threads(self) -> int:
        """How many work at a time."""
        return self.workers or os.cpu_count() or 1

    def kept(self, scene: Scene) -> Store:
        """Where its finished models are kept: in the folder of the results, unless a place is named."""
        return _store(self.store, self.folder(scene))


DEFAULT = Work()


def run(scene: str, /, *, work: Work = DEFAULT) -> None:
    """Compute and compare the influence coefficients of a scene; write a report.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    loaded = load_scene(scene)
    console = Console()
    report = _computed(loaded, work.folder(loaded), work.workers, work.kept(loaded), console)
    console.print(f"Report: {report}", soft_wrap=True)
    if loaded.ics == AUTO:
        with progress.shown(console) as watch:
            store, asked = work.kept(loaded), question_of(loaded)
            chosen = choose(scene, asked, workers=work.threads, store=store, watch=watch)
        console.print(_advice(chosen), soft_wrap=True, markup=False, highlight=False)


def _advice(chosen: Choice) -> str:
    """What was chosen, and what that was judged by."""
    return (
        f"{advising.told(chosen.advice)} Judged on the scene's lines, at its patch." if chosen.advice else ""
    )


def _store(location: str | None, folder: Path) -> Store:
    """A named store, or that in a folder, without what other code left there."""
    if location is not None:
        return Store(location)
    store = Store(folder / "store")
    store.forget_other_code()
    return store


def _computed(scene: Scene, folder: Path, workers: int | None, store: Store, console: Console) -> Path:
    """Compute a scene, with warnings and progress on the console; returns the path of its report."""
    for text in plausibility.warnings(scene):
        console.print(f"note: {text}", markup=False, highlight=False, soft_wrap=True)
    with progress.shown(console) as watch:
        return run_scene(scene, folder, workers=workers, store=store, watch=watch)


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
    with progress.shown(console) as watch:
        asked = matrix_report.Asked(folder, strip, work.threads)
        report = matrix_report.write_matrix(loaded, asked, work.kept(loaded), watch)
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
    with progress.shown(console) as watch:
        store, named = work.kept(loaded), loaded.ics
        exporting.checked(loaded, Wanted(named, discount))
        if named == AUTO:
            all_of_both = Question("combined", NINE, loaded.ics_tolerance)
            chosen = choose(scene, all_of_both, workers=work.threads, store=store, watch=watch)
            named, changes = chosen.ics, {"engine": dict(chosen.engine)} if chosen.engine else {}
            loaded = load_scene(scene, changes)
            console.print(_advice(chosen), soft_wrap=True, markup=False, highlight=False)
        asked = matrix_report.Asked(work.folder(loaded), None, work.threads)
        written = exporting.FORMATS[to](loaded, Wanted(named, discount), asked, store, watch)
    console.print(exporting.told(written), soft_wrap=True, markup=False, highlight=False)


def calibrate(*scene: str, work: Work = DEFAULT) -> None:
    """Fit the effective properties of B-hat-prime to C; write the fits, the scenes with them and one report.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file; with several one report shows all
    """
    if not 1 <= len(scene) <= overlay_sources.MOST:
        raise WrongInput(f"scenes: {len(scene)} of them; give 1 to {overlay_sources.MOST}")
    loaded = [load_scene(name) for name in scene]
    names = [one.name for one in loaded]
    if len(set(names)) < len(names):
        raise WrongInput(f"scenes = {', '.join(scene)}: two of the same name; rename one of them")
    for one in loaded:
        calibration.checked(one)
    console = Console()
    found = []
    for one in loaded:
        folder = folders.made(work.folder(one) if len(loaded) == 1 else (work.out or Path("out")) / one.name)
        with progress.shown(console) as watch:
            console.print(f"{one.name}:", markup=False)
            found.append(
                calibration.calibrate(
                    one, workers=work.workers, store=_store(work.store, folder), watch=watch
                )
            )
        console.print(
            f"Scene with the fit: {calibration_report.write_fit(found[-1], folder)}", soft_wrap=True
        )
    together = folder if len(loaded) == 1 else (work.out or Path("out") / "_".join(names))
    console.print(f"Report: {calibration_report.write_report(found, together)}", soft_wrap=True)


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
    axes, base = calibration_map.Axes(flanks, ratios), load_scene(scene)
    folder = folders.made(work.out or Path("out") / f"{base.name}_map")
    console = Console(width=WIDE, highlight=False)
    with progress.shown(console) as watch:
        found = calibration_map.compute_map(
            scene, axes, workers=work.workers, store=_store(work.store, folder), watch=watch
        )
    console.print(calibration_map_report.table(found))
    console.print(f"Map: {calibration_map_report.write_map(found, folder)}", soft_wrap=True)


def frontier(
    scene: str,
    /,
    *,
    budget: Annotated[float, Parameter(help="seconds; what would take longer is skipped and listed")] = 600.0,
    work: Work = DEFAULT,
) -> None:
    """Try every way to the ICs of a scene: errors, seconds, unknowns, memory; write a report.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    loaded = load_scene(scene)
    folder, console = folders.made(work.folder(loaded)), Console()
    with progress.shown(console) as watch:
        found = trade.compute_frontier(
            scene,
            trade.Asked.all(budget),
            workers=work.threads,
            store=work.kept(loaded),
            watch=watch,
        )
    console.print(frontier_report.summary(found), markup=False, highlight=False)
    console.print(f"Report: {frontier_report.write_frontier(found, folder)}", soft_wrap=True)


def advise(
    scene: str,
    /,
    *,
    tolerance: Annotated[float, Parameter(help="largest error, share of the component itself")] = 0.02,
    components: Annotated[
        str | None, Parameter(help="such as nn,sn; default: all that the scene compares")
    ] = None,
    body: Annotated[BodyName | None, Parameter(help="default: the first that the scene compares")] = None,
    work: Work = DEFAULT,
) -> None:
    """Say which ICs are the cheapest that are good enough, and why.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    loaded = load_scene(scene)
    of_body, asked = body or loaded.compared[0], components.split(",") if components else [*loaded.components]
    folders.checked(work.folder(loaded))
    question = Question(of_body, tuple(asked), tolerance)
    console = Console(width=WIDE, highlight=False)
    with progress.shown(console) as watch:
        _, found = advising.tried_for(
            scene, question, workers=work.threads, store=work.kept(loaded), watch=watch
        )
    advice = advising.advise(found, tolerance, asked, of_body)
    console.print(frontier_report.evidence(found, advice, asked, of_body))
    console.print(advising.told(advice), markup=False)


def validate(
    *,
    only: Annotated[
        tuple[int, ...] | None, Parameter(help="numbers of statements; default: all", consume_multiple=True)
    ] = None,
    tolerance: Annotated[float, Parameter(help="of C")] = validation_runs.TOLERANCE,
    work: Work = DEFAULT,
) -> None:
    """Check what is said about these ICs, and this program, with computed verdicts; write a report."""
    numbers = verdicts.chosen(only)
    if not validation_runs.TIGHTEST <= tolerance <= validation_runs.LOOSEST:
        raise WrongInput(
            f"--tolerance {tolerance:g}: {validation_runs.TIGHTEST:g} ... {validation_runs.LOOSEST:g}"
        )
    folder = folders.made(work.out or Path("out") / "validation")
    console = Console(highlight=False)
    with progress.shown(console) as watch:
        store = _store(work.store, folder)
        runs = validation_runs.Runs(work.threads, store, watch, tolerance)
        report = validation_report.validate(numbers, runs, folder)
    console.print(f"Report: {report}", soft_wrap=True)


def extremes(
    *,
    of: Annotated[
        tuple[Literal["analytic", "harmonic", "solid"], ...],
        Parameter(help="which parts", consume_multiple=True),
    ] = ("analytic", "harmonic", "solid"),
    work: Work = DEFAULT,
) -> None:
    """Try every part at the limits of what may be asked for, and beyond; write errors, cost and messages."""
    if not extremes_available():
        raise WrongInput("femic extremes: run .venv/bin/pip install -c constraints.txt -e '.[extremes]'")
    from compare.extremes import report as extremes_report
    from compare.extremes.engines import Engines

    folder = folders.made(work.out or Path("out") / "extremes")
    console = Console(highlight=False)
    with progress.shown(console) as watch:
        engines = Engines(work.threads, _store(work.store, folder), watch)
        report = extremes_report.try_all(of, engines, folder)
    console.print(f"Report: {report}", soft_wrap=True)


def plan(scene: str, /, *, workers: Workers = None) -> None:
    """Say what a scene would take: models, unknowns, wavenumbers, seconds, memory, file size.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    planning.show(load_scene(scene), workers or os.cpu_count() or 1, Console(width=WIDE, highlight=False))


def compare(
    *scene: str,
    results: Annotated[Path, Parameter(help="folder that has the results of each scene in SCENE/")] = Path(
        "out"
    ),
    out: Annotated[Path | None, Parameter(help="folder for the overlay; default RESULTS/SCENE_SCENE")] = None,
    workers: Workers = None,
    store: StoreAt = None,
) -> None:
    """Show the results of two or more scenes in the same figures and tables; write a report.

    Scenes without results, or with results of another text or femic, are computed first, as by `femic run`.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`), TOML file, or folder with results of `femic run`
    """
    found = overlay_sources.sources(scene, results)
    overlay_sources.common(found)  # raises before any work starts
    folder = overlay_report.folder_of(found, out, results)
    console = Console()
    for source in found:
        if source.scene is not None and not overlay_sources.up_to_date(source):
            console.print(f"{source.name}: no results of it by this femic yet, computing", markup=False)
            _computed(source.scene, source.folder, workers, _store(store, source.folder), console)
    report = overlay_report.write(overlay.load(found), folder)
    console.print(f"Report: {report}", soft_wrap=True)


def show(
    target: str,
    /,
    *,
    body: Annotated[SolidName | None, Parameter(help="default: the first that the scene compares")] = None,
    load: Annotated[DirectionName | None, Parameter(help="direction of the load; default n")] = None,
    out: Annotated[Path | None, Parameter(help="PNG; default beside the .vtu, out/SCENE/show/")] = None,
    window: Annotated[bool | None, Parameter(help="open a window; default: where there is a screen")] = None,
) -> None:
    """Draw a body under a unit load: its cells, displacements and stresses.

    A scene is solved with coarse cells: a preview in seconds.

    Parameters
    ----------
    target
        built-in name (see `femic scenes`), TOML file, or .vtu file of displacements and stresses
    """
    console = Console(soft_wrap=True, highlight=False)
    asked = fields.Shown(target, body, load, out, window)
    fields.show(asked, lambda text: console.print(text, markup=False))


def scenes(
    *, show: Annotated[str | None, Parameter(help="print this scene with every key, ready to copy")] = None
) -> None:
    """List the built-in scenes, or print one with every key, unit and default."""
    console = Console(highlight=False, soft_wrap=True)
    if show is not None:
        console.print(listing(show), end="", markup=False)
        return
    for name in builtin_names():
        console.print(f"{name:12} {load_scene(name).title}", markup=False)
