"""The choice of the ICs that a scene uses: those that it names, or the cheapest that meet its tolerance."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from compare.reports.frontier.advice import Advice, Question, advise, told, tried_for
from compare.scenes.scene import Scene
from femic.means import DEFAULT, Means

AUTO, C = "auto", "C"


@dataclass(frozen=True)
class Choice:
    """Chosen ICs: C or the name of an approximation, and keys of the table `engine` for that C.

    `advice` says why they were chosen; it is None if the scene names them.
    """

    ics: str
    engine: Mapping[str, Any] = field(default_factory=dict)
    advice: Advice | None = None

    @property
    def told(self) -> str:
        """A sentence on what was chosen and how it was judged; empty if the scene names its ICs."""
        return f"{told(self.advice)} Judged on the scene's lines, at its patch." if self.advice else ""


def question_of(scene: Scene) -> Question:
    """The question for all components that a scene compares, of the first of its bodies."""
    return Question(scene.compared[0], scene.components, scene.ics_tolerance)


def choose(base: str, question: Question, means: Means = DEFAULT) -> Choice:
    """The ICs that `femic advise` would name, judged on the lines and at the patch of a scene.

    Raises Failure if no way meets the tolerance.
    """
    request, frontier = tried_for(base, question, means)
    advice = advise(frontier, question)
    settings = {way.name: way.engine for way in request.ways}
    if advice.way not in settings:
        return Choice(advice.way, advice=advice)
    return Choice(C, request.engine(base, settings[advice.way]), advice)
