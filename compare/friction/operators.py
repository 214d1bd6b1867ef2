"""ICs of all directions on a grid: fast operators of approximations, C with all nine components."""

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from compare.contact.compute import c_jobs, require_positive
from compare.contact.pair_on_grid import Placed
from femic.contact.frictional import FullOperator
from femic.contact.operators.approximations import approximate_operator
from femic.contact.operators.dense import PARITY, Asymmetry, GridOperator
from femic.contact.operators.rolled import rolled
from femic.reference.estimate import EstimatedICs
from femic.reference.matrix.pair import vertical
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import RunOptions
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.grids import Grid

FLAT = "A"  # whose convolutions are few: fast on any grid
MOST_DENSE = 96  # strips up to which products of others are 3 to 10 times faster dense between strips


@dataclass(frozen=True, eq=False)
class BodyICs:
    """C of a body on a grid, reciprocal, and its estimate [mm/MPa], shape (n_x, n_s, n_s, 3, 3) each.

    `approach` [mm/MPa] is what is subtracted from the approach of the pair per vertical traction.
    """

    ics: Array
    estimate: Array
    asymmetry: Asymmetry  # before the mean of C(I, J) and C(J, I)^T was taken
    approach: float = 0.0

    def scaled(self, factor: float) -> "BodyICs":
        """C of the same body with a modulus that is smaller by a factor."""
        return BodyICs(factor * self.ics, factor * self.estimate, self.asymmetry, factor * self.approach)


@dataclass(frozen=True, eq=False)
class FullReferenceICs:
    """C of both bodies on a grid in all directions: operator, and the same with C plus its estimate."""

    operator: GridOperator
    perturbed: GridOperator
    estimate: float  # largest estimated error over the largest C_nn, of both bodies
    asymmetry: Asymmetry  # the larger one of both bodies, before the mean of C(I, J) and C(J, I)^T was taken
    seconds: float


def approximation(placed: Placed, variant: str) -> FullOperator:
    """An approximation of the ICs of both bodies on their grid, in the form that is faster there."""
    operator = approximate_operator(variant, placed.pair, placed.grid, upper_offset=placed.offset)
    if variant == FLAT or placed.grid.n_s > MOST_DENSE or isinstance(operator, GridOperator):
        return operator
    return GridOperator.of_convolution(operator)


def full_reference_ics(scene: Scene, placed: Placed, options: RunOptions) -> FullReferenceICs:
    """C of both bodies: each made reciprocal, that of a rolling wheel for the slip of rolling, then added."""
    start, bodies = perf_counter(), body_ics(scene, placed, options)
    total = total_ics(scene, placed, bodies)
    estimates = sum(body.estimate for body in bodies.values())
    require_positive(scene, placed, total[..., 2, 2])
    largest = float(np.max(np.abs(total[..., 2, 2])))
    return FullReferenceICs(
        GridOperator.of(total),
        GridOperator.of(total + estimates),
        float(np.max(estimates)) / largest,
        max((body.asymmetry for body in bodies.values()), key=lambda one: one.share),
        perf_counter() - start,
    )


def body_ics(scene: Scene, placed: Placed, options: RunOptions) -> dict[str, BodyICs]:
    """C of both bodies; it goes like 1 / E. Raises NotConverged as `matrices`."""
    solved, found = matrices(c_jobs(scene, placed), options, combined=True), {}
    for name, reference in solved.items():
        ics, approach = _paired(reference, placed.grid)
        estimates = [_estimate(reference.column(strip)) for strip in range(placed.grid.n_s)]
        estimate = _matrix(estimates, placed.grid)
        found[name] = BodyICs(_reciprocal(ics), estimate, Asymmetry.of(ics), approach)
    return found


def full_operator(
    scene: Scene, placed: Placed, references: Mapping[str, MatrixReference], variation: str
) -> GridOperator:
    """C of both bodies as contact uses it; `variation` "nearer": with far arcs of half the radius."""
    bodies = {}
    for name, reference in references.items():
        ics, approach = _paired(reference, placed.grid, variation)
        bodies[name] = BodyICs(_reciprocal(ics), np.zeros_like(ics), Asymmetry.of(ics), approach)
    return GridOperator.of(total_ics(scene, placed, bodies))


def _paired(reference: MatrixReference, grid: Grid, variation: str = "") -> tuple[Array, float]:
    """C of a body as a pair takes it and what is subtracted from the pair's approach, both [mm/MPa]."""
    columns = [reference.paired_column(strip, variation) for strip in range(grid.n_s)]
    return _matrix(columns, grid), grid.area * reference.approach(variation)


def total_ics(scene: Scene, placed: Placed, bodies: Mapping[str, BodyICs]) -> Array:
    """The sum of the ICs of both bodies (n_x, n_s, n_s, 3, 3) [mm/MPa], as the motion sees them.

    The approach that is subtracted is that of a contact, along z without a turn: it changes no traction.
    """
    lower, upper = bodies["lower"].ics, bodies["upper"].ics
    if scene.contact.motion == "rolling":
        upper = rolled(upper, scene.bodies["upper"].surface, placed.upper_grid)
    moved = vertical(placed.undeformed.lower.contour, placed.grid.strips)
    approach = sum(body.approach for body in bodies.values())
    return np.asarray(lower + upper - approach * np.einsum("ai,bj->abij", moved, moved))


def _reciprocal(ics: Array) -> Array:
    """The mean of C(I, J) and C(J, I)^T."""
    return np.asarray((ics + PARITY * np.swapaxes(np.swapaxes(ics, 1, 2), 3, 4)) / 2)


def _matrix(columns: list[Array], grid: Grid) -> Array:
    """ICs [mm/MPa] (lag, observed, loaded, i, j) of columns (i, j, lag, observed) [mm/N]."""
    return np.asarray(grid.area * np.stack(columns, axis=-1).transpose(2, 3, 4, 0, 1))


def _estimate(column: EstimatedICs) -> Array:
    return column.estimate.astype(float)
