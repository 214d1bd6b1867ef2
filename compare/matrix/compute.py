"""Compute the IC matrix of a scene and write it strip by strip."""

import json
from collections.abc import Mapping
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
COMPARED = (SOURCE,)
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
    approximations: Mapping[tuple[str, str], Deviation]  # from C after the source's discount
    c_deviations: Mapping[str, Deviation]  # estimated errors of C itself, by body
    seconds: float
    memory: float  # peak of the process [MB]

    def deviations(self, body: str) -> dict[str, Deviation]:
        """Return the deviations of the approximations of a body, or of both, by variant."""
        return {
            variant: deviation for (variant, name), deviation in self.approximations.items() if name == body
        }

    def column(self, body: str, strip: int) -> EstimatedICs:
        """Return C of a body, or of both, due to unit loads on a strip, arrays (3, 3, n_x, n_s) [mm/N]."""
        if body in self.matrices:
            return self.matrices[body].column(strip)
        return pair_column(self.matrices, self.scene.bodies["lower"].contour, strip)


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
    return list(plans(matrix_jobs(scene, further=COMPARED), workers))


def require_matrices(scene: Scene) -> None:
    """Raise BadScene for a grid that does not fit, and for an engine without IC matrices."""
    require_none(scene.name, [*grid_misfits(scene), *matrix_engine_misfits(scene)])


def discounted(scene: Scene) -> str:
    """Return a sentence on the rigid part that is subtracted from C, and on the supports of the bodies."""
    return f"{DISCOUNTS[scene.discount]} {_supports(scene)}"


def _supports(scene: Scene) -> str:
    """Return a sentence on the supports of the bodies of IC matrices and contact."""
    hubs = [name for name, body in scene.bodies.items() if np.isfinite(body.rolling_radius)]
    at_hub = f", and the {' and '.join(hubs)} body also at its hub" if hubs else ""
    radius = far_radius(scene.contact_problem, scene.grid)
    return f"The sections are clamped at a far arc of {radius:g} mm{at_hub}."


def compute_matrix(scene: Scene, path: Path, options: RunOptions = DEFAULT) -> MatrixResults:
    """Compute the matrices of a scene and write them to a NetCDF file, one loaded strip at a time.

    Raises BadScene where the grid does not fit, and NotConverged as `femic.reference.at_points.references`.
    """
    start = perf_counter()
    jobs, combined = matrix_jobs(scene, further=COMPARED), "combined" in scene.compared
    matrix_references = matrices(jobs, options, combined=combined)
    options.watch.on_stage("  writing, checking")
    accumulator = _Accumulator.of(scene, jobs)
    with replacing(path) as unfinished:
        _write_coordinates(scene, matrix_references, unfinished)
        with h5netcdf.File(unfinished, "a") as file:
            _create_variables(file, scene)
            for strip in range(scene.grid.n_s):
                _add_column(file, accumulator, strip, matrix_references)
        results = MatrixResults(
            scene,
            matrix_references,
            {name: worst_of(strip_errors) for name, strip_errors in accumulator.errors.items()},
            {
                name: reciprocity(ics, jobs[name].body.contour, scene.grid)
                for name, ics in accumulator.raw.items()
            },
            accumulator.eigenvalues(),
            accumulator.deviations,
            accumulator.c_deviations,
            perf_counter() - start,
            peak_memory(),
        )
        with h5netcdf.File(unfinished, "a") as file:
            file.attrs.update(_attributes(results))
        _require_readable(unfinished)
    return results


def _add_column(
    file: h5netcdf.File,
    accumulator: "_Accumulator",
    strip: int,
    matrix_references: Mapping[str, MatrixReference],
) -> None:
    """Write the column of a loaded strip, and accumulate the results that depend on it."""
    scene = accumulator.scene
    columns = {name: reference.column(strip) for name, reference in matrix_references.items()}
    contour = scene.bodies["lower"].contour
    compared_columns = {
        name: columns[name] if name in columns else pair_column(matrix_references, contour, strip)
        for name in scene.compared
    }
    like_half_spaces = {
        name: total([matrix_references[part].column(strip, SOURCE) for part in parts_of(name)])
        for name in scene.compared
    }
    for b, c in enumerate(compared_columns.values()):
        file["ic"][b, :, :, strip] = scene.grid.area * _directions_last(c.ic)
        file["estimate"][b, :, :, strip] = scene.grid.area * _directions_last(c.estimate)
    accumulator.add(
        strip,
        compared_columns,
        like_half_spaces,
        {name: reference.raw_column(strip) for name, reference in matrix_references.items()},
    )


def _require_readable(path: Path) -> None:
    """Read all matrices of a file, so that HDF5 compares the checksums of all pieces (OSError)."""
    with h5netcdf.File(path, "r") as file:
        for name, _, _ in VARIABLES:
            for strip in range(file[name].shape[3]):
                file[name][:, :, :, strip]


@dataclass(eq=False)
class _Accumulator:
    """Results that accumulate over the columns, loaded strip by loaded strip.

    Whole matrices are held only up to `LARGEST_WHOLE_MATRIX` entries, in single precision, which changes the
    defects of reciprocity and the eigenvalues by 1e-7 of the largest IC.
    """

    scene: Scene
    jobs: Mapping[str, MatrixJob]
    raw: dict[str, Array]  # matrices before the discount by solved body, (n_x, n_s, n_s, 3, 3) [mm/N]
    discounted: dict[str, Array]  # matrices after the discount by body compared, likewise
    errors: dict[str, list[Shares]]  # estimated errors of each column by body compared
    deviations: dict[tuple[str, str], Deviation]  # by (variant, body)
    c_deviations: dict[str, Deviation]  # estimated errors of C itself, by body

    @classmethod
    def of(cls, scene: Scene, jobs: Mapping[str, MatrixJob]) -> "_Accumulator":
        """Return the state before the first strip."""
        shape = _shape(scene)
        held_whole = int(np.prod(shape)) <= LARGEST_WHOLE_MATRIX
        return cls(
            scene,
            jobs,
            {name: np.empty(shape, np.float32) for name in jobs if held_whole},
            {name: np.empty(shape, np.float32) for name in scene.compared if held_whole},
            {name: [] for name in scene.compared},
            {
                (variant, name): Deviation.none(scene.grid.n_s)
                for variant in scene.variants
                for name in scene.compared
                if name in scene.fitted or not needs_effective(variant)
            },
            {name: Deviation.none(scene.grid.n_s) for name in scene.compared},
        )

    def add(
        self,
        strip: int,
        compared: Mapping[str, EstimatedICs],
        like_half_spaces: Mapping[str, EstimatedICs],
        raw: Mapping[str, Array],
    ) -> None:
        """Add the columns of one more loaded strip: C, C after the source's discount, and before any."""
        grid = self.scene.grid
        for name, matrix in self.raw.items():
            matrix[:, :, strip] = _directions_last(raw[name])
        for name, matrix in self.discounted.items():
            matrix[:, :, strip] = _directions_last(compared[name].ic)
        for name, c in compared.items():
            jobs = [self.jobs[part] for part in parts_of(name)]
            self.errors[name].append(column_shares(strip, c, column_scale(strip, c.ic, jobs)))
        for name, c in like_half_spaces.items():
            jobs = [self.jobs[part] for part in parts_of(name)]
            column = ReferenceColumn(c, is_far(strip, grid), half_spaces_nn(strip, jobs))
            self.c_deviations[name] = self.c_deviations[name].with_column(c.estimate, column)
            variants = [variant for variant, compared_name in self.deviations if compared_name == name]
            approximated = approximations(variants, solids(self.scene)[name], grid, strip)
            for variant, ics in approximated.items():
                self.deviations[variant, name] = self.deviations[variant, name].with_column(
                    ics / grid.area - c.ic, column
                )

    def eigenvalues(self) -> dict[str, float]:
        """Return the smallest eigenvalue of each matrix over the ICs of an element on itself."""
        matrices_by_name = {f"{name}, raw": ics for name, ics in self.raw.items()}
        matrices_by_name |= {f"{name}, discounted": ics for name, ics in self.discounted.items()}
        return {name: _relative_smallest_eigenvalue(ics) for name, ics in matrices_by_name.items()}


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
