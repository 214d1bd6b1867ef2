"""C of both bodies on a grid, assembled from the columns of each, and the operators that contact takes.

The approach that is subtracted moves the bodies as the approach of a contact does, along z and without a
turn: tractions do not depend on it. (Each body's own would not cancel where contours differ: the bodies' M_zz
are large and of opposite signs, and normals at equal arc lengths are not parallel.)
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.contact.frictional import FullOperator
from femic.contact.operators.approximations import approximate_operator
from femic.contact.operators.dense import PARITY, Asymmetry, GridOperator
from femic.contact.operators.rolled import rolled
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.positivity import require_positive
from femic.contact.specification import ContactProblem
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.pair import vertical
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.bodies import Domain
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import COMPONENTS, N, S, X

ALL, NORMAL = (X, S, N), (N,)  # directions of tractions with friction, and without
FLAT = "A"  # its convolutions are few: fast on any grid
MOST_DENSE = 96  # strips up to which products of others are 3 to 10 times faster dense between strips
ASPECTS = (0.01, 100.0)  # least and largest dx / ds of a grid of C


@dataclass(frozen=True, eq=False)
class BodyICs:
    """C of a body on a grid [mm/MPa], shape (n_x, n_s, n_s, m, m) in m directions.

    `approach` [mm/MPa] is subtracted from the approach of the pair per vertical traction.
    """

    ics: Array
    approach: float = 0.0

    @property
    def reciprocal(self) -> "BodyICs":
        """The same with the mean of C(I, J) and C(J, I)^T."""
        return replace(self, ics=reciprocal(self.ics))


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
    """An approximation of the ICs of both bodies on their grid, in the form that is faster there."""
    operator = approximate_operator(variant, on_grid.pair, on_grid.grid, upper_offset=on_grid.offset)
    if variant == FLAT or on_grid.grid.n_s > MOST_DENSE or isinstance(operator, GridOperator):
        return operator
    return GridOperator.of_convolution(operator)


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
        max((Asymmetry.of(body.ics) for body in bodies.values()), key=lambda one: one.share),
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
    """The operator of nn ICs (n_x, n_s, n_s) [mm/MPa], which are made symmetric."""
    return GridOperator.of(reciprocal(ics[..., None, None]), NORMAL)


def pair_operator(
    references: Mapping[str, MatrixReference],
    on_grid: PairOnGrid,
    directions: tuple[int, ...],
    *,
    variation: str = "",
    wheel_rolls: bool = False,
) -> GridOperator:
    """The operator of C of both bodies; `variation` "nearer": with far arcs of half the radius."""
    bodies = _bodies(references, on_grid.grid, directions, variation)
    total = sum_of_bodies(on_grid, _each_reciprocal(bodies), wheel_rolls=wheel_rolls)
    return GridOperator.of(total, directions)


def c_of_bodies(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions, directions: tuple[int, ...]
) -> tuple[dict[str, BodyICs], Array]:
    """C of each body, and the sum of their estimated errors [mm/MPa], (n_x, n_s, n_s, m, m).

    C of a body goes like 1 / E. Raises NotConverged as `femic.reference.matrix.reference.matrices`.
    """
    components = COMPONENTS if directions == ALL else ("nn",)
    references = matrices(c_jobs(problem, on_grid, components), options, combined=True)
    grid = on_grid.grid
    estimates = [
        _matrix([reference.column(strip).estimate for strip in range(grid.n_s)], grid, directions)
        for reference in references.values()
    ]
    return _bodies(references, grid, directions), np.asarray(sum(estimates))


def sum_of_bodies(on_grid: PairOnGrid, bodies: Mapping[str, BodyICs], *, wheel_rolls: bool = False) -> Array:
    """The sum of the ICs of both bodies (n_x, n_s, n_s, m, m) [mm/MPa], less the approach of the pair."""
    lower, upper = bodies["lower"].ics, bodies["upper"].ics
    if wheel_rolls:
        upper = rolled(upper, on_grid.undeformed.upper, on_grid.upper_grid)
    moved = vertical(on_grid.undeformed.lower.contour, on_grid.grid.strips)[:, -lower.shape[-1] :]
    approach = sum(body.approach for body in bodies.values())
    return np.asarray(lower + upper - approach * np.einsum("ai,bj->abij", moved, moved))


def reciprocal(ics: Array) -> Array:
    """The mean of C(I, J) and C(J, I)^T, of ICs (n_x, n_s, n_s, m, m) in all directions or along n."""
    m = ics.shape[-1]
    return np.asarray((ics + PARITY[-m:, -m:] * np.swapaxes(np.swapaxes(ics, 1, 2), 3, 4)) / 2)


def components_of(problem: ContactProblem) -> tuple[str, ...]:
    """The components of C that a contact needs."""
    return COMPONENTS if problem.specification.friction else ("nn",)


def c_jobs(
    problem: ContactProblem, on_grid: PairOnGrid, components: tuple[str, ...] | None = None
) -> dict[str, MatrixJob]:
    """The jobs of C of both bodies on a grid; strips of the upper body lie opposite, on its own contour.

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
    """The job of C of a body on a grid."""
    body = replace(problem.bodies[name], domain=Domain(far_radius(problem, grid), np.inf))
    settings = replace(problem.settings, cells=None)
    return MatrixJob(body, grid, settings, components, (problem.discount,))


def far_radius(problem: ContactProblem, grid: Grid) -> float:
    """Radius [mm] of the far arc: a support of the bodies, but for the source's discount a body without end.

    As a support it depends neither on the grid nor on the tolerance.
    """
    if problem.discount != "source":
        return problem.support_radius
    matrices_of = problem.settings.engine.matrices
    least = matrices_of.far_radius(problem.settings.tolerance, grid) if matrices_of else 0.0
    return max(least, *(body.domain.far_radius for body in problem.bodies.values()))


def _bodies(
    references: Mapping[str, MatrixReference], grid: Grid, directions: tuple[int, ...], variation: str = ""
) -> dict[str, BodyICs]:
    """C of bodies before their approach is subtracted, and that."""
    return {
        name: BodyICs(
            _matrix(
                [reference.paired_column(strip, variation) for strip in range(grid.n_s)], grid, directions
            ),
            grid.area * reference.approach(variation),
        )
        for name, reference in references.items()
    }


def _each_reciprocal(bodies: Mapping[str, BodyICs]) -> dict[str, BodyICs]:
    return {name: body.reciprocal for name, body in bodies.items()}


def _matrix(columns: list[Array], grid: Grid, directions: tuple[int, ...]) -> Array:
    """ICs [mm/MPa] (lag, observed, loaded, i, j) of columns (i, j, lag, observed) [mm/N]."""
    of_directions = [column[np.ix_(directions, directions)].astype(float) for column in columns]
    return np.asarray(grid.area * np.stack(of_directions, axis=-1).transpose(2, 3, 4, 0, 1))
