"""Errors of ICs on the lines of a scene, and the ICs themselves."""

import numpy as np
import xarray as xr

from compare.campaigns.results.kind import Jobs, ResultKind
from femic.reference.run_options import RunOptions
from femic.results import ics_dataset
from femic.results.ics import Results, compute, jobs, seconds_of
from femic.scenes.scene import Scene

OF_ERRORS = frozenset(
    {"error", "rms", "weight", "vanishes", "estimate_refinement", "variant", "body", "line", "i", "j"}
    | {"unknowns", "model_seconds", "ic_seconds"}
)
OF_ICS = OF_ERRORS | {"ic", "estimate", "point", "on_line", "x", "s"}


def errors(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return the errors of all ICs: `error`, `rms`, `weight` (body, variant, line, i, j), and the cost of C.

    As in `errors.nc`, for the scene's components. `vanishes` is 1 where a component vanishes, else 0.
    """
    return _errors(compute(scene, options))


def ics(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return `errors`, and `ic`, `estimate` [mm/N] at the points `x`, `s` [mm] of the line `on_line`."""
    results = compute(scene, options)
    at_points = ics_dataset.to_dataset(results)[["ic", "estimate"]].reset_coords(["x", "s"]).drop_vars("line")
    on_line = np.concatenate(
        [np.full(part.stop - part.start, float(k)) for k, part in enumerate(results.lines.values())]
    )
    at_points["on_line"] = "point", on_line, {"long_name": "number of the line of a point"}
    return _described(xr.merge([_errors(results), at_points]))


def jobs_on_lines(scene: Scene) -> list[Jobs]:
    """Return the jobs of C on the lines of a scene."""
    return [jobs(scene)]


def _errors(results: Results) -> xr.Dataset:
    """Return errors of the scene's components, NaN for others, and the cost of the models of C."""
    at_points = ics_dataset.to_dataset(results)
    is_compared = xr.zeros_like(at_points.ic.isel(variant=0, body=0, point=0, drop=True), dtype=bool)
    for component in results.scene.components:
        is_compared.loc[{"i": component[0], "j": component[1]}] = True
    compared = ics_dataset.errors(results, at_points)[list(ics_dataset.ERRORS)]
    measured = compared.astype(float, keep_attrs=True).where(is_compared)
    costs = results.models
    seconds = [[results.seconds[v, body] for body in results.scene.compared] for v in results.variants]
    unknowns = float(max(cost.unknowns for cost in costs.values()))
    return _described(measured.drop_attrs(deep=False)).assign(
        unknowns=((), unknowns, {"units": "1", "long_name": "of the largest model"}),
        model_seconds=((), seconds_of(costs), {"units": "s", "long_name": "of all models of C"}),
        ic_seconds=(("variant", "body"), seconds, {"units": "s", "long_name": "seconds of the ICs"}),
    )


def _described(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with meanings as long names."""
    for variable in dataset.variables.values():
        if "meaning" in variable.attrs:
            variable.attrs["long_name"] = variable.attrs.pop("meaning")
    return dataset.drop_attrs(deep=False)


ERRORS = ResultKind(errors, jobs_on_lines, jobs_on_lines, OF_ERRORS)
ICS = ResultKind(ics, jobs_on_lines, jobs_on_lines, OF_ICS)
