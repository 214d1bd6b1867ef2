"""Makes the self-contained HTML report of a scene."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from compare.ics.compute import Results, reference_of
from compare.ics.dataset import settings
from compare.ics.error_measure import ROUNDING
from compare.ics.errors import apart, measure_of, refinement_scales_of
from compare.ics.summary import summary
from compare.report.html import VANISHING, Row, cell_of, write_page
from compare.report.styles import SYMBOLS
from femic.cache.digests import versions
from femic.reference.accuracy import component_of
from femic.reference.discount import AXES
from femic.reference.level import factors
from femic.reference.result import worst
from femic.scenes.plausibility import warnings
from geometries.arrays import Mask
from geometries.bodies import Body


def write(path: Path, results: Results, errors: xr.Dataset, figures: Mapping[str, Sequence[Path]]) -> Path:
    """Write the report, return its path; `figures` has paths of PNG files by "scene", "curves" and "cost"."""
    scene = results.scene
    return write_page(
        path,
        "report.html.j2",
        title=scene.title,
        summary=summary(results, errors),
        components=scene.components,
        tables=_tables(results, errors),
        rms_tables=_tables(results, errors.assign(error=errors.rms, weight=np.nan)),
        setting=_setting(results),
        E=scene.reference_E,
        L=scene.reference_length,
        rotation_reach=scene.settings.rotation_reach,
        figures=figures,
        models=[{"name": name, "cost": cost} for name, cost in results.models.items()],
        agreement=list(agreement(results)),
        variant_seconds=[
            (SYMBOLS[name], results.seconds[name, scene.compared[0]])
            for name in results.computed(scene.compared[0])
        ],
        settings=settings(scene),
        known=list(_accuracy_rows(results)),
        notes=warnings(scene),
        first=scene.compared[0],
        discounts=[(name, _entries(reference.discount)) for name, reference in results.references.items()],
        scene_text=scene.text,
        versions=", ".join(f"{name} {version}" for name, version in versions().items()),
    )


def _tables(results: Results, errors: xr.Dataset) -> list[dict[str, object]]:
    return [{"body": b, "rows": list(_rows(results, errors, b))} for b in results.scene.compared]


def _rows(results: Results, errors: xr.Dataset, body: str) -> Iterator[Row]:
    for variant in results.variants:
        for k, line in enumerate(results.lines):
            line_errors = errors.sel(body=body, variant=variant, line=line)
            cells = [
                cell_of(line_errors.sel(i=c[0], j=c[1]), known=variant == "C")
                for c in results.scene.components
            ]
            yield Row(SYMBOLS[variant] if k == 0 else "", line, cells)


def _setting(results: Results) -> str:
    scene = results.scene
    bodies = "; ".join(
        f"{name} body: E = {body.material.E:g} MPa, ν = {body.material.nu:g}, {_shape(body)}"
        for name, body in scene.bodies.items()
    )
    ends = (
        " (along x the bodies have no ends)" if scene.settings.engine.infinite_length else " as both ends are"
    )
    place = "the contact centre" if scene.patch.s == 0 else f"s = {scene.patch.s:g} mm"
    return (
        f"{bodies}. Unit loads on a patch of {2 * scene.patch.a:g} × {2 * scene.patch.b:g} mm at {place}. "
        "Each body is its contour, continued by straight flanks and closed by a far arc about the contact "
        f"centre, which is clamped{ends}; contour and flanks are free. The rigid-body motion "
        "that this adds is discounted. The shape of the body far away is a convention of this program."
    )


def _shape(body: Body) -> str:
    if np.isinf(body.rolling_radius):
        return "extruded"
    hub = f", clamped at a hub of radius {body.rolling_radius - body.depth:g} mm" if body.reaches_hub else ""
    return f"revolved, rolling radius {body.rolling_radius:g} mm{hub}"


def _accuracy_rows(results: Results) -> Iterator[dict[str, str]]:
    """Yield how well C of each solved body is known, on both scales, and the cells and domain for it."""
    for name, job in results.jobs.items():
        reference, scale = results.references[name], refinement_scales_of(results, name)
        error, component, line = worst(job, reference.c.estimate, scale)
        cells, domain = factors(reference.level)
        yield {
            "body": name,
            "itself": _largest_estimate(results, name),
            "error": f"{error:.2%} ({component} on {line})",
            "mesh": f"{worst(job, reference.c.mesh_error, scale)[0]:.2%}",
            "truncation": f"{worst(job, reference.c.truncation_error, scale)[0]:.2%}",
            "waves": f"{worst(job, reference.c.waves_error, scale)[0]:.2%}",
            "cells": f"{reference.cells.smallest:.3g} mm at the patch (first × {cells:.3g})",
            "domain": f"far arc {reference.body.domain.far_radius:g} mm, {_length(reference.body)} "
            f"(first × {domain:.3g})",
        }


def _largest_estimate(results: Results, body: str) -> str:
    """The largest estimate of C as a share of the component itself, and the components that vanish."""
    measure = measure_of(results, body)
    components = results.scene.components
    vanishing_components = [
        component for component in components if component_of(measure.vanishing, component)
    ]
    errors = [
        (component_of(line_shares, component), component, line)
        for line, line_shares in measure.shares(reference_of(results, body).estimate).items()
        for component in components
        if component not in vanishing_components
    ]
    largest = "{:.2%} ({} on {})".format(*max(errors)) if errors else "–"
    return largest + (f"; vanishing: {', '.join(vanishing_components)}" if vanishing_components else "")


def agreement(results: Results) -> Iterator[dict[str, str]]:
    """Yield how far C of both engines differ, and whether this is within the sum of their estimates."""
    for body in results.scene.compared if results.checks else ():
        differences, allowed = apart(results, body)
        gone = measure_of(results, body).vanishing
        for line in results.lines:
            apart_of = {
                c: (component_of(differences[line], c), component_of(allowed[line], c))
                for c in results.scene.components
            }
            closest = max(apart_of, key=lambda c: apart_of[c][0] / max(apart_of[c][1], ROUNDING))
            largest = max(apart_of, key=lambda c: (not component_of(gone, c), apart_of[c][0]))
            within = all(difference <= max(estimate, ROUNDING) for difference, estimate in apart_of.values())
            yield {
                "body": body,
                "line": line,
                "apart": f"{apart_of[largest][0]:.2%} ({_marked(largest, gone)})",
                "closest": "{}: {:.2%} of {:.2%}".format(_marked(closest, gone), *apart_of[closest]),
                "verdict": "yes" if within else "no",
            }


def _marked(component: str, gone: Mask) -> str:
    return component + (VANISHING if component_of(gone, component) else "")


def _length(body: Body) -> str:
    """The text that says how far a model extends along x."""
    if body.closed:
        return "all the way round"
    return "endless along x" if np.isinf(body.xi_end) else f"half-length {body.xi_end:.4g} mm"


def _entries(discount: np.ndarray) -> list[str]:
    return [
        f"M_{AXES[a]}{AXES[b]} = {discount[a, b]:.4g}"
        for a in range(4)
        for b in range(a, 4)
        if discount[a, b] != 0
    ]
