"""Advice on the cheapest ICs for wanted numbers of a contact: by what is known of similar ones, or by C."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import xarray as xr

from approx.variants import needed_forms
from compare.report.looks import ics_symbol
from compare.studies.contact_frontier import NO_MAPS, TIGHTEST, approximations, compute_contact_frontier
from compare.studies.frontier import REFERENCE_FACTOR, Advice, Question, advise
from femic.advice.expected import Expectation
from femic.contact.specification import ContactProblem
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene

BUDGET = 600.0  # s
OF_ICS_ALONE = "This is the error from the ICs only; `femic contact` estimates the error from the elements."
Expect = Callable[[ContactProblem, Sequence[str]], Expectation | None]  # None: outside of what is known


def advise_contact(
    base: str,
    question: Question,
    options: RunOptions = DEFAULT,
    given: Mapping[str, Any] = NO_MAPS,
    *,
    budget: float = BUDGET,
    expect: Expect | None = None,
) -> tuple[Advice, xr.Dataset | None]:
    """Return the advice for a scene, and the frontier behind it; None where C was not needed.

    What `expect` knows of similar contacts may decide. Otherwise C is solved, at least four times tighter
    than the tolerance, within a budget of seconds; `given` are the scene's maps of C. Raises as `advise` and
    `compute_contact_frontier`.
    """
    if expect is not None:
        scene = load_scene(base)
        expectation = expect(scene.contact_problem, question.names)
        if expectation is not None and (advice := expected_advice(scene, question, expectation)):
            return advice, None
        options.watch.on_stage("similar contacts do not settle the question, so C is computed")
    tightest = max(question.tolerance / REFERENCE_FACTOR, TIGHTEST)
    frontier = compute_contact_frontier(
        base, question.names, options, given, budget=budget, tightest=tightest, as_shares=True
    )
    return advise(frontier, question), frontier


def expected_advice(scene: Scene, question: Question, expectation: Expectation) -> Advice | None:
    """Return the closest approximation of which enough is known; None where none is.

    All take milliseconds; the simplest that is good enough, for programs without the others, is named, too.
    What is known is of ICs without a fit.
    """
    fitted = scene.pair.has_effective("combined")
    bounds = {
        name: max(expectation.high(name, number) for number in question.names)
        for name in approximations(scene)
        if not (fitted and any(form.effective for form in needed_forms([name])))
    }
    enough = [name for name, bound in bounds.items() if bound <= question.tolerance]
    if not enough:
        return None
    closest, simplest = min(enough, key=bounds.__getitem__), enough[0]
    label = f"contact.ics = [{closest!r}]"
    known = [expectation.describe(closest, number) for number in question.names]
    if simplest != closest:
        known.append(
            f"{ics_symbol(simplest)} is also accurate enough: expected error at most {bounds[simplest]:.1%}."
        )
    text = (
        f"Use {label}: the expected error of {', '.join(question.names)} is at most "
        f"{bounds[closest]:.2%} (tolerance {question.tolerance:.2%}). {' '.join([*known, OF_ICS_ALONE])}"
    )
    return Advice(question, closest, {"contact": {"ics": [closest]}}, bounds[closest], text, label=label)
