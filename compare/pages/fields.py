"""Displacements and stresses of a scene's bodies: `femic run` writes files, `femic show` draws a picture."""

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from compare.report import views
from femic.cache import folders
from femic.reference.job import Job
from femic.reference.run_options import Level, Watch
from femic.reference.solid.fields import write_vtu
from femic.results.ics import Results, jobs
from femic.scenes.load import load_solid_scene
from geometries.errors import Failure, WrongInput
from geometries.patches import DIRECTIONS, Load

Say = Callable[[str], None]

COARSE = Level(cells=-1)  # coarse cells, so that a preview takes seconds


@dataclass(frozen=True)
class ShowRequest:
    """The arguments of `femic show`: `target` is a .vtu file or a scene, None stands for a default."""

    target: str
    body: str | None = None
    load: str | None = None
    out: Path | None = None
    window: bool | None = None


def write_fields(results: Results, folder: Path, watch: Watch) -> None:
    """Write the fields of all loads on the finest model of every solved body to FOLDER/BODY_LOAD.vtu."""
    for name, job in results.jobs.items():
        watch.on_stage(f"  {name} body: solving the finest model again for its fields")
        for path in _write_solved(job, results.references[name].level, job.loads, folder / name):
            watch.on_stage(f"  Fields: {path}")


def _write_solved(job: Job, level: Level, loads: tuple[Load, ...], stem: Path) -> Iterator[Path]:
    """Solve loads on one model of a job, write their fields to STEM_LOAD.vtu and yield the paths."""
    request = replace(job.request(level), loads=loads)
    for load, field in job.settings.engine.nodal_fields(request):
        yield write_vtu(field, stem.with_name(f"{stem.name}_{DIRECTIONS[load.direction]}.vtu"))


def show(request: ShowRequest, say: Say) -> None:
    """Draw a .vtu file, or solve one load on one body of a scene with coarse cells and draw its fields.

    The picture is written as PNG; where there is a screen, it is also opened in a window. Raises WrongInput
    for arguments that do not fit, Failure if this machine cannot draw.
    """
    window = on_screen(request.window)
    if request.out is not None and request.out.suffix != ".png":
        raise WrongInput(f"--out {request.out}: name a file that ends in .png")
    if request.out is not None:
        folders.make(request.out.parent)
    vtu, title = _given_file(request) if request.target.endswith(".vtu") else _preview(request, say)
    loaded = views.read_loaded_body(vtu)
    if not window and not views.can_render():
        raise Failure(f"no picture of {vtu}: {views.NO_RENDERING}")
    png = request.out or vtu.with_suffix(".png")
    views.draw_fields(loaded, png, title=title, window=window)
    say(f"Picture: {png}")


def on_screen(window: bool | None) -> bool:
    """Return whether to open a window: `window`, or if that is None, whether there is a screen.

    Raises WrongInput if a window is requested and there is no screen.
    """
    screen = sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY"))
    if window and not screen:
        raise WrongInput("--window: there is no screen (DISPLAY is not set); without it femic writes a PNG")
    return screen if window is None else window


def _given_file(request: ShowRequest) -> tuple[Path, str]:
    """Return the given .vtu file and its title; raises WrongInput if a body or a load is given, too."""
    if request.body or request.load:
        raise WrongInput(f"{request.target}: has one body and one load; --body and --load are for scenes")
    return Path(request.target), Path(request.target).stem


def _preview(request: ShowRequest, say: Say) -> tuple[Path, str]:
    """Solve one load on coarse cells and write its fields; returns the .vtu file and a title."""
    scene = load_solid_scene(request.target)
    name, direction = request.body or scene.solved[0], request.load or "n"
    title = f"{scene.name}, {name} body, 1 N along +{direction}"
    engine = scene.settings.engine.name
    say(
        f"{title}: solving a preview with coarse cells ({engine} engine); `fields = true` in a scene gives "
        "the finest"
    )
    folder = Path("out") / scene.name / "show"
    load = Load(scene.patch, DIRECTIONS.index(direction))
    job = jobs(replace(scene, compared=(name,)))[name]  # whether or not the scene compares that body
    (vtu,) = _write_solved(job, COARSE, (load,), folder / name)
    say(f"Fields: {vtu}")
    return vtu, title
