"""Results as labelled arrays, written as `ics.nc`, `errors.nc` and one CSV file per line."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest, versions
from femic.cache.files import replacing
from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.discount import AXES
from femic.reference.run_options import factors
from femic.reference.solid.engine import RESIDUAL
from femic.results.ics import (
    Results,
    approximation,
    check_ics,
    ics_measure,
    reference_ics,
    refinement_shares,
    scene_points,
    select_ics,
)
from femic.scenes.plausibility import warnings
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import DIRECTIONS, Patch

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
    the other variables. ICs that were not computed are NaN. `estimate` is the estimated error of C, with its
    parts, and `estimate_solid` that of C by the other engine.
    """
    bodies, references = results.scene.compared, results.references
    ic = [[select_ics(results, variant, body) for body in bodies] for variant in results.variants]
    raw, m = (
        np.stack([getattr(reference, name) for reference in references.values()])
        for name in ("raw", "discount")
    )
    c = [reference_ics(results, body) for body in bodies]
    estimates = {
        name: ([getattr(each, part) for each in c], meaning) for part, (name, meaning) in PARTS.items()
    }
    if results.checks:
        checks = [check_ics(results, body).estimate for body in bodies]
        estimates["estimate_solid"] = checks, "estimated error of C_solid"
    return xr.Dataset(
        {
            "ic": (("variant", "body", *LOCAL), np.array(ic), PER_LOAD),
            **{
                name: (("body", *LOCAL), np.stack(arrays), PER_LOAD | {"meaning": meaning})
                for name, (arrays, meaning) in estimates.items()
            },
            "raw": (("solved", *LOCAL), raw, PER_LOAD | {"meaning": "C before the rigid-body discount"}),
            "discount": (("solved", "axis", "axis_"), m, {"units": "mm/N, 1/N, 1/(N mm)"}),
        },
        coords=_coordinates(results.scene, results.variants)
        | {"solved": list(references), "axis": list(AXES), "axis_": list(AXES)},
        attrs=_attributes(results),
    )


def approximations_dataset(scene: Scene) -> xr.Dataset:
    """Return the approximations of a scene per unit total load without C, labelled as by `to_dataset`."""
    points, _ = scene_points(scene)
    ic = [
        [approximation(scene, variant, body, points) for body in scene.compared] for variant in scene.variants
    ]
    return xr.Dataset(
        {"ic": (("variant", "body", *LOCAL), np.array(ic), PER_LOAD)},
        coords=_coordinates(scene, scene.variants),
        attrs=_load(scene) | {"versions": json.dumps(versions()), "code": results_digest()},
    )


def _coordinates(scene: Scene, variants: Sequence[str]) -> dict[str, Any]:
    """Return the coordinates of ICs at the points of a scene's lines."""
    points, parts = scene_points(scene)
    lines = [np.full(part.stop - part.start, name) for name, part in parts.items()]
    return {
        "variant": list(variants),
        "body": list(scene.compared),
        "i": list(DIRECTIONS),
        "j": list(DIRECTIONS),
        "x": ("point", points.x, {"units": "mm"}),
        "s": ("point", points.s, {"units": "mm"}),
        "line": ("point", np.concatenate(lines)),
    }


def _load(scene: Scene) -> dict[str, str | float]:
    """Return attributes that describe the scene, its load and the factors that make ICs dimensionless."""
    return {
        "title": scene.title,
        "scene": scene.text,
        "load_s": scene.patch.s,
        "a": scene.patch.a,
        "b": scene.patch.b,
        "reference_length": scene.reference_length,
        "reference_E": scene.reference_E,
    }


def _attributes(results: Results) -> dict[str, str | float]:
    """Return what a page says besides the variables: the scene, its bodies, the models of C, settings.

    JSON: `components`; `bodies` by name, `domain` by solved body, `models` by "BODY, MODEL" (`Cost`),
    `seconds` by "VARIANT BODY", NaN where a variant was not computed; `settings`, `warnings`, `versions`.
    Lengths in mm. In `domain`, `half_length` is None where the model is infinite along x, `rolling_radius`
    where the body is prismatic, `hub_radius` where the model does not reach the hub; `truncated`: far arc or
    ends stand for a body without end, and are not given; the factors are over first cells and first domain.
    """
    scene, settings, cells = results.scene, results.scene.settings, results.scene.first_cells
    bodies = {
        name: {
            "E": body.material.E,
            "nu": body.material.nu,
            "rolling_radius": finite(body.rolling_radius),
            "hub_radius": body.rolling_radius - body.depth if body.reaches_hub else None,
            "has_outline": body.outline is not None,
            "far_radius_given": body.domain.radius_given,
            "joints": [float(s) for s in body.contour.joints],
            "symmetric": bool(body.contour.symmetric),
        }
        for name, body in scene.bodies.items()
    }
    domain = {}
    for name, reference in results.references.items():
        body, (cells_factor, domain_factor) = reference.body, factors(reference.level)
        domain[name] = {
            "far_radius": body.domain.far_radius,
            "half_length": finite(body.xi_end),
            "closed": body.closed,
            "truncated": body.truncated,
            "rolling_radius": finite(body.rolling_radius),
            "hub_radius": body.rolling_radius - body.depth if body.reaches_hub else None,
            "smallest_cell": reference.cells.smallest,
            "cells_factor": cells_factor,
            "domain_factor": domain_factor,
        }
    first = scene.bodies["lower"].domain
    solid_settings: dict[str, float | str] = {
        "first line_growth": cells.line_growth,
        "half_length [mm]" if first.length_given else "first half_length [mm]": first.half_length,
        "solver": settings.solver,
        "relative residual": RESIDUAL,
    }
    engine_settings = {  # defaults included
        "engine": settings.engine.description,
        "tolerance": settings.tolerance,
        "most_unknowns": settings.most_unknowns,
        "first smallest_cell [mm]": cells.smallest,
        "first growth": cells.growth,
        "far_radius [mm]" if first.radius_given else "first far_radius [mm]": first.far_radius,
        **({} if settings.engine.infinite_length else solid_settings),
        "reference_length [mm]": scene.reference_length,
        "rotation_reach [mm]": settings.rotation_reach,
        "moment_arm [mm]": settings.moment_arm,
    }
    return _load(scene) | {
        "components": json.dumps(scene.components),
        "bodies": json.dumps(bodies),
        "infinite_length": int(settings.engine.infinite_length),
        "rotation_reach": settings.rotation_reach,
        "moment_arm": settings.moment_arm,
        "domain": json.dumps(domain),
        "models": json.dumps({name: asdict(cost) for name, cost in results.models.items()}),
        "seconds": json.dumps({f"{v} {body}": value for (v, body), value in results.seconds.items()}),
        "settings": json.dumps(engine_settings),
        "warnings": json.dumps(list(warnings(scene))),
        "versions": json.dumps(versions()),
        "code": results_digest(),
    }


def finite(value: float) -> float | None:
    """Return the value, or None for infinity and NaN, which JSON lacks."""
    return float(value) if np.isfinite(value) else None


BY_LINE = ("line", "i", "j")
ERRORS = {  # variables of `errors.nc`: their dims besides the body, and meanings
    "error": (
        ("variant", *BY_LINE),
        "max |v - C| over the line, relative to max |C_ij| (`femic.ic_errors`), or to 0.05 max |C_nn| "
        "where C_ij vanishes; for C: its estimated error",
    ),
    "rms": (("variant", *BY_LINE), "root mean square over the line, relative to the same"),
    "weight": (("variant", *BY_LINE), "max |v - C| over the line, relative to max |C_nn| there"),
    "vanishes": (("i", "j"), "C_ij vanishes by symmetry, or is smaller than ten times its estimated error"),
    "estimate_refinement": (
        BY_LINE,
        "estimated error of C, relative to the larger of max |C_ij| and 0.05 max |C_nn| on the line; "
        "refinement compares it with the tolerance",
    ),
}
ACCURACY_OF_C = {  # further ones, of C with its check and of each solved body: all dims, and meanings
    "estimate_both": (
        ("body", *BY_LINE),
        "sum of the estimated errors of C and C_solid, relative as for error",
    ),
    "solved_error": (("solved", *BY_LINE), "estimate of C of a solved body, share as of error"),
    "solved_vanishes": (("solved", "i", "j"), ERRORS["vanishes"][1]),
    "solved_refinement": (
        ("solved", "part", *BY_LINE),
        f"{ERRORS['estimate_refinement'][1]}; and its parts",
    ),
}
PARTS_OF_ACCURACY = {
    "all": "estimate",
    "mesh": "mesh_error",
    "domain": "truncation_error",
    "wavenumbers": "waves_error",
}


def errors(results: Results, dataset: xr.Dataset) -> xr.Dataset:
    """Return errors of each variant against C per body, line and component, and the accuracy of C.

    `ERRORS` and `ACCURACY_OF_C` have dims and meanings, `femic.ic_errors.error_measure` the definitions.
    The errors of the variant "C" are its estimates, those of "C_solid" differences between both engines.
    """
    bodies = results.scene.compared
    measures = {body: ics_measure(results, body) for body in bodies}
    refinement = [
        _stack(refinement_shares(results, body, dataset.estimate.sel(body=body).values)) for body in bodies
    ]
    measured = _measured(dataset, measures).assign(
        estimate_refinement=(("body", *BY_LINE), np.stack(refinement))
    )
    if "estimate_solid" in dataset:
        both = (dataset.estimate + dataset.estimate_solid).transpose("body", *LOCAL).values
        shares = [_stack(measures[body].shares(each)) for body, each in zip(bodies, both, strict=True)]
        measured["estimate_both"] = ACCURACY_OF_C["estimate_both"][0], np.stack(shares)
    solved = {
        name: (ics_measure(results, name), reference.c) for name, reference in results.references.items()
    }
    values = {
        "solved_error": [_stack(measure.shares(c.estimate)) for measure, c in solved.values()],
        "solved_vanishes": [measure.vanishing for measure, _ in solved.values()],
        "solved_refinement": [
            [
                _stack(refinement_shares(results, name, getattr(c, part)))
                for part in PARTS_OF_ACCURACY.values()
            ]
            for name, (_, c) in solved.items()
        ],
    }
    measured = measured.assign_coords(solved=list(solved), part=list(PARTS_OF_ACCURACY)).assign(
        {name: (ACCURACY_OF_C[name][0], np.array(value)) for name, value in values.items()}
    )
    return _describe(measured)


def errors_in(dataset: xr.Dataset) -> xr.Dataset:
    """Return errors as `errors` does from labelled ICs alone, without those on the scale of refinement.

    Raises WrongInput for a dataset that has no C, and neither C_nn nor A_nn.
    """
    if "C" not in dataset.variant:
        raise WrongInput("ics: the comparison needs C; compute it as well")
    line_names = dataset.line.values
    indices = {str(line): np.flatnonzero(line_names == line) for line in dict.fromkeys(line_names)}
    lines = {line: slice(points[0], points[-1] + 1) for line, points in indices.items()}
    patch = Patch(dataset.a, dataset.b, dataset.load_s)
    far = far_from(patch, dataset.x.values, dataset.s.values)
    measures = {}
    for body in dataset.body.values:
        own = dataset.sel(body=body)
        nn = own.ic.sel(i="n", j="n")
        known = [one for one in ("C", "A") if one in nn.variant and not np.any(nn.sel(variant=one).isnull())]
        if not known:
            raise WrongInput("ics: the error measure needs C_nn or A_nn; compute the component nn, or A")
        c, scale = own.ic.sel(variant="C").values, nn.sel(variant=known[0]).values
        measures[str(body)] = Measure(c, own.estimate.values, scale, lines, far)
    return _describe(_measured(dataset, measures))


def _measured(dataset: xr.Dataset, measures: Mapping[str, Measure]) -> xr.Dataset:
    """Return the errors of all variants by body; those of C are its estimates."""
    bodies = []
    for body, measure in measures.items():
        ic, estimate = dataset.ic.sel(body=body), dataset.estimate.sel(body=body)
        deviations = (ic - ic.sel(variant="C", drop=True)).where(ic.variant != "C", estimate).values
        values = {
            "error": _stack(measure.shares(deviations)),
            "rms": _stack(measure.rms(deviations)),
            "weight": _stack(measure.weights(deviations)),
            "vanishes": measure.vanishing,
        }
        coordinates = {"line": list(measure.lines), "i": list(DIRECTIONS), "j": list(DIRECTIONS)}
        bodies.append(
            xr.Dataset(
                {name: (ERRORS[name][0], value) for name, value in values.items()},
                coords={"variant": ic.variant.values} | coordinates,
            )
        )
    return xr.concat(bodies, dim=xr.Variable("body", list(measures)))


def _describe(measured: xr.Dataset) -> xr.Dataset:
    """Return errors with their meanings."""
    for name, (_, meaning) in (ERRORS | ACCURACY_OF_C).items():
        if name in measured:
            is_share = measured[name].dtype != bool
            measured[name].attrs = {"meaning": meaning} | ({"units": "1"} if is_share else {})
    return measured.assign_attrs(code=results_digest())


def _stack(by_line: Mapping[str, Array]) -> Array:
    """Return values of all lines, (..., 3, 3) each, as one array (..., line, i, j)."""
    return np.stack(list(by_line.values()), axis=-3)


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
        table = xr.Dataset({name: ("point", values) for name, values in columns.items()}).to_pandas()
        with replacing(folder / curves_file(str(line))) as unfinished:
            table.to_csv(unfinished, index=False, float_format="%.10g", na_rep="nan")


def curves_file(line: str) -> str:
    """Return the name of the CSV file of a line's curves."""
    return f"curves_{line.replace(' ', '').replace('=', '')}.csv"
