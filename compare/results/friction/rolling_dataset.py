"""The labelled arrays of rolling, `contact.nc`: creep-force curves, tractions at equal force."""

import xarray as xr

from compare.results.contact.compute import reference_name
from compare.results.friction.dataset import attributes, differences, maps, tables
from compare.results.friction.quantities import OF_ROLLING, Described
from compare.results.friction.rolling import Curve, RollingResults, SolvedRolling

BY_ICS = ("friction", "ics")
OF_FREE = {  # what describes a curve, besides its points
    "zero_creepage": Described("1", "creepage without longitudinal force"),
    "slope": Described("N", "derivative of the longitudinal force by the creepage there"),
    "equal_creepage": Described("1", "creepage at the force at which tractions are compared"),
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
    free = [[_free_numbers(one.curve) for one in row] for row in solved]
    estimates = [[_free_estimates(one) for one in row] for row in solved]
    dataset = dataset.assign(tables(OF_FREE, BY_ICS, {"": free, "estimate_": estimates}))
    dataset["seconds"] = BY_ICS, [[one.seconds for one in row] for row in solved], {"units": "s"}
    dataset.attrs |= {"load": solver.scene.contact.loads[0], "equal_force": solver.wanted.equal_force}
    dataset["rms"] = _rms(dataset)
    return dataset.merge(maps(solver, [[one.curve.equal.contact for one in row] for row in solved]))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """The longitudinal force, or what goes with it, over friction times load."""
    return dataset[name].drop_attrs() / (dataset.friction * dataset.attrs["load"])


def _rms(dataset: xr.Dataset) -> xr.DataArray:
    """Root mean square distance of curves to the reference's, over friction times load."""
    force = scaled_force(dataset)
    reference = force.sel(ics=reference_name([str(name) for name in dataset.ics.values]))
    away = ((force - reference) ** 2).mean("xi") ** 0.5
    return away.assign_attrs(
        units="1", long_name="root mean square distance to the reference's curve over friction times load"
    )


def _estimates(one: SolvedRolling) -> list[dict[str, float]]:
    fine = one.curve.points
    coarse = one.coarse.points if one.coarse else [None] * len(fine)
    return [differences(*of_both, one.change) for of_both in zip(fine, coarse, strict=True)]


def _free_numbers(curve: Curve) -> dict[str, float]:
    """What `OF_FREE` names."""
    equal = float(curve.equal.creepages.longitudinal)
    return {"zero_creepage": curve.zero_creepage, "slope": curve.slope, "equal_creepage": equal}


def _free_estimates(one: SolvedRolling) -> dict[str, float]:
    """Creepages are changed by the estimate of C as forces are."""
    by_change = one.change["F_x"] / one.curve.slope if one.change else 0.0
    change = {"zero_creepage": by_change, "slope": 0.0, "equal_creepage": by_change}
    coarse = _free_numbers(one.coarse) if one.coarse else None
    return differences(_free_numbers(one.curve), coarse, change)
