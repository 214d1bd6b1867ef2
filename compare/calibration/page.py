"""`femic calibrate` writes the fits, the scenes with them, figures and one report."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import tomlkit
import xarray as xr

from approx.calibration import Parameter
from compare.calibration.compute import (
    REPORTED_COMPONENTS,
    Calibrated,
    properties_table,
    to_dataset,
    with_properties,
)
from compare.calibration.figures import (
    COMPARED,
    MICROMETRES_PER_KILONEWTON,
    PROPERTIES,
    fits,
    other_c,
    translation,
)
from compare.ics import curves
from compare.ics.compute import Results
from compare.ics.dataset import errors
from compare.ics.dataset import to_dataset as ics_of
from compare.ics.page import row_name
from compare.ics.summary import body_name
from compare.report.errors import MEASURE, VANISHING, error_row, percent
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_page
from compare.report.tables import Row, Table, numbers, texts, with_estimate
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
READING = (
    "Left: the fit, and the K with which B̂ has the value of C at a point, −(C_xn + A_xs sin ½α{})·πG/"
    "(J_x cos ½α). Right: what the approximations differ from C at the points of the fit; band: the estimate "
    "of C. Table: root mean square of this difference with B̂′; largest errors on the lines of the scene with "
    "B̂ → with B̂′, shares of the component."
)
OTHER_C = (
    "C without curvature: less what the wheels' curvature along x adds to B̂. Translation refitted: C_sn of "
    "another vertical rigid translation, least squares to B̂′ on the lines{}."
)


@dataclass(frozen=True, eq=False)
class Reported:
    """A calibrated scene, its ICs, and their errors on the lines of the scene, the worst over lines."""

    calibrated: Calibrated
    ics: xr.Dataset
    errors: xr.Dataset

    @classmethod
    def of(cls, calibrated: Calibrated) -> "Reported":
        """Measure the errors of a calibrated scene."""
        ics = ics_of(calibrated.results)
        line_errors = errors(_on_own_lines(calibrated), ics)[["error", "weight", "vanishes"]]
        return cls(calibrated, ics, line_errors.max("line", skipna=False))

    @property
    def name(self) -> str:
        """The name of the scene."""
        return self.calibrated.scene.name

    def change(self, body: str, component: str) -> tuple[float, float]:
        """Return the errors of a component without and with the fit [-]."""
        at = self.errors.error.sel(body=body, i=component[0], j=component[1])
        without, with_fit = (at.sel(variant=name).item() for name in COMPARED)
        return without, with_fit


def _on_own_lines(calibrated: Calibrated) -> Results:
    """Return the results on the lines of the scene, without the lines of the calibration."""
    own = {line.name: calibrated.results.lines[line.name] for line in calibrated.scene.lines}
    return replace(calibrated.results, scene=calibrated.scene, lines=own)


def write_fit(calibrated: Calibrated, folder: Path) -> Path:
    """Write `calibration.nc` and `SCENE_calibrated.toml`, the scene with its fits; returns its path."""
    scene = calibrated.scene
    write_dataset(to_dataset(calibrated), folder / "calibration.nc")
    effective = {body: body_fit.effective for body, body_fit in calibrated.fits.items()}
    text = with_properties(scene, effective)
    return write_text(text, folder / f"{scene.name}_calibrated.toml")


def write_report(calibrations: Sequence[Calibrated], folder: Path) -> Path:
    """Write the figures and `calibration.html` of one or more scenes; returns the path of the page."""
    return write_page(page_of(calibrations), folder / "calibration.html", "calibration")


def page_of(calibrations: Sequence[Calibrated]) -> Page:
    """Return the page of one or more calibrated scenes."""
    title = "B̂′ calibrated: " + ", ".join(calibrated.scene.name for calibrated in calibrations)
    reported = [Reported.of(calibrated) for calibrated in calibrations]
    return Page(title, summary(reported), _sections(reported), answer_table(reported))


def _sections(reported: Sequence[Reported]) -> Iterator[Section | Folded]:
    calibrations = [one.calibrated for one in reported]
    curvature = " − curvature term" if calibrations[0].scene.calibration.curvature_apart else ""
    yield Section("", [fits(calibrations), Note(READING.format(curvature))])
    for one in reported:
        scene = one.calibrated.scene
        chart = curves.chart(scene, one.ics)
        named = replace(chart, name=f"curves_{one.name}", start=scene.calibration.components[0])
        block = Section if len(reported) == 1 else Folded
        yield block(f"ICs of {one.name} on its lines, and their differences from C", [named])
    tables = [Section(one.name, [_errors_table(one)]) for one in reported]
    note = Note(f"{MEASURE} Rows “C ±”: the estimated error of C itself.")
    yield Folded("Errors on the lines of the scene", [*tables, note])
    for one in reported:
        yield Folded(f"Parameters of {one.name}, and its scene", list(_parameters(one.calibrated)))
    if all("combined" in calibrated.fits for calibrated in calibrations):
        text = OTHER_C.format(_translations_text(calibrations))
        yield Folded("C without curvature, and with another translation", [other_c(calibrations), text])


def _translations_text(calibrations: Sequence[Calibrated]) -> str:
    moved = [
        f"{calibrated.scene.name}: {MICROMETRES_PER_KILONEWTON * translation(calibrated):.3g} µm/kN"
        for calibrated in calibrations
    ]
    return f" ({', '.join(moved)})"


def _parameters(calibrated: Calibrated) -> Iterator[Block]:
    """Yield how a scene was fitted, and the parameters of each body with the table for scene files."""
    scene, target = calibrated.scene, next(iter(calibrated.targets.values()))
    lines = ", ".join(line.name.removeprefix("fit ") for line in scene.calibration.lines)
    curvature = CURVATURE_APART if scene.calibration.curvature_apart else CURVATURE_FITTED
    yield METHOD
    yield f"Points: lines {lines}, x = {np.min(target.x):.3g} ... {np.max(target.x):.3g} mm. {curvature}"
    for body in calibrated.fits:
        yield _fit_section(calibrated, body)
    yield Note(DEVIATIONS)
    yield Folded("Scene file", [Verbatim(scene.text)])


def _fit_section(calibrated: Calibrated, body: str) -> Section:
    body_fit, scene = calibrated.fits[body], calibrated.scene
    snippet = {"effective": {body: properties_table(scene, body, body_fit.effective)}}
    residuals = ", ".join(
        f"{component}: {rms:.1%} rms, {worst:.1%} at worst"
        for component, rms, worst in zip(
            scene.calibration.components, body_fit.rms, body_fit.worst, strict=True
        )
    )
    rows = [Row(parameter.name, [_value(parameter), parameter.note]) for parameter in body_fit.parameters]
    return Section(
        body,
        [
            Table("parameter", [*numbers("value", unit="mm, MPa"), *texts("note")], rows),
            f"Residual, shares of max |C_ij| of the fitted points: {residuals}. In a scene file "
            f"(`{scene.name}_calibrated.toml` has it):",
            Verbatim(tomlkit.dumps(snippet).strip()),
        ],
    )


def _value(parameter: Parameter) -> str:
    """Return a parameter with its standard deviation, or that it was not fitted."""
    if parameter.deviation is None:
        return f"{parameter.value:.5g} (fixed)"
    return with_estimate(parameter.value, parameter.deviation)


def answer_table(reported: Sequence[Reported]) -> Table:
    """Return what was fitted, and errors without and with it; a row for each property of each body."""
    components = list(dict.fromkeys(c for one in reported for c in _components(one)))
    names = {one: [one.name] if len(reported) > 1 else [] for one in reported}
    rows = [
        Row(", ".join([*names[one], body, PROPERTIES[name]]), _answer_cells(one, body, name, components))
        for one in reported
        for body in one.calibrated.fits
        for name in one.calibrated.scene.calibration.properties
    ]
    heads = [f"{component}: B̂ → B̂′" for component in components]
    columns = [*numbers("far value"), *numbers("r_∞", unit="mm"), *numbers("residual", *heads, unit="%")]
    return Table("fit", columns, rows)


def _components(one: Reported) -> list[str]:
    """Return the fitted components of a scene, then the others that every report shows."""
    return list(dict.fromkeys((*one.calibrated.scene.calibration.components, *REPORTED_COMPONENTS)))


def _answer_cells(one: Reported, body: str, name: str, components: Sequence[str]) -> list[str]:
    body_fit = one.calibrated.fits[body]
    parameters = {parameter.name: parameter for parameter in body_fit.parameters}
    changes = [_change_text(one, body, component) for component in components]
    values = [_value(parameters[f"{name}.{part}"]) for part in ("far", "r_inf")]
    return [*values, f"{100 * float(np.max(body_fit.rms)):.2g}", *changes]


def _change_text(one: Reported, body: str, component: str) -> str:
    """Return the errors of a component without and with the fit [%], a dash where it was not computed."""
    if component not in one.calibrated.scene.components:
        return "–"
    without, with_fit = (f"{100 * error:.3g}" for error in one.change(body, component))
    vanishes = one.errors.vanishes.sel(body=body, i=component[0], j=component[1]).item()
    return f"{without} → {with_fit}{VANISHING if vanishes else ''}"


def summary(reported: Sequence[Reported]) -> str:
    """Return what was fitted, how much it helps, and where it does not, in three sentences."""
    better, worse = [], []
    for one in reported:
        for body, component in product(one.calibrated.fits, _components(one)):
            before, after = one.change(body, component)
            what = f"{component}{_where(one, body, reported)}"
            if component in one.calibrated.scene.calibration.components:
                better.append(f"from {percent(before)} to {percent(after)} in {what}")
            elif after > before and percent(after) != percent(before):
                worse.append(f"{what} ({percent(before)} to {percent(after)})")
    others = join_words(worse) if worse else "no other component"
    return (
        f"{'; '.join(_fitted(reported))}. With B̂′ instead of B̂, the largest error on the lines goes "
        f"{join_words(better)}. It grows in {others}."
    )


def _where(one: Reported, body: str, reported: Sequence[Reported]) -> str:
    """Return the body and the scene of a fit as far as they are not the same for all fits."""
    bodies = {name for each in reported for name in each.calibrated.fits}
    return (f" {body_name(body)}" if len(bodies) > 1 else "") + _in_scene(one, reported)


def _in_scene(one: Reported, reported: Sequence[Reported]) -> str:
    return f" in {one.name}" if len(reported) > 1 else ""


def _fitted(reported: Sequence[Reported]) -> Iterator[str]:
    """Yield the change of each fitted property from the load on, and what the data do not determine."""
    for one in reported:
        calibrated = one.calibrated
        for body, name in product(calibrated.fits, calibrated.scene.calibration.properties):
            half_space = getattr(calibrated.targets[body].solid.constants, name)
            transition = getattr(calibrated.fits[body].effective, name)
            fixed = [
                parameter.name.removeprefix(f"{name}.")
                for parameter in calibrated.fits[body].parameters
                if parameter.name.startswith(f"{name}.") and parameter.deviation is None
            ]
            note = f" (not determined: {join_words(fixed)})" if fixed else ""
            yield (
                f"{PROPERTIES[name].split()[0]} {body_name(body)}{_in_scene(one, reported)} goes from "
                f"{half_space:.3g} at the load to {transition.far:.3g} at {transition.r_inf:.3g} mm{note}"
            )


def _errors_table(one: Reported) -> Table:
    """Return the worst errors on the lines of a scene, a row per body and variant."""
    scene, components = one.calibrated.scene, _components(one)
    rows = []
    for body in scene.compared:
        name = body  # of the first row
        for variant in (*scene.variants, "C"):
            variant_errors = one.errors.sel(body=body, variant=variant)
            place, is_estimate = row_name(variant), variant == "C"
            row = error_row(name, variant_errors, components, is_estimate=is_estimate, place=place)
            if any(cell.text != "–" for cell in row.filled[1:]):
                rows.append(row)
                name = ""
    return Table("body", [*texts("ICs"), *numbers(*components)], rows)
