"""Compression with friction in steps of load, by several ICs: labelled arrays `contact.nc`."""

from collections.abc import Sequence
from time import perf_counter

import xarray as xr

from compare.contact.compute import C
from compare.friction.bodies import Solver
from compare.friction.dataset import Numbers, errors, maps, tables
from compare.friction.parts import by_friction_and_ics
from compare.friction.quantities import OF_PATCH, kinds, measured
from femic.contact.compression import compressed
from femic.contact.estimates import SAFETY, Measured, changes
from femic.contact.frictional import FrictionalContact, FrictionalProblem, Pressing
from femic.contact.normal import PotentialAreaTooSmall
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene
from geometries.errors import Failure

Steps = Sequence[Measured]  # after each load


def compute_compression(scene: Scene, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Numbers by friction, ICs and load, each with `estimate_NAME`, and maps at the largest load.

    The load grows in steps half as large as those between the loads of the scene: errors are of the first
    order in them, and estimated by steps that are twice as large.

    Raises BadScene for what cannot be solved, and Failure.
    """
    return by_friction_and_ics(scene, options, _solved, "Compression with friction")


def _solved(solver: Solver, friction: float, name: str) -> xr.Dataset:
    """The compression by some ICs at some friction."""
    operator, label, loads = (
        solver.operator(name),
        f"friction {friction:g}, {name}",
        solver.scene.contact.loads,
    )
    start = perf_counter()  # what C takes is told by itself
    problem = solver.problem(operator, friction)
    steps, last = in_steps(solver, problem, loads, label)
    seconds = perf_counter() - start
    solver.options.watch.on_stage(f"  {label}: {len(steps)} loads, {seconds:.1f} s")
    estimates = estimates_of(
        steps,
        _on_larger(solver, problem, loads, label),
        in_steps(solver, problem, loads, f"{label}, larger steps", halves=False)[0],
        _with_estimate(solver, friction, label) if name == C else None,
    )
    rows: dict[str, Sequence[Numbers]] = {"": [one.numbers for one in steps], "estimate_": estimates}
    found = xr.Dataset(tables(OF_PATCH, "load", rows), coords={"load": ("load", list(loads), {"units": "N"})})
    return found.merge(maps(solver, last)).assign(seconds=((), seconds, {"units": "s"}))


def in_halves(loads: Sequence[float]) -> list[float]:
    """Loads [N] with one more half way before each of them, from 0 on."""
    before = [0.0, *loads[:-1]]
    return [step for low, load in zip(before, loads, strict=True) for step in ((low + load) / 2, load)]


def _with_estimate(solver: Solver, friction: float, label: str) -> Steps:
    """The numbers by C plus its estimated error."""
    problem = solver.problem(solver.reference.perturbed, friction)
    return in_steps(solver, problem, solver.scene.contact.loads, f"{label} plus its estimate")[0]


def in_steps(
    solver: Solver, problem: FrictionalProblem, loads: Sequence[float], label: str, *, halves: bool = True
) -> tuple[Steps, FrictionalContact]:
    """The numbers after each load, and the last contact; in steps from load to load, or half as large."""
    steps, found = in_halves(loads) if halves else loads, list[Measured]()
    try:
        for contact in compressed(problem, [Pressing(load=load) for load in steps]):
            found.append(measured(OF_PATCH, solver.placed, contact))
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        raise Failure(f"{label}, {steps[len(found)]:g} N: {failure}") from failure
    return found[1::2] if halves else found, contact


def _on_larger(
    solver: Solver, problem: FrictionalProblem, loads: Sequence[float], label: str
) -> list[Steps | None]:
    """The numbers on elements twice and four times as large, None where they are not found."""
    found: list[Steps | None] = []
    for words in ("larger elements", "still larger elements"):
        if not problem.has_coarser:
            break
        problem = problem.coarsened
        try:
            found.append(in_steps(solver, problem, loads, f"{label}, {words}")[0])
        except PotentialAreaTooSmall:
            raise
        except Failure as failure:
            solver.options.watch.on_stage(f"  not in estimates: {failure}")
            found.append(None)
    return found


def estimates_of(
    steps: Steps, on_larger: Sequence[Steps | None], larger_steps: Steps, perturbed: Steps | None
) -> list[dict[str, float]]:
    """Sums of what larger elements, larger steps of load, and C plus its estimate change.

    Steps twice as large have twice the error, with the safety factor of elements.
    """
    of_patch, found = kinds(OF_PATCH), []
    for number, fine in enumerate(steps):
        by_steps = changes(fine, of_patch, larger_steps[number].numbers)
        others = [{name: SAFETY * value for name, value in by_steps.items()}]
        if perturbed is not None:
            others.append(changes(fine, of_patch, perturbed[number].numbers))
        larger = [one[number] if one else None for one in on_larger]
        found.append(errors(OF_PATCH, fine, larger, others))
    return found
