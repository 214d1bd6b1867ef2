"""`femic matrix` computes the IC matrices of a scene and writes them to a file strip by strip."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter

import h5netcdf
import numpy as np
import xarray as xr

from approx.pair import columns as approximations
from approx.variants import needs_effective
from femic.cache.digests import results_digest, versions
from femic.cache.files import netcdf, replacing
from femic.cache.workers import one_blas_thread
from femic.contact.operators.dense import reciprocity, smallest_eigenvalues
from femic.contact.pairs.ics import domain_on
from femic.ic_errors.matrix_deviation import Deviation, ReferenceColumn
from femic.reference.discount import AXES
from femic.reference.engine import peak_memory
from femic.reference.job import Shares
from femic.reference.matrix.job import Discount, MatrixJob
from femic.reference.matrix.reference import (
    MatrixReference,
    column_scale,
    column_shares,
    half_spaces_nn,
    is_far,
    matrices,
    pair_column,
)
from femic.reference.refinement import ModelPlan, plans, worst_shares
from femic.reference.result import EstimatedICs, total
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.ics import costs_by_model, solids, solved_parts
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import require_none
from femic.scenes.lines import grid_misfits
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.patches import COMPONENTS, DIRECTIONS

# --- jobs, and what is subtracted from C ----------------------------------------------------------------


SOURCE: Discount = "source"  # the discount after which C is compared with ICs of half-spaces
DISCOUNTS = {
    "approach": "Only the rigid part of the normal approach is subtracted from C. The rest is the "
    "response of the bodies on their supports.",
    "source": "All motions that [BVSV] discounts are subtracted from C, including the bending of the "
    "sections.",
    "none": "Nothing is subtracted from C.",
}


def matrix_jobs(
    scene: Scene, components: tuple[str, ...] = COMPONENTS, further: tuple[Discount, ...] = ()
) -> dict[str, MatrixJob]:
    """Return the jobs of the bodies that the comparison needs; raises BadScene as `require_matrices`.

    Contact needs only some `components`; the matrix of a scene has all nine. C is computed after the discount
    of the scene; the same models can give it after `further` discounts.
    """
    require_matrices(scene)
    domain = domain_on(scene.contact_problem, scene.grid)
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
        return f"{DISCOUNTS[scene.discount]} The outlines define where the sections are clamped."
    hubs = [
        name
        for name, body in scene.bodies.items()
        if np.isfinite(body.rolling_radius) and body.outline is None
    ]
    at_hub = f", and the {' and '.join(hubs)} body also at its hub" if hubs else ""
    radius = domain_on(scene.contact_problem, scene.grid).far_radius
    without = f" without the {given[0]} body, which its outline clamps," if given else ""
    clamped = f"The sections{without} are clamped at a far arc of {radius:g} mm{at_hub}."
    return f"{DISCOUNTS[scene.discount]} {clamped}"


# --- what follows from the columns ----------------------------------------------------------------------


LARGEST_WHOLE_MATRIX = 40_000_000  # entries of a matrix held as a whole, for reciprocity and eigenvalues


def combined_columns(
    scene: Scene,
    solved: Mapping[str, MatrixReference],
    strip: int,
    known: Mapping[str, EstimatedICs] | None = None,
) -> dict[str, EstimatedICs]:
    """Return C of each body compared due to unit loads on a strip, arrays (3, 3, n_x, n_s) [mm/N].

    `known` are those of the solved bodies, where they are at hand.
    """
    columns = dict(known or {body: reference.column(strip) for body, reference in solved.items()})
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


def matrix_shape(scene: Scene) -> tuple[int, int, int, int, int]:
    """Return the shape of the matrix of a body: lags, observing strips, loaded strips, i, j."""
    grid = scene.grid
    return grid.n_x, grid.n_s, grid.n_s, 3, 3


# --- the file -------------------------------------------------------------------------------------------


DIMENSIONS = ("body", "lag", "observed", "loaded", "i", "j")
DIRECTIONS_LAST = 2, 3, 0, 1  # of a column (i, j, lag, observing strip)
VARIABLES = (("ic", "f8", "C after the discount"), ("estimate", "f4", "estimated error of C"))
DEVIATIONS = {  # from C after the source's discount, of C its estimate: of `Deviation`, and meaning
    "displacement_error": (
        "own_displacement_error",
        "error of displacements, relative to the displacements of the component",
    ),
    "displacement_weight": (
        "displacement_error",
        "the same, relative to displacements under normal tractions",
    ),
    "displacement_vanishes": (
        "negligible",
        "1: the displacement that C causes vanishes or is smaller than ten times its estimated error; "
        "displacement_error is then relative to 5 % of that under normal tractions",
    ),
    "entry_error": (
        "worst",
        "error of entries far from the load, relative to the largest entry of the component there",
    ),
    "near_entry_error": ("near", "error of entries near the load, relative to A_nn there"),
    "entry_vanishes": (
        "vanishing",
        "1: C vanishes far from the load; errors are relative to 0.05 max |C_nn|",
    ),
}


class MatrixFile:
    """The file of the matrices of a scene, written strip by strip while their accuracy is assessed.

    Whole matrices are held only up to `LARGEST_WHOLE_MATRIX` entries, in single precision, which changes the
    defects of reciprocity and the eigenvalues by 1e-7 of the largest IC.
    """

    def __init__(self, scene: Scene, path: Path, options: RunOptions) -> None:
        """Take what the file is for; `begin` opens it."""
        self._scene, self._path, self._options = scene, path, options
        self._file: h5netcdf.File | None = None
        self._solved: Mapping[str, MatrixReference] = {}

    def __enter__(self) -> "MatrixFile":
        """Return this file."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.discard()

    def begin(self, references: Mapping[str, MatrixReference]) -> None:
        """Write the coordinates and M, and prepare the variables, chunked by loaded strip."""
        self._options.watch.on_stage("  checking, writing")
        scene, grid, mm = self._scene, self._scene.grid, {"units": "mm"}
        moments = np.stack([reference.discount for reference in references.values()])
        variants = [*scene.variants, "C"]
        unknown = np.full((len(scene.compared), len(variants), 3, 3), np.nan)
        empty = xr.Dataset(
            {"discount": (("solved", "moved", "force"), moments)}
            | {
                name: (("body", "variant", "i", "j"), unknown, {"units": "1", "long_name": meaning})
                for name, (_, meaning) in DEVIATIONS.items()
            },
            coords={
                "variant": variants,
                "lag": ("lag", grid.lags, mm),
                "observed": ("observed", grid.strips, mm),
                "loaded": ("loaded", grid.strips, mm),
                "body": list(scene.compared),
                "solved": list(references),
                "i": list(DIRECTIONS),
                "j": list(DIRECTIONS),
                "moved": list(AXES),
                "force": list(AXES),
            },
        )
        self._path.write_bytes(netcdf(empty))
        self._file, self._solved = h5netcdf.File(self._path, "a"), references
        for name, kind, meaning in VARIABLES:
            variable = self._file.create_variable(
                name, DIMENSIONS, kind, chunks=(1, grid.n_x, grid.n_s, 1, 3, 3), fletcher32=True
            )
            variable.attrs.update({"units": "mm/MPa", "long_name": meaning})
        shape = matrix_shape(scene)
        held_whole = int(np.prod(shape)) <= LARGEST_WHOLE_MATRIX
        self._raw: dict[str, Array] = {body: np.empty(shape, np.float32) for body in references if held_whole}
        self._discounted: dict[str, Array] = {
            body: np.empty(shape, np.float32) for body in scene.compared if held_whole
        }
        self._errors: dict[str, list[Shares]] = {body: [] for body in scene.compared}
        self._deviations: dict[str, dict[str, Deviation]] = {body: {} for body in scene.compared}

    def made(self, strip: int, columns: Mapping[str, EstimatedICs]) -> Strip:
        """Return what follows from the columns of the solved bodies under loads on a strip.

        Approximations, which are ICs of half-spaces, are compared with C after the source's discount.
        """
        scene, solved, grid = self._scene, self._solved, self._scene.grid
        by_source = columns
        if scene.discount != SOURCE:
            by_source = {body: reference.column(strip, SOURCE) for body, reference in solved.items()}
        compared = combined_columns(scene, solved, strip, columns)
        errors, deviations = {}, {}
        for body, c in compared.items():
            jobs = [solved[part].job for part in solved_parts(body)]
            errors[body] = column_shares(strip, c, column_scale(strip, c.ic, jobs))
            without_bending = total([by_source[part] for part in solved_parts(body)])
            reference = ReferenceColumn(without_bending, is_far(strip, grid), half_spaces_nn(strip, jobs))
            known = [name for name in scene.variants if body in scene.fitted or not needs_effective(name)]
            approximated = approximations(known, solids(scene)[body], grid, strip)
            differences = {
                name: ics / grid.area - without_bending.ic for name, ics in approximated.items()
            } | {"C": without_bending.estimate}
            deviations[body] = {name: reference.deviation(one) for name, one in differences.items()}
        raw = {body: reference.raw_column(strip) for body, reference in solved.items()}
        return Strip(strip, raw, compared, errors, deviations)

    def add(self, made: Strip) -> None:
        """Write the columns of a strip, and add them to the results."""
        assert self._file is not None  # as `begin` has made sure
        strip = made.strip
        for body, matrix in self._raw.items():
            matrix[:, :, strip] = made.raw[body].transpose(DIRECTIONS_LAST)
        for body, matrix in self._discounted.items():
            matrix[:, :, strip] = made.columns[body].ic.transpose(DIRECTIONS_LAST)
        for b, (body, c) in enumerate(made.columns.items()):
            for name, ics in (("ic", c.ic), ("estimate", c.estimate)):
                self._file[name][b, :, :, strip] = self._scene.grid.area * ics.transpose(DIRECTIONS_LAST)
            self._errors[body].append(made.errors[body])
            joined = self._deviations[body]
            for name, deviation in made.deviations[body].items():
                joined[name] = joined[name].merge(deviation) if name in joined else deviation

    def finish(self, start: float) -> Mapping[str, MatrixReference]:
        """Write what holds for whole matrices; return C of the solved bodies. `start`: of the run [s].

        All matrices are read back, so that HDF5 compares the checksums of all pieces (OSError).
        """
        assert self._file is not None  # as `begin` has made sure
        scene = self._scene
        assert all(len(strips) == scene.grid.n_s for strips in self._errors.values())
        whole = {f"{body}, raw": ics for body, ics in self._raw.items()}
        whole |= {f"{body}, discounted": ics for body, ics in self._discounted.items()}
        with one_blas_thread():
            smallest = smallest_eigenvalues(whole.values(), self._options.workers)
        variants = [*scene.variants, "C"]
        for b, by_variant in enumerate(self._deviations.values()):
            for variant, deviation in by_variant.items():
                for name, (key, _) in DEVIATIONS.items():
                    self._file[name][b, variants.index(variant)] = getattr(deviation, key)
        estimates = {body: asdict(worst_shares(strips)) for body, strips in self._errors.items()}
        defects = {
            body: asdict(reciprocity(ics, scene.bodies[body].contour, scene.grid))
            for body, ics in self._raw.items()
        }
        models = {name: asdict(cost) for name, cost in costs_by_model(self._solved).items()}
        self._file.attrs.update(
            {
                "title": f"Matrix of influence coefficients: {scene.title}",
                "meaning": "displacement at an observing strip, direction i, at a lag along x, per unit "
                "traction on an element of a loaded strip, direction j, after the discount; lags < 0: xs, "
                "xn, sx, nx change sign",
                "scene": scene.text,
                "dx": scene.grid.dx,
                "ds": scene.grid.ds,
                "tolerance": scene.settings.tolerance,
                "discounted": scene.discount,
                "far_radius": domain_on(scene.contact_problem, scene.grid).far_radius,
                "estimated_error": json.dumps(estimates),  # the largest
                "reciprocity_defect": json.dumps(defects),  # of raw matrices
                # of the symmetric part, over the least IC xx, ss, nn of an element on itself
                "smallest_eigenvalue": json.dumps(dict(zip(whole, smallest, strict=True))),
                "models": json.dumps(models),
                "seconds": perf_counter() - start,
                "peak_memory": peak_memory(),  # of this process [MB]
                "code": results_digest(),
                "versions": json.dumps(versions()),
            }
        )
        self.discard()
        with h5netcdf.File(self._path, "r") as file:
            for name, _, _ in VARIABLES:
                for strip in range(file[name].shape[3]):
                    file[name][:, :, :, strip]
        return self._solved

    def discard(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
        self._file = None


def file_size(scene: Scene) -> int:
    """Return the size of the NetCDF file in bytes, without its header of a few thousand."""
    entry_bytes = sum(np.dtype(kind).itemsize for _, kind, _ in VARIABLES)
    return len(scene.compared) * entry_bytes * int(np.prod(matrix_shape(scene)))


# --- the computation ------------------------------------------------------------------------------------


FIRST_SECONDS, SECONDS_PER_ENTRY = 1.5, 0.4e-6  # of making, checking and writing matrices; by body compared


def compute_matrix(scene: Scene, path: Path, options: RunOptions = DEFAULT) -> Mapping[str, MatrixReference]:
    """Compute the matrices of a scene and write them to a NetCDF file, one loaded strip at a time.

    Returns C of the solved bodies, of which every column can be made after each discount. Raises BadScene
    where the grid does not fit, and NotConverged as `femic.reference.refinement.references`.
    """
    start = perf_counter()
    jobs, combined = matrix_jobs(scene, further=(SOURCE,)), "combined" in scene.compared
    with replacing(path) as unfinished, MatrixFile(scene, unfinished, options) as file:
        matrices(jobs, options, combined=combined, consumer=file)
        return file.finish(start)


def expected_seconds(scene: Scene) -> float:
    """Return the seconds expected for making, checking and writing the matrices from solved models.

    The law was fitted on one machine of 2 cores (docs/evidence/performance.md).
    """
    return FIRST_SECONDS + SECONDS_PER_ENTRY * len(scene.compared) * int(np.prod(matrix_shape(scene)))
