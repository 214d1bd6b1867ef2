"""Displacements and stresses of a scene's bodies: as files for `femic run`, in a picture for `femic show`."""

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from compare.pages import views
from compare.results.compute import Results, jobs
from compare.scenes.load import load_solid_scene
from compare.scenes.scene import Scene
from femic.job import Job
from femic.level import Level
from femic.means import Watch
from femic.solid.fields import nodal_fields
from femic.solid.vtu import write_vtu
from geometries.errors import Failure, WrongInput
from geometries.patches import DIRECTIONS, Load

Say = Callable[[str], None]

COARSE = Level(cells=-1)  # a preview in seconds


@dataclass(frozen=True)
class Shown:
    """What `femic show` is asked for; `target` is a .vtu file or a scene, None means by default."""

    target: str
    body: str | None = None
    load: str | None = None
    out: Path | None = None
    window: bool | None = None


def write_fields(results: Results, folder: Path, watch: Watch) -> None:
    """Fields of all loads on the finest model of every solved body, as FOLDER/BODY_LOAD.vtu."""
    for name, job in results.jobs.items():
        watch.on_stage(f"  {name} body: solving the finest model again for its fields")
        for path in _written(job, results.references[name].level, job.loads, folder / name):
            watch.on_stage(f"  Fields: {path}")


def _written(job: Job, level: Level, loads: tuple[Load, ...], stem: Path) -> Iterator[Path]:
    """Solve loads on one model of a job and write their fields as STEM_LOAD.vtu."""
    for load, field in nodal_fields(replace(job.request(level), loads=loads)):
        yield write_vtu(field, stem.with_name(f"{stem.name}_{DIRECTIONS[load.direction]}.vtu"))


def show(asked: Shown, say: Say) -> None:
    """Draw a .vtu file, or solve one load on one body of a scene with coarse cells and draw that.

    The picture is a PNG; with a screen it opens in a window too.
    """
    window = on_screen(asked.window)
    if asked.out is not None and asked.out.suffix != ".png":
        raise WrongInput(f"--out {asked.out}: name a file that ends in .png")
    vtu, title = _file(asked) if asked.target.endswith(".vtu") else _preview(asked, say)
    loaded = views.read_loaded(vtu)
    if not window and not views.can_render():
        raise Failure(f"no picture of {vtu}: {views.NO_RENDERING}")
    png = asked.out or vtu.with_suffix(".png")
    png.parent.mkdir(parents=True, exist_ok=True)
    views.draw_fields(loaded, png, title=title, window=window)
    say(f"Picture: {png}")


def on_screen(window: bool | None) -> bool:
    """Whether to open a window: where there is a screen, unless asked otherwise."""
    screen = sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY"))
    if window and not screen:
        raise WrongInput("--window: there is no screen (DISPLAY is not set); without it femic writes a PNG")
    return screen if window is None else window


def _file(asked: Shown) -> tuple[Path, str]:
    """The .vtu file and its title."""
    if asked.body or asked.load:
        raise WrongInput(f"{asked.target}: has one body and one load; --body and --load are for scenes")
    return Path(asked.target), Path(asked.target).stem


def _preview(asked: Shown, say: Say) -> tuple[Path, str]:
    """Solve and write the fields of one load on coarse cells; returns the .vtu file and a title."""
    scene = load_solid_scene(asked.target)
    name, direction = asked.body or scene.solved[0], asked.load or "n"
    title = f"{scene.name}, {name} body, 1 N along +{direction}"
    say(f"{title}: solving a preview with coarse cells; `fields = true` in a scene gives the finest")
    folder = Path("out") / scene.name / "show"
    load = Load(scene.patch, DIRECTIONS.index(direction))
    (vtu,) = _written(_job(scene, name), COARSE, (load,), folder / name)
    say(f"Fields: {vtu}")
    return vtu, title


def _job(scene: Scene, body: str) -> Job:
    """The job of a body, also where the scene does not compare it."""
    return jobs(replace(scene, compared=(body,)))[body]
