"""`femic calibrate` writes the fits, the scenes with them, figures and one report."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import tomlkit

from compare.calibration import figures as calibration_figures
from compare.calibration.compute import (
    REPORTED_COMPONENTS,
    Calibrated,
    properties_table,
    to_dataset,
    with_properties,
)
from compare.ics.compute import Results
from compare.ics.curves import curves
from compare.ics.dataset import errors
from compare.ics.dataset import to_dataset as ics_of
from compare.report.errors import MEASURE, error_row
from compare.report.parts import Note, Page, Picture, Section, Verbatim, write_page
from compare.report.styles import SYMBOLS
from compare.report.tables import Cell, Row, Table, numbers, texts
from femic.cache.files import write_dataset, write_text

METHOD = (
    "B̂′ is B̂ with elastic properties that change from the half-space's value, at the load, to a far value "
    "at the distance r_∞: f(r) = f⁰ + (f_∞ − f⁰)·[(1 − ρ) ρᵐ + ρ (1 − (1 − ρ)ⁿ)], ρ = min(1, r/r_∞). "
    "The parameters follow from weighted least squares against C for one lateral load position."
)
CURVATURE_APART = (
    "Curvature along x is not part of the fit: it is subtracted first, and B̂′ adds it as B̂ does."
)
CURVATURE_FITTED = "The fit includes the curvature of wheels along x: B̂′ has no other curvature."
DEVIATIONS = (
    "Standard deviations assume that deviations of the points are independent and as large as the residual "
    "(or, if larger, the estimated error of C). They are not independent, because f is only a model of C: "
    "standard deviations show which parameters the data determine."
)
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
    title = "B̂′ calibrated: " + ", ".join(calibrated.scene.name for calibrated in calibrations)
    sentences = " ".join(_summary(calibrated) for calibrated in calibrations)
    return write_page(Page(title, sentences, _sections(calibrations)), folder / "calibration.html")


def _sections(calibrations: Sequence[Calibrated]) -> Iterator[Section]:
    yield Section("", [METHOD])
    for calibrated in calibrations:
        yield _scene_section(calibrated)
    heading = "Fits and curves" if len(calibrations) == 1 else "All scenes together"
    yield Section(heading, [_overlay_text(calibrations), *_overlaid(calibrations)])
    curves_of_scenes = (picture for calibrated in calibrations for picture in _curves(calibrated))
    yield Section("Each scene, bodies together and alone", list(curves_of_scenes))


def _overlay_text(calibrations: Sequence[Calibrated]) -> str:
    curvature = " − curvature term" if calibrations[0].scene.calibration.curvature_apart else ""
    moved = [
        f"{calibrated.scene.name}: {_unit(calibrated) * calibration_figures.translation(calibrated):.3g}"
        for calibrated in calibrations
        if "combined" in calibrated.fits
    ]
    translations = f" ({', '.join(moved)}, times E L)" if moved else ""
    return (
        "Marks: the K at which B̂ has the value of C_xn at a point, −(C_xn + A_xs sin "
        f"½α{curvature})·πG/(J_x cos ½α). C without curvature: less what the wheels' curvature along x adds "
        "to B̂. Translation refitted: C_sn of another vertical rigid translation, least squares to B̂′ on "
        f"the lines{translations}."
    )


def _unit(calibrated: Calibrated) -> float:
    return calibrated.scene.reference_E * calibrated.scene.reference_length


def _overlaid(calibrations: Sequence[Calibrated]) -> Iterator[Picture]:
    """Yield the figures of all scenes together."""
    for body in dict.fromkeys(body for calibrated in calibrations for body in calibrated.fits):
        yield Picture(f"effective_{body}", calibration_figures.effective(calibrations, body))
    if not all("combined" in calibrated.fits for calibrated in calibrations):
        return
    for name in calibration_figures.OVERLAID:
        yield Picture(f"calibration_{name}", calibration_figures.overlaid(calibrations, name))


def _curves(calibrated: Calibrated) -> Iterator[Picture]:
    """Yield the curves of a scene, a figure per component."""
    dataset = ics_of(calibrated.results)
    for component in COMPONENTS:
        yield Picture(f"{calibrated.scene.name}_{component}", curves(calibrated.scene, dataset, component))


def _scene_section(calibrated: Calibrated) -> Section:
    scene, target = calibrated.scene, next(iter(calibrated.targets.values()))
    lines = ", ".join(line.name.removeprefix("fit ") for line in scene.calibration.lines)
    points = f"Points: lines {lines}, x = {np.min(target.x):.3g} ... {np.max(target.x):.3g} mm."
    curvature = CURVATURE_APART if scene.calibration.curvature_apart else CURVATURE_FITTED
    return Section(
        f"{scene.name}: {scene.title}",
        [
            f"{points} {curvature}",
            *(_fit_section(calibrated, body) for body in calibrated.fits),
            Note(DEVIATIONS),
            _table(calibrated),
            Note(f"{MEASURE} Rows “C”: the estimated error of C itself."),
        ],
    )


def _on_own_lines(calibrated: Calibrated) -> Results:
    """Return the results on the lines of the scene, without the lines of the calibration."""
    own = {line.name: calibrated.results.lines[line.name] for line in calibrated.scene.lines}
    return replace(calibrated.results, scene=calibrated.scene, lines=own)


def _fit_section(calibrated: Calibrated, body: str) -> Section:
    body_fit, scene = calibrated.fits[body], calibrated.scene
    snippet = {"effective": {body: properties_table(scene, body, body_fit.effective)}}
    residuals = _residuals(calibrated, body, "{}: {:.1%} rms, {:.1%} at worst")
    rows = [
        Row(p.name, [Cell(p.value, ".5g"), "" if p.deviation is None else f"± {p.deviation:.2g}", p.note])
        for p in body_fit.parameters
    ]
    columns = [*numbers("value", unit="mm, MPa"), *numbers("standard deviation"), *texts("note")]
    return Section(
        body,
        [
            Table("parameter", columns, rows),
            f"Residual, shares of max |C_ij| of the fitted points: {residuals}. In a scene file "
            f"(`{scene.name}_calibrated.toml` has it):",
            Verbatim(tomlkit.dumps(snippet).strip()),
        ],
    )


def _residuals(calibrated: Calibrated, body: str, text: str) -> str:
    """Return the texts of all fitted components, with rms and largest residual."""
    fitted, components = calibrated.fits[body], calibrated.scene.calibration.components
    return ", ".join(text.format(*row) for row in zip(components, fitted.rms, fitted.worst, strict=True))


def _table(calibrated: Calibrated) -> Table:
    """Return the table of worst errors on the scene's lines, a row per body and variant."""
    scene = calibrated.scene
    line_errors = errors(_on_own_lines(calibrated), ics_of(calibrated.results))
    worst = line_errors[["error", "weight", "vanishes"]].max("line", skipna=False)
    rows = []
    for body in scene.compared:
        name = body  # of the first row
        for variant in (*scene.variants, "C"):
            variant_errors = worst.sel(body=body, variant=variant)
            symbol, is_estimate = SYMBOLS[variant], variant == "C"
            row = error_row(name, variant_errors, COMPONENTS, is_estimate=is_estimate, place=symbol)
            if any(cell.text != "–" for cell in row.filled[1:]):
                rows.append(row)
                name = ""
    heads = [f"{component}, worst error on the lines" for component in COMPONENTS]
    return Table("body", [*texts("variant"), *numbers(*heads)], rows)


def _summary(calibrated: Calibrated) -> str:
    parts = []
    for body, body_fit in calibrated.fits.items():
        residuals = _residuals(calibrated, body, "{} to {:.1%} rms ({:.1%} at worst)")
        fixed = [p.name for p in body_fit.parameters if p.deviation is None]
        note = f"; not fitted: {', '.join(fixed)}" if fixed else ""
        parts.append(f"{body} {residuals} of max |C|{note}")
    return f"{calibrated.scene.name}: B̂′ reproduces {'; '.join(parts)}."
