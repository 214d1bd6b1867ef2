"""Results by friction and ICs: each is kept in the store as soon as it is finished, and all are joined."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

import xarray as xr

from compare.contact.compute import C, c_jobs
from compare.contact.dataset import provenance
from compare.friction.bodies import Solver, on_fitting_grid
from compare.matrix.compute import discounted
from femic.cache.digests import results_digest
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import RunOptions
from femic.scenes.scene import Scene

Solve = Callable[[Solver, float, str], xr.Dataset]  # with a coefficient of friction, by ICs of a name


def by_friction_and_ics(scene: Scene, options: RunOptions, solve: Solve, title: str) -> xr.Dataset:
    """What `solve` gives for all coefficients of friction and ICs of a scene, which are dimensions of it."""
    start = perf_counter()
    joined = on_fitting_grid(scene, options, lambda solver: _joined(solver, solve))
    made = {
        "title": f"{title}: {scene.title}",
        "meaning": "tractions on the upper body along x, s, n of the lower surface; slip over that surface",
        "discounted": discounted(scene),
    }
    return joined.assign_attrs(made | provenance(scene, perf_counter() - start, solve.__module__))


def _joined(solver: Solver, solve: Solve) -> xr.Dataset:
    frictions, ics = solver.wanted.coefficients, solver.scene.contact.ics
    parts = {(friction, name): _kept(solver, friction, name, solve) for name in ics for friction in frictions}
    rows = [xr.concat([parts[friction, name] for name in ics], "ics") for friction in frictions]
    joined = xr.concat(rows, "friction").assign_coords(friction=list(frictions), ics=list(ics))
    inclination = solver.placed.undeformed.lower.contour.inclination(solver.placed.grid.strips)
    joined["inclination"] = "s", inclination, {"units": "rad"}
    known = parts[frictions[0], C].attrs if C in ics else {}
    grid = solver.placed.grid
    exactly = {"dx": grid.dx, "ds": grid.ds, "s_middle": grid.s}  # differences of coordinates are rounded
    return joined.drop_attrs(deep=False).assign_attrs(known | exactly)


def _kept(solver: Solver, friction: float, name: str, solve: Solve) -> xr.Dataset:
    """What `solve` gives, from the store if it is there."""
    store = solver.options.store
    key = store.key("friction", results_digest(solve.__module__), *_determined_by(solver, friction, name))
    part = store.get(key)
    if part is None:
        part = solve(solver, friction, name).assign_attrs(solver.known_of(name))
        store.put(key, part)
    else:
        solver.options.watch.on_stage(f"  friction {friction:g}, {name}: kept by an earlier run")
    return part


def _determined_by(solver: Solver, friction: float, name: str) -> tuple[object, ...]:
    """All inputs that a result depends on, and not what else the scene asks for."""
    scene, alone = solver.scene, replace(solver.wanted, coefficients=(friction,))
    wanted = replace(scene.contact, ics=(name,), friction=alone)
    of_c = [_inputs(job) for job in c_jobs(scene, solver.placed).values()] if name == C else []
    return scene.pair, wanted, solver.placed.grid, *of_c


def _inputs(job: MatrixJob) -> tuple[object, ...]:
    """What C depends on; the engine is part of the code."""
    settings = replace(job.settings, engine=None)  # type: ignore[arg-type]
    return job.body, job.grid, job.components, job.discounts, settings
