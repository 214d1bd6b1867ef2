"""Kinds of results that a campaign can keep of each scene; a new one is a function and an entry of `KINDS`.

The dims of a variable depend on the scene's own keys only, and all variables are numbers: places and loads
are variables, because they may differ between scenes. The check with the other engine (`engine.check`) is
left out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import xarray as xr

from compare.campaigns.maps import bhat_for_map, maps_of_scene
from compare.studies.frontier import cheapest, worst_shares
from femic.contact.motions import MOTIONS, find_motion
from femic.contact.motions.rolling import OF_CURVE
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import C, c_jobs, full_ics, normal_ics
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.reference.job import Job
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results import ics_dataset
from femic.results.calibration import calibrate, dimensionless_factor, extended, require_calibration
from femic.results.contact import compute_contact, require_solvable
from femic.results.damage import OF_DAMAGE
from femic.results.friction import compute_with_friction
from femic.results.ics import Results, compute, ics_measure, jobs, reference_ics, solver_seconds
from femic.results.stressed_contact import require_stresses, with_one_contact
from femic.results.stresses import ACTUAL, BODIES, HALF_SPACE, compute_stresses
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.patches import DIRECTIONS

Jobs = Mapping[str, Job] | Mapping[str, MatrixJob]
SHARE = {"units": "1"}


@dataclass(frozen=True)
class ResultKind:
    """A kind of results that a campaign can keep of its scenes."""

    compute: Callable[[Scene, RunOptions], xr.Dataset]
    jobs: Callable[[Scene], list[Jobs]]  # C by body, as far as it is known before the computation
    require: Callable[[Scene], object] = lambda _: None  # raises BadScene where the scene has no such results
    names: frozenset[str] = frozenset()  # of all variables and dims
    seconds: Callable[[Scene], float] = lambda _: 1.0  # besides those of C, roughly


# --- ICs on the lines of a scene ------------------------------------------------------------------------


def errors(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return the errors of all ICs: `error`, `rms`, `weight` (body, variant, line, i, j), and the cost of C.

    As in `errors.nc`, for the scene's components. `vanishes` is 1 where a component vanishes, else 0.
    """
    return _errors(compute(scene, options))


def ics(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return `errors`, and `ic`, `estimate` [mm/N] at the points `x`, `s` [mm] of the line `on_line`."""
    results = compute(scene, options)
    at_points = ics_dataset.to_dataset(results)[["ic", "estimate"]].reset_coords(["x", "s"]).drop_vars("line")
    on_line = [np.full(part.stop - part.start, float(k)) for k, part in enumerate(results.lines.values())]
    at_points["on_line"] = "point", np.concatenate(on_line), {"long_name": "number of the line of a point"}
    return _described(xr.merge([_errors(results), at_points]))


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
        model_seconds=((), solver_seconds(costs), {"units": "s", "long_name": "of all models of C"}),
        ic_seconds=(("variant", "body"), seconds, {"units": "s", "long_name": "seconds of the ICs"}),
    )


def _described(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with meanings as long names."""
    for variable in dataset.variables.values():
        if "meaning" in variable.attrs:
            variable.attrs["long_name"] = variable.attrs.pop("meaning")
    return dataset.drop_attrs(deep=False)


def advice(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return the errors of all ICs, and by body the cheapest ICs that are good enough.

    `known_error` (variant, body) is the worst over lines and components, with the estimate of C. `advised`
    is the number of a variant: of those whose known error is at most the scene's `ics_tolerance` and that
    take less than `AS_CHEAP` times the seconds of the fastest of them, the most accurate one; -1: none is.
    """
    results = compute(scene, options)
    variants, bodies = list(results.variants), list(scene.compared)
    bounds = np.zeros((len(variants), len(bodies)))
    for k, body in enumerate(bodies):
        measure, c = ics_measure(results, body), reference_ics(results, body)
        floor = worst_shares(scene, measure.shares(c.estimate))
        bounds[:, k] = np.max(floor)  # of C
        for v, variant in enumerate(variants):
            if (variant, body) in results.approximations:
                deviation = results.approximations[variant, body] - c.ic
                bounds[v, k] = np.max(worst_shares(scene, measure.shares(deviation)) + floor)
    seconds = np.array([[results.seconds[v, body] for body in bodies] for v in variants])
    advised = [float(cheapest(bounds[:, k], seconds[:, k], scene.ics_tolerance)) for k in range(len(bodies))]
    about = "number of the cheapest variant that is accurate enough; -1: none"
    by = ("variant", "body")
    return xr.Dataset(
        {
            "known_error": (by, bounds, SHARE | {"long_name": "error plus estimated error of C"}),
            "ic_seconds": (by, seconds, {"units": "s", "long_name": "seconds of the ICs"}),
            "advised": ("body", advised, {"long_name": about}),
        },
        coords={"variant": variants, "body": bodies},
    )


def jobs_on_lines(scene: Scene) -> list[Jobs]:
    """Return the jobs of C on the lines of a scene."""
    return [jobs(scene)]


OF_ERRORS = frozenset(
    {"error", "rms", "weight", "vanishes", "estimate_refinement", "variant", "body", "line", "i", "j"}
    | {"unknowns", "model_seconds", "ic_seconds"}
)
ERRORS = ResultKind(errors, jobs_on_lines, jobs_on_lines, OF_ERRORS)
ICS = ResultKind(
    ics, jobs_on_lines, jobs_on_lines, OF_ERRORS | {"ic", "estimate", "point", "on_line", "x", "s"}
)
ADVICE = ResultKind(
    advice, jobs_on_lines, names=frozenset({"variant", "body", "known_error", "ic_seconds", "advised"})
)


# --- fits of B-hat-prime --------------------------------------------------------------------------------


def calibration(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return parameters of B-hat-prime, and its deviations from C beside those of B-hat, by fitted body."""
    calibrated = calibrate(scene, options)
    fits, targets = list(calibrated.fits.values()), list(calibrated.targets.values())
    bhat_worst = [
        np.max(np.abs(target.approximate("Bhat") - target.ics) / target.scales, axis=-1) for target in targets
    ]
    parameters, components = ("fitted_body", "parameter"), ("fitted_body", "fitted_component")
    share = SHARE | {"long_name": "deviation from C, relative to max |C| of the points"}
    about_c = {"units": "1", "long_name": "C at the points of the calibration, without dimension"}
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
                np.stack([dimensionless_factor(scene) * target.ics for target in targets]),
                about_c,
            ),
            "Bhat_worst": (components, np.array(bhat_worst), share),
        },
        coords={
            "fitted_body": list(calibrated.fits),
            "parameter": [parameter.name for parameter in fits[0].parameters],
            "fitted_component": list(scene.calibration.components),
        },
    )


CALIBRATION = ResultKind(
    calibration,
    lambda scene: [jobs(extended(scene))],
    require_calibration,
    frozenset(
        {"fit_value", "fit_rms", "fit_worst", "fit_c", "Bhat_worst"}
        | {"fitted_body", "parameter", "fitted_component", "fit_point"}
    ),
)


# --- C on the grid of a scene ---------------------------------------------------------------------------


MATRICES = {
    "c": "C of both bodies after the discount",
    "c_estimate": "its estimated error",
    "bhat": "B-hat of both bodies",
}
MATRIX_DIMS = ("lag", "observed", "loaded", "i", "j")


def matrix(scene: Scene, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return `c`, `c_estimate`, `bhat` (lag, observed, loaded) [mm/MPa] on the grid: a node of a map of C.

    They are those of nn, which contact without friction needs; with friction of all components (..., i, j),
    with displacements of a wheel as the rail sees them where the scene's motion is rolling. The strips of the
    upper body are opposite those of the lower one. Raises as `femic.reference.matrix.reference.matrices`.
    """
    problem = scene.contact_problem
    on_grid = pair_on_grid(problem, scene.grid)
    if scene.contact.friction:
        rolls = find_motion(scene.contact).wheel_rolls
        ic, estimate = full_ics(problem, on_grid, options, wheel_rolls=rolls)
        directions = {name: list(DIRECTIONS) for name in MATRIX_DIMS[3:]}
    else:
        ic, estimate = normal_ics(problem, on_grid, options)
        directions = {}
    bhat = bhat_for_map(scene, on_grid)
    values: dict[str, Array] = {"c": ic, "c_estimate": estimate.astype(np.float32), "bhat": bhat}
    mm = {"units": "mm"}
    about = {name: {"units": "mm/MPa", "long_name": meaning} for name, meaning in MATRICES.items()}
    return xr.Dataset(
        {name: (MATRIX_DIMS[: value.ndim], value, about[name]) for name, value in values.items()}
        | {
            "lag_x": ("lag", scene.grid.lags, mm | {"long_name": "lag along x"}),
            "observed_s": ("observed", scene.grid.strips, mm | {"long_name": "arc length of a strip"}),
            "loaded_s": ("loaded", scene.grid.strips, mm | {"long_name": "arc length of a strip"}),
        },
        coords=directions,
    )


def _matrix_jobs(scene: Scene) -> list[Jobs]:
    return [c_jobs(scene.contact_problem, pair_on_grid(scene.contact_problem, scene.grid))]


MATRIX = ResultKind(
    matrix,
    _matrix_jobs,
    _matrix_jobs,  # raises where the grid fits to no contact
    frozenset({*MATRIX_DIMS, *MATRICES, "lag_x", "observed_s", "loaded_s"}),
)


# --- contacts -------------------------------------------------------------------------------------------


DISTANCES = ("rms", "largest", "estimate_rms", "estimate_largest")  # between creep-force curves
SECONDS_OF_CONTACT = 0.15  # by element across the patch: 1.2 s with 8, without and with friction
END_OF_CURVE = "_of_curve"  # the end of their names in campaigns: errors have an rms, too
CURVES_LARGEST = f"largest{END_OF_CURVE}"
NUMBERS = {name for motion in MOTIONS.values() for name in motion.quantities} | {*OF_CURVE}
CONTACT_NAMES = frozenset(
    {*NUMBERS, *(f"estimate_{name}" for name in NUMBERS), *(name + END_OF_CURVE for name in DISTANCES)}
    | {"ics", "friction", "load", "simplified", *(motion.dimension for motion in MOTIONS.values())}
)


def contact(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return numbers of the contact with their estimates, as `femic contact` does, without maps of the patch.

    Those without friction have dims `case` (a load or an approach) and `ics`; with friction they are over
    friction, ICs and the dimension of the motion.
    """
    if scene.contact.friction is None:
        solved = compute_contact(scene, options, maps_of_scene(scene))
        return solved[[f"{prefix}{name}" for prefix in ("", "estimate_") for name in OF_FRICTIONLESS]]
    solved = compute_with_friction(scene, options, maps_of_scene(scene))
    solved = solved.rename({name: name + END_OF_CURVE for name in DISTANCES if name in solved})
    numbers = solved[[name for name in solved.data_vars if name in CONTACT_NAMES]]
    return numbers.drop_vars([name for name in numbers.coords if name not in CONTACT_NAMES]).astype(float)


def contact_jobs(scene: Scene) -> list[Jobs]:
    """Return the jobs of C on each grid of the contact; none where C is not among the ICs.

    Approximations size the grids; C may make them longer.
    """
    if C not in scene.contact.ics:
        return []
    problem, maps = scene.contact_problem, maps_of_scene(scene)
    return [c_jobs(problem, pair_on_grid(problem, grid)) for grid, _ in grids_of(problem, maps)]


def contact_seconds(scene: Scene) -> float:
    """Return about how many seconds all contacts of a scene take, besides C."""
    contact, friction = scene.contact, scene.contact.friction
    count = len(contact.ics) * len(contact.loadings)
    if friction is not None:
        count *= len(friction.coefficients)
        count *= len(friction.longitudinal) if contact.motion == "rolling" else 1
    return SECONDS_OF_CONTACT * contact.elements * count


CONTACT = ResultKind(contact, contact_jobs, require_solvable, CONTACT_NAMES, contact_seconds)


# --- stresses under a contact, wear and fatigue ---------------------------------------------------------


SHORT = {"von_mises": "mises", "tresca": "tresca", "principal": "principal", "dang_van": "dang_van"}
WITH_ESTIMATE = ("estimate_", "s_", "depth_")  # before the names of stresses in actual bodies
HALF = "half_space_"  # before the names of stresses in half-spaces
OF_CONTACTS = ("xi", "p_max")  # numbers that `contact` has of all contacts of the scene, under these names
DAMAGE = [name for name in OF_DAMAGE if name not in OF_CONTACTS]
SECONDS_OF_STRESSES = 30.0  # on the lattice in both bodies


def stresses(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return the largest stresses [MPa] on the lattice, as `femic stresses` does, and damage by ICs.

    `mises_BODY`, `tresca_BODY`, `principal_BODY`, for contacts that travel `dang_van_BODY`: actual bodies;
    with their places `s_...` and `depth_...`, estimates `estimate_...`, and those of a half-space under the
    same tractions, `half_space_...`. Of rolling `t_gamma`, `work`, `largest_depth_energy`, ... over `ics`.
    """
    computed = compute_stresses(scene, options)
    numbers = {}
    for name, short in ((name, short) for name, short in SHORT.items() if name in computed):
        for body in BODIES:
            true = computed.sel(body=body, source=ACTUAL)
            numbers[f"{short}_{body}"] = true[name]
            numbers[f"{HALF}{short}_{body}"] = computed[name].sel(body=body, source=HALF_SPACE)
            for prefix in WITH_ESTIMATE:
                if f"{prefix}{name}" in computed:
                    numbers[f"{prefix}{short}_{body}"] = true[f"{prefix}{name}"]
    largest = xr.Dataset({name: values.drop_vars(values.coords) for name, values in numbers.items()})
    if "ics" not in computed.dims:
        return largest
    damage = [f"{prefix}{name}" for name in DAMAGE if name in computed for prefix in ("", "estimate_")]
    return largest.merge(computed[damage])


STRESSES = ResultKind(
    stresses,
    lambda scene: contact_jobs(with_one_contact(scene)),
    require_stresses,
    frozenset(
        {
            f"{prefix}{name}_{body}"
            for prefix in ("", HALF, *WITH_ESTIMATE)
            for name in SHORT.values()
            for body in BODIES
        }
        | {*DAMAGE, *(f"estimate_{name}" for name in DAMAGE), "ics"}
    ),
    lambda scene: SECONDS_OF_STRESSES + contact_seconds(with_one_contact(scene)),
)


# --- the registry ---------------------------------------------------------------------------------------


KINDS: Mapping[str, ResultKind] = MappingProxyType(
    {
        "errors": ERRORS,
        "ics": ICS,
        "contact": CONTACT,
        "stresses": STRESSES,
        "matrix": MATRIX,
        "advice": ADVICE,
        "calibration": CALIBRATION,
    }
)


def merge(parts: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return results of several kinds as one dataset; common variables are from the first kind."""
    joined = xr.Dataset()
    for part in parts.values():
        new = [name for name in part.data_vars if name not in joined.data_vars]
        joined = joined.merge(part[new], join="exact", compat="equals", combine_attrs="override")
    return joined
