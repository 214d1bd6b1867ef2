"""Contact with friction of a scene with several ICs, as `femic.contact` solves it: the dataset `contact.nc`.

Numbers are by load in compression, by distance in transient rolling, and by creepage in steady rolling. Each
solution is stored as soon as it is finished.
"""

from collections.abc import Mapping
from dataclasses import replace
from time import perf_counter

import xarray as xr

from femic.cache.digests import results_digest
from femic.contact.datasets import INCLINATION, PREFIXES, read_grid, variables
from femic.contact.friction.motion import friction_factors, in_words
from femic.contact.motions import find_motion, pair_in_motion, solve_with_friction
from femic.contact.motions.motion import Motion
from femic.contact.pairs.ics import NONE_GIVEN, C, GivenICs, c_jobs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.supports import changed_supports_with_friction
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import provenance, require_solvable
from femic.results.matrices import discounted
from femic.scenes.scene import Scene

FRICTION = {"units": "1", "long_name": "coefficient of friction"}
FACTOR = {"units": "1", "long_name": "factor of friction by the contact angle"}
PREFIX = "supported_"  # of the names of numbers with other supports


def compute_with_friction(
    scene: Scene, options: RunOptions = DEFAULT, given: Mapping[str, GivenICs] = NONE_GIVEN
) -> xr.Dataset:
    """Return numbers by friction, ICs and the dimension of the motion, each with `estimate_NAME`, and maps.

    `given` are ICs of the caller by name. Raises BadScene for what cannot be solved, and Failure as
    `femic.contact`.
    """
    require_solvable(scene, given)
    start, motion = perf_counter(), find_motion(scene.contact)
    by_angle, ics = scene.contact_problem.specification.friction, scene.contact.ics
    assert by_angle is not None
    frictions, factors = by_angle.coefficients, by_angle.friction_by_angle

    def solve_all(pair: PairWithFriction) -> xr.Dataset:
        parts = {
            (friction, name): _solve_or_load(motion, pair, friction, name)
            for name in ics
            for friction in frictions
        }
        rows = [xr.concat([parts[friction, name] for name in ics], "ics") for friction in frictions]
        joined = xr.concat(rows, "friction").assign_coords(
            friction=("friction", list(frictions), FRICTION), ics=list(ics)
        )
        grid = pair.on_grid.grid
        inclination = pair.on_grid.undeformed.lower.contour.inclination(grid.strips)
        joined["inclination"] = "s", inclination, INCLINATION
        joined["friction_factor"] = "s", friction_factors(factors, inclination), FACTOR
        c_quality = parts[frictions[0], C].attrs if C in ics else {}
        exact = {"dx": grid.dx, "ds": grid.ds, "s_middle": grid.s}  # differences of coordinates are rounded
        return joined.drop_attrs(deep=False).assign_attrs(
            c_quality | exact, friction_by_angle=in_words(factors)
        )

    joined = solve_with_friction(scene.contact_problem, solve_all, options, given)
    attributes = {
        "title": f"{motion.title}: {scene.title}",
        "meaning": "tractions on the upper body along x, s, n of the lower surface; slip over that surface",
        "discounted": discounted(scene),
        **provenance(scene, perf_counter() - start),
    }
    return motion.complete(joined.assign_attrs(attributes), scene.contact)


def _solve_or_load(motion: Motion, pair: PairWithFriction, friction: float, name: str) -> xr.Dataset:
    """Return a solution, from the store if it is there; that with C has its quality as attributes.

    Its inputs are those of the motion, without the other keys of the scene; and of C, the engine by its name,
    because the digest covers its code.
    """
    problem, store = pair.problem, pair.options.store
    alone = replace(pair.specification, coefficients=(friction,))
    inputs = [problem.pair, replace(problem.specification, ics=(name,), friction=alone), pair.on_grid.grid]
    if name in pair.given:
        inputs.append(pair.given[name])
    elif name == C:
        for job in c_jobs(problem, pair.on_grid).values():
            settings = replace(job.settings, engine=None)  # type: ignore[arg-type]
            engine = job.settings.engine.name
            inputs += [(job.body, job.grid, job.components, job.discounts, settings, engine)]
    key = store.key("friction", results_digest(), *inputs)
    part = store.get(key)
    if part is not None:
        pair.options.watch.on_stage(f"  friction {friction:g}, {name}: stored by an earlier run")
        return part
    assert motion.solve is not None
    part = motion.solve(pair, friction, name)
    if name == C and name not in pair.given:
        c = pair.reference
        part = part.assign_attrs(
            C_estimate=c.estimate,
            C_asymmetry=c.asymmetry.share,
            C_asymmetry_component=c.asymmetry.component,
            C_seconds=c.seconds,
        )
    store.put(key, part)
    return part


def with_supports(scene: Scene, dataset: xr.Dataset, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return the arrays of a motion with `supported_NAME` (supports): one contact with C on other supports.

    It has the least coefficient of friction; rolling is at the creepage nearest 0, a compression after its
    last load. `supported_friction`, and `supported_xi` or `supported_load`, say so. The arrays are
    unchanged where they have no C, or the scene does not request it. Raises NotConverged as `matrices`.
    """
    if C not in dataset.ics.values or not scene.contact.supports:
        return dataset
    problem, friction = scene.contact_problem, float(dataset.friction.min())
    pair = pair_in_motion(problem, pair_on_grid(problem, read_grid(dataset)), options)
    points = changed_supports_with_friction(pair, friction)
    if not points:
        return dataset
    places, numbers = zip(*points.values(), strict=True)
    motion = find_motion(scene.contact)
    supported = xr.Dataset(
        variables(motion.quantities, "supports", {PREFIX: numbers}), coords={"supports": list(points)}
    )
    for name, value in {"friction": friction, motion.dimension: places[0]}.items():
        about = dataset[name].attrs
        meaning = about["long_name"] + PREFIXES[PREFIX]
        supported[PREFIX + name] = (), value, about | {"long_name": meaning}
    return dataset.merge(supported)
