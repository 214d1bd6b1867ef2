"""Commands that say which ICs to use: `frontier`, `advise`."""

from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cli.work import DEFAULT_WORK, TABLE_WIDTH, SceneName, Work
from femic.late import Late
from femic.scenes.calibration import BodyName
from femic.scenes.load import load_scene

Question = Late("compare.frontier.advice:Question")
frontier_for = Late("compare.frontier.advice:frontier_for")
advise_from = Late("compare.frontier.advice:advise")
text_of = Late("compare.frontier.advice:sentence")
request_all = Late("compare.frontier.compute:FrontierRequest.all")
compute_frontier = Late("compare.frontier.compute:compute_frontier")
summary = Late("compare.frontier.page:summary")
evidence = Late("compare.frontier.page:evidence")
write_frontier = Late("compare.frontier.page:write_frontier")


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
        computed = compute_frontier(scene, request_all(budget), options)
    console.print(summary(computed), markup=False, highlight=False)
    console.print(f"Report: {write_frontier(computed, folder)}", soft_wrap=True)


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
        _, computed = frontier_for(scene, question, options)
    advice = advise_from(computed, question)
    console.print(evidence(computed, advice))
    console.print(text_of(advice), markup=False)
