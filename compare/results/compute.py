"""From a scene to labelled results: reference ICs, approximations, dataset."""

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from approx.pair import Pair, Solid
from compare.results.measure import Measure, far_from
from compare.scenes.scene import Scene
from femic.at_points import references
from femic.estimate import Estimated, total
from femic.job import Job
from femic.means import DEFAULT, Means
from femic.models import Cost, Points
from femic.reference import Reference, scales
from geometries.arrays import Array, Mask
from geometries.patches import N, Patch

REPETITIONS = 5  # of an approximation, for its timing


@dataclass(frozen=True)
class Results:
    """All ICs of a scene per unit total load [mm/N], shape (3, 3, n_points) each."""

    scene: Scene
    points: Points
    lines: Mapping[str, slice]  # which points belong to which line
    jobs: Mapping[str, Job]  # of each solved body
    references: Mapping[str, Reference]  # of each solved body
    checks: Mapping[str, Reference]  # by the solid engine where it is the check, else empty
    approximations: Mapping[tuple[str, str], Array]  # by (variant, body)
    seconds: Mapping[tuple[str, str], float]  # by (variant, body), C summed over its models

    @property
    def variants(self) -> tuple[str, ...]:
        """What there is to show: the approximations, C of the check, C."""
        return (*self.scene.variants, *(("C_solid",) if self.checks else ()), "C")

    @property
    def models(self) -> dict[str, Cost]:
        """What every solved model took, by body and model."""
        named = {f"{body}, {{}}": found for body, found in self.references.items()}
        named |= {f"solid check, {body}, {{}}": found for body, found in self.checks.items()}
        return {name.format(m): cost for name, found in named.items() for m, cost in found.models.items()}


def scene_points(scene: Scene) -> tuple[Points, dict[str, slice]]:
    """All points of the scene's lines one after the other, and the part that is each line."""
    starts = np.cumsum([0, *(len(line.x) for line in scene.lines)])
    parts = {line.name: slice(*starts[k : k + 2]) for k, line in enumerate(scene.lines)}
    x, s = (np.concatenate([getattr(line, c) for line in scene.lines]) for c in ("x", "s"))
    return Points(x, s), parts


def jobs(scene: Scene) -> dict[str, Job]:
    """What the reference engine has to do: only the bodies and load directions asked for."""
    points, lines = scene_points(scene)
    return {
        name: Job(scene.bodies[name], scene.patch, scene.components, points, lines, scene.settings)
        for name in scene.solved
    }


def compute(scene: Scene, means: Means = DEFAULT) -> Results:
    """Compute everything the scene asks for.

    Solved models are kept in the store. Raises NotConverged where the estimated error of
    what is compared cannot be brought down to the tolerance.
    """
    asked, combined = jobs(scene), "combined" in scene.compared
    found = references(asked, means, combined=combined)
    checks: dict[str, Reference] = {}
    if scene.check:
        means.watch.on_stage(f"  check by the {scene.check.settings.engine.name} engine")
        checks = references(jobs(scene.check), means, combined=combined)
    points, lines = scene_points(scene)
    approximations, seconds = approximated(scene, points)
    seconds |= _reference_seconds("C", found) | _reference_seconds("C_solid", checks)
    return Results(scene, points, lines, asked, found, checks, approximations, seconds)


def approximated(
    scene: Scene, points: Points
) -> tuple[dict[tuple[str, str], Array], dict[tuple[str, str], float]]:
    """Approximations of what is compared, and their seconds; NaN where there are no effective properties."""
    pair = scene.pair
    ics: dict[tuple[str, str], Array] = {}
    seconds: dict[tuple[str, str], float] = {}
    for name in scene.compared:
        for variant in scene.variants:
            if variant == "Bhat_prime" and not pair.has_effective(name):
                ics[variant, name], seconds[variant, name] = np.full((3, 3, len(points.x)), np.nan), np.nan
            else:
                ics[variant, name], seconds[variant, name] = _timed(
                    variant, solids(scene)[name], scene.patch, points
                )
    return ics, seconds


def solids(scene: Scene) -> dict[str, Solid | Pair]:
    """What approximations see under the names of the comparison."""
    pair = scene.pair
    return {"lower": pair.lower, "upper": pair.upper, "combined": pair}


def _timed(variant: str, solid: Solid | Pair, patch: Patch, points: Points) -> tuple[Array, float]:
    """ICs per unit load, and the least seconds of a few repetitions."""
    seconds = []
    for _ in range(REPETITIONS):
        start = perf_counter()
        ic = solid.approximate(variant, patch, (points.x, points.s))
        seconds.append(perf_counter() - start)
    return ic / patch.area, min(seconds)


def _reference_seconds(variant: str, found: Mapping[str, Reference]) -> dict[tuple[str, str], float]:
    """Seconds of C, summed over its models; of both bodies under "combined"."""
    per_body = {
        (variant, name): sum(sum(cost.seconds.values()) for cost in solved.models.values())
        for name, solved in found.items()
    }
    return per_body | {(variant, "combined"): sum(per_body.values())} if found else {}


def reference_of(results: Results, body: str) -> Estimated:
    """C of a body with its estimate, or of both."""
    return total([results.references[name].c for name in parts_of(body)])


def check_of(results: Results, body: str) -> Estimated:
    """C of the solid engine with its estimate, where it is the check."""
    return total([results.checks[name].c for name in parts_of(body)])


def refinement_scales_of(results: Results, body: str) -> dict[str, Array]:
    """Scale of refinement per line, shape (3, 3), of a body's C or of both bodies': `femic.accuracy`."""
    of_body = [results.jobs[name] for name in parts_of(body)]
    return scales(of_body, reference_of(results, body).ic)


def measure_of(results: Results, body: str) -> Measure:
    """What errors of a body's ICs, or of both bodies', are shares of: `compare.results.measure`."""
    at, patch = (results.points.x, results.points.s), results.scene.patch
    a = solids(results.scene)[body].approximate("A", patch, at) / patch.area
    return Measure.of(reference_of(results, body), a[N, N], results.lines, far_from(patch, *at))


def ics_of(results: Results, variant: str, body: str) -> Array:
    """C, C of the check or an approximation of a body or of both, (3, 3, n_points) [mm/N]."""
    if variant == "C":
        return reference_of(results, body).ic
    return check_of(results, body).ic if variant == "C_solid" else results.approximations[variant, body]


def shares_of(results: Results, body: str, off: Array) -> dict[str, Array]:
    """Deviations of a body's ICs, (3, 3, n_points), per line: errors of the components, (3, 3).

    Shares of the component itself; of 0.05 max |C_nn| where it is one of those `vanishing`.
    """
    return measure_of(results, body).shares(off)


def weights_of(results: Results, body: str, off: Array) -> dict[str, Array]:
    """The same deviations as shares of max |C_nn| on each line, (3, 3)."""
    return measure_of(results, body).weights(off)


def vanishing(results: Results, body: str) -> Mask:
    """Which components of a body's C, (3, 3), vanish: by symmetry, or below ten times their estimates."""
    return measure_of(results, body).vanishing


def refinement_shares_of(results: Results, body: str, off: Array) -> dict[str, Array]:
    """Deviations of a body's C per line, (3, 3), as refinement sees them: to be held against a tolerance."""
    scales = refinement_scales_of(results, body)
    return {
        line: np.max(np.abs(off[..., part]), axis=-1) / scales[line] for line, part in results.lines.items()
    }


def apart(results: Results, body: str) -> tuple[dict[str, Array], dict[str, Array]]:
    """How far C of both engines are apart per line, and the sum of their estimates; as `shares_of`."""
    c, check = reference_of(results, body), check_of(results, body)
    return shares_of(results, body, c.ic - check.ic), shares_of(results, body, c.estimate + check.estimate)


def parts_of(body: str) -> tuple[str, ...]:
    """The bodies whose ICs add up to those of a body of the comparison."""
    return ("upper", "lower") if body == "combined" else (body,)


def estimated_errors(results: Results) -> dict[tuple[str, str], Array]:
    """Estimated error of C by (body, line), shape (3, 3), of every solved body; as refinement sees it."""
    return {
        (body, line): errors
        for body, found in results.references.items()
        for line, errors in refinement_shares_of(results, body, found.c.estimate).items()
    }
