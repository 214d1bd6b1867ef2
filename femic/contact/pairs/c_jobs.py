"""The jobs of C of both bodies of a contact: grid, components and far arc of each."""

from dataclasses import replace

import numpy as np

from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.specification import ContactProblem
from femic.reference.matrix.job import MatrixJob
from geometries.bodies import Domain
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import COMPONENTS

ASPECTS = (0.01, 100.0)  # least and largest dx / ds of a grid of C


def components_of(problem: ContactProblem) -> tuple[str, ...]:
    """Return the components of C that a contact needs."""
    return COMPONENTS if problem.specification.friction else ("nn",)


def c_jobs(
    problem: ContactProblem, on_grid: PairOnGrid, components: tuple[str, ...] | None = None
) -> dict[str, MatrixJob]:
    """Return the jobs of C of both bodies on a grid; the upper strips lie opposite, on their own contour.

    By default with the `components` that the contact needs. Raises WrongInput for slender elements.
    """
    grid, (least, largest) = on_grid.grid, ASPECTS
    if not least <= grid.dx / grid.ds <= largest:
        raise WrongInput(
            f"{problem.name}: C on elements of {grid.dx:g} x {grid.ds:g} mm: dx / ds is outside "
            f"{least:g} ... {largest:g}: give a [grid] of other elements, with contact.grid = 'scene'"
        )
    grids = {"lower": grid, "upper": on_grid.upper_grid}
    return {
        name: job_of(problem, name, grids[name], components or components_of(problem))
        for name in problem.bodies
    }


def job_of(problem: ContactProblem, name: str, grid: Grid, components: tuple[str, ...]) -> MatrixJob:
    """Return the job of C of a body on a grid."""
    body = replace(problem.bodies[name], domain=domain_on(problem, grid))
    settings = replace(problem.settings, cells=None)
    return MatrixJob(body, grid, settings, components, (problem.discount,))


def domain_on(problem: ContactProblem, grid: Grid) -> Domain:
    """Return the domain of both bodies: its far arc is a support, but for the source's discount a far end.

    As a support it depends neither on the grid nor on the tolerance; where it is given it is one in any case.
    """
    given = any(body.domain.radius_given for body in problem.bodies.values())
    if given or problem.discount != "source":
        return Domain(problem.support_radius, np.inf, radius_given=given)
    matrices_of = problem.settings.engine.matrices
    least = matrices_of.far_radius(problem.settings.tolerance, grid) if matrices_of else 0.0
    return Domain(max(least, *(body.domain.far_radius for body in problem.bodies.values())), np.inf)
