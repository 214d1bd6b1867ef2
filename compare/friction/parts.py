"""Solutions by friction and ICs: each is stored as soon as it is finished, and all are joined."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import xarray as xr

from compare.contact.dataset import INCLINATION, SECONDS
from femic.cache.digests import results_digest
from femic.contact.friction.by_angle import friction_factors, in_words
from femic.contact.pairs.c_jobs import c_jobs
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.reference.matrix.job import MatrixJob

FRICTION = {"units": "1", "long_name": "coefficient of friction"}
FACTOR = {"units": "1", "long_name": "factor of friction by the contact angle"}
Labelled = Callable[[PairWithFriction, Any], xr.Dataset]  # a solution, which has its `seconds`, as arrays


def by_friction_and_ics(pair: PairWithFriction, labelled: Labelled) -> xr.Dataset:
    """Return the solutions along the dimensions friction and ICs."""
    by_angle = pair.specification.friction_by_angle
    frictions, ics = pair.specification.coefficients, pair.problem.specification.ics
    parts = {
        (friction, name): _stored(pair, friction, name, labelled) for name in ics for friction in frictions
    }
    rows = [xr.concat([parts[friction, name] for name in ics], "ics") for friction in frictions]
    joined = xr.concat(rows, "friction").assign_coords(
        friction=("friction", list(frictions), FRICTION), ics=list(ics)
    )
    grid = pair.on_grid.grid
    inclination = pair.on_grid.undeformed.lower.contour.inclination(grid.strips)
    joined["inclination"] = "s", inclination, INCLINATION
    joined["friction_factor"] = "s", friction_factors(by_angle, inclination), FACTOR
    c_quality = parts[frictions[0], C].attrs if C in ics else {}
    words = {"friction_by_angle": in_words(by_angle)}
    exact = {"dx": grid.dx, "ds": grid.ds, "s_middle": grid.s}  # differences of coordinates are rounded
    return joined.drop_attrs(deep=False).assign_attrs(c_quality | exact | words)


def _stored(pair: PairWithFriction, friction: float, name: str, labelled: Labelled) -> xr.Dataset:
    """Return a solution, from the store if it is there."""
    store, solve = pair.options.store, pair.motion.solve
    assert solve is not None
    key = store.key("friction", results_digest(labelled.__module__), *_inputs(pair, friction, name))
    part = store.get(key)
    if part is None:
        solution = solve(pair, friction, name)
        part = labelled(pair, solution).assign(seconds=((), solution.seconds, SECONDS))
        part = part.assign_attrs(_c_quality(pair, name))
        store.put(key, part)
    else:
        pair.options.watch.on_stage(f"  friction {friction:g}, {name}: stored by an earlier run")
    return part


def _c_quality(pair: PairWithFriction, name: str) -> dict[str, float | str]:
    """Return errors and cost of C on the grid; empty for other ICs and for given C."""
    if name != C or name in pair.given:
        return {}
    c = pair.reference
    return {
        "C_estimate": c.estimate,
        "C_asymmetry": c.asymmetry.share,
        "C_asymmetry_component": c.asymmetry.component,
        "C_seconds": c.seconds,
    }


def _inputs(pair: PairWithFriction, friction: float, name: str) -> tuple[object, ...]:
    """Return the inputs that a solution depends on, without the other keys of the scene."""
    problem, alone = pair.problem, replace(pair.specification, coefficients=(friction,))
    specification = replace(problem.specification, ics=(name,), friction=alone)
    common = problem.pair, specification, pair.on_grid.grid
    if name in pair.given:
        return *common, pair.given[name]
    jobs = c_jobs(problem, pair.on_grid).values() if name == C else ()
    return *common, *map(_c_inputs, jobs)


def _c_inputs(job: MatrixJob) -> tuple[object, ...]:
    """Return all inputs of C; the engine by its name, because the digest covers its code."""
    settings = replace(job.settings, engine=None)  # type: ignore[arg-type]
    return job.body, job.grid, job.components, job.discounts, settings, job.settings.engine.name
