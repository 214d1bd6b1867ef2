"""Compute the IC matrices of a scene and write them strip by strip."""

from pathlib import Path
from time import perf_counter

import numpy as np

from compare.matrix.file import MatrixFile
from compare.matrix.jobs import SOURCE, matrix_jobs
from compare.matrix.results import MatrixResults, matrix_shape
from femic.cache.files import replacing
from femic.reference.matrix.reference import matrices
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene

FIRST_SECONDS, SECONDS_PER_ENTRY = 1.5, 0.4e-6  # of making, checking and writing matrices; by body compared


def compute_matrix(scene: Scene, path: Path, options: RunOptions = DEFAULT) -> MatrixResults:
    """Compute the matrices of a scene and write them to a NetCDF file, one loaded strip at a time.

    Raises BadScene where the grid does not fit, and NotConverged as `femic.reference.at_points.references`.
    """
    start = perf_counter()
    jobs, combined = matrix_jobs(scene, further=(SOURCE,)), "combined" in scene.compared
    with replacing(path) as unfinished, MatrixFile(scene, unfinished, options) as file:
        matrices(jobs, options, combined=combined, consumer=file)
        return file.finished(start)


def expected_seconds(scene: Scene) -> float:
    """Return the seconds expected for making, checking and writing the matrices from solved models.

    The law was fitted on one machine of 2 cores (docs/how-to/matrix.md).
    """
    return FIRST_SECONDS + SECONDS_PER_ENTRY * len(scene.compared) * int(np.prod(matrix_shape(scene)))
