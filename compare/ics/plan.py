"""The models that `femic run` solves."""

from compare.ics.compute import jobs
from compare.plan.models import Step, steps_of
from femic.scenes.scene import Scene


def run_steps(scene: Scene, workers: int) -> list[Step]:
    """The models that `femic run` solves in its first round."""
    steps = list(steps_of(jobs(scene), workers))
    return steps + (list(steps_of(jobs(scene.check), workers, "check, ")) if scene.check else [])
