"""Plans of models: their expected unknowns, seconds and memory."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from femic.reference.engine import Engine, ExpectedCost
from femic.reference.job import Job
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import Level, factors


@dataclass(frozen=True)
class ModelPlan:
    """A model before it is solved: its name, engine, size, and expected cost."""

    name: str
    engine: Engine
    cells: float  # their size over the size of the scene's first cells
    far_radius: float  # mm
    along_x: str  # extent of the model along x, in words
    expected: ExpectedCost


def plans(
    jobs: Mapping[str, Job] | Mapping[str, MatrixJob], workers: int, prefix: str = ""
) -> Iterator[ModelPlan]:
    """Yield the plans of the models of the first round; `prefix` comes before their names."""
    for name, job in jobs.items():
        engine = job.settings.engine
        for model, level in Level().models(engine.estimate.model_names(job.body)).items():
            request = job.request(level)
            body, expected = request.body, engine.models.expected_cost(request, workers)
            length_along_x = "infinite" if np.isinf(body.xi_end) else f"{body.xi_end:.4g} mm"
            yield ModelPlan(
                f"{prefix}{name}, {model}",
                engine,
                factors(level)[0],
                body.domain.far_radius,
                "full circle" if body.closed else length_along_x,
                expected,
            )


def total_seconds(model_plans: list[ModelPlan], workers: int) -> float:
    """Return the expected seconds of all models.

    Engines that share a model among workers solve models one by one, others solve them side by side.
    """
    return sum(plan.expected.seconds / (1 if plan.engine.shares_a_model else workers) for plan in model_plans)
