"""Predicts the unknowns, seconds and memory of models."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from femic.reference.engine import Engine
from femic.reference.job import Job
from femic.reference.level import Level, factors
from femic.reference.matrix.job import MatrixJob
from femic.reference.models import Planned


@dataclass(frozen=True)
class Step:
    """A model of a plan: its name, engine, size, and what it will take."""

    name: str
    engine: Engine
    cells: float  # their size over that of the scene's first cells
    far_radius: float  # mm
    along_x: str  # extent of the model along x, in words
    takes: Planned


def steps_of(
    jobs_of_bodies: Mapping[str, Job] | Mapping[str, MatrixJob], workers: int, prefix: str = ""
) -> Iterator[Step]:
    """The models of jobs that are solved in the first round; `prefix` comes before their names."""
    for name, job in jobs_of_bodies.items():
        engine = job.settings.engine
        for model, level in Level().models(engine.estimate.models).items():
            request = job.request(level)
            body, takes = request.body, engine.models.planned(request, workers)
            length_along_x = "endless" if np.isinf(body.xi_end) else f"{body.xi_end:.4g} mm"
            yield Step(
                f"{prefix}{name}, {model}",
                engine,
                factors(level)[0],
                body.domain.far_radius,
                "all round" if body.closed else length_along_x,
                takes,
            )


def seconds(steps: list[Step], workers: int) -> float:
    """Seconds that all steps will take.

    Engines that share a model among workers solve models one by one, others solve them side by side.
    """
    return sum(step.takes.seconds / (1 if step.engine.shares_a_model else workers) for step in steps)
