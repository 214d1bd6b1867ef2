"""What is kept of a scene of a campaign, by name: a function of the scene that gives a dataset of numbers.

No variable has dims that depend on more than the scene's own keys, and all are numbers: places and loads are
variables, because they may differ between scenes. The check by the other engine (`engine.check`) is left out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from compare.calibration.compute import Calibrated, calibrate, extended, require_calibration, unit_of
from compare.contact.compute import C, c_jobs, cases_of, compute_contact, grids_of
from compare.contact.dataset import to_dataset as contact_dataset
from compare.contact.pair_on_grid import placed_on
from compare.contact.quantities import QUANTITIES
from compare.friction.compression import compute_compression
from compare.friction.displaced import PREFIX
from compare.friction.quantities import OF_PATCH, OF_ROLLING
from compare.friction.rolling import OF_FREE, compute_rolling
from compare.ics import dataset as of_points
from compare.ics.compute import Results, compute, jobs, reference_of, seconds_of
from compare.ics.errors import measure_of
from femic.campaigns.maps.node import OF_NODE, node
from femic.reference.accuracy import component_of
from femic.reference.job import Job
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import RunOptions
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene
from geometries.arrays import Array

OF_CURVES = ("rms", "largest", "estimate_rms", "estimate_largest")  # distances of creep-force curves
OF_CURVE = "_of_curve"  # the end of their names in campaigns: errors have an rms, too
CURVES_LARGEST = f"largest{OF_CURVE}"
AS_CHEAP = 3.0  # times the fastest good ICs' seconds: faster ones count as equally cheap, as clocks vary
COSTS = ("unknowns", "model_seconds", "ic_seconds")
OF_ERRORS = ("error", "rms", "weight", "vanishes", "estimate_refinement")
SHARE = {"units": "1"}

Jobs = Mapping[str, Job] | Mapping[str, MatrixJob]


@dataclass(frozen=True)
class Keeper:
    """How something is kept of a scene."""

    of: Callable[[Scene, RunOptions], xr.Dataset]
    jobs: Callable[[Scene], list[Jobs]]  # what is solved for it as far as it is known before, by body
    require: Callable[[Scene], object] = lambda _: None  # raises BadScene where the scene does not have it
    names: frozenset[str] = frozenset()  # of all variables and dims


def kept_errors(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Errors of all ICs against C: `error`, `rms`, `weight` (body, variant, line, i, j) and what C took.

    They are those of `errors.nc`, of the scene's components. `vanishes` is 1 where a component does, else 0.
    """
    return _errors(compute(scene, options))


def kept_ics(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Errors as of `kept_errors`, and `ic`, `estimate` [mm/N] at the points `x`, `s` [mm] of `on_line`."""
    results = compute(scene, options)
    ics = of_points.to_dataset(results)
    on_line = np.concatenate(
        [np.full(part.stop - part.start, float(k)) for k, part in enumerate(results.lines.values())]
    )
    at_points = ics[["ic", "estimate"]].reset_coords(["x", "s"]).drop_vars("line")
    at_points["on_line"] = "point", on_line, {"long_name": "number of the line of a point"}
    return _described(xr.merge([_errors(results), at_points]))


def kept_contact(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Numbers of the contact with their estimates: without friction (case, ics), else as `femic contact`.

    Those with friction are by friction, ICs and load or creepage; maps over the patch are not kept.
    """
    if scene.contact.friction is None:
        solved = contact_dataset(compute_contact(scene, options))
        names = [f"{prefix}{name}" for prefix in ("", "estimate_") for name in QUANTITIES]
        return solved[names].assign_coords(case=np.arange(solved.sizes["case"], dtype=float))
    computed = {"rolling": compute_rolling, "compression": compute_compression}[scene.contact.motion]
    solved = computed(scene, options).drop_vars(["C_seconds", "seconds"], errors="ignore")
    numbers = [
        name
        for name, variable in solved.data_vars.items()
        if not ({"x", "s"} & set(variable.dims) or str(name).startswith(PREFIX))
    ]
    numbers_only = solved[numbers].drop_vars(["x", "s", "direction", "tangential"], errors="ignore")
    distances = {name: name + OF_CURVE for name in OF_CURVES if name in numbers}
    return numbers_only.astype(float).rename(distances)


def kept_advice(scene: Scene, options: RunOptions) -> xr.Dataset:
    """The errors of all ICs, and which are the cheapest that are good enough, by body.

    `known_error` (variant, body) is the worst over lines and components, with the estimate of C. `advised`
    is the number of the variant: of those whose known error is at most the scene's `ics_tolerance` and that
    take less than `AS_CHEAP` times the seconds of the fastest of them, the most accurate one; -1: none is.
    """
    results = compute(scene, options)
    variants = list(results.variants)
    known = np.array([_known(results, body) for body in scene.compared]).T
    seconds = np.array([[results.seconds[v, body] for body in scene.compared] for v in variants])
    advised = [_cheapest(known[:, k], seconds[:, k], scene.ics_tolerance) for k in range(len(scene.compared))]
    return xr.Dataset(
        {
            "known_error": (("variant", "body"), known, SHARE | {"long_name": "error and estimate of C"}),
            "ic_seconds": (("variant", "body"), seconds, {"units": "s", "long_name": "seconds of the ICs"}),
            "advised": (
                "body",
                np.array(advised, dtype=float),
                {"long_name": "number of the variant that is good enough and cheap; -1: none"},
            ),
        },
        coords={"variant": variants, "body": list(scene.compared)},
    )


def kept_calibration(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Fitted parameters of B-hat-prime, and its deviations from C beside those of B-hat, by fitted body."""
    calibrated = calibrate(scene, options)
    fits = list(calibrated.fits.values())
    parameters, components = ("fitted_body", "parameter"), ("fitted_body", "fitted_component")
    share = SHARE | {"long_name": "deviation from C, share of max |C| of the points"}
    return xr.Dataset(
        {
            "fit_value": (
                parameters,
                [[parameter.value for parameter in fit.parameters] for fit in fits],
                {"long_name": "fitted parameters; r_inf in mm, G in MPa"},
            ),
            "fit_rms": (components, np.stack([fit.rms for fit in fits]), share),
            "fit_worst": (components, np.stack([fit.worst for fit in fits]), share),
            "fit_c": (
                (*components, "fit_point"),
                np.stack([unit_of(scene) * target.ics for target in calibrated.targets.values()]),
                {"units": "1", "long_name": "C at the points of the calibration, without dimension"},
            ),
            "Bhat_worst": (components, _worst_of_bhat(calibrated), share),
        },
        coords={
            "fitted_body": list(calibrated.fits),
            "parameter": [parameter.name for parameter in fits[0].parameters],
            "fitted_component": list(scene.calibration.components),
        },
    )


def _errors(results: Results) -> xr.Dataset:
    """Errors of the components that the scene asks for, NaN of others, and what the models of C took."""
    ics = of_points.to_dataset(results)
    asked = xr.zeros_like(ics.ic.isel(variant=0, body=0, point=0, drop=True), dtype=bool)
    for component in results.scene.components:
        asked.loc[{"i": component[0], "j": component[1]}] = True
    errors = of_points.errors(results, ics).astype(float, keep_attrs=True).where(asked)
    costs = results.models
    errors["unknowns"] = (), float(max(cost.unknowns for cost in costs.values()))
    errors["unknowns"].attrs = {"units": "1", "long_name": "of the largest model"}
    errors["model_seconds"] = (), seconds_of(costs), {"units": "s", "long_name": "of all models of C"}
    seconds = [[results.seconds[v, body] for body in results.scene.compared] for v in results.variants]
    errors["ic_seconds"] = ("variant", "body"), seconds, {"units": "s", "long_name": "seconds of the ICs"}
    return _described(errors.drop_attrs(deep=False))


def _described(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with meanings as long names."""
    for variable in dataset.variables.values():
        if "meaning" in variable.attrs:
            variable.attrs["long_name"] = variable.attrs.pop("meaning")
    return dataset.drop_attrs(deep=False)


def _known(results: Results, body: str) -> list[float]:
    """Bounds of the errors of all ICs of a body, the worst over lines and components; C: its estimate."""
    measure, c = measure_of(results, body), reference_of(results, body)
    floor = _worst(results, measure.shares(c.estimate))
    bounds = {
        variant: _worst(results, measure.shares(ics - c.ic)) + floor
        for (variant, of_body), ics in results.approximations.items()
        if of_body == body
    }
    return [float(np.max(bounds.get(variant, floor))) for variant in results.variants]


def _worst(results: Results, shares: Mapping[str, Array]) -> Array:
    """The largest share over the lines by component of the scene, (n_components,)."""
    largest = np.max(list(shares.values()), axis=0)
    return np.array([component_of(largest, component) for component in results.scene.components])


def _cheapest(known: Array, seconds: Array, tolerance: float) -> int:
    """The number of the cheapest ICs that are good enough, -1 where none are."""
    good = np.flatnonzero(known <= tolerance)
    if not good.size:
        return -1
    cheap = good[seconds[good] <= AS_CHEAP * np.min(seconds[good])]
    return int(cheap[np.argmin(known[cheap])])


def _worst_of_bhat(calibrated: Calibrated) -> Array:
    """Largest deviations of B-hat from C by fitted body and component."""
    deviations = [
        np.abs(target.approximate("Bhat") - target.ics) / target.scales
        for target in calibrated.targets.values()
    ]
    return np.array([np.max(deviation, axis=-1) for deviation in deviations])


def _on_lines(scene: Scene) -> list[Jobs]:
    """The jobs of C on the lines of a scene."""
    return [jobs(scene)]


def _matrix_jobs(scene: Scene) -> dict[str, MatrixJob]:
    """The jobs of C on the scene's grid, for contact without friction."""
    return c_jobs(scene, placed_on(scene, scene.grid))


def _require_frictionless(scene: Scene) -> None:
    """Raise BadScene with friction: maps of C know nn only."""
    if scene.contact.friction is not None:
        raise BadScene(
            f'{scene.name}: contact.motion = {scene.contact.motion!r}: "matrix" keeps C_nn, for contact '
            "without friction; leave the motion out"
        )
    _matrix_jobs(scene)


def _contact_jobs(scene: Scene) -> list[Jobs]:
    """The jobs of C on each grid of the contact; none where no C is wanted.

    Grids that follow from the contact are found by approximations; C may make them longer.
    """
    if C not in scene.contact.ics:
        return []
    return [c_jobs(scene, placed_on(scene, grid)) for grid, _ in grids_of(scene)]


def _names_of_contact() -> frozenset[str]:
    """The names in all that is kept of contacts, without friction or with it."""
    numbers = {*QUANTITIES, *OF_PATCH, *OF_ROLLING, *OF_FREE}
    return frozenset({*numbers, *(f"estimate_{name}" for name in numbers), *OF_CONTACT})


OF_CONTACT = ("case", "ics", "friction", "load", "xi", *(name + OF_CURVE for name in OF_CURVES), "simplified")
ON_LINES = frozenset({*OF_ERRORS, *("variant", "body", "line", "i", "j"), *COSTS})
AT_POINTS = ON_LINES | {"ic", "estimate", "point", "on_line", "x", "s"}
OF_ADVICE = frozenset({"variant", "body", "known_error", "ic_seconds", "advised"})
OF_FITS = frozenset(
    {"fit_value", "fit_rms", "fit_worst", "fit_c", "Bhat_worst"}
    | {"fitted_body", "parameter", "fitted_component", "fit_point"}
)

KEEPERS: Mapping[str, Keeper] = MappingProxyType(
    {
        "errors": Keeper(kept_errors, _on_lines, names=ON_LINES),
        "ics": Keeper(kept_ics, _on_lines, names=AT_POINTS),
        "contact": Keeper(kept_contact, _contact_jobs, cases_of, _names_of_contact()),
        "matrix": Keeper(node, lambda scene: [_matrix_jobs(scene)], _require_frictionless, OF_NODE),
        "advice": Keeper(kept_advice, _on_lines, names=OF_ADVICE),
        "calibration": Keeper(
            kept_calibration, lambda scene: [jobs(extended(scene))], require_calibration, OF_FITS
        ),
    }
)


def kept_together(parts: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """What is kept of a scene, as one dataset; variables that several parts have are those of the first."""
    joined = xr.Dataset()
    for part in parts.values():
        new = [name for name in part.data_vars if name not in joined.data_vars]
        joined = joined.merge(part[new], **_EXACT)
    return joined


_EXACT: dict[str, Any] = {"join": "exact", "compat": "equals", "combine_attrs": "override"}
