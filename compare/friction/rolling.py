"""Creep-force curves of a wheel by several ICs: labelled arrays `contact.nc`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import xarray as xr

from compare.contact.compute import C, reference_name
from compare.friction.bodies import Solver
from compare.friction.curve import Curve, Path
from compare.friction.dataset import Numbers, errors, maps, scalars, tables
from compare.friction.displaced import DISPLACED, PREFIX, displaced_numbers
from compare.friction.parts import by_friction_and_ics
from compare.friction.quantities import OF_ROLLING, Described, kinds
from femic.contact.estimates import CREEPAGE, SLOPE, changes
from femic.contact.frictional import FrictionalProblem
from femic.contact.normal import PotentialAreaTooSmall
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene
from geometries.errors import Failure

OF_FREE = {  # what describes a curve, besides its points
    "zero_creepage": Described("1", "creepage without longitudinal force", kind=CREEPAGE),
    "slope": Described("N", "derivative of the longitudinal force by the creepage there", kind=SLOPE),
    "equal_creepage": Described("1", "creepage at the force at which tractions are compared", kind=CREEPAGE),
}
UNKNOWN = dict.fromkeys(OF_ROLLING, np.nan)  # numbers where there is no contact
Distance = Callable[[xr.DataArray], xr.DataArray]
DISTANCES: Mapping[str, tuple[Distance, str]] = {  # of curves, from distances of their points
    "rms": (
        lambda away: (away**2).mean("xi") ** 0.5,
        "root mean square distance to the reference's curve over friction times load",
    ),
    "largest": (
        lambda away: away.max("xi"),
        "largest distance to the reference's curve over friction times load",
    ),
}


def compute_rolling(scene: Scene, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Numbers by friction, ICs and creepage `xi`, each with `estimate_NAME`, and maps at equal force.

    `simplified` marks contacts that are found in the less accurate form only; `rms` and `largest` are
    distances of curves to the reference's. `displaced_NAME` is a number at the creepage nearest 0 with the
    distance of the displaced wheel, which is linearised otherwise.

    Raises BadScene for what cannot be solved, and Failure as `contact`.
    """
    dataset = by_friction_and_ics(scene, options, _solved, "Rolling with friction")
    wanted = scene.contact.friction
    dataset.attrs["load"] = scene.contact.loads[0]
    dataset.attrs["equal_force"] = wanted.equal_force if wanted else 0.0
    return dataset.assign(_away(dataset))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """The longitudinal force, or what goes with it, over friction times load."""
    return dataset[name].drop_attrs() / (dataset.friction * dataset.attrs["load"])


def _away(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Distances of curves to the reference's, over friction times load: `rms` and `largest`, with estimates.

    By the triangle inequality of each distance, they are wrong by that of the estimates of both curves at
    most; that of the reference to itself is 0.
    """
    force, known = scaled_force(dataset), scaled_force(dataset, "estimate_F_x")
    reference = reference_name([str(name) for name in dataset.ics.values])
    away = abs(force - force.sel(ics=reference))
    wrong = (known + known.sel(ics=reference)).where(dataset.ics != reference, 0.0).where(away.notnull())
    return {
        prefix + name: distance(values).assign_attrs(units="1", long_name=meaning)
        for prefix, values in (("", away), ("estimate_", wrong))
        for name, (distance, meaning) in DISTANCES.items()
    }


def _solved(solver: Solver, friction: float, name: str) -> xr.Dataset:
    """The curve by some ICs at some friction."""
    operator, start = solver.operator(name), perf_counter()  # what C takes is told by itself
    problem = solver.problem(operator, friction)
    path = Path.of(solver, problem, f"friction {friction:g}, {name}")
    curve = path.curve()
    seconds = perf_counter() - start
    solver.options.watch.on_stage(
        f"  {path.label}: {len(curve.points)} of {len(path.xi)} creepages, {seconds:.1f} s"
    )
    change = _change(path, curve) if name == C else None
    found = _labelled(solver, curve, _on_larger(path), change).assign(seconds=((), seconds, {"units": "s"}))
    return found.assign(scalars(DISPLACED, {PREFIX: displaced_numbers(path, curve)}))


def _on_larger(path: Path) -> list[Curve | None]:
    """The curves on elements twice and four times as large, None where one is not found."""
    found, problem = [], path.problem.problem
    for words in ("larger elements", "still larger elements"):
        if not problem.has_coarser:
            break
        problem = problem.coarsened
        found.append(_coarse(path.solver, problem, f"{path.label}, {words}"))
    return found


def _coarse(solver: Solver, problem: FrictionalProblem, label: str) -> Curve | None:
    """The curve on larger elements, None where it is not found: estimates do without it then."""
    try:
        return Path.of(solver, problem, label).curve()
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        solver.options.watch.on_stage(f"  not in estimates: {failure}")
        return None


@dataclass(frozen=True, eq=False)
class Change:
    """By how much numbers of a curve change with the estimated error of C: its points, and `free`."""

    points: Sequence[Numbers]
    free: Numbers


def _change(path: Path, curve: Curve) -> Change:
    """The change by the estimated error of C, solved at a few creepages and linear between these.

    They are the one nearest 0 and those with the largest forces; NaN where no such contact is found.
    """
    perturbed = path.solver.problem(path.solver.reference.perturbed, path.problem.problem.friction)
    beside = Path.of(path.solver, perturbed, f"{path.label} plus its estimate")
    rows = {}
    for xi in deciding(curve):
        if contact := beside.tried(xi, curve.contacts[xi]):
            rows[xi] = changes(curve.points[xi], kinds(OF_ROLLING), beside.measured(contact).numbers)
    try:
        free = beside.free(list(curve.contacts.values()))[0].numbers
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        path.solver.options.watch.on_stage(f"  no estimates: {failure}")
        free = dict.fromkeys(OF_FREE, np.nan)
    return Change([between(rows, xi) for xi in path.xi], changes(curve.free, kinds(OF_FREE), free))


def deciding(curve: Curve) -> list[float]:
    """The creepages nearest 0, and with the largest forces both ways, growing."""
    force = {xi: one.numbers["F_x"] for xi, one in curve.points.items()}
    return sorted({min(force, key=abs), min(force, key=force.__getitem__), max(force, key=force.__getitem__)})


def between(rows: Mapping[float, Numbers], xi: float) -> dict[str, float]:
    """Numbers at a creepage from rows at growing ones: linear between them, and constant beyond."""
    if not rows:
        return dict.fromkeys(OF_ROLLING, np.nan)
    return {
        name: float(np.interp(xi, list(rows), [row[name] for row in rows.values()])) for name in OF_ROLLING
    }


def _labelled(
    solver: Solver, curve: Curve, larger: Sequence[Curve | None], change: Change | None
) -> xr.Dataset:
    """A curve with the estimates of its numbers, and its maps at equal force."""
    xis = solver.wanted.longitudinal
    of_points = [
        errors(
            OF_ROLLING,
            curve.points.get(xi),
            [one.points.get(xi) if one else None for one in larger],
            [change.points[number]] if change else [],
        )
        for number, xi in enumerate(xis)
    ]
    of_free = errors(
        OF_FREE, curve.free, [one.free if one else None for one in larger], [change.free] if change else []
    )
    points = [curve.points[xi].numbers if xi in curve.points else UNKNOWN for xi in xis]
    numbers = {
        **tables(OF_ROLLING, "xi", {"": points, "estimate_": of_points}),
        **scalars(OF_FREE, {"": curve.free.numbers, "estimate_": of_free}),
        "simplified": ("xi", [xi in curve.contacts and curve.contacts[xi].simplified for xi in xis]),
    }
    found = xr.Dataset(numbers, coords={"xi": list(xis)})
    return found.merge(maps(solver, curve.equal.contact))
