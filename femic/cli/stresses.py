"""The command `stresses`: stresses under a contact inside the bodies, wear and fatigue numbers."""

from dataclasses import asdict, dataclass
from typing import Annotated, Any

from cyclopts import Parameter

from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce, print_warnings
from femic.late import lazy_imports
from femic.scenes.load import load_scene

with lazy_imports():
    from compare.pages import stresses as page
    from femic.results import stressed_contact as contacts
    from femic.results import stresses as compute


@Parameter(name="*")
@dataclass(frozen=True)
class OneContact:
    """Which contact of a scene is solved, with which ICs, and how finely its bodies are modelled."""

    ics: Annotated[
        str | None, Parameter(help="such as A,Bhat,C: which ICs to solve it with; default: contact.ics")
    ] = None
    friction: Annotated[
        float | None,
        Parameter(help="coefficient of friction; default: stresses.friction, or the largest of the scene"),
    ] = None
    force: Annotated[
        float | None,
        Parameter(
            help="of rolling: F_x / (friction load), -1 ... 1; default: stresses.force, or "
            "contact.equal_force"
        ),
    ] = None
    fineness: Annotated[
        float | None, Parameter(help="of the models of both bodies; default: stresses.fineness")
    ] = None

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of a scene that have the values of these options."""
        ics = {} if self.ics is None else {"ics": self.ics.split(",")}
        friction = {} if self.friction is None else {"friction": [self.friction]}
        names = "friction", "force", "fineness"
        return {
            "contact": ics | friction,
            "stresses": _given({name: getattr(self, name) for name in names}),
        }


@Parameter(name="*")
@dataclass(frozen=True)
class Constants:
    """Constants of the surfaces and the rolling speed."""

    yield_stress: Annotated[
        float | None,
        Parameter(help="in tension [MPa], for shakedown and surface fatigue; default: damage.yield_stress"),
    ] = None
    hardness: Annotated[
        float | None, Parameter(help="[MPa], for wear by Archard; needs --speed; default: damage.hardness")
    ] = None
    speed: Annotated[
        float | None,
        Parameter(help="of rolling [m/s], for wear laws that depend on it; default: damage.speed"),
    ] = None

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of a scene that have the values of these options."""
        return {"damage": _given(asdict(self))}


SCENES_CONTACT, SCENES_CONSTANTS = OneContact(), Constants()


def stresses(
    scene: SceneName,
    *,
    contact: OneContact = SCENES_CONTACT,
    constants: Constants = SCENES_CONSTANTS,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the stresses under the contact of a scene in both bodies; write stresses.nc and a report.

    Contact is solved as by `femic contact`: without friction at the largest load, in rolling at one force, in
    compression at the last load. The tractions of C (without it of B-hat, or the last ICs) load the true
    bodies and half-spaces. Of rolling, the report has wear and fatigue numbers by each of the ICs.
    Options take the place of keys of the tables [contact], [stresses] and [damage] of the scene.
    """
    changes = {table: keys for table, keys in (contact.keys | constants.keys).items() if keys}
    loaded = load_scene(scene, changes)
    contacts.require_stresses(loaded)
    console, folder = terminal(), work.folder(loaded)
    print_warnings(loaded, console)
    with work.options(folder, console) as options:
        results = compute.compute_stresses(loaded, options)
        options.watch.on_stage("charts of the report")
        dataset, report = page.write_stresses(results, folder)
    console.print(page.summary(dataset), soft_wrap=True)
    announce(report, console)


def _given(values: dict[str, Any]) -> dict[str, Any]:
    """Return the values that are given."""
    return {name: value for name, value in values.items() if value is not None}
