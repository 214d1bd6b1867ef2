"""The file of the IC matrices of a scene."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import h5netcdf
import numpy as np
import xarray as xr

from compare.ics.compute import models_of
from compare.matrix.results import Accumulator, MatrixResults, Strip, directions_last, matrix_shape
from femic.cache.digests import results_digest, versions
from femic.contact.pairs.c_jobs import domain_on
from femic.reference.discount import AXES
from femic.reference.estimate import EstimatedICs
from femic.reference.matrix.reference import MatrixReference
from femic.reference.run_options import RunOptions
from femic.scenes.scene import Scene
from geometries.patches import DIRECTIONS

DIMENSIONS = ("body", "lag", "observed", "loaded", "i", "j")
VARIABLES = (("ic", "f8", "C after the discount"), ("estimate", "f4", "estimated error of C"))


class MatrixFile:
    """The file of the matrices of a scene, written strip by strip while their accuracy is assessed."""

    def __init__(self, scene: Scene, path: Path, options: RunOptions) -> None:
        """Take what the file is for; `begin` opens it."""
        self._scene, self._path, self._options = scene, path, options
        self._begun: tuple[Accumulator, h5netcdf.File] | None = None

    def __enter__(self) -> "MatrixFile":
        """Return this file."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.discard()

    def begin(self, references: Mapping[str, MatrixReference]) -> None:
        """Write the coordinates, and prepare the variables of the matrices."""
        self._options.watch.on_stage("  checking, writing")
        _write_coordinates(self._scene, references, self._path)
        file = h5netcdf.File(self._path, "a")
        self._begun = Accumulator.of(self._scene, references), file
        _create_variables(file, self._scene)

    def made(self, strip: int, columns: Mapping[str, EstimatedICs]) -> Strip:
        """Return what the columns of the solved bodies give."""
        accumulator, _ = self._opened
        return Strip.of(self._scene, accumulator.solved, strip, columns)

    def add(self, made: Strip) -> None:
        """Write the columns of a strip, and add them to the results."""
        accumulator, file = self._opened
        accumulator.add(made)
        for b, c in enumerate(made.columns.values()):
            for name, ics in (("ic", c.ic), ("estimate", c.estimate)):
                file[name][b, :, :, made.strip] = self._scene.grid.area * directions_last(ics)

    def finished(self, start: float) -> MatrixResults:
        """Return the results, written to the file, which is read back; `start` is when the run began [s]."""
        accumulator, file = self._opened
        results = accumulator.results(start, self._options.workers)
        file.attrs.update(_attributes(results))
        self.discard()
        _require_readable(self._path)
        return results

    def discard(self) -> None:
        """Close the file, and drop what has been accumulated."""
        if self._begun is not None:
            self._begun[1].close()
        self._begun = None

    @property
    def _opened(self) -> tuple[Accumulator, h5netcdf.File]:
        assert self._begun is not None  # as `begin` has made sure
        return self._begun


def file_size(scene: Scene) -> int:
    """Return the size of the NetCDF file in bytes, without its header of a few thousand."""
    entry_bytes = sum(np.dtype(kind).itemsize for _, kind, _ in VARIABLES)
    return len(scene.compared) * entry_bytes * int(np.prod(matrix_shape(scene)))


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
        "far_radius": domain_on(scene.contact_problem, scene.grid).far_radius,
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


def _require_readable(path: Path) -> None:
    """Read all matrices of a file, so that HDF5 compares the checksums of all pieces (OSError)."""
    with h5netcdf.File(path, "r") as file:
        for name, _, _ in VARIABLES:
            for strip in range(file[name].shape[3]):
                file[name][:, :, :, strip]
