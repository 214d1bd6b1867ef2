"""Creep-force curves of a wheel by several ICs: labelled arrays `contact.nc`."""

from collections.abc import Mapping
from time import perf_counter

import xarray as xr

from compare.results.contact.compute import C, reference_name
from compare.results.friction.bodies import Solver
from compare.results.friction.curve import Curve, Numbers, Path
from compare.results.friction.dataset import differences, maps, scalars, tables
from compare.results.friction.displaced import DISPLACED, PREFIX, displaced_numbers
from compare.results.friction.parts import by_friction_and_ics
from compare.results.friction.quantities import OF_ROLLING, Described
from compare.scenes.scene import Scene
from contact.frictional import FrictionalProblem
from contact.normal import PotentialAreaTooSmall
from femic.means import DEFAULT, Means
from geometries.errors import Failure

OF_FREE = {  # what describes a curve, besides its points
    "zero_creepage": Described("1", "creepage without longitudinal force"),
    "slope": Described("N", "derivative of the longitudinal force by the creepage there"),
    "equal_creepage": Described("1", "creepage at the force at which tractions are compared"),
}


def compute_rolling(scene: Scene, means: Means = DEFAULT) -> xr.Dataset:
    """Numbers by friction, ICs and creepage `xi`, each with `estimate_NAME`, and maps at equal force.

    `simplified` marks contacts that are found in the less accurate form only; `rms` and `largest` are
    distances of curves to the reference's. `displaced_NAME` is a number at the creepage nearest 0 with the
    distance of the displaced wheel, which is linearised otherwise.

    Raises BadScene for what cannot be solved, and Failure as `contact`.
    """
    dataset = by_friction_and_ics(scene, means, _solved, "Rolling with friction")
    wanted = scene.contact.friction
    dataset.attrs["load"] = scene.contact.loads[0]
    dataset.attrs["equal_force"] = wanted.equal_force if wanted else 0.0
    return dataset.assign(rms=_rms(dataset), largest=_largest(dataset))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """The longitudinal force, or what goes with it, over friction times load."""
    return dataset[name].drop_attrs() / (dataset.friction * dataset.attrs["load"])


def _rms(dataset: xr.Dataset) -> xr.DataArray:
    """Root mean square distance of curves to the reference's, over friction times load."""
    away = (_away(dataset) ** 2).mean("xi") ** 0.5
    return away.assign_attrs(
        units="1", long_name="root mean square distance to the reference's curve over friction times load"
    )


def _largest(dataset: xr.Dataset) -> xr.DataArray:
    """Largest distance of curves to the reference's at any creepage, over friction times load."""
    largest = abs(_away(dataset)).max("xi")
    return largest.assign_attrs(
        units="1", long_name="largest distance to the reference's curve over friction times load"
    )


def _away(dataset: xr.Dataset) -> xr.DataArray:
    """Longitudinal forces less those by the reference, over friction times load."""
    force = scaled_force(dataset)
    return force - force.sel(ics=reference_name([str(name) for name in dataset.ics.values]))


def _solved(solver: Solver, friction: float, name: str) -> xr.Dataset:
    """The curve by some ICs at some friction."""
    operator, start = solver.operator(name), perf_counter()  # what C takes is told by itself
    problem = solver.problem(operator, friction)
    path = Path.of(solver, problem, f"friction {friction:g}, {name}")
    curve = path.curve()
    seconds = perf_counter() - start
    solver.means.watch.on_stage(f"  {path.label}: {len(curve.points)} creepages, {seconds:.1f} s")
    coarse = _coarse(solver, problem.coarsened, f"{path.label}, larger elements")
    change = _change(path, curve) if name == C else None
    found = _labelled(solver, curve, coarse, change).assign(seconds=((), seconds, {"units": "s"}))
    return found.assign(scalars(DISPLACED, {PREFIX: displaced_numbers(path, curve)}))


def _coarse(solver: Solver, problem: FrictionalProblem, label: str) -> Curve | None:
    """The curve on larger elements, None where it is not found: numbers have no estimates then."""
    try:
        return Path.of(solver, problem, label).curve()
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        solver.means.watch.on_stage(f"  no estimates: {failure}")
        return None


def _change(path: Path, curve: Curve) -> Numbers:
    """By how much numbers of a curve by C change with the estimated error of C, at its first creepage."""
    perturbed = path.solver.problem(path.solver.reference.perturbed, path.problem.problem.friction)
    of_perturbed = Path.of(path.solver, perturbed, f"{path.label} plus its estimate").first()
    same = curve.points[path.xi.index(of_perturbed.creepages.longitudinal)]
    return {key: abs(value - same[key]) for key, value in path.numbers(of_perturbed).items()}


def _labelled(solver: Solver, curve: Curve, coarse: Curve | None, change: Numbers | None) -> xr.Dataset:
    """A curve with the estimates of its numbers, and its maps at equal force."""
    on_larger = coarse.points if coarse else [None] * len(curve.points)
    of_points = [
        differences(fine, larger, change) for fine, larger in zip(curve.points, on_larger, strict=True)
    ]
    numbers = {
        **tables(OF_ROLLING, "xi", {"": curve.points, "estimate_": of_points}),
        **scalars(OF_FREE, {"": _free(curve), "estimate_": _free_estimates(curve, coarse, change)}),
        "simplified": ("xi", list(curve.simplified)),
    }
    found = xr.Dataset(numbers, coords={"xi": list(solver.wanted.longitudinal)})
    return found.merge(maps(solver, curve.equal.contact))


def _free(curve: Curve) -> dict[str, float]:
    """What `OF_FREE` names."""
    equal = float(curve.equal.creepages.longitudinal)
    return {"zero_creepage": curve.zero_creepage, "slope": curve.slope, "equal_creepage": equal}


def _free_estimates(curve: Curve, coarse: Curve | None, change: Numbers | None) -> Mapping[str, float]:
    """Creepages are changed by the estimate of C as forces are."""
    by_change = change["F_x"] / curve.slope if change else 0.0
    changes = {"zero_creepage": by_change, "slope": 0.0, "equal_creepage": by_change}
    return differences(_free(curve), _free(coarse) if coarse else None, changes)
