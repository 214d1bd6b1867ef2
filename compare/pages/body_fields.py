"""Displacements and stresses of a scene's bodies: `femic run` writes files, `femic show` draws a picture."""

import os
import sys
from collections.abc import Iterator
from dataclasses import replace
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

COARSE = Level(cells=-1)  # coarse cells, so that a preview takes seconds


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


def show(
    target: str, body: str | None, load: str | None, out: Path | None, window: bool | None
) -> Iterator[str]:
    """Draw a .vtu file, or solve one load on one body of a scene with coarse cells and draw its fields.

    Yields what was done. The picture is written as PNG; with a `window`, by default where there is a screen,
    it is also opened there. Raises WrongInput for arguments that do not fit, Failure if this machine cannot
    draw.
    """
    screen = sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY"))
    if window and not screen:
        raise WrongInput("--window: there is no screen (DISPLAY is not set); without it femic writes a PNG")
    if out is not None and out.suffix != ".png":
        raise WrongInput(f"--out {out}: name a file that ends in .png")
    if out is not None:
        folders.make(out.parent)
    if target.endswith(".vtu"):
        if body or load:
            raise WrongInput(
                f"{target}: a .vtu file holds one body and one load; use --body and --load with scenes only"
            )
        vtu, title = Path(target), Path(target).stem
    else:
        scene = load_solid_scene(target)
        name, direction = body or scene.solved[0], load or "n"
        title = f"{scene.name}, {name} body, 1 N along +{direction}"
        yield (
            f"{title}: solving a preview with coarse cells ({scene.settings.engine.name} engine); set "
            "`fields = true` in the scene for the finest model"
        )
        unit_load = Load(scene.patch, DIRECTIONS.index(direction))
        job = jobs(replace(scene, compared=(name,)))[name]  # whether or not the scene compares that body
        (vtu,) = _write_solved(job, COARSE, (unit_load,), Path("out") / scene.name / "show" / name)
        yield f"Fields: {vtu}"
    loaded = views.read_loaded_body(vtu)
    in_window = screen if window is None else window
    if not in_window and not views.can_render():
        raise Failure(f"no picture of {vtu}: {views.NO_RENDERING}")
    png = out or vtu.with_suffix(".png")
    views.draw_fields(loaded, png, title=title, window=in_window)
    yield f"Picture: {png}"
