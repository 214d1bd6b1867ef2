"""The command `stresses`: stresses under a contact inside the bodies, wear and fatigue numbers."""

from typing import Annotated

from cyclopts import Parameter

from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce, print_warnings
from femic.lazy import lazy_imports
from femic.scenes.load import load_scene

with lazy_imports():
    from compare.pages import stresses as page
    from femic.results import stressed_contact as contacts
    from femic.results import stresses as compute


def stresses(
    scene: SceneName,
    *,
    ics: Annotated[
        str | None, Parameter(help="such as A,Bhat,C: which ICs to solve it with; default: contact.ics")
    ] = None,
    friction: Annotated[
        float | None,
        Parameter(help="coefficient of friction; default: stresses.friction, or the largest of the scene"),
    ] = None,
    force: Annotated[
        float | None,
        Parameter(
            help="of rolling: F_x / (friction load), -1 ... 1; default: stresses.force, or "
            "contact.equal_force"
        ),
    ] = None,
    fineness: Annotated[
        float | None, Parameter(help="of the models of both bodies; default: stresses.fineness")
    ] = None,
    yield_stress: Annotated[
        float | None,
        Parameter(help="in tension [MPa], for shakedown and surface fatigue; default: damage.yield_stress"),
    ] = None,
    hardness: Annotated[
        float | None, Parameter(help="[MPa], for wear by Archard; needs --speed; default: damage.hardness")
    ] = None,
    speed: Annotated[
        float | None,
        Parameter(help="of rolling [m/s], for wear laws that depend on it; default: damage.speed"),
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the stresses under the contact of a scene in both bodies; write stresses.nc and a report.

    Contact is solved as by `femic contact`: without friction at the largest load, in rolling at one force, in
    compression at the last load. The tractions of C (without it of B-hat, or the last ICs) load the true
    bodies and half-spaces. Of rolling, the report has wear and fatigue numbers by each of the ICs.
    Options take the place of keys of the tables [contact], [stresses] and [damage] of the scene.
    """
    changes = option_changes(
        ics=ics,
        friction=friction,
        force=force,
        fineness=fineness,
        yield_stress=yield_stress,
        hardness=hardness,
        speed=speed,
    )
    loaded = load_scene(scene, changes)
    contacts.require_stresses(loaded)
    console, folder = terminal(), work.folder(loaded)
    print_warnings(loaded, console)
    with work.options(folder, console) as run_options:
        dataset = compute.compute_stresses(loaded, run_options)
        run_options.watch.on_stage("charts of the report")
        report = page.write_stresses(dataset, folder)
    console.print(page.summary(dataset), soft_wrap=True)
    announce(report, console)


def option_changes(
    *,
    ics: str | None = None,
    friction: float | None = None,
    force: float | None = None,
    fineness: float | None = None,
    yield_stress: float | None = None,
    hardness: float | None = None,
    speed: float | None = None,
) -> dict[str, dict[str, object]]:
    """Return the keys of a scene that have the values of the options, by table."""
    tables: dict[str, dict[str, object]] = {
        "contact": {
            "ics": None if ics is None else ics.split(","),
            "friction": None if friction is None else [friction],
        },
        "stresses": {"friction": friction, "force": force, "fineness": fineness},
        "damage": {"yield_stress": yield_stress, "hardness": hardness, "speed": speed},
    }
    given = {
        table: {key: value for key, value in keys.items() if value is not None}
        for table, keys in tables.items()
    }
    return {table: keys for table, keys in given.items() if keys}
