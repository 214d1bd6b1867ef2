"""The jobs of the IC matrices of a scene, and what is subtracted from C."""

from dataclasses import replace

import numpy as np

from femic.contact.pairs.c_jobs import domain_on
from femic.reference.matrix.job import Discount, MatrixJob
from femic.reference.plan import ModelPlan, plans
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import require_none
from femic.scenes.grid import grid_misfits
from femic.scenes.scene import Scene
from geometries.patches import COMPONENTS

SOURCE: Discount = "source"  # the discount after which C is compared with ICs of half-spaces
DISCOUNTS = {
    "approach": "The rigid part of the normal approach is subtracted from C; the rest is the response of the "
    "bodies with their supports.",
    "source": "All motions that [BVSV] discounts are subtracted from C, including bending of the sections.",
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
        return f"{DISCOUNTS[scene.discount]} The sections are clamped where their outlines say."
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
