"""The motions whose contact is solved, each in a file of its own: keys, solution, estimates, dataset, wants.

A motion is registered here, and its page in `compare.pages.friction_pages`. Scenes are checked by this
registry: what solves a contact is loaded when it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from femic.contact.motions import compression, none, rolling, transient
from femic.contact.motions.motion import Motion
from femic.contact.specification import ContactProblem, ContactSpecification
from femic.lazy import lazy_imports
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.errors import WrongInput

with lazy_imports():
    from femic.contact.pairs import grids, ics, pair_on_grid, pair_with_friction

MOTIONS: dict[str, Motion] = {
    "none": none.MOTION,
    "rolling": rolling.MOTION,
    "transient": transient.MOTION,
    "compression": compression.MOTION,
}

Outcome = TypeVar("Outcome")


def find_motion(specification: ContactSpecification) -> Motion:
    """Return the motion of a specification; raise WrongInput for an unknown one."""
    if specification.motion not in MOTIONS:
        raise WrongInput(f"motion = {specification.motion!r}: one of {', '.join(MOTIONS)}")
    return MOTIONS[specification.motion]


def pair_in_motion(
    problem: ContactProblem,
    on_grid: pair_on_grid.PairOnGrid,
    options: RunOptions = DEFAULT,
    given: Mapping[str, ics.GivenICs] | None = None,
) -> pair_with_friction.PairWithFriction:
    """Return the bodies of a problem on a grid, with friction, in its motion; `given` are ICs by name."""
    rolls = find_motion(problem.specification).wheel_rolls
    return pair_with_friction.PairWithFriction(problem, on_grid, rolls, options, given or {})


def solve_with_friction(
    problem: ContactProblem,
    solve: Callable[[pair_with_friction.PairWithFriction], Outcome],
    options: RunOptions = DEFAULT,
    given: Mapping[str, ics.GivenICs] | None = None,
) -> Outcome:
    """Return the solution of `solve` on a grid that fits the largest load, made longer where needed.

    `given` are ICs of the caller by name; with some of them among those of the problem, the grid is theirs.
    """
    own = ics.select_given(problem.specification.ics, given or {})
    ((grid, loadings),) = grids.grids_of(problem, own)

    def solve_on(on_grid: pair_on_grid.PairOnGrid) -> Outcome:
        n_x, n_s = on_grid.grid.n_x, on_grid.grid.n_s
        size = f"{on_grid.grid.dx:.3g} x {on_grid.grid.ds:.3g} mm"
        options.watch.on_stage(f"  {n_x} x {n_s} elements of {size}: {loadings[-1]}")
        return solve(pair_in_motion(problem, on_grid, options, own))

    return grids.on_fitting_grid(problem, grid, solve_on, longer=not own)
