"""A motion solved again for its estimates: on larger elements, and with ICs plus their estimated errors."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from femic.contact.estimates import Numbers
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.pair_with_friction import PairWithFriction
from geometries.arrays import Array
from geometries.errors import Failure

Solution = TypeVar("Solution")
Solve = Callable[[PairWithFriction, FrictionalProblem, str], Solution]  # the last is a label for messages
ELEMENTS = ("larger elements", "still larger elements")


@dataclass(frozen=True, eq=False)
class Change:
    """By how much a solution changes when the estimated errors of its ICs are added to these.

    0 where no errors of ICs are known, NaN where the changed ICs have no solution.
    """

    points: Sequence[Numbers]  # by creepage or load
    p: Array  # of tractions in the contact that has maps [MPa], (n_x, n_s, 3)


def if_possible(pair: PairWithFriction, consequence: str, solve: Callable[[], Solution]) -> Solution | None:
    """Return a solution; None where there is none, which is reported. Raises PotentialAreaTooSmall."""
    try:
        return solve()
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        pair.options.watch.on_stage(f"  {consequence}: {failure}")
        return None


def on_larger_elements(
    pair: PairWithFriction, problem: FrictionalProblem, label: str, solve: Solve[Solution]
) -> list[Solution | None]:
    """Return the solutions on elements twice and four times as large, None where there is none."""
    solutions: list[Solution | None] = []
    for elements in ELEMENTS:
        if not problem.has_coarser:
            break
        problem = problem.coarsened
        solve_coarse = partial(solve, pair, problem, f"{label}, {elements}")
        solutions.append(if_possible(pair, "not in estimates", solve_coarse))
    return solutions


def with_perturbed_ics(
    pair: PairWithFriction, friction: float, name: str, label: str, solve: Solve[Solution]
) -> Solution | None:
    """Return the solution with ICs plus their estimated errors; None where no errors are known."""
    operator = pair.perturbed(name)
    if operator is None:
        return None
    return solve(pair, pair.frictional(operator, friction), f"{label} plus its estimate")


def differences(numbers: Numbers, changed: Numbers | None) -> dict[str, float]:
    """Return changed numbers less the numbers themselves; NaN where there are none."""
    return {name: np.nan if changed is None else changed[name] - value for name, value in numbers.items()}


def change_of_tractions(contact: FrictionalContact, changed: FrictionalContact | None) -> Array:
    """Return changed tractions less those of a contact [MPa], (n_x, n_s, 3); NaN where there are none."""
    return np.full_like(contact.p, np.nan) if changed is None else changed.p - contact.p
