"""`femic calibrate` writes the fits, the scenes with them, figures and one report."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import tomlkit
import xarray as xr

from compare.calibration import figures as calibration_figures
from compare.calibration.compute import (
    REPORTED_COMPONENTS,
    Calibrated,
    properties_table,
    to_dataset,
    with_properties,
)
from compare.ics.compute import Results
from compare.ics.dataset import errors
from compare.ics.dataset import to_dataset as ics_of
from compare.report.curves import curves
from compare.report.html import cell_of, write_page
from compare.report.styles import SYMBOLS, save
from femic.cache import folders
from femic.cache.files import write_dataset, write_text

COMPONENTS = tuple(component for component in REPORTED_COMPONENTS if component != "nn")


def write_fit(calibrated: Calibrated, folder: Path) -> Path:
    """Write `calibration.nc` and `SCENE_calibrated.toml`, the scene with its fits; returns its path."""
    scene = calibrated.scene
    write_dataset(to_dataset(calibrated), folder / "calibration.nc")
    effective = {body: body_fit.effective for body, body_fit in calibrated.fits.items()}
    text = with_properties(scene, effective, folder)
    return write_text(text, folder / f"{scene.name}_calibrated.toml")


def write_report(calibrations: Sequence[Calibrated], folder: Path) -> Path:
    """Write the figures and `calibration.html` of one or more scenes; returns the path of the page."""
    figures_folder = folders.make(folder / "figures")
    return write_page(
        folder / "calibration.html",
        "calibration.html.j2",
        title="B̂′ calibrated: " + ", ".join(calibrated.scene.name for calibrated in calibrations),
        summary=" ".join(_summary(calibrated) for calibrated in calibrations),
        scenes=[_scene_section(calibrated, figures_folder) for calibrated in calibrations],
        overlaid=list(_overlaid(calibrations, figures_folder)),
        components=COMPONENTS,
    )


def _overlaid(calibrations: Sequence[Calibrated], folder: Path) -> Iterator[Path]:
    """Draw the figures of all scenes together; yields their paths."""
    for body in dict.fromkeys(body for calibrated in calibrations for body in calibrated.fits):
        yield save(calibration_figures.effective(calibrations, body), folder / f"effective_{body}.png")
    if not all("combined" in calibrated.fits for calibrated in calibrations):
        return
    for name in calibration_figures.OVERLAID:
        yield save(calibration_figures.overlaid(calibrations, name), folder / f"calibration_{name}.png")


def _scene_section(calibrated: Calibrated, folder: Path) -> dict[str, object]:
    dataset, on_lines = ics_of(calibrated.results), on_own_lines(calibrated)
    name = calibrated.scene.name
    return {
        "name": name,
        "title": calibrated.scene.title,
        "fits": [_fit_section(calibrated, body) for body in calibrated.fits],
        "rows": list(_rows(calibrated, errors(on_lines, dataset))),
        "figures": [save(curves(on_lines, dataset, c), folder / f"{name}_{c}.png") for c in COMPONENTS],
        "points": ", ".join(line.name.removeprefix("fit ") for line in calibrated.scene.calibration.lines),
        "range": _range(calibrated),
        "curvature": calibrated.scene.calibration.curvature_apart,
        "translation": _translation(calibrated),
    }


def on_own_lines(calibrated: Calibrated) -> Results:
    """The results on the lines of the scene: those of the calibration do not count for its errors."""
    own = {line.name: calibrated.results.lines[line.name] for line in calibrated.scene.lines}
    return replace(calibrated.results, scene=calibrated.scene, lines=own)


def _fit_section(calibrated: Calibrated, body: str) -> dict[str, object]:
    body_fit = calibrated.fits[body]
    snippet = {"effective": {body: properties_table(calibrated.scene, body, body_fit.effective)}}
    return {
        "body": body,
        "parameters": body_fit.parameters,
        "residuals": _residuals(calibrated, body, "{}: {:.1%} rms, {:.1%} at worst"),
        "snippet": tomlkit.dumps(snippet).strip(),
    }


def _residuals(calibrated: Calibrated, body: str, text: str) -> str:
    """The texts of each component that was fitted to, with its rms and its largest residual filled in."""
    fitted, components = calibrated.fits[body], calibrated.scene.calibration.components
    return ", ".join(text.format(*row) for row in zip(components, fitted.rms, fitted.worst, strict=True))


def _range(calibrated: Calibrated) -> str:
    target = next(iter(calibrated.targets.values()))
    return f"{np.min(target.x):.3g} ... {np.max(target.x):.3g}"


def _translation(calibrated: Calibrated) -> str:
    if "combined" not in calibrated.fits:
        return ""
    unit = calibrated.scene.reference_E * calibrated.scene.reference_length
    return f"{unit * calibration_figures.translation(calibrated):.3g}"


def _rows(calibrated: Calibrated, line_errors: xr.Dataset) -> Iterator[dict[str, object]]:
    """Yield a table row per body and variant, with the worst errors on the scene's lines."""
    for body in calibrated.scene.compared:
        for variant in (*calibrated.scene.variants, "C"):
            variant_errors = line_errors[["error", "weight", "vanishes"]].sel(body=body, variant=variant)
            largest = variant_errors.max("line", skipna=False)
            cells = [cell_of(largest.sel(i=c[0], j=c[1]), known=variant == "C") for c in COMPONENTS]
            if not all(cell.text == "–" for cell in cells):
                yield {"body": body, "symbol": SYMBOLS[variant], "cells": cells, "first": variant == "A"}


def _summary(calibrated: Calibrated) -> str:
    parts = []
    for body, body_fit in calibrated.fits.items():
        residuals = _residuals(calibrated, body, "{} to {:.1%} rms ({:.1%} at worst)")
        fixed = [p.name for p in body_fit.parameters if p.deviation is None]
        note = f"; not fitted: {', '.join(fixed)}" if fixed else ""
        parts.append(f"{body} {residuals} of max |C|{note}")
    return f"{calibrated.scene.name}: B̂′ reproduces {'; '.join(parts)}."
