"""Which ICs a scene uses: those that it names, or the cheapest that are good enough."""

from dataclasses import dataclass

from compare.frontier.advice import Advice, advise, asked_for
from compare.frontier.trade import compute_frontier
from compare.scenes.load import load_scene
from compare.scenes.scene import Scene
from femic.refinement import SILENT, Watch
from femic.store import Store

AUTO, C = "auto", "C"


@dataclass(frozen=True)
class Choice:
    """ICs by name, C or an approximation, the scene with the settings of that C, and why (None: named)."""

    ics: str
    scene: Scene
    advice: Advice | None = None


def choose(
    base: str,
    scene: Scene,
    *,
    workers: int,
    store: Store | None = None,
    watch: Watch = SILENT,
) -> Choice:
    """The ICs that the scene names; where that is "auto", those that `femic advise` would name.

    They meet `ics_tolerance` in all components of the first body that the scene compares. Raises Failure
    where nothing does.
    """
    if scene.ics != AUTO:
        return Choice(scene.ics, scene)
    body = scene.compared[0]
    asked = asked_for(scene.ics_tolerance, scene.components, body)
    found = compute_frontier(base, asked, workers=workers, store=store, watch=watch)
    advice = advise(found, scene.ics_tolerance, scene.components, body)
    settings = {way.name: way.engine for way in asked.ways}
    if advice.way not in settings:
        return Choice(advice.way, scene, advice)
    return Choice(C, load_scene(base, {"engine": dict(settings[advice.way])}), advice)
