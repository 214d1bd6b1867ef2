"""`femic calibrate` writes the fits, the scenes with them, figures and one report.

The charts show fitted properties and what they leave of C; C without curvature, and translated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, product
from pathlib import Path

import numpy as np
import tomlkit
import xarray as xr

from approx.calibration import Parameter, pointwise_k
from compare.pages import ics_figures as curves
from compare.pages.ics import body_name, row_name
from compare.pages.ics_figures import shown_half
from compare.report.charts import Chart, Curve, Panel
from compare.report.errors import MEASURE, VANISHING, error_row, percent
from compare.report.looks import FURTHER, Look, looks_of, symbol_of, without_marker
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_page
from compare.report.tables import Row, Table, numbers, texts, with_estimate
from femic.cache.files import write_dataset, write_text
from femic.results.calibration import (
    REPORTED_COMPONENTS,
    Calibrated,
    properties_table,
    to_dataset,
    with_properties,
)
from femic.results.ics import Results, points_of, reference_of
from femic.results.ics_dataset import errors
from femic.results.ics_dataset import to_dataset as ics_of
from geometries.arrays import Array
from geometries.patches import N, OffsetLine, S, indices

# --- files and the page ---------------------------------------------------------------------------------


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
class FitReport:
    """A calibrated scene, its ICs, and their errors on the lines of the scene, the worst over lines."""

    calibrated: Calibrated
    ics: xr.Dataset
    errors: xr.Dataset

    @classmethod
    def measure(cls, calibrated: Calibrated) -> "FitReport":
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
    reported = [FitReport.measure(calibrated) for calibrated in calibrations]
    return Page(title, summary(reported), _sections(reported), answer_table(reported))


def _sections(reported: Sequence[FitReport]) -> Iterator[Section | Folded]:
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


def answer_table(reported: Sequence[FitReport]) -> Table:
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


def _components(one: FitReport) -> list[str]:
    """Return the fitted components of a scene, then the others that every report shows."""
    return list(dict.fromkeys((*one.calibrated.scene.calibration.components, *REPORTED_COMPONENTS)))


def _answer_cells(one: FitReport, body: str, name: str, components: Sequence[str]) -> list[str]:
    body_fit = one.calibrated.fits[body]
    parameters = {parameter.name: parameter for parameter in body_fit.parameters}
    changes = [_change_text(one, body, component) for component in components]
    values = [_value(parameters[f"{name}.{part}"]) for part in ("far", "r_inf")]
    return [*values, f"{100 * float(np.max(body_fit.rms)):.2g}", *changes]


def _change_text(one: FitReport, body: str, component: str) -> str:
    """Return the errors of a component without and with the fit [%], a dash where it was not computed."""
    if component not in one.calibrated.scene.components:
        return "–"
    without, with_fit = (f"{100 * error:.3g}" for error in one.change(body, component))
    vanishes = one.errors.vanishes.sel(body=body, i=component[0], j=component[1]).item()
    return f"{without} → {with_fit}{VANISHING if vanishes else ''}"


def summary(reported: Sequence[FitReport]) -> str:
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
        f"{'; '.join(_fit_sentences(reported))}. With B̂′ instead of B̂, the largest error on the lines goes "
        f"{join_words(better)}. It grows in {others}."
    )


def _where(one: FitReport, body: str, reported: Sequence[FitReport]) -> str:
    """Return the body and the scene of a fit as far as they are not the same for all fits."""
    bodies = {name for each in reported for name in each.calibrated.fits}
    return (f" {body_name(body)}" if len(bodies) > 1 else "") + _in_scene(one, reported)


def _in_scene(one: FitReport, reported: Sequence[FitReport]) -> str:
    return f" in {one.name}" if len(reported) > 1 else ""


def _fit_sentences(reported: Sequence[FitReport]) -> Iterator[str]:
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


def _errors_table(one: FitReport) -> Table:
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


# --- charts ---------------------------------------------------------------------------------------------


PROPERTIES = {"mismatch_k": "K [-]", "G": "G [MPa]", "nu": "ν [-]"}
COMPARED = ("Bhat", "Bhat_prime")  # without and with the fit
WITHOUT, REFITTED = "C without curvature", "C, translation refitted to B̂′"
C_BESIDE = {  # the component that each C is about, and the ICs beside it
    WITHOUT: ("xn", ("Bhat_prime", "C"), Look("#808080", "dash", width=2.2)),
    REFITTED: ("sn", ("B", "Bhat", "Bhat_prime", "C"), Look("#17a2a2", "dash", width=2.2)),
}
MARKERS = ("circle-open", "square-open", "diamond-open", "triangle-up-open", "hexagon-open")
MARKED = 20  # most marks of a line
MICROMETRES_PER_KILONEWTON = 1e6  # of mm/N


def fits(calibrations: Sequence[Calibrated]) -> Chart:
    """Return the fitted properties over the distance, and what they leave of C, a step per scene."""
    steps = {calibrated.scene.name: list(_of_fits(calibrated, calibrations)) for calibrated in calibrations}
    return Chart("fits", steps, 2, "scene", 0.95, next(iter(steps)))


def _of_fits(calibrated: Calibrated, others: Sequence[Calibrated]) -> Iterator[Panel]:
    for body in calibrated.fits:
        for name in calibrated.scene.calibration.properties:
            yield _property(calibrated, others, body, name)
    for body, target in calibrated.targets.items():
        for component in target.components:
            yield _residual(calibrated, body, component)


def _property(calibrated: Calibrated, others: Sequence[Calibrated], body: str, name: str) -> Panel:
    """Return a property over the distance, as fitted in all scenes; if only xn is fitted, the K of points."""
    target = calibrated.targets[body]
    curves = list(_marks(calibrated, body)) if (name, target.components) == ("mismatch_k", ("xn",)) else []
    for other, look in zip(others, cycle(FURTHER), strict=False):
        transition = getattr(other.fits[body].effective, name) if body in other.fits else None
        if transition is not None:
            r = np.linspace(0.0, float(np.max(other.targets[body].r)), 200)
            half_space = getattr(other.targets[body].solid.constants, name)
            curves.append(Curve(f"fit, {other.scene.name}", r, transition.at(r, half_space), look))
    return Panel(f"{body}: effective {PROPERTIES[name]}", "r [mm]", PROPERTIES[name], curves)


def _lines(calibrated: Calibrated) -> Iterator[tuple[str, slice]]:
    """Yield the lines of the calibration, and which of its points are theirs."""
    start = 0
    for line in calibrated.scene.calibration.lines:
        yield line.name.removeprefix("fit "), slice(start, start + len(line.x))
        start += len(line.x)


def _marks(calibrated: Calibrated, body: str) -> Iterator[Curve]:
    """Yield the K with which B-hat has the value of C at a point, for some points of each line."""
    target = calibrated.targets[body]
    k = pointwise_k(target)[0]
    for (line, part), marker in zip(_lines(calibrated), cycle(MARKERS), strict=False):
        r, k_of_line = target.r[part], k[part]
        shown = slice(None, None, -(-len(r) // MARKED))
        yield Curve(f"K at {line}", r[shown], k_of_line[shown], Look("#808080", "", marker))


def _residual(calibrated: Calibrated, body: str, component: str) -> Panel:
    """Return differences of approximations from C at the fitted points, and its estimate [% of max |C|]."""
    target, looks = calibrated.targets[body], looks_of(("C", *COMPARED))
    k = target.components.index(component)
    unit, error = 100 / target.scales[k], np.broadcast_to(target.error, target.ics.shape)[k]
    ics = {
        "C": target.ics[k],
        "Bhat": target.approximate("Bhat")[k],
        "Bhat_prime": target.bhat_prime(calibrated.fits[body].effective)[k],
    }
    curves = [
        Curve(
            symbol_of(name),
            target.r[part],
            unit * (values - ics["C"])[part],
            without_marker(looks[name]),
            unit * error[part] if name == "C" else None,
        )
        for name, values in ics.items()
        for _, part in _lines(calibrated)
    ]
    return Panel(
        f"{body}: {component} minus C, fitted points",
        "r [mm]",
        f"Δ{component} [% of max |C|]",
        curves,
    )


def translation(calibrated: Calibrated) -> float:
    """Return the vertical translation [mm/N] that brings C_sn closest to B-hat-prime on the scene's lines.

    In local directions of the lower body, its s component is the translation times -sin(delta).
    """
    points = points_of(calibrated.results, calibrated.scene.lines)
    lean = _lean(calibrated, calibrated.results.points.s[points])
    c = reference_of(calibrated.results, "combined").ic[S, N, points]
    difference = calibrated.results.approximations["Bhat_prime", "combined"][S, N, points] - c
    return -float(lean @ difference) / max(float(lean @ lean), 1e-300)


def _lean(calibrated: Calibrated, s: Array) -> Array:
    """Return the sine of the lower body's inclination at arc lengths, (n,)."""
    return np.sin(calibrated.scene.bodies["lower"].contour.inclination(s))


def curve(calibrated: Calibrated, name: str, component: str, part: slice) -> Array:
    """Return a component of both bodies [mm/N], (n,), at points: C, an approximation or one of `C_BESIDE`."""
    i, j = indices(component)
    c = reference_of(calibrated.results, "combined").ic[i, j, part]
    x, s = calibrated.results.points.x[part], calibrated.results.points.s[part]
    patch = calibrated.scene.patch
    if name == "C":
        return np.asarray(c)
    if name == WITHOUT:
        return np.asarray(c - calibrated.scene.pair.curvature(patch, (x, s))[i, j] / patch.area)
    if name == REFITTED:
        return np.asarray(c - _lean(calibrated, s) * translation(calibrated))
    return np.asarray(calibrated.results.approximations[name, "combined"][i, j, part])


def other_c(calibrations: Sequence[Calibrated]) -> Chart:
    """Return C without curvature, and with another translation, beside B-hat-prime; a step per scene."""
    steps = {
        calibrated.scene.name: [
            _beside(calibrated, name, line) for name in C_BESIDE for line in calibrated.scene.lines
        ]
        for calibrated in calibrations
    }
    columns = max(len(calibrated.scene.lines) for calibrated in calibrations)
    return Chart("other_c", steps, columns, "scene", start=next(iter(steps)))


def _beside(calibrated: Calibrated, name: str, line: OffsetLine) -> Panel:
    component, others, look = C_BESIDE[name]
    scene, part = calibrated.scene, calibrated.results.lines[line.name]
    shown = shown_half(scene, line)
    looks = {name: look} | looks_of(others)
    curves = [
        Curve(
            one if one == name else symbol_of(one),
            line.running[shown],
            MICROMETRES_PER_KILONEWTON * curve(calibrated, one, component, part)[shown],
            without_marker(looks[one]),
        )
        for one in looks
    ]
    return Panel(f"combined, {line.name}", f"{line.along} [mm]", f"{component} [µm/kN]", curves)
