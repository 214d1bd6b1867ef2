"""Compression with friction in steps of load, by several ICs: labelled arrays `contact.nc`."""

from collections.abc import Sequence
from time import perf_counter

import xarray as xr

from compare.results.contact.compute import C
from compare.results.friction.bodies import Solver
from compare.results.friction.dataset import Numbers, differences, maps, tables
from compare.results.friction.parts import by_friction_and_ics
from compare.results.friction.quantities import OF_PATCH, numbers
from compare.scenes.scene import Scene
from contact.compression import compressed
from contact.frictional import FrictionalContact, FrictionalProblem, Pressing
from contact.normal import PotentialAreaTooSmall
from femic.means import DEFAULT, Means
from geometries.errors import Failure


def compute_compression(scene: Scene, means: Means = DEFAULT) -> xr.Dataset:
    """Numbers by friction, ICs and load, each with `estimate_NAME`, and maps at the largest load.

    Raises BadScene for what cannot be solved, and Failure.
    """
    return by_friction_and_ics(scene, means, _solved, "Compression with friction")


def _solved(solver: Solver, friction: float, name: str) -> xr.Dataset:
    """The compression by some ICs at some friction."""
    operator, label = solver.operator(name), f"friction {friction:g}, {name}"
    start = perf_counter()  # what C takes is told by itself
    problem = solver.problem(operator, friction)
    steps, last = _in_steps(solver, problem, label)
    seconds = perf_counter() - start
    solver.means.watch.on_stage(f"  {label}: {len(steps)} loads, {seconds:.1f} s")
    coarse, _ = _in_steps(solver, problem.coarsened, f"{label}, larger elements")
    perturbed = _with_estimate(solver, friction, label) if name == C else steps
    rows = {"": steps, "estimate_": _estimates(steps, coarse, perturbed)}
    loads = ("load", list(solver.scene.contact.loads), {"units": "N"})
    found = xr.Dataset(tables(OF_PATCH, "load", rows), coords={"load": loads})
    return found.merge(maps(solver, last)).assign(seconds=((), seconds, {"units": "s"}))


def _with_estimate(solver: Solver, friction: float, label: str) -> list[dict[str, float]]:
    """The numbers by C plus its estimated error."""
    problem = solver.problem(solver.reference.perturbed, friction)
    return _in_steps(solver, problem, f"{label} plus its estimate")[0]


def _in_steps(
    solver: Solver, problem: FrictionalProblem, label: str
) -> tuple[list[dict[str, float]], FrictionalContact]:
    """The numbers after each load, and the last contact."""
    loads, found = solver.scene.contact.loads, []
    try:
        for contact in compressed(problem, [Pressing(load=load) for load in loads]):
            found.append(numbers(OF_PATCH, solver.placed, contact))
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        raise Failure(f"{label}, {loads[len(found)]:g} N: {failure}") from failure
    return found, contact


def _estimates(
    steps: Sequence[Numbers], coarse: Sequence[Numbers], perturbed: Sequence[Numbers]
) -> list[dict[str, float]]:
    return [
        differences(fine, larger, {name: abs(value - other[name]) for name, value in fine.items()})
        for fine, larger, other in zip(steps, coarse, perturbed, strict=True)
    ]
