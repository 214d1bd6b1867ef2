"""Commands that help to choose ICs: `frontier`, `advise`."""

from typing import Annotated

from cyclopts import Parameter

from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, TABLE_WIDTH, SceneName, Work, announce, maps_of
from femic.lazy import lazy_imports
from femic.scenes import wants
from femic.scenes.calibration import BodyName
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

with lazy_imports():
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
    str | None,
    Parameter(
        help="components of the ICs instead of contact numbers, such as nn,sn; default: "
        "all components of the scene"
    ),
]
Budget = Annotated[
    float, Parameter(help="time limit in seconds; choices that would take longer are skipped and listed")
]


def frontier(
    scene: SceneName,
    /,
    *,
    want: Wanted = None,
    components: Components = None,
    budget: Budget = 600.0,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compare all choices of ICs for a scene, error against time; write a report.

    For a scene with loads: the contact with all ICs, on coarser and finer grids, and the errors of the wanted
    numbers (default: all). With `--components`, or for a scene without loads: the errors of the ICs.
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
        maps = maps_of(loaded)
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
        raise WrongInput("--want, --components: give either contact numbers or components of the ICs")
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
        BodyName | None,
        Parameter(help="body, for components of the ICs; default: the first body that the scene compares"),
    ] = None,
    solve: Annotated[
        bool, Parameter(help="compute C even if similar contacts would settle the question", negative="")
    ] = False,
    tolerance: Annotated[
        float | None,
        Parameter(help="largest accepted error of ICs, such as 0.02; default: ics_tolerance of the scene"),
    ] = None,
    budget: Budget = 600.0,
    work: Work = DEFAULT_WORK,
) -> None:
    """Name the cheapest ICs that meet the tolerance, with reasons.

    For a scene with loads, the tolerance applies to contact numbers: p_max, and F_x in rolling, unless you
    name others. With `--components` or `--body`, or for a scene without loads, it applies to the ICs. C is
    computed only if similar contacts do not settle the question.
    """
    if want is not None and body is not None:
        raise WrongInput("--want, --body: --body applies to components of the ICs; leave one of the two out")
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
    expect, maps = None if solve else expected.expect, maps_of(loaded)
    with work.options(folder, console) as options:
        answer, solved = contact_advice.advise_contact(
            scene, question, options, maps, budget=budget, expect=expect
        )
    if solved is not None:
        console.print(page.evidence(solved, answer))
    console.print(answer.text)
