"""ICs of a scene: C, its check with the solid engine, and approximations; their errors and differences.

Errors are shares: of C's components, of max |C_nn|, and on the scale of refinement. `body` is "lower",
"upper", or "combined" for both together.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from timeit import repeat

import numpy as np

from approx.pair import Pair, Solid
from approx.variants import needs_effective
from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.engine import Cost, Points
from femic.reference.job import Job
from femic.reference.matrix.reference import MatrixReference
from femic.reference.refinement import ModelPlan, plans, references
from femic.reference.result import EstimatedICs, Reference, scales, total
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.errors import require_none
from femic.scenes.lines import single_load_misfits
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices
from geometries.patches import N, OffsetLine

# --- the computation ------------------------------------------------------------------------------------


REPETITIONS = 5  # how often an approximation is computed for its timing


@dataclass(frozen=True)
class Results:
    """All ICs of a scene per unit total load [mm/N], shape (3, 3, n_points) each."""

    scene: Scene
    references: Mapping[str, Reference]  # by solved body
    checks: Mapping[str, Reference]  # by solved body, with the solid engine where it is the check, else empty
    approximations: Mapping[tuple[str, str], Array]  # by (variant, body)
    seconds: Mapping[tuple[str, str], float]  # by (variant, body); of C, the sum over its models

    @cached_property
    def points(self) -> Points:
        """The points of all lines."""
        return scene_points(self.scene)[0]

    @cached_property
    def lines(self) -> dict[str, slice]:
        """Which points belong to which line."""
        return scene_points(self.scene)[1]

    @cached_property
    def jobs(self) -> dict[str, Job]:
        """The jobs by solved body."""
        return jobs(self.scene)

    @property
    def variants(self) -> tuple[str, ...]:
        """Names of all ICs: the approximations, C of the check, C."""
        return (*self.scene.variants, *(("C_solid",) if self.checks else ()), "C")

    @property
    def models(self) -> dict[str, Cost]:
        """The cost of every solved model, by body and model."""
        return costs_by_model(self.references) | costs_by_model(self.checks, "solid check, ")


def costs_by_model(
    references: Mapping[str, Reference] | Mapping[str, MatrixReference], prefix: str = ""
) -> dict[str, Cost]:
    """Return the cost of every model of references by body, by "PREFIXBODY, MODEL"."""
    return {
        f"{prefix}{body}, {model}": cost
        for body, reference in references.items()
        for model, cost in reference.models.items()
    }


def solver_seconds(models: Mapping[str, Cost]) -> float:
    """Return the seconds of all stages of models, summed."""
    return sum(sum(cost.seconds.values()) for cost in models.values())


def scene_points(scene: Scene) -> tuple[Points, dict[str, slice]]:
    """Return the points of the scene's lines one after the other, and the part of each line."""
    starts = np.cumsum([0, *(len(line.x) for line in scene.lines)])
    parts = {line.name: slice(*starts[k : k + 2]) for k, line in enumerate(scene.lines)}
    x, s = (np.concatenate([getattr(line, c) for line in scene.lines]) for c in ("x", "s"))
    return Points(x, s), parts


def line_points(results: Results, lines: Iterable[OffsetLine]) -> Indices:
    """Return the indices of the points of lines, (n,)."""
    parts = [results.lines[line.name] for line in lines]
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


def jobs(scene: Scene) -> dict[str, Job]:
    """Return the jobs by body: only the bodies and load directions that the scene needs. Raises BadScene."""
    require_none(scene.name, single_load_misfits(scene))
    points, lines = scene_points(scene)
    return {
        name: Job(scene.bodies[name], scene.patch, scene.components, points, lines, scene.settings)
        for name in scene.solved
    }


def run_plans(scene: Scene, workers: int) -> list[ModelPlan]:
    """Return the plans of the models that `femic run` solves in its first round."""
    checks = plans(jobs(scene.check), workers, "check, ") if scene.check else ()
    return [*plans(jobs(scene), workers), *checks]


def compute(scene: Scene, options: RunOptions = DEFAULT) -> Results:
    """Compute all ICs of a scene.

    Solved models are stored. Raises NotConverged where the estimated error of the compared ICs cannot be
    reduced to the tolerance.
    """
    combined = "combined" in scene.compared
    solved = references(jobs(scene), options, combined=combined)
    checks: dict[str, Reference] = {}
    if scene.check:
        options.watch.on_stage(f"  check with the {scene.check.settings.engine.name} engine")
        checks = references(jobs(scene.check), options, combined=combined)
    approximations, seconds = approximate_all(scene, scene_points(scene)[0])
    for variant, solution in (("C", solved), ("C_solid", checks)):
        if solution:
            per_body = {name: solver_seconds(reference.models) for name, reference in solution.items()}
            summed = per_body | {"combined": sum(per_body.values())}
            seconds |= {(variant, name): value for name, value in summed.items()}
    return Results(scene, solved, checks, approximations, seconds)


def approximate_all(
    scene: Scene, points: Points
) -> tuple[dict[tuple[str, str], Array], dict[tuple[str, str], float]]:
    """Return approximations, (3, 3, n_points) [mm/N], and their seconds, both by (variant, body).

    They are NaN where a variant needs effective properties and the body has none.
    """
    ics, seconds = {}, {}
    for body, variant in product(scene.compared, scene.variants):
        approximate = partial(approximation, scene, variant, body, points)
        ics[variant, body] = approximate()
        missing = np.all(np.isnan(ics[variant, body]))
        seconds[variant, body] = np.nan if missing else min(repeat(approximate, number=1, repeat=REPETITIONS))
    return ics, seconds


def approximation(scene: Scene, variant: str, body: str, points: Points) -> Array:
    """Return an approximation, (3, 3, n_points) [mm/N]; NaN where effective properties are missing."""
    if needs_effective(variant) and body not in scene.fitted:
        return np.full((3, 3, len(points.x)), np.nan)
    ics = solids(scene)[body].approximate(variant, scene.patch, (points.x, points.s))
    return ics / scene.patch.area


def with_approximations(results: Results, scene: Scene) -> Results:
    """Return the results with another scene, which has the same points, and its approximations."""
    approximations, seconds = approximate_all(scene, results.points)
    return replace(
        results, scene=scene, approximations=approximations, seconds={**results.seconds, **seconds}
    )


def solids(scene: Scene) -> dict[str, Solid | Pair]:
    """Return the input of approximations for "lower", "upper" and "combined"."""
    pair = scene.pair
    return {"lower": pair.lower, "upper": pair.upper, "combined": pair}


# --- ICs and errors by body -----------------------------------------------------------------------------


def reference_ics(results: Results, body: str) -> EstimatedICs:
    """Return C of a body, or of both, with its estimate, (3, 3, n_points) [mm/N]."""
    return total([results.references[name].c for name in solved_parts(body)])


def check_ics(results: Results, body: str) -> EstimatedICs:
    """Return C of the check with its estimate, (3, 3, n_points) [mm/N]."""
    return total([results.checks[name].c for name in solved_parts(body)])


def select_ics(results: Results, variant: str, body: str) -> Array:
    """Return ICs of a body or of both, (3, 3, n_points) [mm/N]: C, C of the check or an approximation."""
    if variant == "C":
        return reference_ics(results, body).ic
    return check_ics(results, body).ic if variant == "C_solid" else results.approximations[variant, body]


def solved_parts(body: str) -> tuple[str, ...]:
    """Return the bodies whose ICs add up: both for "combined", else the body itself."""
    return ("upper", "lower") if body == "combined" else (body,)


def ics_measure(results: Results, body: str) -> Measure:
    """Return the measure of errors of a body's ICs: `femic.ic_errors.error_measure`."""
    points, patch = (results.points.x, results.points.s), results.scene.patch
    a = solids(results.scene)[body].approximate("A", patch, points) / patch.area
    return Measure.against(reference_ics(results, body), a[N, N], results.lines, far_from(patch, *points))


def engine_differences(results: Results, body: str) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return differences between C of both engines and sums of their estimates, by line, (3, 3) [-]."""
    c, check, measure = reference_ics(results, body), check_ics(results, body), ics_measure(results, body)
    return measure.shares(c.ic - check.ic), measure.shares(c.estimate + check.estimate)


def refinement_shares(results: Results, body: str, deviations: Array) -> dict[str, Array]:
    """Return deviations from C, (3, 3, n_points) [mm/N], as shares of the scale of refinement, by line.

    These shares are compared with a tolerance (`femic.reference.job`).
    """
    by_line = scales([results.jobs[name] for name in solved_parts(body)], reference_ics(results, body).ic)
    return {
        line: np.max(np.abs(deviations[..., part]), axis=-1) / by_line[line]
        for line, part in results.lines.items()
    }
