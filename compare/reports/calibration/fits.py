"""Effective properties of a scene fitted to its C: points, fits, the scene with them."""

import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr

from approx.calibration import Fit, fit
from approx.effective import EffectiveProperties
from approx.pair import Pair
from approx.target import Target, indices
from compare.results.compute import Results, approximated, compute, reference_of, solids
from compare.results.provenance import results_digest
from compare.scenes.checks import calibration_misfits
from compare.scenes.errors import require_none
from compare.scenes.file import SceneFile
from compare.scenes.scene import Scene
from femic.means import DEFAULT, Means
from femic.work.provenance import versions
from geometries.arrays import Array
from geometries.errors import WrongInput

SHOWN = ("nn", "xn", "sn")  # components that the report shows, whatever is fitted
DRAWN = ("A", "B", "Bhat")  # variants that it shows beside B-hat-prime


@dataclass(frozen=True, eq=False)
class Calibrated:
    """A scene with fitted properties, its ICs with them, and what they were fitted to."""

    scene: Scene  # with the fitted properties
    results: Results  # of the scene, on the lines of the calibration, too
    fits: Mapping[str, Fit]  # by body
    targets: Mapping[str, Target]


def calibrate(scene: Scene, means: Means = DEFAULT) -> Calibrated:
    """Compute C at the points of the scene's calibration and on its lines, and fit to it.

    Raises BadScene where the calibration does not fit the scene, NotConverged as `compute`.
    """
    checked(scene)
    asked = replace(
        scene,
        lines=(*scene.lines, *scene.calibration.lines),
        components=tuple(dict.fromkeys((*SHOWN, *scene.calibration.components))),
        variants=("A",),  # the others follow when the fit is there
        check=None,
    )
    results = compute(asked, means)
    means.watch.on_stage("  fitting")
    targets = {body: target_of(results, body) for body in scene.calibration.bodies}
    fits = {body: fit(target, scene.calibration.properties) for body, target in targets.items()}
    results = _with_fits(results, scene, fits)
    return Calibrated(replace(results.scene, lines=scene.lines), results, fits, targets)


def checked(scene: Scene) -> Scene:
    """The scene; raises BadScene, before any work, where its calibration cannot be done."""
    errors = list(calibration_misfits(scene))
    if not errors:
        shape = len(scene.calibration.components), sum(len(line.x) for line in scene.calibration.lines)
        try:
            for body in scene.calibration.bodies:
                target_from(scene, _on_planes(scene, np.ones(shape), body), body)
        except WrongInput as error:
            errors.append(f"calibration: {error}")
    require_none(scene.name, errors)
    return scene


def _on_planes(scene: Scene, ics: Array, body: str) -> Array:
    """ICs as given, but A on planes, where C is A: what vanishes is known before C is."""
    bodies = scene.bodies.values()
    bent = any(np.ptp(one.contour.inclination(np.linspace(*one.s_range, 99))) for one in bodies)
    if bent or any(np.isfinite(one.rolling_radius) for one in bodies):
        return ics
    return target_from(scene, ics, body).by("A")


def target_of(results: Results, body: str) -> Target:
    """C of a body at the points of the scene's calibration, as something to fit to."""
    scene = results.scene
    parts = [results.lines[line.name] for line in scene.calibration.lines]
    points = np.concatenate([np.arange(part.start, part.stop) for part in parts])
    rows, columns = zip(*(indices(component) for component in scene.calibration.components), strict=True)
    c, error = (
        scene.patch.area * getattr(reference_of(results, body), part)[list(rows), list(columns)][:, points]
        for part in ("ic", "estimate")
    )
    return replace(target_from(scene, c, body), error=error)


def target_from(scene: Scene, ics: Array, body: str = "combined") -> Target:
    """ICs (n_components, n) [mm/MPa] at the points of the scene's calibration, known exactly."""
    calibration = scene.calibration
    solid = replace(solids(scene)[body], effective=None)
    if isinstance(solid, Pair):
        solid = replace(solid, curvature_apart=calibration.curvature_apart)
    x, s = (np.concatenate([getattr(line, name) for line in calibration.lines]) for name in ("x", "s"))
    weights = _weights(x, s - scene.patch.s) if calibration.logarithmic else np.ones(len(x))
    return Target(solid, scene.patch, x, s, calibration.components, ics, weights, np.zeros(1))


def _weights(x: Array, s: Array) -> Array:
    """Points at even distances count alike per octave: squares of weights go like 1 / r; 1 at the nearest."""
    r = np.hypot(x, s)
    return np.asarray(np.sqrt(np.min(r) / r))


def _with_fits(results: Results, scene: Scene, fits: Mapping[str, Fit]) -> Results:
    """Results of the scene as it is with the fitted properties."""
    found = {body: one.effective for body, one in fits.items()}
    calibrated = replace(
        results.scene,
        text=with_properties(scene, found, Path()),
        effective={**{name: scene.effective[name] for name in _kept(scene, found)}, **found},
        curvature_apart=scene.calibration.curvature_apart if "combined" in fits else scene.curvature_apart,
        variants=tuple(dict.fromkeys((*scene.variants, *DRAWN, "Bhat_prime"))),
    )
    approximations, seconds = approximated(calibrated, results.points)
    return replace(
        results, scene=calibrated, approximations=approximations, seconds={**results.seconds, **seconds}
    )


def _kept(scene: Scene, fitted: Mapping[str, EffectiveProperties]) -> list[str]:
    """Bodies whose given properties stay: those of both together would outweigh new ones of each."""
    outdone = set(fitted) if "combined" in fitted else {*fitted, "combined"}
    return [name for name in scene.effective if name not in outdone]


def with_properties(scene: Scene, found: Mapping[str, EffectiveProperties], folder: Path) -> str:
    """The text of a scene file with effective properties and B-hat-prime, to be written into a folder."""
    table = tomllib.loads(scene.text)
    listed = table.get("variants", SceneFile.model_fields["variants"].default)
    table["variants"] = list(dict.fromkeys((*listed, "Bhat_prime")))
    given = {name: table["effective"][name] for name in _kept(scene, found)}
    for body, properties in found.items():
        given[body] = properties_table(scene, body, properties)
    for name, file in scene.files.items():
        path = file.resolve()
        relative = os.path.relpath(path, folder.resolve())
        table[name]["contour"]["file"] = str(relative if (folder / relative).is_file() else path)
    table["effective"] = given
    scalars = {key: value for key, value in table.items() if not isinstance(value, dict)}
    return tomlkit.dumps(scalars | table)


def properties_table(scene: Scene, body: str, properties: EffectiveProperties) -> dict[str, Any]:
    """A table [effective.BODY] of a scene file."""
    table: dict[str, Any] = {}
    if body == "combined" and scene.calibration.curvature_apart:
        table["curvature"] = "apart"
    for name in scene.calibration.properties:
        transition = getattr(properties, name)
        table[name] = tomlkit.inline_table()
        for key in ("far", "r_inf", "m", "n"):
            table[name][key] = float(f"{getattr(transition, key):.6g}")
    return table


def to_dataset(calibrated: Calibrated) -> xr.Dataset:
    """The fits with their covariance and residual, and the points, weights and ICs that they are fits of."""
    scene, bodies = calibrated.scene, list(calibrated.fits)
    first = calibrated.targets[bodies[0]]
    names = [parameter.name for parameter in calibrated.fits[bodies[0]].parameters]
    per_body = ("body", "parameter")
    fits, targets = list(calibrated.fits.values()), list(calibrated.targets.values())
    ic = ("body", "component", "point")
    area = scene.patch.area
    return xr.Dataset(
        {
            "value": (
                per_body,
                [[p.value for p in one.parameters] for one in fits],
                {"units": "r_inf: mm, G: MPa"},
            ),
            "covariance": (("body", "parameter", "parameter_"), np.stack([_full(one) for one in fits])),
            "note": (per_body, [[p.note for p in one.parameters] for one in fits]),
            "rms": (
                ("body", "component"),
                np.stack([one.rms for one in fits]),
                {"meaning": "share of max |C|"},
            ),
            "worst": (("body", "component"), np.stack([one.worst for one in fits]), {"meaning": "likewise"}),
            "c": (ic, np.stack([one.ics for one in targets]) / area, {"units": "mm/N"}),
            "estimate": (ic, np.stack([one.error for one in targets]) / area, {"units": "mm/N"}),
            "fitted": (
                ic,
                np.stack(
                    [
                        target.of(calibrated.fits[body].effective)
                        for body, target in calibrated.targets.items()
                    ]
                )
                / area,
                {"units": "mm/N"},
            ),
            "weight": ("point", first.weights),
        },
        coords={
            "body": bodies,
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


def _full(found: Fit) -> Array:
    """Covariance of all parameters, NaN where they were not fitted."""
    fitted = [k for k, parameter in enumerate(found.parameters) if parameter.deviation is not None]
    full = np.full((len(found.parameters),) * 2, np.nan)
    full[np.ix_(fitted, fitted)] = found.covariance
    return full
