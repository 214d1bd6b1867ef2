"""The command `stresses`: stresses under a contact inside the bodies, wear and fatigue numbers."""

from __future__ import annotations

from typing import Annotated, Any

from cyclopts import Parameter

from femic.cli.terminal import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce, print_warnings
from femic.late import lazy_imports
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.stresses import answers, compute, contacts, damage, page

ROLLING = "rolling"


def stresses(
    scene: SceneName,
    *,
    ics: Annotated[
        str | None, Parameter(help="such as A,Bhat,C: which ICs to solve it with; default: the scene's")
    ] = None,
    friction: Annotated[
        float | None, Parameter(help="coefficient of friction; default: the largest of the scene")
    ] = None,
    force: Annotated[
        float | None,
        Parameter(help="of rolling: F_x / (friction load), -1 ... 1; default: the scene's equal_force"),
    ] = None,
    yield_stress: Annotated[
        float | None, Parameter(help="in tension [MPa], for shakedown and surface fatigue")
    ] = None,
    hardness: Annotated[float | None, Parameter(help="[MPa], for wear by Archard; needs --speed")] = None,
    speed: Annotated[
        float | None, Parameter(help="of rolling [m/s], for wear laws that depend on it")
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the stresses under the contact of a scene in both bodies; write stresses.nc and a report.

    Contact is solved as by `femic contact`: without friction at the largest load, in rolling at one force, in
    compression at the last load. The tractions of C (without it those of B-hat, or the last ICs) load the true
    bodies and half-spaces. Of rolling, the report has wear and fatigue numbers by each of the ICs.
    """
    request = compute.Request(damage.Material(yield_stress, hardness, speed))
    loaded = _loaded(scene, ics, friction, force)
    contacts.require_stresses(loaded)
    if loaded.contact.motion != ROLLING and (given := hardness or speed):
        raise WrongInput(
            f"--hardness or --speed = {given:g}: {loaded.name} does not roll, so it does not wear; leave them out"
        )
    console, folder = terminal(markup=False, highlight=False), work.folder(loaded)
    print_warnings(loaded, console)
    with work.options(folder, console) as options:
        results = compute.compute_stresses(loaded, request, options)
        options.watch.on_stage("charts of the report")
        dataset, report = page.write_stresses(results, folder)
    console.print(answers.summary(dataset), soft_wrap=True)
    announce(report, console)


def _loaded(name: str, ics: str | None, friction: float | None, force: float | None) -> Scene:
    """Return the scene of a name with these ICs, friction and force; raises WrongInput where it has none."""
    scene, changes = load_scene(name), dict[str, Any]()
    if ics:
        changes["ics"] = ics.split(",")
    if friction is not None:
        if scene.contact.friction is None:
            raise WrongInput(
                f"--friction = {friction:g}: {scene.name} has no friction (motion = 'none'); leave it out"
            )
        changes["friction"] = [friction]
    if force is not None:
        if scene.contact.motion != ROLLING:
            raise WrongInput(f"--force = {force:g}: {scene.name} does not roll; leave it out")
        changes["equal_force"] = force
    return load_scene(name, {"contact": changes}) if changes else scene
