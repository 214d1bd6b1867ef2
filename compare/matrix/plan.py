"""The models that `femic matrix` solves."""

from compare.matrix.compute import COMPARED, matrix_jobs
from compare.plan.models import Step, steps_of
from femic.scenes.scene import Scene


def matrix_steps(scene: Scene, workers: int) -> list[Step]:
    """The models that `femic matrix` solves in its first round; raises BadScene as `matrix_jobs` does."""
    return list(steps_of(matrix_jobs(scene, further=COMPARED), workers))
