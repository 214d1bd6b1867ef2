"""Advice on the cheapest ICs for wanted numbers of a contact, with the evidence for it."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import xarray as xr

from approx.variants import needed_forms
from compare.report.looks import symbol_of
from compare.studies.contact_frontier import (
    BEYOND_BUDGET,
    NO_MAPS,
    ContactRequest,
    compute_contact_frontier,
    vanishing,
)
from compare.studies.contact_ways import TIGHTEST, approximations, worst
from compare.studies.frontier import REFERENCE_FACTOR, cheapest
from femic.contact.specification import ContactProblem
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.errors import Failure, WrongInput

BUDGET = 600.0  # s
OF_ICS_ALONE = "That is the error of the ICs; the contact estimates that of its elements itself."


class Expectation(Protocol):
    """What is known of the errors of ICs in a contact without solving it with C."""

    def high(self, ics: str, number: str) -> float:
        """Return the largest error to be expected, a share; infinite where nothing is known."""

    def sentence_of(self, ics: str, number: str) -> str:
        """Return what is expected of a number with some ICs, and how reliable that is."""


Expect = Callable[[ContactProblem, Sequence[str]], Expectation | None]  # None: outside of what is known


@dataclass(frozen=True)
class ContactQuestion:
    """The numbers of a contact that are wanted, and the tolerance of their errors [-].

    Raises WrongInput for no number, and unless the tolerance is above 0 and at most 1.
    """

    wants: tuple[str, ...]
    tolerance: float

    def __post_init__(self) -> None:
        """Validate."""
        if not self.wants:
            raise WrongInput("--want: name one number or more, such as p_max,F_x")
        if not 0 < self.tolerance <= 1:
            raise WrongInput(f"--tolerance {self.tolerance:g}: must be above 0 and at most 1")


@dataclass(frozen=True)
class ContactAdvice:
    """ICs that meet a tolerance, with the keys of a scene file that they change.

    `bound` is what the error of what is wanted is at most, and `because` says how that is known. `way` is the
    name in the frontier, "" where C was not solved.
    """

    question: ContactQuestion
    ics: str
    changes: Mapping[str, Any]
    bound: float
    because: str
    way: str = ""


@dataclass(frozen=True)
class Effort:
    """The seconds that may be spent on an answer, and what is asked before C is solved, if anything."""

    budget: float = BUDGET
    expect: Expect | None = None

    def __post_init__(self) -> None:
        """Raise WrongInput unless the budget is positive."""
        ContactRequest(budget=self.budget)


ALLOWED = Effort()


@dataclass(frozen=True)
class Answer:
    """Advice, and the frontier behind it; None where C was not needed."""

    advice: ContactAdvice
    frontier: xr.Dataset | None


def advise_contact(dataset: xr.Dataset, question: ContactQuestion) -> ContactAdvice:
    """Return the cheapest way of a frontier whose error bounds meet the tolerance: see `cheapest`.

    Raises Failure where no way meets it, and where no error of a wanted number is known as a share.
    """
    for name in question.wants:
        if not dataset.judged.sel(number=name).any():
            raise vanishing(name, f"the estimate of the reference, {dataset.attrs['best']}")
    errors = worst(dataset, question.wants)
    number = cheapest(errors.bound.values, errors.seconds.values, question.tolerance)
    if number < 0:
        best = errors.isel(way=int(np.argmin(np.nan_to_num(errors.bound.values, nan=np.inf))))
        raise Failure(
            f"no way meets {question.tolerance:g}: the best, {best.way.item()}, is known to "
            f"{best.bound.item():.2g} in {best.number.item()} at {best.case.item()} (the reference, "
            f"{dataset.attrs['best']}, has an estimate of {best.floor.item():.2g} there): give a larger "
            f"tolerance, fewer numbers, or more contact.elements{_beyond_budget(dataset)}"
        )
    way = errors.isel(way=number)
    return ContactAdvice(
        question,
        str(way.ics.item()),
        _changes(way),
        way.bound.item(),
        " ".join(_reasons(dataset, question, way)),
        str(way.way.item()),
    )


def _beyond_budget(dataset: xr.Dataset) -> str:
    """Return which ways the budget left out, in words, and the option that allows more."""
    skipped = json.loads(dataset.attrs.get("skipped", "{}"))
    left_out = [name for name, reason in skipped.items() if BEYOND_BUDGET in reason]
    return f"; or a larger --budget, which left out {', '.join(left_out)}" if left_out else ""


def _reasons(dataset: xr.Dataset, question: ContactQuestion, way: xr.Dataset) -> Iterator[str]:
    """Yield where the error is largest, and of which numbers it is not known everywhere."""
    best = dataset.attrs["best"]
    how = "by its own estimate" if way.way.item() == best else f"measured against {best}"
    yield f"Worst: {way.number.item()} at {way.case.item()}, {how}."
    for name in question.wants:
        judged, points = (int(dataset[count].sel(number=name).sum()) for count in ("judged", "points"))
        if judged < points:
            yield (
                f"{name} is judged at {judged} of {points} points: elsewhere it is below ten times the "
                "estimate of the reference."
            )


def _changes(way: xr.Dataset) -> dict[str, Any]:
    """Return the keys of a scene file that a way of the frontier changes."""
    contact: dict[str, Any] = {"ics": [str(way.ics.item())]}
    if way.elements.item():
        contact["elements"] = int(way.elements.item())
    tolerance = way.tolerance.item()
    return {"contact": contact} | ({} if np.isnan(tolerance) else {"engine": {"tolerance": tolerance}})


def answer(
    base: str,
    question: ContactQuestion,
    options: RunOptions = DEFAULT,
    given: Mapping[str, Any] = NO_MAPS,
    effort: Effort = ALLOWED,
) -> Answer:
    """Return the answer to a question on a scene; C is at least four times tighter than its tolerance.

    Raises as `advise_contact` and `compute_contact_frontier`.
    """
    if effort.expect is not None:
        scene = load_scene(base)
        expectation = effort.expect(scene.contact_problem, question.wants)
        if expectation is not None and (advice := expected_advice(scene, question, expectation)):
            return Answer(advice, None)
        options.watch.on_stage("what is known of similar contacts does not decide: C is solved")
    tightest = max(question.tolerance / REFERENCE_FACTOR, TIGHTEST)
    request = ContactRequest(question.wants, effort.budget, tightest, as_shares=True)
    dataset = compute_contact_frontier(base, request, options, given)
    return Answer(advise_contact(dataset, question), dataset)


def expected_advice(
    scene: Scene, question: ContactQuestion, expectation: Expectation
) -> ContactAdvice | None:
    """Return the closest approximation of which enough is known; None where none is.

    All take milliseconds; the simplest that is good enough, for programs without the others, is named, too.
    What is known is of ICs without a fit.
    """
    fitted = scene.pair.has_effective("combined")
    bounds = {
        name: max(expectation.high(name, number) for number in question.wants)
        for name in approximations(scene)
        if not (fitted and any(form.effective for form in needed_forms([name])))
    }
    enough = [name for name, bound in bounds.items() if bound <= question.tolerance]
    if not enough:
        return None
    closest, simplest = min(enough, key=bounds.__getitem__), enough[0]
    known = [expectation.sentence_of(closest, number) for number in question.wants]
    if simplest != closest:
        known.append(f"{symbol_of(simplest)} is good enough, too: expected within {bounds[simplest]:.1%}.")
    because = " ".join([*known, OF_ICS_ALONE])
    return ContactAdvice(question, closest, {"contact": {"ics": [closest]}}, bounds[closest], because)


def sentence(advice: ContactAdvice) -> str:
    """Return the advice in sentences."""
    elements = advice.changes["contact"].get("elements")
    tolerance = advice.changes.get("engine", {}).get("tolerance")
    settings = [
        *([f"contact.elements = {elements}"] if elements else []),
        *([f"engine.tolerance = {tolerance:g}"] if tolerance else []),
    ]
    setting = " with ".join(filter(None, [f"contact.ics = [{advice.ics!r}]", " and ".join(settings)]))
    known = "to" if advice.way else "expected within"
    return (
        f"Use {setting}: {', '.join(advice.question.wants)} {known} {advice.bound:.2%} (tolerance "
        f"{advice.question.tolerance:.2%}). {advice.because}"
    )
