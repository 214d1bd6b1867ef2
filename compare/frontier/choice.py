"""The choice of the ICs that a scene uses, if it does not name them: the cheapest that meet its tolerance."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from compare.frontier.advice import Advice, Question, advise, frontier_for, sentence
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene


@dataclass(frozen=True)
class Choice:
    """Chosen ICs: C or the name of an approximation, why, and keys of the table `engine` for that C."""

    ics: str
    advice: Advice
    engine: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sentence(self) -> str:
        """A sentence on the choice and its evidence."""
        return f"{sentence(self.advice)} Errors are measured on the scene's lines, at its patch."


def question_of(scene: Scene) -> Question:
    """Return the question for all components that a scene compares, and the first of its bodies."""
    return Question(scene.compared[0], scene.components, scene.ics_tolerance)


def choose(base: str, question: Question, options: RunOptions = DEFAULT) -> Choice:
    """Return the ICs that `femic advise` would name, measured on the lines and at the patch of a scene.

    Raises Failure if no way meets the tolerance.
    """
    request, frontier = frontier_for(base, question, options)
    advice = advise(frontier, question)
    settings = {way.name: way.engine for way in request.ways}
    if advice.way not in settings:
        return Choice(advice.way, advice)
    return Choice("C", advice, request.engine(base, settings[advice.way]))
