"""`femic calibrate`: compute, fit, write the fits, the scenes with them, figures and one report."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import tomlkit
import xarray as xr

from compare.pages.curves import curves
from compare.pages.html import Cell, embedded, error_cell, known_cell, rendered
from compare.pages.styles import SYMBOLS, save
from compare.reports.calibration import figures as calibration_figures
from compare.reports.calibration.fits import SHOWN, Calibrated, properties_table, to_dataset, with_properties
from compare.results.compute import Results
from compare.results.dataset import errors, write
from compare.results.dataset import to_dataset as ics_of

COMPONENTS = tuple(component for component in SHOWN if component != "nn")


def write_fit(calibrated: Calibrated, folder: Path) -> Path:
    """Write `calibration.nc` and `SCENE_calibrated.toml`, the scene with the fit; returns its path."""
    scene = calibrated.scene
    write(to_dataset(calibrated), folder / "calibration.nc")
    path = folder / f"{scene.name}_calibrated.toml"
    effective = {body: found.effective for body, found in calibrated.fits.items()}
    path.write_text(with_properties(scene, effective, folder), encoding="utf-8")
    return path


def write_report(found: Sequence[Calibrated], folder: Path) -> Path:
    """Write the figures and `calibration.html` of one or more scenes; returns its path."""
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    path = folder / "calibration.html"
    path.write_text(
        rendered(
            "calibration.html.j2",
            title="B̂′ calibrated: " + ", ".join(one.scene.name for one in found),
            summary=" ".join(_summary(one) for one in found),
            scenes=[_of_scene(one, folder) for one in found],
            overlaid=[embedded(one) for one in _overlaid(found, folder)],
            components=COMPONENTS,
        ),
        encoding="utf-8",
    )
    return path


def _overlaid(found: Sequence[Calibrated], folder: Path) -> Iterator[Path]:
    """Figures of all scenes together."""
    at = folder / "figures"
    for body in dict.fromkeys(body for one in found for body in one.fits):
        yield save(calibration_figures.effective(found, body), at / f"effective_{body}.png")
    if not all("combined" in one.fits for one in found):
        return
    drawn = {
        "xn": calibration_figures.overlaid(found, "xn"),
        "xn_without_curvature": calibration_figures.without_curvature(found),
        "sn": calibration_figures.translation_refitted(found),
    }
    for name, figure in drawn.items():
        yield save(figure, at / f"calibration_{name}.png")


def _of_scene(one: Calibrated, folder: Path) -> dict[str, object]:
    dataset, on_lines = ics_of(one.results), on_own_lines(one)
    at = folder / "figures"
    drawn = [
        save(curves(on_lines, dataset, component), at / f"{one.scene.name}_{component}.png")
        for component in COMPONENTS
    ]
    return {
        "name": one.scene.name,
        "title": one.scene.title,
        "fits": [_of_body(one, body) for body in one.fits],
        "rows": list(_rows(one, errors(on_lines, dataset))),
        "figures": [embedded(path) for path in drawn],
        "points": ", ".join(line.name.removeprefix("fit ") for line in one.scene.calibration.lines),
        "range": _range(one),
        "curvature": one.scene.calibration.curvature_apart,
        "translation": _translation(one),
    }


def on_own_lines(one: Calibrated) -> Results:
    """Results on the lines of the scene: those of the calibration have no part in its errors."""
    own = {line.name: one.results.lines[line.name] for line in one.scene.lines}
    return replace(one.results, scene=one.scene, lines=own)


def _of_body(one: Calibrated, body: str) -> dict[str, object]:
    found = one.fits[body]
    snippet = {"effective": {body: properties_table(one.scene, body, found.effective)}}
    return {
        "body": body,
        "parameters": [
            {
                "name": p.name,
                "value": f"{p.value:.5g}",
                "deviation": "" if p.deviation is None else f"± {p.deviation:.2g}",
                "note": p.note,
            }
            for p in found.parameters
        ],
        "residuals": ", ".join(
            f"{component}: {rms:.1%} rms, {worst:.1%} at worst"
            for component, rms, worst in zip(
                one.scene.calibration.components, found.rms, found.worst, strict=True
            )
        ),
        "snippet": tomlkit.dumps(snippet).strip(),
    }


def _range(one: Calibrated) -> str:
    target = next(iter(one.targets.values()))
    return f"{np.min(target.x):.3g} ... {np.max(target.x):.3g}"


def _translation(one: Calibrated) -> str:
    if "combined" not in one.fits:
        return ""
    unit = one.scene.reference_E * one.scene.reference_length
    return f"{unit * calibration_figures.translation(one):.3g}"


def _rows(one: Calibrated, found: xr.Dataset) -> Iterator[dict[str, object]]:
    """Worst errors of every variant on the scene's lines, bodies together."""
    for body in one.scene.compared:
        for variant in (*one.scene.variants, "C"):
            at = found[["error", "weight", "vanishes"]].sel(body=body, variant=variant)
            largest = at.max("line", skipna=False)
            cells = [_cell(largest.sel(i=component[0], j=component[1])) for component in COMPONENTS]
            if not all(cell.text == "–" for cell in cells):
                yield {"body": body, "symbol": SYMBOLS[variant], "cells": cells, "first": variant == "A"}


def _cell(worst: xr.Dataset) -> Cell:
    made = known_cell if worst.variant.item() == "C" else error_cell
    return made(worst.error.item(), worst.weight.item(), vanishes=bool(worst.vanishes))


def _summary(one: Calibrated) -> str:
    parts = []
    for body, found in one.fits.items():
        at_worst = ", ".join(
            f"{component} to {rms:.1%} rms ({worst:.1%} at worst)"
            for component, rms, worst in zip(
                one.scene.calibration.components, found.rms, found.worst, strict=True
            )
        )
        fixed = [p.name for p in found.parameters if p.deviation is None]
        note = f"; not fitted: {', '.join(fixed)}" if fixed else ""
        parts.append(f"{body} {at_worst} of max |C|{note}")
    return f"{one.scene.name}: B̂′ reproduces {'; '.join(parts)}."
