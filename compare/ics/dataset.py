"""Results as labelled arrays, written as `ics.nc`, `errors.nc` and one CSV file per line."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from compare.ics.compute import Results, check_of, ics_of, reference_of
from compare.ics.errors import measure_of, refinement_shares_of
from femic.cache.digests import results_digest, versions
from femic.cache.files import replacing
from femic.reference.discount import AXES
from femic.reference.solid.engine import RESIDUAL
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.patches import DIRECTIONS

LOCAL = ("i", "j", "point")
PER_LOAD = {"units": "mm/N"}
PARTS = {  # of `EstimatedICs`: variables of `ics.nc` and their meanings
    "estimate": ("estimate", "estimated error of C"),
    "mesh_error": ("estimate_mesh", "its part from the mesh"),
    "truncation_error": ("estimate_truncation", "its part from the domain"),
    "waves_error": ("estimate_wavenumbers", "its part from the wavenumbers"),
}


def to_dataset(results: Results) -> xr.Dataset:
    """Return all ICs per unit total load after the discount, their estimates, ICs before it, and M.

    `ic` has the dims (variant, body, i, j, point) [mm/N]; the dataset has dims, units and meanings of
    the other variables. ICs that were not computed are NaN.
    """
    bodies, points, references = results.scene.compared, results.points, results.references
    ic = [[ics_of(results, variant, body) for body in bodies] for variant in results.variants]
    raw, m = (
        np.stack([getattr(reference, name) for reference in references.values()])
        for name in ("raw", "discount")
    )
    lines = [np.full(part.stop - part.start, name) for name, part in results.lines.items()]
    return xr.Dataset(
        {
            "ic": (("variant", "body", *LOCAL), np.array(ic), PER_LOAD),
            **_estimates(results),
            "raw": (("solved", *LOCAL), raw, PER_LOAD | {"meaning": "C before the rigid-body discount"}),
            "discount": (("solved", "axis", "axis_"), m, {"units": "mm/N, 1/N, 1/(N mm)"}),
        },
        coords={
            "variant": list(results.variants),
            "body": list(bodies),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
            "solved": list(references),
            "axis": list(AXES),
            "axis_": list(AXES),
            "x": ("point", points.x, {"units": "mm"}),
            "s": ("point", points.s, {"units": "mm"}),
            "line": ("point", np.concatenate(lines)),
        },
        attrs=_attributes(results),
    )


def _estimates(results: Results) -> dict[str, xr.Variable]:
    """Return the estimated error of C, its parts, and the estimate of the other engine's C."""
    c = [reference_of(results, body) for body in results.scene.compared]
    values = {name: ([getattr(one, part) for one in c], meaning) for part, (name, meaning) in PARTS.items()}
    if results.checks:
        checks = [check_of(results, body).estimate for body in results.scene.compared]
        values["estimate_solid"] = checks, "estimated error of C_solid"
    return {
        name: xr.Variable(("body", *LOCAL), np.stack(arrays), PER_LOAD | {"meaning": meaning})
        for name, (arrays, meaning) in values.items()
    }


def _attributes(results: Results) -> dict[str, str | float]:
    scene = results.scene
    models = {
        name: {
            "unknowns": cost.unknowns,
            "solver": cost.solver,
            "seconds": cost.seconds,
            "peak_memory": cost.peak_memory,
        }
        for name, cost in results.models.items()
    }
    return {
        "title": scene.title,
        "scene": scene.text,
        "load_s": scene.patch.s,
        "a": scene.patch.a,
        "b": scene.patch.b,
        "reference_length": scene.reference_length,
        "reference_E": scene.reference_E,
        "rotation_reach": scene.settings.rotation_reach,
        "moment_arm": scene.settings.moment_arm,
        "domain": json.dumps(domains(results)),
        "models": json.dumps(models),
        "seconds": json.dumps({f"{v} {body}": value for (v, body), value in results.seconds.items()}),
        "settings": json.dumps(settings(scene)),
        "versions": json.dumps(versions()),
        "code": results_digest(__name__),
    }


def domains(results: Results) -> dict[str, dict[str, float | None]]:
    """Return sizes of the final model of each solved body [mm].

    `half_length` is None where the model is infinite along x, `rolling_radius` where the body is prismatic,
    `hub_radius` where the model does not reach the hub.
    """
    return {
        name: {
            "far_radius": reference.body.domain.far_radius,
            "half_length": finite(reference.body.xi_end),
            "rolling_radius": finite(reference.body.rolling_radius),
            "hub_radius": reference.body.rolling_radius - reference.body.depth
            if reference.body.reaches_hub
            else None,
            "smallest_cell": reference.cells.smallest,
        }
        for name, reference in results.references.items()
    }


def finite(value: float) -> float | None:
    """Return the value, or None for infinity and NaN, which JSON lacks."""
    return float(value) if np.isfinite(value) else None


def settings(scene: Scene) -> dict[str, float | str]:
    """Return all settings of the reference engine, defaults included."""
    reference_settings, cells, domain = scene.settings, scene.first_cells, scene.bodies["lower"].domain
    solid_settings: dict[str, float | str] = {
        "first line_growth": cells.line_growth,
        "first half_length [mm]": domain.half_length,
        "solver": reference_settings.solver,
        "relative residual": RESIDUAL,
    }
    return {
        "engine": reference_settings.engine.description,
        "tolerance": reference_settings.tolerance,
        "most_unknowns": reference_settings.most_unknowns,
        "first smallest_cell [mm]": cells.smallest,
        "first growth": cells.growth,
        "first far_radius [mm]": domain.far_radius,
        **({} if reference_settings.engine.infinite_length else solid_settings),
        "reference_length [mm]": scene.reference_length,
        "rotation_reach [mm]": reference_settings.rotation_reach,
        "moment_arm [mm]": reference_settings.moment_arm,
    }


ERRORS = {  # variables of `errors.nc`: their dims and meanings
    "error": (
        ("variant", "line", "i", "j"),
        "max |v - C| over the line, share of max |C_ij| (`femic.ic_errors`); of 0.05 max |C_nn| where that "
        "vanishes; C: its estimate",
    ),
    "rms": (("variant", "line", "i", "j"), "root of the mean square over the line, share of the same"),
    "weight": (("variant", "line", "i", "j"), "max |v - C| over the line, share of max |C_nn| there"),
    "vanishes": (("i", "j"), "C_ij vanishes: by symmetry, or below ten times its estimate"),
    "estimate_refinement": (
        ("line", "i", "j"),
        "estimate of C, share of the larger of max |C_ij| and 0.05 max |C_nn| on the line: what refinement "
        "holds against the tolerance",
    ),
}


def errors(results: Results, dataset: xr.Dataset) -> xr.Dataset:
    """Return errors of each variant against C per body, line and component.

    `ERRORS` has their dims and meanings, `femic.ic_errors.error_measure` their definitions. The errors of the
    variant "C" are its estimates.
    """
    bodies = list(results.scene.compared)
    measured = xr.concat(
        [_body_errors(results, dataset.sel(body=body), body) for body in bodies],
        dim=xr.Variable("body", bodies),
    )
    for name, (_, meaning) in ERRORS.items():
        measured[name].attrs = {"meaning": meaning} | ({} if name == "vanishes" else {"units": "1"})
    return measured.assign_attrs(code=results_digest(__name__))


def _body_errors(results: Results, body_dataset: xr.Dataset, body: str) -> xr.Dataset:
    measure, variants = measure_of(results, body), body_dataset.variant.values
    c, estimate = body_dataset.ic.sel(variant="C").values, body_dataset.estimate.values
    deviations = [estimate if v == "C" else body_dataset.ic.sel(variant=v).values - c for v in variants]
    values = {
        "error": [_stacked(measure.shares(deviation)) for deviation in deviations],
        "rms": [_stacked(measure.rms(deviation)) for deviation in deviations],
        "weight": [_stacked(measure.weights(deviation)) for deviation in deviations],
        "vanishes": measure.vanishing,
        "estimate_refinement": _stacked(refinement_shares_of(results, body, estimate)),
    }
    return xr.Dataset(
        {name: (dims, np.asarray(values[name])) for name, (dims, _) in ERRORS.items()},
        coords={
            "variant": variants,
            "line": list(results.lines),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
        },
    )


def _stacked(by_line: Mapping[str, Array]) -> Array:
    """Return values of all lines, (3, 3) each, as one array (line, i, j)."""
    return np.stack(list(by_line.values()))


def write_curves(dataset: xr.Dataset, components: tuple[str, ...], folder: Path) -> None:
    """Write one CSV file per line: x, s [mm] and each plotted curve [mm/N], in columns like C_nn_combined."""
    for line in dict.fromkeys(dataset.line.values):
        on_line = dataset.isel(point=np.flatnonzero(dataset.line.values == line))
        columns = {"x [mm]": on_line.x.values, "s [mm]": on_line.s.values}
        for body in dataset.body.values:
            for component in components:
                curve = on_line.sel(body=body, i=component[0], j=component[1])
                for variant in dataset.variant.values:
                    columns[f"{variant}_{component}_{body} [mm/N]"] = curve.ic.sel(variant=variant).values
                columns[f"estimate_{component}_{body} [mm/N]"] = curve.estimate.values
                if "estimate_solid" in curve:
                    columns[f"estimate_solid_{component}_{body} [mm/N]"] = curve.estimate_solid.values
        name = str(line).replace(" ", "").replace("=", "")
        with replacing(folder / f"curves_{name}.csv") as unfinished:
            np.savetxt(
                unfinished,
                np.column_stack(list(columns.values())),
                delimiter=",",
                header=",".join(columns),
                comments="",
                fmt="%.10g",
            )
