"""The cheapest ICs that are good enough for a tolerance, with the evidence."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from compare.reports.frontier import ways
from compare.reports.frontier.trade import Asked, compute_frontier, known_errors
from femic.means import DEFAULT, Means
from geometries.errors import Failure, WrongInput

ALIKE = 3.0  # times as many seconds as the fastest are as cheap: what a clock can tell of approximations
TIGHTER = 10.0  # C where that does not say whether a component vanishes
FINER = 4  # times tighter than the tolerance is the C against which errors are measured


@dataclass(frozen=True)
class Advice:
    """A way to ICs that meets a tolerance."""

    way: str
    label: str
    error: float  # at most, worst of the components
    seconds: float
    component: str  # the worst
    vanishes: bool  # C of this component does: the error is a share of 0.05 max |C_nn|
    body: str
    tolerance: float


def advise(dataset: xr.Dataset, tolerance: float, components: Sequence[str], body: str) -> Advice:
    """The cheapest way of a frontier whose errors, with those of the reference, meet the tolerance.

    Among ways that are as cheap (`ALIKE`) it is the closest. Raises WrongInput for components or bodies that
    the frontier does not have, Failure where no way is good enough.
    """
    for name, asked in (("component", components), ("body", [body])):
        unknown = [one for one in asked if one not in dataset[name].values]
        if unknown:
            raise WrongInput(
                f"{name} = {', '.join(unknown)}: the scene has {', '.join(dataset[name].values)}"
            )
    errors = known_errors(dataset, body).sel(component=list(components))
    worst = errors.max("component")
    seconds = dataset.seconds.sel(body=body)
    enough = worst.way.values[(worst <= tolerance).values]
    if not enough.size:
        best = str(worst.way.values[int(np.nanargmin(worst.values))])
        raise Failure(
            f"no way meets {tolerance:g}: the best, {best}, is known to {float(worst.min()):.2g}; ask for "
            "less, or for fewer components"
        )
    fastest = float(seconds.sel(way=enough).min())
    cheap = [one for one in enough if float(seconds.sel(way=one)) <= ALIKE * fastest]
    way = min(cheap, key=lambda one: float(worst.sel(way=one)))
    of_way = errors.sel(way=way)
    component = str(of_way.component.values[int(np.argmax(of_way.values))])
    return Advice(
        str(way),
        str(dataset.label.sel(way=way).item()),
        float(of_way.max()),
        float(seconds.sel(way=way)),
        component,
        bool(dataset.vanishes.sel(body=body, component=component)),
        body,
        tolerance,
    )


def told(advice: Advice) -> str:
    """The advice as a sentence."""
    of_what = "; it vanishes in C, so that is a share of 0.05 C_nn" if advice.vanishes else ""
    return (
        f"Use {advice.label}: {advice.body} ICs to {advice.error:.2%} of a component (worst: "
        f"{advice.component}{of_what}), {advice.tolerance:.2%} asked for."
    )


@dataclass(frozen=True)
class Question:
    """Of which body, in which components, and how accurately ICs are to be chosen."""

    body: str
    components: tuple[str, ...]
    tolerance: float


def tried_for(base: str, question: Question, means: Means = DEFAULT) -> tuple[Asked, xr.Dataset]:
    """What an advice rests on: the ways that were tried, and their frontier.

    Where a component vanishes in C, but not by symmetry, a tighter C is tried: it may just be small, and
    then its errors are shares of itself.
    """
    tolerance, body, components = question.tolerance, question.body, list(question.components)
    while True:
        asked = asked_for(tolerance, components, body)
        found = compute_frontier(base, asked, means)
        of_asked = found.sel(body=body, component=[one for one in components if one in found.component])
        undecided = bool(np.any(of_asked.vanishes & ~of_asked.by_symmetry))
        if not undecided or tolerance / FINER <= ways.TIGHTEST:
            return asked, found
        tolerance /= TIGHTER


def asked_for(tolerance: float, components: Sequence[str], body: str) -> Asked:
    """What has to be tried: the approximations, and C accurate enough to judge them by; of one body only."""
    if not 0 < tolerance <= 1:
        raise WrongInput(f"--tolerance {tolerance:g}: between 0 and 1")
    changes = {"components": list(components), "bodies": [body]}
    return Asked(tuple(ways.harmonic(tolerance / FINER)), changes=changes)
