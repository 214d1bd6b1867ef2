"""The self-contained HTML report of a comparison."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.html import VANISHING, Cell, embedded, error_cell, known_cell, rendered
from compare.pages.styles import SYMBOLS
from compare.reports.scene.summary import summary
from compare.results.compute import (
    Results,
    apart,
    measure_of,
    reference_of,
    refinement_scales_of,
    vanishing,
)
from compare.results.dataset import settings
from compare.results.measure import ROUNDING
from compare.scenes.plausibility import warnings
from femic.accuracy import component_of
from femic.discount import AXES
from femic.level import factors
from femic.reference import worst
from femic.work.provenance import versions
from geometries.arrays import Mask
from geometries.bodies import Body


@dataclass(frozen=True)
class Row:
    """The errors of one variant on one line, a cell per component."""

    symbol: str
    line: str
    cells: list[Cell]
    first: bool


def render(results: Results, errors: xr.Dataset, figures: Mapping[str, Sequence[Path]]) -> str:
    """The report as HTML; `figures` has the paths of PNGs under "scene", "curves", "cost"."""
    scene = results.scene
    return rendered(
        "report.html.j2",
        title=scene.title,
        summary=summary(results, errors),
        components=scene.components,
        tables=[{"body": b, "rows": list(_rows(results, errors, b, "error"))} for b in scene.compared],
        rms_tables=[{"body": b, "rows": list(_rows(results, errors, b, "rms"))} for b in scene.compared],
        setting=_setting(results),
        E=scene.reference_E,
        L=scene.reference_length,
        rotation_reach=scene.settings.rotation_reach,
        figures={kind: [embedded(path) for path in paths] for kind, paths in figures.items()},
        models=[{"name": name, "cost": cost} for name, cost in results.models.items()],
        agreement=list(agreement(results)),
        variant_seconds=[
            (SYMBOLS[name], results.seconds[name, scene.compared[0]])
            for name in results.variants
            if not np.isnan(results.seconds[name, scene.compared[0]])
        ],
        settings=settings(scene),
        known=_known(results),
        notes=warnings(scene),
        first=scene.compared[0],
        discounts=[(name, _entries(reference.discount)) for name, reference in results.references.items()],
        scene_text=scene.text,
        versions=", ".join(f"{name} {version}" for name, version in versions().items()),
    )


def _rows(results: Results, errors: xr.Dataset, body: str, measure: str) -> Iterator[Row]:
    for variant in results.variants:
        for k, line in enumerate(results.lines):
            at = errors.sel(body=body, variant=variant, line=line)
            cells = [_cell(at.sel(i=c[0], j=c[1]), measure) for c in results.scene.components]
            yield Row(SYMBOLS[variant] if k == 0 else "", line, cells, k == 0)


def _cell(at: xr.Dataset, measure: str) -> Cell:
    """An error with its weight, or an rms, of a variant on a line."""
    made = known_cell if at.variant.item() == "C" else error_cell
    weight = at.weight.item() if measure == "error" else np.nan
    return made(at[measure].item(), weight, vanishes=bool(at.vanishes))


def _setting(results: Results) -> str:
    scene = results.scene
    bodies = "; ".join(
        f"{name} body: E = {body.material.E:g} MPa, ν = {body.material.nu:g}, {_shape(body)}"
        for name, body in scene.bodies.items()
    )
    ends = " (along x the bodies have no ends)" if scene.settings.engine.endless else " as both ends are"
    at = "the contact centre" if scene.patch.s == 0 else f"s = {scene.patch.s:g} mm"
    return (
        f"{bodies}. Unit loads on a patch of {2 * scene.patch.a:g} × {2 * scene.patch.b:g} mm at {at}. "
        "Each body is its contour, continued by straight flanks and closed by a far arc about the contact "
        f"centre, which is clamped{ends}; contour and flanks are free. The rigid-body motion "
        "that this adds is discounted. The shape of the body far away is a convention of this program."
    )


def _shape(body: Body) -> str:
    if np.isinf(body.rolling_radius):
        return "extruded"
    hub = f", clamped at a hub of radius {body.rolling_radius - body.depth:g} mm" if body.reaches_hub else ""
    return f"revolved, rolling radius {body.rolling_radius:g} mm{hub}"


def _known(results: Results) -> list[dict[str, str]]:
    """How well C of each solved body is known, on both scales, and what that took."""
    rows = []
    for name, job in results.jobs.items():
        found, scale = results.references[name], refinement_scales_of(results, name)
        error, component, line = worst(job, found.c.estimate, scale)
        cells, domain = factors(found.level)
        rows.append(
            {
                "body": name,
                "itself": _of_itself(results, name),
                "error": f"{error:.2%} ({component} on {line})",
                "mesh": f"{worst(job, found.c.mesh_error, scale)[0]:.2%}",
                "truncation": f"{worst(job, found.c.truncation_error, scale)[0]:.2%}",
                "waves": f"{worst(job, found.c.waves_error, scale)[0]:.2%}",
                "cells": f"{found.cells.smallest:.3g} mm at the patch (first × {cells:.3g})",
                "domain": f"far arc {found.body.domain.far_radius:g} mm, {_length(found.body)} "
                f"(first × {domain:.3g})",
            }
        )
    return rows


def _of_itself(results: Results, body: str) -> str:
    """The largest estimate of a component of C as a share of the component itself; which vanish."""
    measure = measure_of(results, body)
    components = results.scene.components
    gone = [c for c in components if component_of(measure.vanishing, c)]
    errors = [
        (component_of(of_line, c), c, line)
        for line, of_line in measure.shares(reference_of(results, body).estimate).items()
        for c in components
        if c not in gone
    ]
    shown = "{:.2%} ({} on {})".format(*max(errors)) if errors else "–"
    return shown + (f"; vanishing: {', '.join(gone)}" if gone else "")


def agreement(results: Results) -> Iterator[dict[str, str]]:
    """How far C of both engines are apart, and whether that is within the sum of their estimates."""
    for body in results.scene.compared if results.checks else ():
        off_by, known_to = apart(results, body)
        gone = vanishing(results, body)
        for line in results.lines:
            components = {
                v: (component_of(off_by[line], v), component_of(known_to[line], v))
                for v in results.scene.components
            }
            closest = max(components, key=lambda v: components[v][0] / max(components[v][1], ROUNDING))
            largest = max(components, key=lambda v: (not component_of(gone, v), components[v][0]))
            yield {
                "body": body,
                "line": line,
                "apart": f"{components[largest][0]:.2%} ({_marked(largest, gone)})",
                "closest": "{}: {:.2%} of {:.2%}".format(_marked(closest, gone), *components[closest]),
                "verdict": "yes" if all(a <= max(e, ROUNDING) for a, e in components.values()) else "no",
            }


def _marked(component: str, gone: Mask) -> str:
    return component + (VANISHING if component_of(gone, component) else "")


def _length(body: Body) -> str:
    """How far a model goes along x."""
    if body.closed:
        return "all the way round"
    return "endless along x" if np.isinf(body.xi_end) else f"half-length {body.xi_end:.4g} mm"


def _entries(m: np.ndarray) -> list[str]:
    return [f"M_{AXES[a]}{AXES[b]} = {m[a, b]:.4g}" for a in range(4) for b in range(a, 4) if m[a, b] != 0]
