"""Fit of effective properties to the C of a scene, and the scene file with them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import tomlkit
import xarray as xr

from approx.calibration import Fit, Target, fit, octave_weights
from approx.effective import EffectiveProperties
from approx.pair import Pair
from femic.cache.digests import results_digest, versions
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results import ics_dataset
from femic.results.ics import Results, compute, line_points, reference_ics, solids, with_approximations
from femic.scenes.calibration import calibration_misfits
from femic.scenes.errors import require_none
from femic.scenes.file import SceneFile
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import places

REPORTED_COMPONENTS = ("nn", "xn", "sn")  # components that every report shows, whichever were fitted
COMPARED_VARIANTS = ("A", "B", "Bhat")  # variants that the report compares with B-hat-prime


@dataclass(frozen=True, eq=False)
class FittedScene:
    """A scene with fitted properties, its ICs on its own lines, the fits and their targets by body.

    `errors` are those of `errors.nc`, the worst over the scene's own lines.
    """

    scene: Scene
    ics: xr.Dataset
    errors: xr.Dataset
    fits: Mapping[str, Fit]
    targets: Mapping[str, Target]


def calibrate(scene: Scene, options: RunOptions = DEFAULT) -> FittedScene:
    """Compute C on the lines of the scene and of its calibration, and fit effective properties to it.

    Raises BadScene if the calibration does not fit the scene, NotConverged as `compute` does.
    """
    require_calibration(scene)
    results, calibration = compute(extended(scene), options), scene.calibration
    options.watch.on_stage("  fitting")
    targets = {body: fit_target(results, body) for body in calibration.bodies}
    fits = {body: fit(target, calibration.properties) for body, target in targets.items()}
    effective = {body: body_fit.effective for body, body_fit in fits.items()}
    remaining = {name: scene.effective[name] for name in _remaining_bodies(scene, effective)}
    calibrated = replace(
        results.scene,
        text=with_properties(scene, effective),
        effective=remaining | effective,
        curvature_apart=calibration.curvature_apart if "combined" in fits else scene.curvature_apart,
        variants=tuple(dict.fromkeys((*scene.variants, *COMPARED_VARIANTS, "Bhat_prime"))),
    )
    ics = ics_dataset.to_dataset(with_approximations(results, calibrated))
    ics = ics.isel(point=np.isin(ics.line.values, [line.name for line in scene.lines]))
    errors = ics_dataset.errors_in(ics)[["error", "weight", "vanishes"]].max("line", skipna=False)
    return FittedScene(replace(calibrated, lines=scene.lines), ics, errors, fits, targets)


def extended(scene: Scene) -> Scene:
    """Return the scene with the lines and components of its calibration, for which C is computed."""
    return replace(
        scene,
        lines=(*scene.lines, *scene.calibration.lines),
        components=tuple(dict.fromkeys((*REPORTED_COMPONENTS, *scene.calibration.components))),
        variants=("A",),  # the other variants are computed after the fit
        check=None,
    )


def require_calibration(scene: Scene) -> None:
    """Raise BadScene, before any computation, if the scene cannot be calibrated.

    Where all bodies are planes C is A: so components that vanish are found before C is computed.
    """
    errors = list(calibration_misfits(scene))
    if not errors:
        shape = len(scene.calibration.components), sum(len(line.x) for line in scene.calibration.lines)
        is_curved = any(
            np.isfinite(body.rolling_radius)
            or np.ptp(body.contour.inclination(np.linspace(*body.s_range, 99)))
            for body in scene.bodies.values()
        )
        try:
            for name in scene.calibration.bodies:
                ics = np.ones(shape)  # [mm/MPa]
                target_from(scene, ics if is_curved else target_from(scene, ics, name).approximate("A"), name)
        except WrongInput as error:
            errors.append(f"calibration: {error}")
    require_none(scene.name, errors)


def fit_target(results: Results, body: str) -> Target:
    """Return the target of a fit: C of a body and its estimate at the points of the scene's calibration."""
    scene = results.scene
    points = line_points(results, scene.calibration.lines)
    fitted = places(scene.calibration.components)
    c, error = (
        scene.patch.area * getattr(reference_ics(results, body), part)[fitted][:, points]
        for part in ("ic", "estimate")
    )
    return replace(target_from(scene, c, body), error=error)


def target_from(scene: Scene, ics: Array, body: str = "combined") -> Target:
    """Return the target of a fit: exact ICs (n_components, n) [mm/MPa] at the points of the calibration."""
    calibration = scene.calibration
    solid = replace(solids(scene)[body], effective=None)
    if isinstance(solid, Pair):
        solid = replace(solid, curvature_apart=calibration.curvature_apart)
    x, s = (np.concatenate([getattr(line, name) for line in calibration.lines]) for name in ("x", "s"))
    weights = octave_weights(np.hypot(x, s - scene.patch.s)) if calibration.logarithmic else np.ones(len(x))
    return Target(solid, scene.patch, x, s, calibration.components, ics, weights, np.zeros(1))


def dimensionless_factor(scene: Scene) -> float:
    """Return the factor that makes ICs per unit pressure dimensionless [MPa/mm]."""
    return scene.reference_E * scene.reference_length / scene.patch.area


def _remaining_bodies(scene: Scene, fitted: Mapping[str, EffectiveProperties]) -> list[str]:
    """Return the bodies whose given properties remain in force.

    Combined properties take precedence over properties of each body, and would hide new ones.
    """
    overruled = set(fitted) if "combined" in fitted else {*fitted, "combined"}
    return [name for name in scene.effective if name not in overruled]


def with_properties(scene: Scene, effective: Mapping[str, EffectiveProperties]) -> str:
    """Return the text of the scene's file, including comments, with effective properties and B-hat-prime."""
    document = tomlkit.parse(scene.text)
    listed = document.get("variants", SceneFile.model_fields["variants"].default)
    document["variants"] = list(dict.fromkeys((*listed, "Bhat_prime")))
    given = {name: document["effective"][name] for name in _remaining_bodies(scene, effective)}
    for body, properties in effective.items():
        given[body] = properties_table(scene, body, properties)
    document.pop("effective", None)
    document["effective"] = given
    return tomlkit.dumps(document)


def properties_table(scene: Scene, body: str, properties: EffectiveProperties) -> dict[str, Any]:
    """Return the table [effective.BODY] of a scene file."""
    table: dict[str, Any] = {}
    if body == "combined" and scene.calibration.curvature_apart:
        table["curvature"] = "apart"
    for name in scene.calibration.properties:
        transition = getattr(properties, name)
        table[name] = tomlkit.inline_table()
        for key in ("far", "r_inf", "m", "n"):
            table[name][key] = float(f"{getattr(transition, key):.6g}")
    return table


def to_dataset(calibrated: FittedScene) -> xr.Dataset:
    """Return the fits with covariances and residuals, and the fitted points, weights and ICs [mm/N].

    `value`, `note` (body, parameter) and `covariance` are those of the parameters; `rms`, `worst` (body,
    component) are residuals as shares of max |C|; `c`, its `estimate` and the `fitted` B-hat-prime (body,
    component, point) are ICs.
    """
    scene, targets, fits = calibrated.scene, calibrated.targets, list(calibrated.fits.values())
    first = next(iter(targets.values()))
    names = [parameter.name for parameter in fits[0].parameters]
    by_parameter, share = ("body", "parameter"), {"meaning": "share of max |C|"}
    values, notes = (
        [[getattr(parameter, key) for parameter in fit.parameters] for fit in fits]
        for key in ("value", "note")
    )
    ics = {
        "c": [target.ics for target in targets.values()],
        "estimate": [target.error for target in targets.values()],
        "fitted": [target.bhat_prime(calibrated.fits[body].effective) for body, target in targets.items()],
    }
    return xr.Dataset(
        {
            "value": (by_parameter, values, {"units": "r_inf: mm, G: MPa"}),
            "note": (by_parameter, notes),
            "covariance": ((*by_parameter, "parameter_"), np.stack([fit.full_covariance for fit in fits])),
            "rms": (("body", "component"), np.stack([fit.rms for fit in fits]), share),
            "worst": (("body", "component"), np.stack([fit.worst for fit in fits]), share),
            **{
                name: (("body", "component", "point"), np.stack(each) / scene.patch.area, {"units": "mm/N"})
                for name, each in ics.items()
            },
            "weight": ("point", first.weights),
        },
        coords={
            "body": list(targets),
            "component": list(first.components),
            "parameter": names,
            "parameter_": names,
            "x": ("point", first.x, {"units": "mm"}),
            "s": ("point", first.s, {"units": "mm"}),
        },
        attrs={
            "title": f"effective properties: {scene.title}",
            "scene": scene.text,
            "curvature": "apart" if scene.calibration.curvature_apart else "contained",
            "code": results_digest(),
            "versions": str(versions()),
        },
    )
