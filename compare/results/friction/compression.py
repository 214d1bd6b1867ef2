"""Compression with friction in steps of load, by several ICs, and its labelled arrays `contact.nc`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import xarray as xr

from compare.results.contact.compute import C
from compare.results.friction.bodies import Solver, on_fitting_grid
from compare.results.friction.dataset import attributes, differences, maps, tables
from compare.results.friction.quantities import OF_PATCH, numbers
from compare.scenes.scene import Scene
from contact.compression import compressed
from contact.frictional import FrictionalContact, FrictionalProblem, Pressing
from contact.normal import PotentialAreaTooSmall
from femic.means import DEFAULT, Means
from geometries.errors import Failure

Numbers = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class SolvedCompression:
    """Compression by some ICs at some friction: numbers by load, and the contact at the largest one.

    `coarse` are the numbers on elements twice as large; `perturbed` those by C plus its estimated error, None
    of others.
    """

    steps: Sequence[Numbers]
    coarse: Sequence[Numbers]
    perturbed: Sequence[Numbers] | None
    last: FrictionalContact
    seconds: float


@dataclass(frozen=True, eq=False)
class CompressionResults:
    """The compression of a scene by friction and ICs."""

    solver: Solver
    solved: Mapping[tuple[float, str], SolvedCompression]
    seconds: float


def compute_compression(scene: Scene, means: Means = DEFAULT) -> CompressionResults:
    """Solve the compression of a scene; raises BadScene for what cannot be solved, and Failure."""
    start = perf_counter()
    solver, solved = on_fitting_grid(scene, means, lambda solver: (solver, _all(solver)))
    return CompressionResults(solver, solved, perf_counter() - start)


def _all(solver: Solver) -> dict[tuple[float, str], SolvedCompression]:
    return {
        (friction, name): _solved(solver, friction, name)
        for name in solver.scene.contact.ics
        for friction in solver.wanted.coefficients
    }


def _solved(solver: Solver, friction: float, name: str) -> SolvedCompression:
    """The compression by some ICs at some friction."""
    start, label = perf_counter(), f"friction {friction:g}, {name}"
    problem = solver.problem(solver.operator(name), friction)
    steps, last = _in_steps(solver, problem, label)
    seconds = perf_counter() - start
    coarse, _ = _in_steps(solver, problem.coarsened, f"{label}, larger elements")
    perturbed = None
    if name == C and solver.reference is not None:
        with_estimate = solver.problem(solver.reference.perturbed, friction)
        perturbed, _ = _in_steps(solver, with_estimate, f"{label} plus its estimate")
    solver.means.watch.on_stage(f"  {label}: {len(steps)} loads, {seconds:.1f} s")
    return SolvedCompression(steps, coarse, perturbed, last, seconds)


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


def to_dataset(results: CompressionResults) -> xr.Dataset:
    """Numbers by friction, ICs and load, each with `estimate_NAME`, and maps at the largest load."""
    solver = results.solver
    ics, frictions = solver.scene.contact.ics, solver.wanted.coefficients
    solved = [[results.solved[friction, name] for name in ics] for friction in frictions]
    dataset = xr.Dataset(
        tables(
            OF_PATCH,
            ("friction", "ics", "load"),
            {
                "": [[list(one.steps) for one in row] for row in solved],
                "estimate_": [[_estimates(one) for one in row] for row in solved],
            },
        ),
        coords={
            "friction": list(frictions),
            "ics": list(ics),
            "load": ("load", list(solver.scene.contact.loads), {"units": "N"}),
        },
        attrs=attributes(solver, f"Compression with friction: {solver.scene.title}", results.seconds),
    )
    dataset["seconds"] = ("friction", "ics"), [[one.seconds for one in row] for row in solved], {"units": "s"}
    return dataset.merge(maps(solver, [[one.last for one in row] for row in solved]))


def _estimates(one: SolvedCompression) -> list[dict[str, float]]:
    perturbed = one.perturbed or one.steps
    return [
        differences(fine, coarse, {name: abs(value - other[name]) for name, value in fine.items()})
        for fine, coarse, other in zip(one.steps, one.coarse, perturbed, strict=True)
    ]
