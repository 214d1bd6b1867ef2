"""Compute the IC matrix of a scene and write it strip by strip."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter

import h5netcdf
import numpy as np
import xarray as xr

from approx.matrix import columns as approximations
from approx.variants import needs_effective
from compare.ics.compute import models_of, parts_of, solids
from femic.cache.digests import results_digest, versions
from femic.cache.files import replacing
from femic.cache.threads import one_blas_thread
from femic.contact.operators.dense import GridOperator
from femic.contact.operators.reciprocity import Reciprocity, reciprocity
from femic.contact.pairs.c_jobs import far_radius
from femic.ic_errors.matrix_deviation import Deviation, ReferenceColumn
from femic.reference.accuracy import Shares
from femic.reference.assessment import worst_of
from femic.reference.discount import AXES
from femic.reference.estimate import EstimatedICs, total
from femic.reference.matrix.columns import column_scale, column_shares, half_spaces_nn, is_far
from femic.reference.matrix.job import Discount, MatrixJob
from femic.reference.matrix.pair import pair_column
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.models import peak_memory
from femic.reference.plan import ModelPlan, plans
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import require_none
from femic.scenes.grid import grid_misfits
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.bodies import Domain
from geometries.patches import COMPONENTS, DIRECTIONS

DIMENSIONS = ("body", "lag", "observed", "loaded", "i", "j")
SOURCE: Discount = "source"  # the discount after which C is compared with ICs of half-spaces
DISCOUNTS = {
    "approach": "The rigid part of the normal approach is subtracted from C; the rest is the response of the "
    "bodies with their supports.",
    "source": "All motions that [BVSV] discounts are subtracted from C, including bending of the sections.",
    "none": "Nothing is subtracted from C.",
}
LARGEST_WHOLE_MATRIX = 40_000_000  # entries of a matrix held as a whole, for reciprocity and eigenvalues
VARIABLES = (("ic", "f8", "C after the discount"), ("estimate", "f4", "estimated error of C"))


@dataclass(frozen=True, eq=False)
class MatrixResults:
    """The IC matrices of a scene's bodies, their errors, and how well they satisfy reciprocity and energy."""

    scene: Scene
    matrices: Mapping[str, MatrixReference]  # by solved body
    errors: Mapping[str, Shares]  # largest estimated error, by body compared
    reciprocity: Mapping[str, Reciprocity]  # defect of the raw matrix, by solved body
    eigenvalues: Mapping[str, float]  # smallest of the symmetric part, over the element's own ICs
    deviations: Mapping[str, Mapping[str, Deviation]]  # from C after the source's discount, by body, variant
    seconds: float
    memory: float  # peak of the process [MB]


def columns_of(scene: Scene, solved: Mapping[str, MatrixReference], strip: int) -> dict[str, EstimatedICs]:
    """Return C of each body compared due to unit loads on a strip, arrays (3, 3, n_x, n_s) [mm/N]."""
    columns = {body: reference.column(strip) for body, reference in solved.items()}
    if "combined" in scene.compared:
        columns["combined"] = pair_column(solved, scene.bodies["lower"].contour, strip, columns)
    return {body: columns[body] for body in scene.compared}


def matrix_jobs(
    scene: Scene, components: tuple[str, ...] = COMPONENTS, further: tuple[Discount, ...] = ()
) -> dict[str, MatrixJob]:
    """Return the jobs of the bodies that the comparison needs; raises BadScene as `require_matrices`.

    Contact needs only some `components`; the matrix of a scene has all nine. C is computed after the discount
    of the scene; the same models can give it after `further` discounts.
    """
    require_matrices(scene)
    domain = Domain(far_radius(scene.contact_problem, scene.grid), np.inf)
    settings = replace(scene.settings, cells=None)
    return {
        name: MatrixJob(
            replace(body, domain=domain),
            scene.grid,
            settings,
            components,
            tuple(dict.fromkeys((scene.discount, *further))),
        )
        for name, body in scene.bodies.items()
        if name in scene.solved
    }


def matrix_plans(scene: Scene, workers: int) -> list[ModelPlan]:
    """Return the plans of the models of the first round; raises BadScene as `matrix_jobs` does."""
    return list(plans(matrix_jobs(scene, further=(SOURCE,)), workers))


def require_matrices(scene: Scene) -> None:
    """Raise BadScene for a grid that does not fit, and for an engine without IC matrices."""
    require_none(scene.name, [*grid_misfits(scene), *matrix_engine_misfits(scene)])


def discounted(scene: Scene) -> str:
    """Return sentences on the rigid part that is subtracted from C, and on the supports of the bodies."""
    given = [name for name, body in scene.bodies.items() if body.outline is not None]
    if len(given) == len(scene.bodies):
        return f"{DISCOUNTS[scene.discount]} The sections are clamped where their outlines say."
    hubs = [
        name
        for name, body in scene.bodies.items()
        if np.isfinite(body.rolling_radius) and body.outline is None
    ]
    at_hub = f", and the {' and '.join(hubs)} body also at its hub" if hubs else ""
    radius = far_radius(scene.contact_problem, scene.grid)
    without = f" without the {given[0]} body, which its outline clamps," if given else ""
    clamped = f"The sections{without} are clamped at a far arc of {radius:g} mm{at_hub}."
    return f"{DISCOUNTS[scene.discount]} {clamped}"


def compute_matrix(scene: Scene, path: Path, options: RunOptions = DEFAULT) -> MatrixResults:
    """Compute the matrices of a scene and write them to a NetCDF file, one loaded strip at a time.

    Raises BadScene where the grid does not fit, and NotConverged as `femic.reference.at_points.references`.
    """
    start = perf_counter()
    jobs, combined = matrix_jobs(scene, further=(SOURCE,)), "combined" in scene.compared
    accumulator = _Accumulator.of(scene, matrices(jobs, options, combined=combined))
    options.watch.on_stage("  writing, checking")
    with replacing(path) as unfinished:
        _write_coordinates(scene, accumulator.solved, unfinished)
        with h5netcdf.File(unfinished, "a") as file:
            _create_variables(file, scene)
            ics, estimates = file["ic"], file["estimate"]
            for columns in accumulator.strips():
                for b, c in enumerate(columns.columns.values()):
                    ics[b, :, :, columns.strip] = scene.grid.area * _directions_last(c.ic)
                    estimates[b, :, :, columns.strip] = scene.grid.area * _directions_last(c.estimate)
            results = accumulator.results(start)
            file.attrs.update(_attributes(results))
        _require_readable(unfinished)
    return results


def _require_readable(path: Path) -> None:
    """Read all matrices of a file, so that HDF5 compares the checksums of all pieces (OSError)."""
    with h5netcdf.File(path, "r") as file:
        for name, _, _ in VARIABLES:
            for strip in range(file[name].shape[3]):
                file[name][:, :, :, strip]


@dataclass(frozen=True, eq=False)
class _Strip:
    """The columns of one loaded strip, and what follows from them, by body compared."""

    strip: int
    columns: Mapping[str, EstimatedICs]  # C after the discount
    errors: Mapping[str, Shares]  # their estimated errors
    deviations: Mapping[str, Mapping[str, Deviation]]  # by variant; of "C": its estimated errors

    @classmethod
    def of(cls, scene: Scene, solved: Mapping[str, MatrixReference], strip: int) -> "_Strip":
        """Return the columns of a loaded strip."""
        columns = columns_of(scene, solved, strip)
        by_source = {body: reference.column(strip, SOURCE) for body, reference in solved.items()}
        errors, deviations = {}, {}
        for body, c in columns.items():
            jobs = [solved[part].job for part in parts_of(body)]
            errors[body] = column_shares(strip, c, column_scale(strip, c.ic, jobs))
            without_bending = total([by_source[part] for part in parts_of(body)])
            column = ReferenceColumn(without_bending, is_far(strip, scene.grid), half_spaces_nn(strip, jobs))
            deviations[body] = _deviations(scene, body, strip, column)
        return cls(strip, columns, errors, deviations)


def _deviations(scene: Scene, body: str, strip: int, column: ReferenceColumn) -> dict[str, Deviation]:
    """Compare approximations, which are ICs of half-spaces, with C after the source's discount."""
    c, grid = column.c, scene.grid
    approximated = approximations(_variants(scene, body), solids(scene)[body], grid, strip)
    differences = {variant: ics / grid.area - c.ic for variant, ics in approximated.items()}
    return {
        name: Deviation.of_column(difference, column)
        for name, difference in (differences | {"C": c.estimate}).items()
    }


@dataclass(frozen=True, eq=False)
class _Accumulator:
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
    def of(cls, scene: Scene, solved: Mapping[str, MatrixReference]) -> "_Accumulator":
        """Return the state before the first strip."""
        shape = _shape(scene)
        held_whole = int(np.prod(shape)) <= LARGEST_WHOLE_MATRIX
        return cls(
            scene,
            solved,
            {body: np.empty(shape, np.float32) for body in solved if held_whole},
            {body: np.empty(shape, np.float32) for body in scene.compared if held_whole},
            {body: [] for body in scene.compared},
            {body: {} for body in scene.compared},
        )

    def strips(self) -> Iterator[_Strip]:
        """Yield the columns of each loaded strip, added to the results."""
        with one_blas_thread():
            for strip in range(self.scene.grid.n_s):
                columns = _Strip.of(self.scene, self.solved, strip)
                self._add(columns)
                yield columns

    def _add(self, columns: _Strip) -> None:
        """Add the columns of one more loaded strip."""
        strip = columns.strip
        for body, matrix in self.raw.items():
            matrix[:, :, strip] = _directions_last(self.solved[body].raw_column(strip))
        for body, matrix in self.discounted.items():
            matrix[:, :, strip] = _directions_last(columns.columns[body].ic)
        for body, deviations in columns.deviations.items():
            self.errors[body].append(columns.errors[body])
            joined = self.deviations[body]
            for name, deviation in deviations.items():
                joined[name] = joined[name].joined(deviation) if name in joined else deviation

    def results(self, start: float) -> MatrixResults:
        """Return the results after the last strip; `start` is when their computation began [s]."""
        scene = self.scene
        whole = {f"{body}, raw": ics for body, ics in self.raw.items()}
        whole |= {f"{body}, discounted": ics for body, ics in self.discounted.items()}
        with one_blas_thread():
            eigenvalues = {name: _relative_smallest_eigenvalue(ics) for name, ics in whole.items()}
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


def _variants(scene: Scene, body: str) -> list[str]:
    """Return the variants that can be computed for a body, or for both."""
    return [variant for variant in scene.variants if body in scene.fitted or not needs_effective(variant)]


def file_size(scene: Scene) -> int:
    """Return the size of the NetCDF file in bytes, without its header of a few thousand."""
    entry_bytes = sum(np.dtype(kind).itemsize for _, kind, _ in VARIABLES)
    return len(scene.compared) * entry_bytes * int(np.prod(_shape(scene)))


def _shape(scene: Scene) -> tuple[int, int, int, int, int]:
    grid = scene.grid
    return grid.n_x, grid.n_s, grid.n_s, 3, 3


def _directions_last(column: Array) -> Array:
    """Return a column (i, j, lag, observing strip) as (lag, observing strip, i, j)."""
    return np.moveaxis(column, (0, 1), (2, 3))


def _relative_smallest_eigenvalue(ics: Array) -> float:
    """Return the smallest eigenvalue of a matrix over the least IC xx, ss, nn of an element on itself."""
    own_ic = np.min(np.diagonal(ics[0], axis1=0, axis2=1).diagonal(axis1=0, axis2=1))
    return GridOperator.of(ics).smallest_eigenvalue() / float(own_ic)


def _write_coordinates(scene: Scene, matrix_references: Mapping[str, MatrixReference], path: Path) -> None:
    """Write the file without its matrices: coordinates and M."""
    grid, mm = scene.grid, {"units": "mm"}
    xr.Dataset(
        {
            "discount": (
                ("solved", "moved", "force"),
                np.stack([reference.discount for reference in matrix_references.values()]),
            )
        },
        coords={
            "lag": ("lag", grid.lags, mm),
            "observed": ("observed", grid.strips, mm),
            "loaded": ("loaded", grid.strips, mm),
            "body": list(scene.compared),
            "solved": list(matrix_references),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
            "moved": list(AXES),
            "force": list(AXES),
        },
    ).to_netcdf(path, engine="h5netcdf")


def _create_variables(file: h5netcdf.File, scene: Scene) -> None:
    """Create the variables of the matrices, chunked by loaded strip."""
    grid = scene.grid
    for name, kind, meaning in VARIABLES:
        variable = file.create_variable(
            name, DIMENSIONS, kind, chunks=(1, grid.n_x, grid.n_s, 1, 3, 3), fletcher32=True
        )
        variable.attrs.update({"units": "mm/MPa", "long_name": meaning})


def _attributes(results: MatrixResults) -> dict[str, str | float]:
    scene = results.scene
    models = {name: asdict(cost) for name, cost in models_of(results.matrices).items()}
    return {
        "title": f"IC matrix: {scene.title}",
        "meaning": "displacement at an observing strip, direction i, at a lag along x, per unit traction on "
        "an element of a loaded strip, direction j, after the discount; lags < 0: xs, xn, sx, nx change sign",
        "scene": scene.text,
        "dx": scene.grid.dx,
        "ds": scene.grid.ds,
        "tolerance": scene.settings.tolerance,
        "discounted": scene.discount,
        "far_radius": far_radius(scene.contact_problem, scene.grid),
        "estimated_error": json.dumps({name: asdict(shares) for name, shares in results.errors.items()}),
        "reciprocity_defect": json.dumps(
            {name: asdict(defect) for name, defect in results.reciprocity.items()}
        ),
        "smallest_eigenvalue": json.dumps(dict(results.eigenvalues)),
        "models": json.dumps(models),
        "seconds": results.seconds,
        "peak_memory": results.memory,
        "code": results_digest(__name__),
        "versions": json.dumps(versions()),
    }
