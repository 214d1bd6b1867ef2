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
    """Return the points from s = -reach to +reach [mm], within the contours, at x [mm] from the load.

    Raises WrongInput.
    """
    return checked(LineAlongS, {"along": "s", "x": x, "reach": reach, "points": points})


@with_checked_arguments
def points(x: ArrayLike, s: ArrayLike, name: str = "points") -> OffsetLine:
    """Return arbitrary points: x from the load and arc length s [mm], with shapes that broadcast.

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

    `ics` lists names of approximations and "C"; `components` are names such as "xn", the displacement along x
    under a load along n. The variable `ic` (variant, body, i, j, point) [mm/N] is the displacement i under a
    unit total load j, and NaN if you did not ask for it. C is given after the rigid-body discount, with its
    estimated error `estimate` (body, i, j, point) [mm/N] and further variables that the dataset describes.
    Points have the coordinates x, s [mm] and line.

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

    Variables over (body, variant, line, i, j): `error`, the largest error on the line relative to the
    component (for C, its estimated error); `rms`, the root mean square error; `weight`, the largest error
    relative to C_nn. `vanishes` (body, i, j) tells whether the component is zero; its errors are then
    relative to 0.05 C_nn. docs/theory/errors.md defines the measure. You can also compare the files `ics.nc`
    of `femic run`.

    Raises WrongInput without C, and without nn.
    """
    ics = ics_by_label("ics", ics)
    if "estimate" not in ics and "C" in ics.variant:
        raise WrongInput(
            "ics: the variable estimate (error of C) is missing; give a complete dataset of compute_ics"
        )
    return errors_in(ics)


@dataclass(frozen=True, eq=False)
class FittedPair:
    """A pair with B-hat-prime fitted to C, and the fit.

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
    """Fit B-hat-prime to C under a load on a patch, on lines along x (docs/how-to/calibration.md).

    The `properties` "mismatch_k", "G" or "nu" of the `bodies` "combined", "lower" or "upper" become functions
    of the distance from the load that bring `components` as close to C as possible. With `curvature_apart`,
    the properties of "combined" exclude the curvature of wheels.

    Raises WrongInput, and Failure where C cannot be computed to the tolerance.
    """
    curvature = "apart" if curvature_apart else "contained"
    fit = {"bodies": bodies, "properties": properties, "components": components, "curvature": curvature}
    keys = {"patch": asdict(patch), "bodies": bodies, "calibration": fit}
    calibrated = calibrate(make_scene(pair, options, keys), options.run)
    scene = calibrated.scene
    fitted = replace(pair, effective=scene.effective, curvature_apart=scene.curvature_apart)
    return FittedPair(fitted, fit_dataset(calibrated))
