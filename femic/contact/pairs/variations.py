"""A motion solved again for its estimates: on larger elements, and with ICs plus their estimated errors."""

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from femic.contact.frictional import FrictionalProblem
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.pair_with_friction import PairWithFriction
from geometries.errors import Failure

Solution = TypeVar("Solution")
Solve = Callable[[PairWithFriction, FrictionalProblem, str], Solution]  # the last is a label for messages
ELEMENTS = ("larger elements", "still larger elements")


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
