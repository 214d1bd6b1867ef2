"""Which ICs a scene uses: those that it names, or the cheapest that are good enough."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from compare.reports.frontier.advice import Advice, Question, advise, told, tried_for
from compare.scenes.scene import Scene
from femic.means import DEFAULT, Means

AUTO, C = "auto", "C"


@dataclass(frozen=True)
class Choice:
    """ICs by name, C or an approximation, keys of the table `engine` for that C, and why (None: named)."""

    ics: str
    engine: Mapping[str, Any] = field(default_factory=dict)
    advice: Advice | None = None

    @property
    def told(self) -> str:
        """What was chosen, and what that was judged by."""
        return f"{told(self.advice)} Judged on the scene's lines, at its patch." if self.advice else ""


def question_of(scene: Scene) -> Question:
    """All that a scene compares of its first body."""
    return Question(scene.compared[0], scene.components, scene.ics_tolerance)


def choose(base: str, question: Question, means: Means = DEFAULT) -> Choice:
    """The ICs that `femic advise` would name, judged on the lines and at the patch of a scene.

    Raises Failure where nothing is good enough.
    """
    asked, found = tried_for(base, question, means)
    advice = advise(found, question.tolerance, question.components, question.body)
    settings = {way.name: way.engine for way in asked.ways}
    if advice.way not in settings:
        return Choice(advice.way, advice=advice)
    return Choice(C, asked.engine(base, settings[advice.way]), advice)
