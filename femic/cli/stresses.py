"""The command `stresses`: stresses under a contact inside the bodies, wear and fatigue numbers."""

from dataclasses import dataclass
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


@Parameter(name="*")
@dataclass(frozen=True)
class OneContact:
    """Which contact of a scene is solved, and with which ICs."""

    ics: Annotated[
        str | None, Parameter(help="such as A,Bhat,C: which ICs to solve it with; default: the scene's")
    ] = None
    friction: Annotated[
        float | None, Parameter(help="coefficient of friction; default: the largest of the scene")
    ] = None
    force: Annotated[
        float | None,
        Parameter(help="of rolling: F_x / (friction load), -1 ... 1; default: the scene's equal_force"),
    ] = None

    def of(self, name: str) -> Scene:
        """Return the scene of a name with this contact; raises WrongInput where it cannot have it."""
        scene, changes = load_scene(name), dict[str, Any]()
        if self.ics:
            changes["ics"] = self.ics.split(",")
        if self.friction is not None:
            if scene.contact.friction is None:
                raise WrongInput(
                    f"--friction = {self.friction:g}: {scene.name} has no friction (motion = 'none'); leave "
                    "it out"
                )
            changes["friction"] = [self.friction]
        if self.force is not None:
            if scene.contact.motion != ROLLING:
                raise WrongInput(f"--force = {self.force:g}: {scene.name} does not roll; leave it out")
            changes["equal_force"] = self.force
        return load_scene(name, {"contact": changes}) if changes else scene


@Parameter(name="*")
@dataclass(frozen=True)
class Constants:
    """Constants of the surfaces and the rolling speed."""

    yield_stress: Annotated[
        float | None, Parameter(help="in tension [MPa], for shakedown and surface fatigue")
    ] = None
    hardness: Annotated[float | None, Parameter(help="[MPa], for wear by Archard; needs --speed")] = None
    speed: Annotated[float | None, Parameter(help="of rolling [m/s], for wear laws that depend on it")] = None

    def require_rolling(self, scene: Scene) -> None:
        """Raise WrongInput for constants that a scene has no use for."""
        for name in ("yield_stress", "hardness", "speed"):
            if (value := getattr(self, name)) is not None and scene.contact.motion != ROLLING:
                option = name.replace("_", "-")
                raise WrongInput(
                    f"--{option} = {value:g}: wear and fatigue numbers are those of rolling, and "
                    f"{scene.name} does not roll; leave it out"
                )


SCENES_CONTACT, NO_CONSTANTS = OneContact(), Constants()


def stresses(
    scene: SceneName,
    *,
    contact: OneContact = SCENES_CONTACT,
    constants: Constants = NO_CONSTANTS,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the stresses under the contact of a scene in both bodies; write stresses.nc and a report.

    Contact is solved as by `femic contact`: without friction at the largest load, in rolling at one force, in
    compression at the last load. The tractions of C (without it of B-hat, or the last ICs) load the true
    bodies and half-spaces. Of rolling, the report has wear and fatigue numbers by each of the ICs.
    """
    material = damage.Material(constants.yield_stress, constants.hardness, constants.speed)
    loaded = contact.of(scene)
    contacts.require_stresses(loaded)
    constants.require_rolling(loaded)
    console, folder = terminal(markup=False, highlight=False), work.folder(loaded)
    print_warnings(loaded, console)
    with work.options(folder, console) as options:
        results = compute.compute_stresses(loaded, compute.Request(material), options)
        options.watch.on_stage("charts of the report")
        dataset, report = page.write_stresses(results, folder)
    console.print(answers.summary(dataset), soft_wrap=True)
    announce(report, console)
