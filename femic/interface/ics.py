"""ICs at points: C with its estimate, approximations, and their errors."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import xarray as xr
from numpy.typing import ArrayLike

from approx.halfspace import observers
from approx.variants import VARIANTS
from femic.interface.arguments import array, with_checked_arguments
from femic.interface.bodies import Pair, checked
from femic.interface.labels import ics_by_label
from femic.interface.options import DEFAULT, Line, Options, in_turn, make_scene
from femic.results.calibration import calibrate
from femic.results.calibration import to_dataset as fit_dataset
from femic.results.ics import compute
from femic.results.ics_dataset import approximations_dataset, errors_in, to_dataset
from femic.scenes.lines import LineAlongS, LineAlongX
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS, OffsetLine, Patch

BODIES = ("combined", "lower", "upper")
ICS = ("A", "B", "Bbar", "Bhat", "mix", "C")


@with_checked_arguments
def line_along_x(s: float, reach: float = 25.0, points: int = 401) -> LineAlongX:
    """Return the points from x = -reach to +reach [mm] at arc length s [mm]. Raises WrongInput."""
    return checked(LineAlongX, {"along": "x", "s": s, "reach": reach, "points": points})


@with_checked_arguments
def line_along_s(x: float, reach: float = 25.0, points: int = 401) -> LineAlongS:
    """Return the points from s = -reach to +reach [mm], as far as contours go, at x [mm] from the load.

    Raises WrongInput.
    """
    return checked(LineAlongS, {"along": "s", "x": x, "reach": reach, "points": points})


@with_checked_arguments
def points(x: ArrayLike, s: ArrayLike, name: str = "points") -> OffsetLine:
    """Return points of any kind: at x from the load and at arc length s [mm], of shapes that broadcast.

    Raises WrongInput for points that are not finite numbers.
    """
    x, s = (values.ravel() for values in observers(array("x", x), array("s", s)))
    return OffsetLine(name, "s", x, s)


@with_checked_arguments
@in_turn
def compute_ics(
    pair: Pair,
    patch: Patch,
    lines: Sequence[Line],
    ics: Sequence[str] = ICS,
    *,
    bodies: Sequence[str] = BODIES,
    components: Sequence[str] = COMPONENTS,
    options: Options = DEFAULT,
) -> xr.Dataset:
    """Compute ICs under a load on a patch at the points of lines.

    `ics` are names of approximations and "C", `components` such as "xn", the displacement along x under a
    load along n. The variable `ic` (variant, body, i, j, point) [mm/N] is the displacement i under a unit
    total load j, NaN where it was not asked for. With C, after the rigid-body discount, come its estimated
    error `estimate` (body, i, j, point) [mm/N] and more, which the dataset describes. Points have the
    coordinates x, s [mm] and line.

    Raises WrongInput, and Failure where C cannot be computed to the tolerance.
    """
    for k, name in enumerate(ics):
        if name not in (*VARIANTS, "C"):
            raise WrongInput(f"ics[{k}] = {name!r}: give one of {', '.join(VARIANTS)}, C")
        if name in ics[:k]:
            raise WrongInput(f"ics = {list(ics)}: {name} given twice: name each once")
    variants = [name for name in ics if name != "C"]
    keys = {"patch": asdict(patch), "variants": variants or ["A"], "bodies": bodies, "components": components}
    scene = make_scene(pair, options, keys, lines=lines)
    if "C" not in ics:
        return approximations_dataset(scene)
    dataset = to_dataset(compute(scene, options.run))
    return dataset.sel(variant=list(ics))


@with_checked_arguments
def compare_ics(ics: xr.Dataset) -> xr.Dataset:
    """Compare approximations with C: return their errors on the lines of a dataset of `compute_ics`.

    Variables over (body, variant, line, i, j): `error`, the largest on the line as a share of the component,
    of C the estimated one; `rms`, its root mean square; `weight`, the largest as a share of C_nn; `vanishes`
    (body, i, j), whether the component is zero, and errors are shares of 0.05 C_nn. docs/theory/errors.md
    defines the measure. Files `ics.nc` of `femic run` may be compared, too.

    Raises WrongInput without C, and without nn.
    """
    ics = ics_by_label("ics", ics)
    if "estimate" not in ics and "C" in ics.variant:
        raise WrongInput("ics: no variable estimate, the error of C: give a whole dataset of compute_ics")
    return errors_in(ics)


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
    return FittedPair(fitted, fit_dataset(calibrated))
