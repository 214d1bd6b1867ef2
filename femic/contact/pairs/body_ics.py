"""C of each body on the grid of a contact, and their sum without the approach of the pair.

The approach that is subtracted moves the bodies as the approach of a contact does, along z and without a
turn: tractions do not depend on it. (Each body's own would not cancel where contours differ: the bodies' M_zz
are large and of opposite signs, and normals at equal arc lengths are not parallel.)
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from femic.contact.operators.dense import PARITY
from femic.contact.operators.rolled import rolled
from femic.contact.pairs.c_jobs import c_jobs
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.specification import ContactProblem
from femic.reference.matrix.pair import vertical
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import RunOptions
from geometries.arrays import Array
from geometries.grids import Grid
from geometries.patches import COMPONENTS, N, S, X

ALL, NORMAL = (X, S, N), (N,)  # directions of tractions with friction, and without


@dataclass(frozen=True, eq=False)
class BodyICs:
    """C of a body on a grid [mm/MPa], shape (n_x, n_s, n_s, m, m) in m directions.

    `approach` [mm/MPa] is subtracted from the approach of the pair per vertical traction.
    """

    ics: Array
    approach: float = 0.0


def c_of_bodies(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions, directions: tuple[int, ...]
) -> tuple[dict[str, BodyICs], Array]:
    """C of each body, and the sum of their estimated errors [mm/MPa], (n_x, n_s, n_s, m, m).

    C of a body goes like 1 / E. Raises NotConverged as `femic.reference.matrix.reference.matrices`.
    """
    components = COMPONENTS if directions == ALL else ("nn",)
    references = matrices(c_jobs(problem, on_grid, components), options, combined=True)
    grid = on_grid.grid
    return bodies_of(references, grid, directions), estimate_of(references, grid, directions)


def estimate_of(references: Mapping[str, MatrixReference], grid: Grid, directions: tuple[int, ...]) -> Array:
    """Return the sum of the estimated errors of both bodies' C [mm/MPa], (n_x, n_s, n_s, m, m)."""
    estimates = [
        _matrix([reference.column(strip).estimate for strip in range(grid.n_s)], grid, directions)
        for reference in references.values()
    ]
    return np.asarray(sum(estimates))


def sum_of_bodies(on_grid: PairOnGrid, bodies: Mapping[str, BodyICs], *, wheel_rolls: bool = False) -> Array:
    """Return the sum of the ICs of both bodies (n_x, n_s, n_s, m, m) [mm/MPa], less their approach."""
    lower, upper = bodies["lower"].ics, bodies["upper"].ics
    if wheel_rolls:
        upper = rolled(upper, on_grid.undeformed.upper, on_grid.upper_grid)
    moved = vertical(on_grid.undeformed.lower.contour, on_grid.grid.strips)[:, -lower.shape[-1] :]
    approach = sum(body.approach for body in bodies.values())
    return np.asarray(lower + upper - approach * np.einsum("ai,bj->abij", moved, moved))


def reciprocal(ics: Array) -> Array:
    """Return the mean of C(I, J) and C(J, I)^T, of ICs (n_x, n_s, n_s, m, m) in all directions or along n."""
    m = ics.shape[-1]
    return np.asarray((ics + PARITY[-m:, -m:] * np.swapaxes(np.swapaxes(ics, 1, 2), 3, 4)) / 2)


def bodies_of(
    references: Mapping[str, MatrixReference], grid: Grid, directions: tuple[int, ...], variation: str = ""
) -> dict[str, BodyICs]:
    """Return C of bodies before their approach is subtracted, and this approach."""
    return {
        name: BodyICs(
            _matrix(
                [reference.paired_column(strip, variation) for strip in range(grid.n_s)], grid, directions
            ),
            grid.area * reference.approach(variation),
        )
        for name, reference in references.items()
    }


def _matrix(columns: list[Array], grid: Grid, directions: tuple[int, ...]) -> Array:
    """ICs [mm/MPa] (lag, observed, loaded, i, j) of columns (i, j, lag, observed) [mm/N]."""
    of_directions = [column[np.ix_(directions, directions)].astype(float) for column in columns]
    return np.asarray(grid.area * np.stack(of_directions, axis=-1).transpose(2, 3, 4, 0, 1))
