"""Commands that help to choose ICs: `frontier`, `advise`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cli.work import DEFAULT_WORK, TABLE_WIDTH, SceneName, Work, announce
from femic.late import lazy_imports
from femic.scenes.calibration import BodyName
from femic.scenes.load import load_scene

with lazy_imports():
    from compare.frontier import advice, compute, page


def frontier(
    scene: SceneName,
    /,
    *,
    budget: Annotated[
        float, Parameter(help="seconds; ways that would take longer are skipped and listed")
    ] = 600.0,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compare all ways to compute the ICs of a scene: errors, seconds, unknowns, memory; write a report."""
    loaded = load_scene(scene)
    folder, console = work.folder(loaded), Console()
    with work.options(folder, console) as options:
        computed = compute.compute_frontier(scene, compute.FrontierRequest.all(budget), options)
        report = page.write_frontier(computed, folder)
    console.print(page.summary(computed), markup=False, highlight=False)
    announce(report, console)


def advise(
    scene: SceneName,
    /,
    *,
    tolerance: Annotated[float, Parameter(help="largest error, share of the component itself")] = 0.02,
    components: Annotated[
        str | None, Parameter(help="such as nn,sn; default: all that the scene compares")
    ] = None,
    body: Annotated[BodyName | None, Parameter(help="default: the first that the scene compares")] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Name the cheapest ICs that are good enough, with reasons."""
    loaded = load_scene(scene)
    named = tuple(components.split(",")) if components else loaded.components
    question = advice.Question(body or loaded.compared[0], named, tolerance)
    folder = work.folder(loaded)
    console = Console(width=TABLE_WIDTH, highlight=False)
    with work.options(folder, console) as options:
        _, computed = advice.frontier_for(scene, question, options)
    answer = advice.advise(computed, question)
    console.print(page.evidence(computed, answer))
    console.print(advice.sentence(answer), markup=False)
