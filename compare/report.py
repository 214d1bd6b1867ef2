"""The self-contained HTML report of a comparison."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from compare.dataset import settings
from compare.figures import SYMBOLS
from compare.html import ZERO, Cell, embedded, error_cell, rendered
from compare.pipeline import Results, apart, jobs, refinement_scales_of
from compare.scenes.plausibility import warnings
from femic.accuracy import component_of
from femic.discount import AXES
from femic.provenance import versions
from femic.reference import factors, worst
from geometries.bodies import Body

TINY = 1e-9  # of a line's scale: a component that vanishes by symmetry


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
        tables=[{"body": b, "rows": list(_rows(results, errors, b, "max"))} for b in scene.compared],
        rms_tables=[{"body": b, "rows": list(_rows(results, errors, b, "rms"))} for b in scene.compared],
        setting=_setting(results),
        E=scene.reference_E,
        L=scene.reference_length,
        rotation_reach=scene.rotation_reach,
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


def summary(results: Results, errors: xr.Dataset) -> str:
    """One paragraph, computed: worst error per variant, best variant per component, accuracy of C."""
    body = results.scene.compared[0]
    worst = errors["max"].sel(body=body)
    parts, computed = [], _computed(results, body)
    for variant in computed:
        error, component, line = _worst_of(results, worst.sel(variant=variant))
        parts.append(f"{SYMBOLS[variant]} {error:.1%} ({component} on {line})")
    best = []
    for component in results.scene.components:
        per_variant = worst.sel(i=component[0], j=component[1]).max("line")
        values = {v: per_variant.sel(variant=v).item() for v in computed}
        least = min(values.values())
        names = " = ".join(SYMBOLS[v] for v, value in values.items() if value <= least * (1 + 1e-6))
        best.append(f"{component}: {names} ({least:.1%})")
    known, component, line = _worst_of(results, worst.sel(variant="C"))
    checked = ""
    if results.checks:
        apart, where, on = _worst_of(results, worst.sel(variant="C_solid"))
        checked = f" The solid engine's C deviates from it by {apart:.2%} at most ({where} on {on})."
    return (
        f"Largest error of the {body} influence coefficients on the {len(results.lines)} lines: "
        f"{', '.join(parts)}. Closest to C: {'; '.join(best)}. "
        f"C itself is known to {known:.2%} or better (least well: {component} on {line}).{checked}"
    )


def _computed(results: Results, body: str) -> list[str]:
    """The variants that could be computed."""
    seconds = results.seconds
    return [variant for variant in results.scene.variants if not np.isnan(seconds[variant, body])]


def _worst_of(results: Results, errors: xr.DataArray) -> tuple[float, str, str]:
    return max(
        (errors.sel(i=c[0], j=c[1], line=line).item(), c, line)
        for c in results.scene.components
        for line in results.lines
    )


def _rows(results: Results, errors: xr.Dataset, body: str, measure: str) -> Iterator[Row]:
    for variant in results.variants:
        for k, line in enumerate(results.lines):
            at = errors.sel(body=body, variant=variant, line=line)
            cells = [_cell(at[measure].sel(i=c[0], j=c[1]).item(), at, c) for c in results.scene.components]
            yield Row(SYMBOLS[variant] if k == 0 else "", line, cells, k == 0)


def _cell(error: float, at: xr.Dataset, component: str) -> Cell:
    own = at["own"].sel(i=component[0], j=component[1]).item()
    scaled = at["max"].sel(i=component[0], j=component[1]).item()
    if np.isnan(own) and scaled < 1e-9:
        return ZERO
    return error_cell(error, f" ({100 * own * error / scaled:.3g} %)" if own > 1.0001 * scaled else "")


def _setting(results: Results) -> str:
    scene = results.scene
    bodies = "; ".join(
        f"{name} body: E = {body.material.E:g} MPa, ν = {body.material.nu:g}, {_shape(body)}"
        for name, body in scene.bodies.items()
    )
    ends = " as both ends are" if scene.engine == "solid" else " (along x the bodies have no ends)"
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
    """How well C of each solved body is known, and what that took."""
    rows = []
    for name, job in jobs(results.scene).items():
        found, scale = results.references[name], refinement_scales_of(results, name)
        error, component, line = worst(job, found.c.estimate, scale)
        cells, domain = factors(found.level)
        rows.append(
            {
                "body": name,
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


def agreement(results: Results) -> Iterator[dict[str, str]]:
    """How far C of both engines are apart, and whether that is within the sum of their estimates."""
    for body in results.scene.compared if results.checks else ():
        off_by, known_to = apart(results, body)
        for line in results.lines:
            components = {
                v: (component_of(off_by[line], v), component_of(known_to[line], v))
                for v in results.scene.components
            }
            worst_one = max(components, key=lambda v: components[v][0] / max(components[v][1], TINY))
            off, estimate = components[worst_one]
            yield {
                "body": body,
                "line": line,
                "apart": f"{max(a for a, _ in components.values()):.2%}",
                "closest": f"{worst_one}: {off:.2%} of {estimate:.2%}",
                "verdict": "yes" if all(a <= max(e, TINY) for a, e in components.values()) else "no",
            }


def _length(body: Body) -> str:
    """How far a model goes along x."""
    if body.closed:
        return "all the way round"
    return "endless along x" if np.isinf(body.xi_end) else f"half-length {body.xi_end:.4g} mm"


def _entries(m: np.ndarray) -> list[str]:
    return [f"M_{AXES[a]}{AXES[b]} = {m[a, b]:.4g}" for a in range(4) for b in range(a, 4) if m[a, b] != 0]
