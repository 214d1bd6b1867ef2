"""`femic calibrate` writes the fits, the scenes with them, figures and one report.

The charts show fitted properties and what they leave of C; C without curvature, and translated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import cycle, product
from pathlib import Path

import numpy as np
import tomlkit
import xarray as xr

from approx.calibration import Parameter, pointwise_k
from compare.pages.ics import row_name
from compare.pages.ics_figures import along_line, chart, is_mirrored, lines_in
from compare.report.charts import Chart, Curve, Panel
from compare.report.errors import MEASURE, VANISHING, error_row, percent
from compare.report.looks import FURTHER, Look, ics_looks, ics_symbol, without_marker
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_page
from compare.report.tables import ROUNDING, Cell, Row, Table, numbers, texts, with_estimate
from compare.report.verdicts import NO, NOT_DECIDED
from compare.report.verdicts import verdict as is_within
from femic.cache.files import write_dataset, write_text
from femic.results.calibration import (
    REPORTED_COMPONENTS,
    FittedScene,
    properties_table,
    to_dataset,
    with_properties,
)
from geometries.patches import N, S

# --- files and the page ---------------------------------------------------------------------------------


METHOD = (
    "B̂′ is B̂ with elastic properties that depend on the distance from the load. They change from the "
    "half-space value at the load to a far value at the distance r_∞: f(r) = f⁰ + (f_∞ − f⁰)·[(1 − ρ) ρᵐ "
    "+ ρ (1 − (1 − ρ)ⁿ)], ρ = min(1, r/r_∞). A weighted least-squares fit to C for one lateral load "
    "position gives the parameters."
)
CURVATURE_APART = (
    "The fit leaves out curvature along x: its effect is subtracted first, and B̂′ adds it again as B̂ does."
)
CURVATURE_FITTED = "The fit includes the curvature of wheels along x; B̂′ adds no other curvature term."
DEVIATIONS = (
    "The standard deviations assume that the deviations of the points are independent and as large as the "
    "residual (or as the estimated error of C, if that is larger). They are not independent, because f is "
    "only a model of C. Use the standard deviations to see which parameters the data determine."
)
READING = (
    "Panels “effective …”: the fit, and the K that makes B̂ equal to C at a point, −(C_xn + A_xs sin "
    "½α{})·πG/(J_x cos ½α). Panels “… minus C”: differences of the approximations from C at the points of "
    "the fit; band: estimated error of C. Table: root mean square of this difference with B̂′ (residual), "
    "and the largest errors on the lines of the scene with B̂ → with B̂′, relative to the component. “Not "
    "decided”: both errors differ by less than the estimated error of C."
)
OTHER_C = (
    "C without curvature: C minus the part that the curvature of the wheel along x adds to B̂. "
    "Translation refitted: C_sn with another vertical rigid translation, fitted to B̂′ on the lines by "
    "least squares{}."
)


def shown_components(calibrated: FittedScene) -> list[str]:
    """Return the fitted components, then the others that every report shows."""
    return list(dict.fromkeys((*calibrated.scene.calibration.components, *REPORTED_COMPONENTS)))


def errors_without_and_with(calibrated: FittedScene, body: str, component: str) -> list[float]:
    """Return the errors of a component without and with the fit [-]."""
    at = calibrated.errors.error.sel(body=body, i=component[0], j=component[1])
    return [at.sel(variant=name).item() for name in COMPARED]


def write_fit(calibrated: FittedScene, folder: Path) -> Path:
    """Write `calibration.nc` and `SCENE_calibrated.toml`, the scene with its fits; returns its path."""
    scene = calibrated.scene
    write_dataset(to_dataset(calibrated), folder / "calibration.nc")
    effective = {body: body_fit.effective for body, body_fit in calibrated.fits.items()}
    return write_text(with_properties(scene, effective), folder / f"{scene.name}_calibrated.toml")


def write_report(calibrations: Sequence[FittedScene], folder: Path) -> Path:
    """Write the figures and `calibration.html` of one or more scenes; returns the path of the page."""
    title = "Fit of B̂′ to C: " + ", ".join(calibrated.scene.name for calibrated in calibrations)
    answer, doubtful = answer_table(calibrations), list(doubts(calibrations))
    page = Page(title, summary(calibrations), _sections(calibrations), answer, doubtful)
    return write_page(page, folder / "calibration.html", "calibration")


def summary(calibrations: Sequence[FittedScene]) -> str:
    """Return the errors of the fitted components without and with the fit, and whether it is better."""
    changes = []
    for one in calibrations:
        for body, component in product(one.fits, one.scene.calibration.components):
            before, after = errors_without_and_with(one, body, component)
            known = percent(_estimate(one, body, component))
            changes.append(
                f"{one.scene.name}, {body} C_{component}: {percent(before)} with B̂, {percent(after)} with "
                f"B̂′, ± {known} ({_verdict(one, body, component)})"
            )
    return (
        f"Largest errors on the lines of the scene, ± the estimated error of C: {'; '.join(changes)}. All "
        "numbers are relative to the component itself."
    )


BETTER, WORSE, SAME = "better", "worse", "the same"


def verdict(before: float, after: float, estimate: float) -> str:
    """Return whether an error after the fit is better than before; errors are known to an estimate."""
    change = abs(after - before)
    if np.isnan(change):
        return "not known"
    if change <= ROUNDING:
        return SAME
    if is_within(change, estimate, 0.0) != NO:
        return NOT_DECIDED
    return BETTER if after < before else WORSE


def _verdict(calibrated: FittedScene, body: str, component: str) -> str:
    before, after = errors_without_and_with(calibrated, body, component)
    return verdict(before, after, _estimate(calibrated, body, component))


def _estimate(calibrated: FittedScene, body: str, component: str) -> float:
    """Return the estimated error of C on the scale of errors of a component [-]."""
    at = {"body": body, "variant": "C", "i": component[0], "j": component[1]}
    return float(calibrated.errors.error.sel(at).item())


def doubts(calibrations: Sequence[FittedScene]) -> Iterator[str]:
    """Yield components that the fit makes worse, and parameters that it could not determine."""
    for one in calibrations:
        shown = [component for component in shown_components(one) if component in one.scene.components]
        for body, body_fit in one.fits.items():
            name = f"{one.scene.name}, {body}"
            worse = [component for component in shown if _verdict(one, body, component) == WORSE]
            if worse:
                yield f"{name}: B̂′ is worse than B̂ in {join_words(worse)}."
            for parameter in body_fit.parameters:
                if parameter.note:
                    yield f"{name}, {parameter.name}: {parameter.note}"


def _sections(calibrations: Sequence[FittedScene]) -> Iterator[Section | Folded]:
    curvature = " − curvature term" if calibrations[0].scene.calibration.curvature_apart else ""
    yield Section("", [fits(calibrations), Note(READING.format(curvature))])
    for one in calibrations:
        name, start = one.scene.name, one.scene.calibration.components[0]
        named = replace(chart({name: one.ics}), name=f"curves_{name}", start=start)
        block = Section if len(calibrations) == 1 else Folded
        yield block(f"ICs of {name} on its lines, and their differences from C", [named])
    tables = [Section(one.scene.name, [_errors_table(one)]) for one in calibrations]
    note = Note(f"{MEASURE} Rows “C ±”: the estimated error of C.")
    yield Folded("Errors on the lines of the scene", [*tables, note])
    for one in calibrations:
        yield Folded(f"Parameters of {one.scene.name}, and its scene", list(_parameters(one)))
    if all("combined" in calibrated.fits for calibrated in calibrations):
        moved = ", ".join(f"{one.scene.name}: {1e6 * translation(one):.3g} µm/kN" for one in calibrations)
        text = OTHER_C.format(f" ({moved})")
        yield Folded("C without curvature, and with another translation", [other_c(calibrations), text])


def _parameters(calibrated: FittedScene) -> Iterator[Block]:
    """Yield how a scene was fitted, and the parameters of each body with the table for scene files."""
    scene, target = calibrated.scene, next(iter(calibrated.targets.values()))
    lines = ", ".join(line.name.removeprefix("fit ") for line in scene.calibration.lines)
    curvature = CURVATURE_APART if scene.calibration.curvature_apart else CURVATURE_FITTED
    yield METHOD
    yield f"Points: lines {lines}, x = {np.min(target.x):.3g} ... {np.max(target.x):.3g} mm. {curvature}"
    for body, body_fit in calibrated.fits.items():
        snippet = {"effective": {body: properties_table(scene, body, body_fit.effective)}}
        shares = zip(scene.calibration.components, body_fit.rms, body_fit.worst, strict=True)
        residuals = ", ".join(f"{c}: {rms:.1%} rms, {worst:.1%} at most" for c, rms, worst in shares)
        rows = [Row(parameter.name, [_value(parameter), parameter.note]) for parameter in body_fit.parameters]
        columns = [*numbers("value", unit="mm, MPa"), *texts("note")]
        residual = (
            f"Residual relative to max |C_ij| of the fitted points: {residuals}. Lines for a scene file "
            f"(already in `{scene.name}_calibrated.toml`):"
        )
        text = Verbatim(tomlkit.dumps(snippet).strip())
        yield Section(body, [Table("parameter", columns, rows), residual, text])
    yield Note(DEVIATIONS)
    yield Folded("Scene file", [Verbatim(scene.text)])


def _value(parameter: Parameter) -> str:
    """Return a parameter with its standard deviation, or that it was not fitted."""
    if parameter.deviation is None:
        return f"{parameter.value:.5g} (fixed)"
    return with_estimate(parameter.value, parameter.deviation)


def answer_table(calibrations: Sequence[FittedScene]) -> Table:
    """Return what was fitted, and errors without and with it; a row for each property of each body."""
    components = list(dict.fromkeys(component for one in calibrations for component in shown_components(one)))
    rows = []
    for one in calibrations:
        scene, scene_name = one.scene, [one.scene.name] if len(calibrations) > 1 else []
        for body, name in product(one.fits, scene.calibration.properties):
            body_fit, changes = one.fits[body], []
            for component in components:
                errors = [f"{100 * error:.3g}" for error in errors_without_and_with(one, body, component)]
                vanishes = one.errors.vanishes.sel(body=body, i=component[0], j=component[1]).item()
                text = f"{' → '.join(errors)}{VANISHING if vanishes else ''}"
                found = _verdict(one, body, component)
                changes.append(Cell(text, below=found) if component in scene.components else "–")
            parameters = {parameter.name: parameter for parameter in body_fit.parameters}
            values = [_value(parameters[f"{name}.{part}"]) for part in ("far", "r_inf")]
            cells = [*values, f"{100 * float(np.max(body_fit.rms)):.2g}", *changes]
            rows.append(Row(", ".join([*scene_name, body, PROPERTIES[name]]), cells))
    heads = [f"{component}: B̂ → B̂′" for component in components]
    columns = [*numbers("far value"), *numbers("r_∞", unit="mm"), *numbers("residual", *heads, unit="%")]
    return Table("fit", columns, rows)


def _errors_table(one: FittedScene) -> Table:
    """Return the worst errors on the lines of a scene, a row per body and variant."""
    scene, components, rows = one.scene, shown_components(one), []
    for body in scene.compared:
        name = body  # of the first row
        for variant in (*scene.variants, "C"):
            errors, place = one.errors.sel(body=body, variant=variant), row_name(variant)
            row = error_row(name, errors, components, is_estimate=variant == "C", place=place)
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


def fits(calibrations: Sequence[FittedScene]) -> Chart:
    """Return the fitted properties over the distance, and what they leave of C, a step per scene."""
    steps = {}
    for calibrated in calibrations:
        properties = product(calibrated.fits, calibrated.scene.calibration.properties)
        targets = calibrated.targets.items()
        steps[calibrated.scene.name] = [
            *(_property(calibrated, calibrations, body, name) for body, name in properties),
            *(_residual(calibrated, body, c) for body, target in targets for c in target.components),
        ]
    return Chart("fits", steps, 2, "scene", 0.95, next(iter(steps)))


def _property(calibrated: FittedScene, others: Sequence[FittedScene], body: str, name: str) -> Panel:
    """Return a property over the distance, as fitted in all scenes.

    If only xn is fitted, marks are the K with which B-hat has the value of C at some points of each line.
    """
    target, curves = calibrated.targets[body], []
    if (name, target.components) == ("mismatch_k", ("xn",)):
        k = pointwise_k(target)[0]
        for (line, part), marker in zip(_lines(calibrated), cycle(MARKERS), strict=False):
            r, k_of_line = target.r[part], k[part]
            shown = slice(None, None, -(-len(r) // MARKED))
            curves.append(Curve(f"K at {line}", r[shown], k_of_line[shown], Look("#808080", "", marker)))
    for other, look in zip(others, cycle(FURTHER), strict=False):
        transition = getattr(other.fits[body].effective, name) if body in other.fits else None
        if transition is not None:
            r = np.linspace(0.0, float(np.max(other.targets[body].r)), 200)
            half_space = getattr(other.targets[body].solid.constants, name)
            curves.append(Curve(f"fit, {other.scene.name}", r, transition.at(r, half_space), look))
    return Panel(f"{body}: effective {PROPERTIES[name]}", "r [mm]", PROPERTIES[name], curves)


def _lines(calibrated: FittedScene) -> Iterator[tuple[str, slice]]:
    """Yield the lines of the calibration, and which of its points are theirs."""
    start = 0
    for line in calibrated.scene.calibration.lines:
        yield line.name.removeprefix("fit "), slice(start, start + len(line.x))
        start += len(line.x)


def _residual(calibrated: FittedScene, body: str, component: str) -> Panel:
    """Return differences of approximations from C at the fitted points, and its estimate [% of max |C|]."""
    target, looks = calibrated.targets[body], ics_looks(("C", *COMPARED))
    k = target.components.index(component)
    unit, error = 100 / target.scales[k], np.broadcast_to(target.error, target.ics.shape)[k]
    ics = {
        "C": target.ics[k],
        "Bhat": target.approximate("Bhat")[k],
        "Bhat_prime": target.bhat_prime(calibrated.fits[body].effective)[k],
    }
    curves = [
        Curve(
            ics_symbol(name),
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


def translation(one: FittedScene) -> float:
    """Return the vertical translation [mm/N] that brings C_sn closest to B-hat-prime on the scene's lines.

    In local directions of the lower body, its s component is the translation times -sin(delta).
    """
    lean = np.sin(one.scene.bodies["lower"].contour.inclination(one.ics.s.values))
    ic = one.ics.ic.sel(body="combined", i="s", j="n")
    difference = (ic.sel(variant="Bhat_prime") - ic.sel(variant="C")).values
    return -float(lean @ difference) / max(float(lean @ lean), 1e-300)


def ics_with_other_c(one: FittedScene) -> xr.Dataset:
    """Return the ICs of both bodies, among them the two C of `C_BESIDE` [mm/N]."""
    scene, c = one.scene, one.ics.ic.sel(variant="C", body=["combined"])
    places = one.ics.x.values, one.ics.s.values
    without = c - scene.pair.curvature(scene.patch, places) / scene.patch.area
    moved = np.zeros(c.shape)
    moved[0, S, N] = translation(one) * np.sin(scene.bodies["lower"].contour.inclination(places[1]))
    both = xr.concat([without, c - moved], xr.Variable("variant", [WITHOUT, REFITTED]))
    ic = xr.concat([one.ics.ic.sel(body=["combined"]), both], "variant")
    return ic.to_dataset(name="ic").assign_attrs(one.ics.attrs)


def other_c(calibrations: Sequence[FittedScene]) -> Chart:
    """Return C without curvature, and with another translation, beside B-hat-prime; a step per scene."""
    steps: dict[str, list[Panel]] = {}
    for one in calibrations:
        ics, lines, steps[one.scene.name] = ics_with_other_c(one), lines_in(one.ics), []
        for (name, (component, others, look)), line in product(C_BESIDE.items(), lines):
            part = along_line(ics, line, "combined", component, dimensionless=False)
            if is_mirrored(one.ics, line):
                part = part.isel(point=part["at"].values >= 0)
            curves = [
                Curve(
                    label,
                    part["at"].values,
                    part.ic.sel(variant=variant).values,
                    without_marker(look_of_curve),
                )
                for variant, label, look_of_curve in (
                    (name, name, look),
                    *((other, ics_symbol(other), its) for other, its in ics_looks(others).items()),
                )
            ]
            steps[one.scene.name].append(Panel(f"combined, {line}", part.across, part.up, curves))
    columns = max(len(one.scene.lines) for one in calibrations)
    return Chart("other_c", steps, columns, "scene", start=next(iter(steps)))
