"""What follows from the columns of the IC matrices of a scene."""

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from approx.matrix import columns as approximations
from approx.variants import needs_effective
from compare.ics.compute import parts_of, solids
from compare.matrix.jobs import SOURCE
from femic.cache.threads import one_blas_thread
from femic.contact.operators.dense import smallest_eigenvalues
from femic.contact.operators.reciprocity import Reciprocity, reciprocity
from femic.ic_errors.matrix_deviation import Deviation, ReferenceColumn
from femic.reference.accuracy import Shares
from femic.reference.assessment import worst_of
from femic.reference.estimate import EstimatedICs, total
from femic.reference.matrix.columns import column_scale, column_shares, half_spaces_nn, is_far
from femic.reference.matrix.pair import pair_column
from femic.reference.matrix.reference import MatrixReference
from femic.reference.models import peak_memory
from femic.scenes.scene import Scene
from geometries.arrays import Array

LARGEST_WHOLE_MATRIX = 40_000_000  # entries of a matrix held as a whole, for reciprocity and eigenvalues


@dataclass(frozen=True, eq=False)
class MatrixResults:
    """The IC matrices of a scene's bodies, their errors, and how well they satisfy reciprocity and energy."""

    scene: Scene
    matrices: Mapping[str, MatrixReference]  # by solved body
    errors: Mapping[str, Shares]  # largest estimated error, by body compared
    reciprocity: Mapping[str, Reciprocity]  # defect of the raw matrix, by solved body
    # smallest of the symmetric part, over the least IC xx, ss, nn of an element on itself
    eigenvalues: Mapping[str, float]
    deviations: Mapping[str, Mapping[str, Deviation]]  # from C after the source's discount, by body, variant
    seconds: float
    memory: float  # peak of this process [MB]


def columns_of(scene: Scene, solved: Mapping[str, MatrixReference], strip: int) -> dict[str, EstimatedICs]:
    """Return C of each body compared due to unit loads on a strip, arrays (3, 3, n_x, n_s) [mm/N]."""
    return _compared(
        scene, solved, strip, {body: reference.column(strip) for body, reference in solved.items()}
    )


def _compared(
    scene: Scene,
    solved: Mapping[str, MatrixReference],
    strip: int,
    of_solved: Mapping[str, EstimatedICs],
) -> dict[str, EstimatedICs]:
    """Return the columns of the bodies compared from those of the solved bodies."""
    columns = dict(of_solved)
    if "combined" in scene.compared:
        columns["combined"] = pair_column(solved, scene.bodies["lower"].contour, strip, columns)
    return {body: columns[body] for body in scene.compared}


@dataclass(frozen=True, eq=False)
class Strip:
    """The columns of one loaded strip, and what follows from them, by body compared."""

    strip: int
    raw: Mapping[str, Array]  # C before the discount, by solved body
    columns: Mapping[str, EstimatedICs]  # C after the discount
    errors: Mapping[str, Shares]  # their estimated errors
    deviations: Mapping[str, Mapping[str, Deviation]]  # by variant; of "C": its estimated errors

    @classmethod
    def of(
        cls,
        scene: Scene,
        solved: Mapping[str, MatrixReference],
        strip: int,
        of_solved: Mapping[str, EstimatedICs],
    ) -> "Strip":
        """Return what follows from the columns of the solved bodies under loads on a strip."""
        columns = _compared(scene, solved, strip, of_solved)
        by_source = of_solved
        if scene.discount != SOURCE:
            by_source = {body: reference.column(strip, SOURCE) for body, reference in solved.items()}
        errors, deviations = {}, {}
        for body, c in columns.items():
            jobs = [solved[part].job for part in parts_of(body)]
            errors[body] = column_shares(strip, c, column_scale(strip, c.ic, jobs))
            without_bending = total([by_source[part] for part in parts_of(body)])
            column = ReferenceColumn(without_bending, is_far(strip, scene.grid), half_spaces_nn(strip, jobs))
            deviations[body] = _deviations(scene, body, strip, column)
        raw = {body: reference.raw_column(strip) for body, reference in solved.items()}
        return cls(strip, raw, columns, errors, deviations)


def _deviations(scene: Scene, body: str, strip: int, column: ReferenceColumn) -> dict[str, Deviation]:
    """Compare approximations, which are ICs of half-spaces, with C after the source's discount."""
    c, grid = column.c, scene.grid
    approximated = approximations(_variants(scene, body), solids(scene)[body], grid, strip)
    differences = {variant: ics / grid.area - c.ic for variant, ics in approximated.items()}
    return {
        name: Deviation.of_column(difference, column)
        for name, difference in (differences | {"C": c.estimate}).items()
    }


def _variants(scene: Scene, body: str) -> list[str]:
    """Return the variants that can be computed for a body, or for both."""
    return [variant for variant in scene.variants if body in scene.fitted or not needs_effective(variant)]


@dataclass(frozen=True, eq=False)
class Accumulator:
    """Results that accumulate over the columns, loaded strip by loaded strip.

    Whole matrices are held only up to `LARGEST_WHOLE_MATRIX` entries, in single precision, which changes the
    defects of reciprocity and the eigenvalues by 1e-7 of the largest IC.
    """

    scene: Scene
    solved: Mapping[str, MatrixReference]  # by solved body
    raw: dict[str, Array]  # matrices before the discount by solved body, (n_x, n_s, n_s, 3, 3) [mm/N]
    discounted: dict[str, Array]  # matrices after the discount by body compared, likewise
    errors: dict[str, list[Shares]]  # estimated errors of each column by body compared
    deviations: dict[str, dict[str, Deviation]]  # by body compared and variant; of "C": its estimated errors

    @classmethod
    def of(cls, scene: Scene, solved: Mapping[str, MatrixReference]) -> "Accumulator":
        """Return the state before the first strip."""
        shape = matrix_shape(scene)
        held_whole = int(np.prod(shape)) <= LARGEST_WHOLE_MATRIX
        return cls(
            scene,
            solved,
            {body: np.empty(shape, np.float32) for body in solved if held_whole},
            {body: np.empty(shape, np.float32) for body in scene.compared if held_whole},
            {body: [] for body in scene.compared},
            {body: {} for body in scene.compared},
        )

    def add(self, columns: Strip) -> None:
        """Add the columns of one more loaded strip."""
        strip = columns.strip
        for body, matrix in self.raw.items():
            matrix[:, :, strip] = directions_last(columns.raw[body])
        for body, matrix in self.discounted.items():
            matrix[:, :, strip] = directions_last(columns.columns[body].ic)
        for body, deviations in columns.deviations.items():
            self.errors[body].append(columns.errors[body])
            joined = self.deviations[body]
            for name, deviation in deviations.items():
                joined[name] = joined[name].joined(deviation) if name in joined else deviation

    def results(self, start: float, workers: int) -> MatrixResults:
        """Return the results after the last strip; `start` is when their computation began [s]."""
        scene = self.scene
        assert all(len(of_body) == scene.grid.n_s for of_body in self.errors.values())
        whole = {f"{body}, raw": ics for body, ics in self.raw.items()}
        whole |= {f"{body}, discounted": ics for body, ics in self.discounted.items()}
        with one_blas_thread():
            eigenvalues = dict(zip(whole, smallest_eigenvalues(whole.values(), workers), strict=True))
        return MatrixResults(
            scene,
            self.solved,
            {body: worst_of(strip_errors) for body, strip_errors in self.errors.items()},
            {
                body: reciprocity(ics, scene.bodies[body].contour, scene.grid)
                for body, ics in self.raw.items()
            },
            eigenvalues,
            self.deviations,
            perf_counter() - start,
            peak_memory(),
        )


def matrix_shape(scene: Scene) -> tuple[int, int, int, int, int]:
    """Return the shape of the matrix of a body: lags, observing strips, loaded strips, i, j."""
    grid = scene.grid
    return grid.n_x, grid.n_s, grid.n_s, 3, 3


def directions_last(column: Array) -> Array:
    """Return a column (i, j, lag, observing strip) as (lag, observing strip, i, j)."""
    return np.moveaxis(column, (0, 1), (2, 3))
