"""Commands that say which ICs to use: `frontier`, `advise`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.frontier import advice as advising
from compare.frontier import page, trade
from compare.frontier.advice import Question
from femic.cli.work import DEFAULT_WORK, TABLE_WIDTH, SceneName, Work
from femic.scenes.calibration import BodyName
from femic.scenes.load import load_scene


def frontier(
    scene: SceneName,
    /,
    *,
    budget: Annotated[float, Parameter(help="seconds; what would take longer is skipped and listed")] = 600.0,
    work: Work = DEFAULT_WORK,
) -> None:
    """Try every way to the ICs of a scene: errors, seconds, unknowns, memory; write a report."""
    loaded = load_scene(scene)
    folder, console = work.folder(loaded), Console()
    with work.options(folder, console) as options:
        computed = trade.compute_frontier(scene, trade.FrontierRequest.all(budget), options)
    console.print(page.summary(computed), markup=False, highlight=False)
    console.print(f"Report: {page.write_frontier(computed, folder)}", soft_wrap=True)


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
    """Say which ICs are the cheapest that are good enough, and why."""
    loaded = load_scene(scene)
    asked_components = tuple(components.split(",")) if components else loaded.components
    question = Question(body or loaded.compared[0], asked_components, tolerance)
    folder = work.folder(loaded)
    console = Console(width=TABLE_WIDTH, highlight=False)
    with work.options(folder, console) as options:
        _, computed = advising.frontier_for(scene, question, options)
    advice = advising.advise(computed, question)
    console.print(page.evidence(computed, advice))
    console.print(advising.sentence(advice), markup=False)
