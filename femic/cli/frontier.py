"""Commands that help to choose ICs: `frontier`, `advise`."""

from typing import Annotated

from cyclopts import Parameter

from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, TABLE_WIDTH, SceneName, Work, announce
from femic.lazy import lazy_imports
from femic.scenes import wants
from femic.scenes.calibration import BodyName
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.campaigns import maps as c_map
    from compare.pages import frontier as page
    from compare.studies import contact_advice
    from compare.studies import contact_frontier as contact_study
    from compare.studies import frontier as study
    from femic.advice import expected

Wanted = Annotated[
    str | None,
    Parameter(help="numbers of the contact, such as p_max,F_x (see docs/decide/frontier.md)"),
]
Components = Annotated[
    str | None, Parameter(help="ICs by themselves, such as nn,sn; default: all that the scene compares")
]
Budget = Annotated[float, Parameter(help="seconds; ways that would take longer are skipped and listed")]


def frontier(
    scene: SceneName,
    /,
    *,
    want: Wanted = None,
    components: Components = None,
    budget: Budget = 600.0,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compare errors and seconds of all ways to a contact, or to the ICs of a scene; write a report.

    Of a scene with loads, the contact with all ICs, on coarser and finer grids: errors of what is wanted, by
    default of all numbers. With `--components`, and of other scenes: the ICs by themselves.
    """
    loaded = load_scene(scene)
    names = _wanted(loaded, want, components)
    folder, console = work.folder(loaded), terminal()
    if names is None:
        changes = {"components": components.split(",")} if components else {}
        request = study.FrontierRequest.all(budget, changes)
        load_scene(scene, changes)  # raises before any work starts
        with work.options(folder, console) as options:
            computed = study.compute_frontier(scene, request, options)
            report = page.write_frontier(computed, folder)
    else:
        contact_study.require_comparable(loaded, names, budget)
        maps = c_map.maps_of_scene(loaded)
        with work.options(folder, console) as options:
            computed = contact_study.compute_contact_frontier(scene, names, options, maps, budget=budget)
            report = page.write_frontier(computed, folder)
    console.print(page.summary(computed))
    announce(report, console)


def _wanted(scene: Scene, want: str | None, components: str | None) -> tuple[str, ...] | None:
    """Return the numbers of a contact that are wanted, none: all; None where ICs by themselves are.

    Raises WrongInput where both are named.
    """
    if want is not None and components is not None:
        raise WrongInput(
            "--want, --components: numbers of the contact, or ICs by themselves: give one of them"
        )
    if want is not None:
        return tuple(name.strip() for name in want.split(","))
    if components is not None or not wants.wants_of(scene.contact):
        return None
    return scene.want


def advise(
    scene: SceneName,
    /,
    *,
    want: Wanted = None,
    components: Components = None,
    body: Annotated[
        BodyName | None, Parameter(help="of ICs by themselves; default: the first that the scene compares")
    ] = None,
    solve: Annotated[
        bool, Parameter(help="solve C also where what is known of similar contacts would decide", negative="")
    ] = False,
    tolerance: Annotated[
        float | None,
        Parameter(help="largest error, share of what the table says; default: ics_tolerance of the scene"),
    ] = None,
    budget: Budget = 600.0,
    work: Work = DEFAULT_WORK,
) -> None:
    """Name the cheapest ICs that are good enough, with reasons.

    Of a scene with loads, for numbers of its contact: p_max, and in rolling F_x, unless others are wanted.
    With `--components` or `--body`, and of other scenes, for the ICs by themselves. C is solved only where
    what is known of similar contacts does not decide.
    """
    if want is not None and body is not None:
        raise WrongInput("--want, --body: a body is one of ICs by themselves: leave one of both out")
    loaded = load_scene(scene)
    largest = loaded.ics_tolerance if tolerance is None else tolerance
    names = None if body is not None else _wanted(loaded, want, components)
    folder, console = work.folder(loaded), terminal(width=TABLE_WIDTH)
    if names is None:
        named = tuple(components.split(",")) if components else loaded.components
        question = study.Question(named, largest, body or loaded.compared[0])
        with work.options(folder, console) as options:
            _, computed = study.frontier_for(scene, question, options)
        answer = study.advise(computed, question)
        console.print(page.evidence(computed, answer))
        console.print(answer.text)
        return
    question = study.Question(names or wants.default_names(loaded.contact), largest)
    contact_study.require_comparable(loaded, question.names, budget)
    expect, maps = None if solve else expected.expect, c_map.maps_of_scene(loaded)
    with work.options(folder, console) as options:
        answer, solved = contact_advice.advise_contact(
            scene, question, options, maps, budget=budget, expect=expect
        )
    if solved is not None:
        console.print(page.evidence(solved, answer))
    console.print(answer.text)
