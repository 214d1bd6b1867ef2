"""The IC matrix of a scene: computed, checked, written strip by strip."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter

import h5netcdf
import numpy as np
import xarray as xr

from approx.matrix import column
from compare.results.compute import parts_of, solids
from compare.results.matrix.deviation import Column, Deviation
from compare.results.matrix.reciprocity import Reciprocity, reciprocity
from compare.results.provenance import results_digest
from compare.scenes.checks import grid_misfits
from compare.scenes.errors import require_none
from compare.scenes.scene import Scene
from contact.grid_operator import GridOperator
from femic.accuracy import Shares
from femic.discount import AXES
from femic.estimate import Estimated, total
from femic.harmonic.record import HARMONIC
from femic.matrix.columns import column_scale, column_shares, half_spaces_nn, is_far, worst_of
from femic.matrix.job import MatrixJob, far_radius_for
from femic.matrix.reference import MatrixReference, matrices
from femic.means import DEFAULT, Means
from femic.models import peak_memory
from femic.work.provenance import versions
from geometries.arrays import Array
from geometries.bodies import Domain
from geometries.patches import DIRECTIONS

DIMENSIONS = ("body", "lag", "observed", "loaded", "i", "j")
LARGEST = 12_000_000  # entries of a matrix that is held as a whole, for reciprocity and eigenvalues
VARIABLES = (("ic", "f8", "C after the discount"), ("estimate", "f4", "estimated error of C"))


@dataclass(frozen=True, eq=False)
class MatrixResults:
    """The matrices of a scene's bodies, and what they keep of what elasticity demands."""

    scene: Scene
    found: Mapping[str, MatrixReference]
    errors: Mapping[str, Shares]  # estimated, at worst, of each body compared
    reciprocity: Mapping[str, Reciprocity]  # defect of the raw matrices
    eigenvalues: Mapping[str, float]  # smallest, of the symmetric part, over the element's own ICs
    approximations: Mapping[tuple[str, str], Deviation]  # by (variant, body)
    known: Mapping[str, Deviation]  # by body: what C's own estimate allows
    seconds: float
    memory: float  # MB, of the process at its peak

    def column(self, body: str, strip: int) -> Estimated:
        """C of a body, or of both, due to unit loads on a strip [mm/N], arrays (3, 3, n_x, n_s)."""
        return total([self.found[name].column(strip) for name in parts_of(body)])


def matrix_jobs(scene: Scene) -> dict[str, MatrixJob]:
    """The jobs of the bodies that the comparison needs; raises BadScene where the grid does not fit."""
    require_none(scene.name, grid_misfits(scene))
    least = far_radius_for(scene.settings.tolerance, scene.grid)
    settings = replace(scene.settings, engine=HARMONIC, cells=None)
    return {
        name: MatrixJob(
            replace(body, domain=Domain(max(least, body.domain.far_radius), np.inf)), scene.grid, settings
        )
        for name, body in scene.bodies.items()
        if name in scene.solved
    }


def compute_matrix(scene: Scene, path: Path, means: Means = DEFAULT) -> MatrixResults:
    """Compute the matrices of a scene and write them to a NetCDF file; one loaded strip at a time.

    Raises BadScene for a grid that does not fit, NotConverged as `femic.at_points.references`.
    """
    start = perf_counter()
    jobs, combined = matrix_jobs(scene), "combined" in scene.compared
    found = matrices(jobs, means, combined=combined)
    means.watch.on_stage("  writing, checking")
    collected = _Collected.of(scene, jobs)
    temporary = path.with_suffix(".part")
    _skeleton(scene, found, temporary)
    with h5netcdf.File(temporary, "a") as file:
        _variables(file, scene)
        for strip in range(scene.grid.n_s):
            of_body = {name: reference.column(strip) for name, reference in found.items()}
            compared = {name: total([of_body[part] for part in parts_of(name)]) for name in scene.compared}
            for b, c in enumerate(compared.values()):
                file["ic"][b, :, :, strip] = scene.grid.area * _last(c.ic)
                file["estimate"][b, :, :, strip] = scene.grid.area * _last(c.estimate)
            collected.add(strip, compared, {name: one.raw_column(strip) for name, one in found.items()})
    results = MatrixResults(
        scene,
        found,
        {name: worst_of(of_strips) for name, of_strips in collected.errors.items()},
        {name: reciprocity(ics, jobs[name].body.contour, scene.grid) for name, ics in collected.raw.items()},
        collected.eigenvalues(),
        collected.deviations,
        collected.known,
        perf_counter() - start,
        peak_memory(),
    )
    with h5netcdf.File(temporary, "a") as file:
        file.attrs.update(_attributes(results))
    temporary.replace(path)
    return results


@dataclass(eq=False)
class _Collected:
    """What the columns say, gathered loaded strip by loaded strip; whole matrices only up to `LARGEST`."""

    scene: Scene
    jobs: Mapping[str, MatrixJob]
    raw: dict[str, Array]  # of each solved body, (n_x, n_s, n_s, 3, 3)
    discounted: dict[str, Array]  # of all that is compared
    errors: dict[str, list[Shares]]
    deviations: dict[tuple[str, str], Deviation]
    known: dict[str, Deviation]

    @classmethod
    def of(cls, scene: Scene, jobs: Mapping[str, MatrixJob]) -> "_Collected":
        """Nothing yet."""
        shape, pair = _shape(scene), scene.pair
        whole = int(np.prod(shape)) <= LARGEST
        return cls(
            scene,
            jobs,
            {name: np.empty(shape) for name in jobs if whole},
            {name: np.empty(shape) for name in scene.compared if whole},
            {name: [] for name in scene.compared},
            {
                (variant, name): Deviation.none(scene.grid.n_s)
                for variant in scene.variants
                for name in scene.compared
                if variant != "Bhat_prime" or pair.has_effective(name)
            },
            {name: Deviation.none(scene.grid.n_s) for name in scene.compared},
        )

    def add(self, strip: int, compared: Mapping[str, Estimated], raw: Mapping[str, Array]) -> None:
        """The columns of one more strip."""
        grid = self.scene.grid
        for name, whole in self.raw.items():
            whole[:, :, strip] = _last(raw[name])
        for name, whole in self.discounted.items():
            whole[:, :, strip] = _last(compared[name].ic)
        columns = {}
        for name, c in compared.items():
            jobs = [self.jobs[part] for part in parts_of(name)]
            self.errors[name].append(column_shares(strip, c, column_scale(strip, c.ic, jobs)))
            columns[name] = Column(c, is_far(strip, grid), half_spaces_nn(strip, jobs))
            self.known[name] = self.known[name].with_column(c.estimate, columns[name])
        for (variant, name), deviation in self.deviations.items():
            other = column(variant, solids(self.scene)[name], grid, strip) / grid.area
            self.deviations[variant, name] = deviation.with_column(other - compared[name].ic, columns[name])

    def eigenvalues(self) -> dict[str, float]:
        """Smallest of each matrix."""
        of_all = {f"{name}, raw": ics for name, ics in self.raw.items()}
        of_all |= {f"{name}, discounted": ics for name, ics in self.discounted.items()}
        return {name: _definite(ics) for name, ics in of_all.items()}


def file_size(scene: Scene) -> int:
    """Bytes of the NetCDF file, but for a few thousand."""
    each = sum(np.dtype(kind).itemsize for _, kind, _ in VARIABLES)
    return len(scene.compared) * each * int(np.prod(_shape(scene)))


def _shape(scene: Scene) -> tuple[int, int, int, int, int]:
    grid = scene.grid
    return grid.n_x, grid.n_s, grid.n_s, 3, 3


def _last(column: Array) -> Array:
    """(i, j, lag, observer) as (lag, observer, i, j)."""
    return np.moveaxis(column, (0, 1), (2, 3))


def _definite(ics: Array) -> float:
    """Smallest eigenvalue over the element's own ICs in its directions, the least of them."""
    own = np.min(np.diagonal(ics[0], axis1=0, axis2=1).diagonal(axis1=0, axis2=1))
    return GridOperator.of(ics).smallest_eigenvalue() / float(own)


def _skeleton(scene: Scene, found: Mapping[str, MatrixReference], path: Path) -> None:
    """The file without its matrices: coordinates and M."""
    grid, mm = scene.grid, {"units": "mm"}
    xr.Dataset(
        {"discount": (("solved", "moved", "force"), np.stack([one.discount for one in found.values()]))},
        coords={
            "lag": ("lag", grid.lags, mm),
            "observed": ("observed", grid.strips, mm),
            "loaded": ("loaded", grid.strips, mm),
            "body": list(scene.compared),
            "solved": list(found),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
            "moved": list(AXES),
            "force": list(AXES),
        },
    ).to_netcdf(path, engine="h5netcdf")


def _variables(file: h5netcdf.File, scene: Scene) -> None:
    """Room for the matrices, loaded strip by loaded strip."""
    grid = scene.grid
    for name, kind, meaning in VARIABLES:
        variable = file.create_variable(name, DIMENSIONS, kind, chunks=(1, grid.n_x, grid.n_s, 1, 3, 3))
        variable.attrs.update({"units": "mm/MPa", "long_name": meaning})


def _attributes(results: MatrixResults) -> dict[str, str | float]:
    scene = results.scene
    models = {
        f"{name}, {model}": asdict(cost)
        for name, found in results.found.items()
        for model, cost in found.models.items()
    }
    return {
        "title": f"IC matrix: {scene.title}",
        "meaning": "displacement at an observing strip, direction i, at a lag along x, per unit traction on "
        "an element of a loaded strip, direction j, after the discount; lags < 0: xs, xn, sx, nx change sign",
        "scene": scene.text,
        "dx": scene.grid.dx,
        "ds": scene.grid.ds,
        "tolerance": scene.settings.tolerance,
        "estimated_error": json.dumps({name: asdict(shares) for name, shares in results.errors.items()}),
        "reciprocity_defect": json.dumps({name: asdict(one) for name, one in results.reciprocity.items()}),
        "smallest_eigenvalue": json.dumps(dict(results.eigenvalues)),
        "models": json.dumps(models),
        "seconds": results.seconds,
        "peak_memory": results.memory,
        "code": results_digest(),
        "versions": json.dumps(versions()),
    }
