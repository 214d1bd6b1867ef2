"""Results as labelled arrays: `ics.nc`, `errors.nc` and one CSV per line."""

import json
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from compare.pipeline import Results, check_of, reference_of, scales_of
from compare.provenance import results_digest
from compare.scenes.scene import Scene
from femic.discount import AXES
from femic.provenance import versions
from femic.solid.engine import RESIDUAL
from geometries.patches import DIRECTIONS

Array = NDArray[np.float64]


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
        "rotation_reach": scene.rotation_reach,
        "moment_arm": scene.moment_arm,
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


ENGINES = {"solid": "solid: quadratic tetrahedra", "harmonic": "harmonic: quartic triangles of the section"}


def settings(scene: Scene) -> dict[str, float | str]:
    """Everything that was set for the reference engine, defaults included."""
    domain = scene.bodies["lower"].domain
    of_engine: dict[str, float | str] = {
        "first line_growth": scene.cells.line_growth,
        "first half_length [mm]": domain.half_length,
        "solver": scene.solver,
        "relative residual": RESIDUAL,
    }
    if scene.engine == "harmonic":
        of_engine = {}
    return {
        "engine": ENGINES[scene.engine],
        "tolerance": scene.tolerance,
        "most_unknowns": scene.most_unknowns,
        "first smallest_cell [mm]": scene.cells.smallest,
        "first growth": scene.cells.growth,
        "first far_radius [mm]": domain.far_radius,
        **of_engine,
        "reference_length [mm]": scene.reference_length,
        "rotation_reach [mm]": scene.rotation_reach,
        "moment_arm [mm]": scene.moment_arm,
    }


def errors(results: Results, dataset: xr.Dataset) -> xr.Dataset:
    """Errors of each variant against C per body, line and component (shares of the line's scale).

    `max` and `rms` refer to the scale of design section 2, `own` to max |C_ij| itself; the variant
    "C" carries its estimated error.
    """
    bodies = list(results.scene.compared)
    per_body = [_body_errors(results, dataset, body) for body in bodies]
    found = xr.concat(per_body, dim=xr.Variable("body", bodies))
    for measure in found.data_vars.values():
        measure.attrs = {"units": "1"}
    return found.assign_attrs(code=results_digest())


def _body_errors(results: Results, dataset: xr.Dataset, body: str) -> xr.Dataset:
    of_body, scales = dataset.sel(body=body), scales_of(results, body)
    per_line = [_line_errors(of_body.isel(point=p), scales[line]) for line, p in results.lines.items()]
    return xr.concat(per_line, dim=xr.Variable("line", list(results.lines)))


def _line_errors(on_line: xr.Dataset, scale_ij: Array) -> xr.Dataset:
    c = on_line.ic.sel(variant="C")
    difference = abs(on_line.ic - c)
    difference = difference.where(on_line.variant != "C", on_line.estimate)
    scale = xr.DataArray(scale_ij, dims=("i", "j"))
    own = abs(c).max("point")
    negligible = own < 1e-9 * scale  # zero by symmetry: it has no share of its own
    return xr.Dataset(
        {
            "max": difference.max("point", skipna=False) / scale,
            "rms": np.sqrt((difference**2).mean("point", skipna=False)) / scale,
            "own": (difference.max("point", skipna=False) / own.where(~negligible)),
        }
    ).drop_vars("line", errors="ignore")


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
