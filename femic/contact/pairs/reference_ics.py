"""C of both bodies on a grid as operators of contact, with its quality; approximations as operators."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.contact.operators.approximations import approximate_operator
from femic.contact.operators.dense import Asymmetry, GridOperator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.body_ics import (
    ALL,
    NORMAL,
    BodyICs,
    bodies_of,
    c_of_bodies,
    reciprocal,
    sum_of_bodies,
)
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.positivity import require_positive
from femic.contact.specification import ContactProblem
from femic.reference.matrix.reference import MatrixReference
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.patches import N


@dataclass(frozen=True, eq=False)
class ReferenceICs:
    """C of both bodies on a grid as an operator, the same with its estimated error added, and its quality."""

    operator: GridOperator
    perturbed: GridOperator
    estimate: float  # largest estimated error over the largest C_nn
    asymmetry: Asymmetry  # before the mean of C(I, J) and C(J, I)^T was taken
    eigenvalue: float  # smallest of C_nn over the least IC of an element on itself (`require_positive`)
    seconds: float


def approximation(on_grid: PairOnGrid, variant: str) -> FullOperator:
    """Return an approximation of the ICs of both bodies on their grid."""
    return approximate_operator(variant, on_grid.pair, on_grid.grid, upper_offset=on_grid.offset)


def normal_reference_ics(problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions) -> ReferenceICs:
    """C_nn of both bodies on a grid; raises Failure as `require_positive`."""
    start = perf_counter()
    ics, estimate = normal_ics(problem, on_grid, options)
    largest = float(np.max(np.abs(ics)))
    return ReferenceICs(
        normal_operator(ics),
        normal_operator(ics + estimate),
        float(np.max(estimate)) / largest,
        Asymmetry(float(np.max(np.abs(ics - np.swapaxes(ics, 1, 2)))) / largest, "nn"),
        require_positive(problem, on_grid, ics),
        perf_counter() - start,
    )


def full_reference_ics(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions, *, wheel_rolls: bool
) -> ReferenceICs:
    """C of both bodies in all directions; raises Failure as `require_positive`.

    `wheel_rolls`: with the displacements of the upper body as the rail sees them in rolling.
    """
    start = perf_counter()
    bodies, estimate = c_of_bodies(problem, on_grid, options, ALL)
    ics = sum_of_bodies(on_grid, _each_reciprocal(bodies), wheel_rolls=wheel_rolls)
    eigenvalue = require_positive(problem, on_grid, ics[..., N, N])
    return ReferenceICs(
        GridOperator.of(ics),
        GridOperator.of(ics + estimate),
        float(np.max(estimate)) / float(np.max(np.abs(ics[..., N, N]))),
        max((Asymmetry.of(body.ics) for body in bodies.values()), key=lambda asymmetry: asymmetry.share),
        eigenvalue,
        perf_counter() - start,
    )


def normal_ics(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions = DEFAULT
) -> tuple[Array, Array]:
    """C_nn of both bodies on a grid and its estimated error [mm/MPa], (n_x, n_s, n_s) each."""
    bodies, estimate = c_of_bodies(problem, on_grid, options, NORMAL)
    return sum_of_bodies(on_grid, bodies)[..., 0, 0], estimate[..., 0, 0]


def normal_operator(ics: Array) -> GridOperator:
    """Return the operator of nn ICs (n_x, n_s, n_s) [mm/MPa], which are made symmetric."""
    return GridOperator.of(reciprocal(ics[..., None, None]), NORMAL)


def pair_operator(
    references: Mapping[str, MatrixReference],
    on_grid: PairOnGrid,
    directions: tuple[int, ...],
    *,
    variation: str = "",
    wheel_rolls: bool = False,
) -> GridOperator:
    """Return the operator of C of both bodies; `variation` "nearer": with far arcs of half the radius."""
    bodies = bodies_of(references, on_grid.grid, directions, variation)
    total = sum_of_bodies(on_grid, _each_reciprocal(bodies), wheel_rolls=wheel_rolls)
    return GridOperator.of(total, directions)


def _each_reciprocal(bodies: Mapping[str, BodyICs]) -> dict[str, BodyICs]:
    return {name: replace(body, ics=reciprocal(body.ics)) for name, body in bodies.items()}
