"""B-hat-prime fitted to C of a pair."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import xarray as xr

from femic.interface.arguments import with_checked_arguments
from femic.interface.bodies import Pair
from femic.interface.options import DEFAULT, Options, in_turn, make_scene
from femic.results.calibration import calibrate, to_dataset
from geometries.patches import Patch


@dataclass(frozen=True, eq=False)
class FittedPair:
    """A pair whose B-hat-prime is fitted to C, and the fit.

    Variables of `fit`: `value` (body, parameter) of the effective properties, with `covariance` and `note`;
    `rms` and `worst` (body, component), deviations from C as shares of its largest value; `c`, `estimate` and
    `fitted` (body, component, point) [mm/N], the ICs at the points.
    """

    pair: Pair
    fit: xr.Dataset


@with_checked_arguments
@in_turn
def fit_bhat_prime(
    pair: Pair,
    patch: Patch,
    *,
    bodies: Sequence[str] = ("combined",),
    properties: Sequence[str] = ("mismatch_k",),
    components: Sequence[str] = ("xn",),
    curvature_apart: bool = False,
    options: Options = DEFAULT,
) -> FittedPair:
    """Fit B-hat-prime to C under a load on a patch, at points of lines along x (docs/how-to/calibration.md).

    Of the `bodies` "combined", both together, "lower" or "upper", the `properties` "mismatch_k", "G" or "nu"
    become functions of the distance from the load, such that `components` are as close to C as possible. With
    `curvature_apart` those of "combined" leave out the curvature of wheels.

    Raises WrongInput, and Failure where C cannot be computed to the tolerance.
    """
    curvature = "apart" if curvature_apart else "contained"
    fit = {"bodies": bodies, "properties": properties, "components": components, "curvature": curvature}
    keys = {"patch": asdict(patch), "bodies": bodies, "calibration": fit}
    calibrated = calibrate(make_scene(pair, options, keys), options.run)
    scene = calibrated.scene
    fitted = replace(pair, effective=scene.effective, curvature_apart=scene.curvature_apart)
    return FittedPair(fitted, to_dataset(calibrated))
