"""The labelled arrays of rolling, `contact.nc`: creep-force curves, tractions at equal force."""

from collections.abc import Callable

import xarray as xr

from compare.results.contact.compute import reference_name
from compare.results.friction.dataset import attributes, differences, maps, tables
from compare.results.friction.quantities import OF_ROLLING
from compare.results.friction.rolling import RollingResults, SolvedRolling

BY_ICS = ("friction", "ics")
OF_FREE = {  # what free rolling is described by: units and meanings
    "zero_creepage": ("1", "creepage without longitudinal force"),
    "slope": ("N", "derivative of the longitudinal force by the creepage there"),
    "equal_creepage": ("1", "creepage at the force at which tractions are compared"),
}


def to_dataset(results: RollingResults) -> xr.Dataset:
    """Numbers by friction, ICs and creepage `xi`, each with `estimate_NAME`, and maps at equal force."""
    solver = results.solver
    ics, frictions = solver.scene.contact.ics, solver.wanted.coefficients
    solved = [[results.solved[friction, name] for name in ics] for friction in frictions]
    dataset = xr.Dataset(
        tables(
            OF_ROLLING,
            (*BY_ICS, "xi"),
            {
                "": [[list(one.curve.points) for one in row] for row in solved],
                "estimate_": [[_estimates(one) for one in row] for row in solved],
            },
        ),
        coords={"friction": list(frictions), "ics": list(ics), "xi": list(solver.wanted.longitudinal)},
        attrs=attributes(solver, f"Rolling with friction: {solver.scene.title}", results.seconds),
    )
    for name, (unit, meaning) in OF_FREE.items():
        described = {"units": unit, "long_name": meaning}
        dataset[name] = BY_ICS, _each(solved, _FREE[name]), described
        dataset[f"estimate_{name}"] = BY_ICS, _each(solved, _FREE_ESTIMATES[name]), described
    dataset["seconds"] = BY_ICS, _each(solved, lambda one: one.seconds), {"units": "s"}
    dataset.attrs |= {"load": solver.scene.contact.loads[0], "equal_force": solver.wanted.equal_force}
    dataset["rms"] = _rms(dataset)
    return dataset.merge(maps(solver, [[one.curve.equal.contact for one in row] for row in solved]))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """The longitudinal force, or what goes with it, over friction times load."""
    return dataset[name] / (dataset.friction * dataset.attrs["load"])


def _rms(dataset: xr.Dataset) -> xr.DataArray:
    """Root mean square distance of curves to the reference's, over friction times load."""
    force = scaled_force(dataset)
    reference = force.sel(ics=reference_name([str(name) for name in dataset.ics.values]))
    return ((force - reference) ** 2).mean("xi") ** 0.5


def _each(solved: list[list[SolvedRolling]], number: Callable[[SolvedRolling], float]) -> list[list[float]]:
    return [[number(one) for one in row] for row in solved]


def _estimates(one: SolvedRolling) -> list[dict[str, float]]:
    pairs = zip(one.curve.points, one.coarse.points, strict=True)
    return [differences(fine, coarse, one.change) for fine, coarse in pairs]


def _by_change(one: SolvedRolling) -> float:
    """The change of creepages by that of the force by the estimate of C."""
    return one.change["F_x"] / one.curve.slope if one.change else 0.0


_FREE: dict[str, Callable[[SolvedRolling], float]] = {
    "zero_creepage": lambda one: one.curve.zero_creepage,
    "slope": lambda one: one.curve.slope,
    "equal_creepage": lambda one: float(one.curve.equal.creepages.longitudinal),
}
_FREE_ESTIMATES: dict[str, Callable[[SolvedRolling], float]] = {
    "zero_creepage": lambda one: abs(one.curve.zero_creepage - one.coarse.zero_creepage) + _by_change(one),
    "slope": lambda one: abs(one.curve.slope - one.coarse.slope),
    "equal_creepage": lambda one: (
        abs(one.curve.equal.creepages.longitudinal - one.coarse.equal.creepages.longitudinal)
        + _by_change(one)
    ),
}
