"""Results as labelled arrays: `ics.nc`, `errors.nc` and one CSV per line."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from compare.results.compute import Results, check_of, measure_of, reference_of, refinement_shares_of
from compare.results.provenance import results_digest
from compare.scenes.scene import Scene
from femic.discount import AXES
from femic.solid.engine import RESIDUAL
from femic.work.provenance import versions
from geometries.arrays import Array
from geometries.patches import DIRECTIONS


def to_dataset(results: Results) -> xr.Dataset:
    """All ICs per unit total load after the discount, with estimate, raw field and M. NaN: not computed."""
    scene = results.scene
    bodies = list(scene.compared)
    variants = list(results.variants)
    shape = (len(variants), len(bodies), 3, 3, len(results.points.x))
    ic = np.full(shape, np.nan)
    for b, body in enumerate(bodies):
        for v, variant in enumerate(scene.variants):
            ic[v, b] = results.approximations[variant, body]
        ic[-1, b] = reference_of(results, body).ic
        if results.checks:
            ic[-2, b] = check_of(results, body).ic
    dims = ("body", "i", "j", "point")
    solved = list(results.references)
    line = np.concatenate([np.full(p.stop - p.start, name) for name, p in results.lines.items()])
    per_load = {"units": "mm/N"}
    estimate, mesh, truncation, waves = (
        np.stack([getattr(reference_of(results, body), part) for body in bodies])
        for part in ("estimate", "mesh_error", "truncation_error", "waves_error")
    )
    raw = np.stack([results.references[name].raw for name in solved])
    discount = np.stack([results.references[name].discount for name in solved])
    check = {}
    if results.checks:
        known = np.stack([check_of(results, body).estimate for body in bodies])
        check["estimate_solid"] = (dims, known, per_load | {"meaning": "estimated error of C_solid"})
    return xr.Dataset(
        {
            "ic": (("variant", *dims), ic, per_load),
            "estimate": (dims, estimate, per_load | {"meaning": "estimated error of C"}),
            "estimate_mesh": (dims, mesh, per_load | {"meaning": "its part from the mesh"}),
            "estimate_truncation": (dims, truncation, per_load | {"meaning": "its part from the domain"}),
            "estimate_wavenumbers": (dims, waves, per_load | {"meaning": "its part from the wavenumbers"}),
            "raw": (("solved", *dims[1:]), raw, per_load | {"meaning": "C before the rigid-body discount"}),
            "discount": (("solved", "axis", "axis_"), discount, {"units": "mm/N, 1/N, 1/(N mm)"}),
            **check,
        },
        coords={
            "variant": variants,
            "body": bodies,
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
            "solved": solved,
            "axis": list(AXES),
            "axis_": list(AXES),
            "x": ("point", results.points.x, {"units": "mm"}),
            "s": ("point", results.points.s, {"units": "mm"}),
            "line": ("point", line),
        },
        attrs=_attributes(results),
    )


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
        "code": results_digest(),
    }


def domains(results: Results) -> dict[str, dict[str, float | None]]:
    """Shape and final size of each solved body's model [mm]; None: prismatic, no hub, endless along x."""
    return {
        name: {
            "far_radius": found.body.domain.far_radius,
            "half_length": _finite(found.body.xi_end),
            "rolling_radius": _finite(found.body.rolling_radius),
            "hub_radius": found.body.rolling_radius - found.body.depth if found.body.reaches_hub else None,
            "smallest_cell": found.cells.smallest,
        }
        for name, found in results.references.items()
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def settings(scene: Scene) -> dict[str, float | str]:
    """Everything that was set for the reference engine, defaults included."""
    chosen, cells, domain = scene.settings, scene.first_cells, scene.bodies["lower"].domain
    of_engine: dict[str, float | str] = {
        "first line_growth": cells.line_growth,
        "first half_length [mm]": domain.half_length,
        "solver": chosen.solver,
        "relative residual": RESIDUAL,
    }
    return {
        "engine": chosen.engine.describes,
        "tolerance": chosen.tolerance,
        "most_unknowns": chosen.most_unknowns,
        "first smallest_cell [mm]": cells.smallest,
        "first growth": cells.growth,
        "first far_radius [mm]": domain.far_radius,
        **({} if chosen.engine.endless else of_engine),
        "reference_length [mm]": scene.reference_length,
        "rotation_reach [mm]": chosen.rotation_reach,
        "moment_arm [mm]": chosen.moment_arm,
    }


ERRORS = {  # what `errors.nc` has: over which dims, and what they say
    "error": (
        ("variant", "line", "i", "j"),
        "max |v - C| over the line, share of max |C_ij| (`compare.results.measure`); of 0.05 max |C_nn| "
        "where that vanishes; C: its estimate",
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
    """Errors of each variant against C per body, line and component; how they are measured: `ERRORS`.

    The variant "C" carries its estimated error.
    """
    bodies = list(results.scene.compared)
    found = xr.concat(
        [_body_errors(results, dataset.sel(body=body), body) for body in bodies],
        dim=xr.Variable("body", bodies),
    )
    for name, (_, meaning) in ERRORS.items():
        found[name].attrs = {"meaning": meaning} | ({} if name == "vanishes" else {"units": "1"})
    return found.assign_attrs(code=results_digest())


def _body_errors(results: Results, of_body: xr.Dataset, body: str) -> xr.Dataset:
    measure, variants = measure_of(results, body), of_body.variant.values
    c, estimate = of_body.ic.sel(variant="C").values, of_body.estimate.values
    offs = [estimate if v == "C" else of_body.ic.sel(variant=v).values - c for v in variants]
    values = {
        "error": [_stacked(measure.shares(off)) for off in offs],
        "rms": [_stacked(measure.rms(off)) for off in offs],
        "weight": [_stacked(measure.weights(off)) for off in offs],
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


def _stacked(of_lines: Mapping[str, Array]) -> Array:
    """(line, i, j)."""
    return np.stack(list(of_lines.values()))


def write(dataset: xr.Dataset, path: Path) -> None:
    """Write a NetCDF file whole or not at all."""
    temporary = path.with_suffix(".part")
    dataset.to_netcdf(temporary, engine="h5netcdf")
    temporary.replace(path)


def write_curves(dataset: xr.Dataset, components: tuple[str, ...], folder: Path) -> None:
    """One CSV per line: x, s and each plotted curve [mm/N], columns like C_nn_combined."""
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
        np.savetxt(
            folder / f"curves_{name}.csv",
            np.column_stack(list(columns.values())),
            delimiter=",",
            header=",".join(columns),
            comments="",
            fmt="%.10g",
        )
