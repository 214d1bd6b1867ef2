"""Advice on the cheapest ICs that meet a tolerance, with the evidence for it."""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from compare.frontier import ways
from compare.frontier.compute import FrontierRequest, compute_frontier, engine_table, error_bounds
from femic.reference.engines import ENGINES
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

AS_CHEAP = 3.0  # times the fastest way's seconds: faster ways count as equally cheap, as clocks vary
RETRY_FACTOR = 10.0  # times tighter is the next C, if one leaves open whether a component vanishes
REFERENCE_FACTOR = 4  # how many times tighter than the tolerance the reference C is


@dataclass(frozen=True)
class Question:
    """The body and the components whose ICs are to be chosen, and the tolerance of their errors [-]."""

    body: str
    components: tuple[str, ...]
    tolerance: float


@dataclass(frozen=True)
class Advice:
    """A way to ICs that meets a tolerance, with its error and its seconds."""

    question: Question
    way: str
    label: str
    error: float  # upper bound, of the worst component
    seconds: float
    component: str  # the worst one
    vanishes: bool  # whether this component vanishes in C: the error is then a share of 0.05 max |C_nn|


def advise(dataset: xr.Dataset, question: Question) -> Advice:
    """Return the cheapest way of a frontier whose error bounds meet the tolerance: see `cheapest`.

    Raises WrongInput for components or bodies that the frontier does not have, Failure if no way meets the
    tolerance.
    """
    body, components, tolerance = question.body, list(question.components), question.tolerance
    for dimension, names in (("component", components), ("body", [body])):
        unknown = [name for name in names if name not in dataset[dimension].values]
        if unknown:
            raise WrongInput(
                f"{dimension} = {', '.join(unknown)}: the scene has {', '.join(dataset[dimension].values)}"
            )
    errors = error_bounds(dataset, body).sel(component=components)
    worst, seconds = errors.max("component"), dataset.seconds.sel(body=body)
    number = cheapest(worst.values, seconds.values, tolerance)
    if number < 0:
        best = str(worst.way.values[int(np.nanargmin(worst.values))])
        raise Failure(
            f"no way meets {tolerance:g}: the best, {best}, has errors up to {float(worst.min()):.2g}: give "
            "a larger tolerance, or fewer components"
        )
    way, way_errors = dataset.isel(way=number), errors.isel(way=number)
    component = str(way_errors.component.values[int(np.argmax(way_errors.values))])
    return Advice(
        question,
        str(way.way.item()),
        str(way.label.item()),
        float(way_errors.max()),
        float(seconds[number]),
        component,
        bool(dataset.vanishes.sel(body=body, component=component)),
    )


def cheapest(bounds: Array, seconds: Array, tolerance: float) -> int:
    """Return the number of the cheapest ICs whose error bound meets a tolerance, -1 if none does.

    Among equally cheap ICs (`AS_CHEAP`) the most accurate are chosen.
    """
    good = np.flatnonzero(bounds <= tolerance)
    if not good.size:
        return -1
    cheap = good[seconds[good] <= AS_CHEAP * np.min(seconds[good])]
    return int(cheap[np.argmin(bounds[cheap])])


def sentence(advice: Advice) -> str:
    """Return the advice as a sentence."""
    share_note = "; it vanishes in C, so that is a share of 0.05 C_nn" if advice.vanishes else ""
    return (
        f"Use {advice.label}: {advice.question.body} ICs to {advice.error:.2%} of a component (worst: "
        f"{advice.component}{share_note}; tolerance {advice.question.tolerance:.2%})."
    )


def frontier_for(
    base: str, question: Question, options: RunOptions = DEFAULT
) -> tuple[FrontierRequest, xr.Dataset]:
    """Return the request that answers a question, and its frontier.

    If a component vanishes in C, but not by symmetry, a tighter C is computed: the component may only be
    small, and its errors would then be shares of itself.
    """
    tightest = ENGINES[engine_table(base)["kind"]].comparison.tolerances[-1]
    while True:
        request = request_for(base, question)
        frontier = compute_frontier(base, request, options)
        body = frontier.sel(body=question.body)
        undecided = bool(np.any(body.vanishes & ~body.by_symmetry))
        if not undecided or question.tolerance / REFERENCE_FACTOR <= tightest:
            return request, frontier
        question = replace(question, tolerance=question.tolerance / RETRY_FACTOR)


def request_for(base: str, question: Question) -> FrontierRequest:
    """Return the request for the approximations of one body, and C of the scene's engine to measure them.

    Raises WrongInput unless the tolerance is above 0 and at most 1.
    """
    if not 0 < question.tolerance <= 1:
        raise WrongInput(f"--tolerance {question.tolerance:g}: must be above 0 and at most 1")
    changes = {"components": list(question.components), "bodies": [question.body]}
    kind, tightest = engine_table(base)["kind"], question.tolerance / REFERENCE_FACTOR
    return FrontierRequest(tuple(ways.engine_ways(kind, tightest)), changes=changes)
