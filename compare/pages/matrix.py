"""`femic matrix` computes the IC matrices of a scene and writes the file, the figures and the report."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compare.pages.ics import body_name, row_name
from compare.pages.ics_figures import combined_first, main_body
from compare.pages.matrix_figures import chart, response
from compare.report.errors import COMPONENTS as COMPONENT_NAMES
from compare.report.errors import error_cell, percent
from compare.report.looks import symbol_of
from compare.report.parts import Folded, Note, Page, Section, Verbatim, write_page
from compare.report.tables import Cell, Row, Table, numbers, texts
from femic.cache.digests import PAGE_FOLDERS, results_digest
from femic.contact.operators.dense import Reciprocity
from femic.reference.engine import Cost
from femic.reference.refinement import ModelPlan, total_seconds
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.ics import models_of, seconds_of
from femic.results.matrices import MatrixResults, compute_matrix, discounted, expected_seconds, matrix_plans
from femic.results.matrix_check import ColumnCheck, check_columns
from femic.scenes import receipts
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS, Grid, N

COMMAND = "matrix"
ACCURACY = (
    "Largest estimated error of C over all lags and pairs of strips, and its largest parts, on the scale of "
    "refinement, to which the tolerance applies. Four elements from the load and further that is the larger "
    "of max |C_ij| and 0.05 max A_nn over the lags of a pair of strips; nearer: 5 A_nn at the same place. As "
    "shares of the components themselves: rows “C” below. The file has an estimate for each entry."
)
REQUIREMENTS = (
    "Reciprocity: largest |C(I, J) − C(J, I)ᵀ| of the raw solution over the largest value of the same "
    "component, where it is largest. Loads act on whole elements, displacements are read at centres: ICs "
    "of curved bodies are not exactly reciprocal, and least so where a joint of arc and flank lies in a "
    "strip, because local directions are constant beyond it. Work: smallest eigenvalue of the symmetric "
    "part over the least IC of an element on itself; positive: tractions always do work."
)
TOO_LARGE = "Not computed: the matrices of this grid are too large to be kept in memory."
CHECKS = (
    "Single loads in 3D, on three observing strips: the largest difference from the matrix, as a share of "
    "the component itself (without vanishing ones), the sum of both estimates there, and the largest ratio "
    "of a difference to this sum."
)
WORST = (
    "C is taken after the discount of [BVSV] here. Four elements from the load and further: the largest |V "
    "− C| of a component as a share of its own largest |C_ij| there. Small, below it: nearer entries, "
    "shares of A_nn at the same place. † C_ij vanishes there, share of 0.05 max |C_nn|."
)
APPROXIMATIONS = (
    "Approximations are ICs of half-spaces, so C is taken after the discount of [BVSV] here, which also "
    "takes away the bending of the section. Largest displacement error that tractions of at most 1 anywhere "
    "on the grid can cause, as a share of the largest displacement that the component itself can cause. "
    "Small, below it: the weight, the same as a share of the largest displacement by normal tractions. "
    "“Vanishes”: the component is zero, or the displacement that it causes is less than ten times its "
    "estimated error; an "
    "approximation is then tested as a zero, and its number, with †, is a share of 0.05 of the largest "
    "displacement by normal tractions. Row “C”: the estimated error of C itself."
)
MEASURES = {  # of `Deviation`: the errors, the weights below them, and which components vanish
    "displacements": ("own_displacement_error", "displacement_error", "negligible"),
    "worst": ("worst", "near", "vanishing"),
}


@dataclass(frozen=True, eq=False)
class MatrixOutput:
    """The matrices of a scene as they are reported: their file, the plans of their models, and checks."""

    results: MatrixResults
    file: Path
    plans: Sequence[ModelPlan]
    checks: Sequence[ColumnCheck]
    strip: int  # loaded in charts


def write_matrix(scene: Scene, out: Path, strip: int | None = None, options: RunOptions = DEFAULT) -> Path:
    """Write `matrix.nc`, figures of one loaded strip and `matrix.html`; returns the path of the page.

    By default the loaded strip is the one nearest to the patch. Nothing is computed if the folder has the
    same results already. Raises WrongInput for a strip that the grid does not have.
    """
    watch, workers = options.watch, options.workers
    loaded_strip = _loaded_strip(scene, strip)
    path, key = out / "matrix.html", receipts.key_of(scene, results_digest(*PAGE_FOLDERS), loaded_strip)
    if receipts.holds(out, COMMAND, key):
        watch.on_stage("  as it is there already")
        return path
    model_plans = matrix_plans(scene, workers)
    watch.on_stage(
        f"  about {total_seconds(model_plans, workers):.0f} s, "
        f"{max(plan.expected.memory for plan in model_plans):.0f} MB for models that are not stored yet, "
        f"then {expected_seconds(scene):.0f} s"
    )
    with receipts.renewed(out, COMMAND, key, ["matrix.nc", path.name]):
        results = compute_matrix(scene, out / "matrix.nc", options)
        checks = check_columns(results, options)
        output = MatrixOutput(results, out / "matrix.nc", model_plans, checks, loaded_strip)
        write_page(page_of(output), path, COMMAND)
    return path


def _loaded_strip(scene: Scene, strip: int | None) -> int:
    n_s = scene.grid.n_s
    if strip is None:
        return int(np.argmin(np.abs(scene.grid.strips - scene.patch.s)))
    if not 0 <= strip < n_s:
        raise WrongInput(f"--strip {strip}: the grid has strips 0 ... {n_s - 1}")
    return strip


def page_of(output: MatrixOutput) -> Page:
    """Return the page of the matrices of a scene."""
    title = f"IC matrix: {output.results.scene.title}"
    return Page(title, summary(output), _sections(output), answer_table(output.results, output.checks))


def _sections(output: MatrixOutput) -> Iterator[Section | Folded]:
    results, checks = output.results, output.checks
    scene, costs = results.scene, models_of(results.matrices)
    yield Section("", [chart(response(results, output.strip)), Note(_chart_text(scene, output.strip))])
    yield Folded("Estimated errors of C", [f"{discounted(scene)} {ACCURACY}", _accuracy_table(results)])
    missing = "" if results.eigenvalues else TOO_LARGE
    yield Folded("Reciprocity and positive work", [REQUIREMENTS, missing, _requirements_table(results)])
    if checks:
        heading = "Columns computed with the solid engine"
        yield Folded(heading, [_checks_text(scene, checks), _checks_table(checks)])
    for body in combined_first(scene.compared):
        displacements, worst = (_errors_table(results, body, measure) for measure in MEASURES)
        heading, entries = (
            f"Errors of approximations of the {body} matrix",
            Folded("Worst entries", [WORST, worst]),
        )
        yield Folded(heading, [APPROXIMATIONS, displacements, entries])
    yield Folded("Cost: expected / actual", [_cost_table(output.plans, costs), _cost_text(results, costs)])
    yield Folded("The scene", [Verbatim(scene.text)])


def _accuracy_table(results: MatrixResults) -> Table:
    columns = [*numbers("estimate"), *texts("worst at"), *numbers("mesh", "domain", "wavenumbers")]
    rows = [
        Row(
            name,
            [
                Cell(shares.total, ".3%"),
                f"{shares.component} {shares.line}",
                *(Cell(part, ".3%") for part in (shares.mesh, shares.truncation, shares.waves)),
            ],
        )
        for name, shares in results.errors.items()
    ]
    return Table("body", columns, rows)


def _requirements_table(results: MatrixResults) -> Table:
    """Return the table of the reciprocity defect and the smallest eigenvalue of each matrix."""
    rows = []
    for name, eigenvalue in results.eigenvalues.items():
        body, _, kind = name.partition(", ")
        defect = (
            reciprocity_text(results.reciprocity[body], results.scene.grid) if kind == "raw" else "as raw"
        )
        rows.append(Row(name, [defect, Cell(eigenvalue, ".3f")]))
    return Table("matrix", [*texts("reciprocity defect"), *numbers("smallest eigenvalue")], rows)


def reciprocity_text(defect: Reciprocity, grid: Grid) -> str:
    """Return text for the report: the largest defect, its place, and the largest away from joints."""
    first, second = sorted(defect.strips)
    where = f"{defect.worst:.1e} of {defect.component} (strips {first} and {second}, "
    where += f"s = {grid.strips[first]:.3g}, {grid.strips[second]:.3g} mm)"
    if not defect.at_joints:
        return where
    elsewhere = "" if defect.elsewhere is None else f"; {defect.elsewhere:.1e} without these"
    return f"{where}; joints in strips {', '.join(map(str, defect.at_joints))}{elsewhere}"


def _checks_text(scene: Scene, checks: Sequence[ColumnCheck]) -> str:
    minutes = scene.grid.n_s * np.mean([check.seconds for check in checks]) / 60
    return (
        f"{CHECKS} All {scene.grid.n_s} strips of a body would take {minutes:.0f} minutes (extrapolated from "
        "these)."
    )


def _checks_table(checks: Sequence[ColumnCheck]) -> Table:
    columns = ["strip", "difference", "allowed", "largest difference / allowed", "s"]
    rows = [
        Row(
            check.body,
            [
                str(check.strip),
                f"{check.difference:.2%} ({check.component})",
                Cell(check.allowed, ".2%"),
                Cell(check.closest, ".2f"),
                Cell(check.seconds, ".0f"),
            ],
        )
        for check in checks
    ]
    return Table("body", columns, rows)


def _errors_table(results: MatrixResults, body: str, measure: str) -> Table:
    """Return a table with a row per approximation and one for C, by a measure of `MEASURES`."""
    rows = []
    for variant, deviation in results.deviations[body].items():
        values = (getattr(deviation, name).ravel() for name in MEASURES[measure])
        cells = [
            error_cell(float(error), float(weight), vanishes=bool(vanishes), is_estimate=variant == "C")
            for error, weight, vanishes in zip(*values, strict=True)
        ]
        rows.append(Row(row_name(variant), cells))
    return Table("variant", COMPONENTS, rows)


def _chart_text(scene: Scene, strip: int) -> str:
    grid, body = scene.grid, body_name(main_body(scene.compared))
    return (
        f"Displacements {body} per total load of 1 kN on an element of strip {strip} (cross, s = "
        f"{grid.strips[strip]:.3g} mm); at x < 0, xs, sx, xn and nx change sign. The first map is the matrix "
        "of the file. Approximations are ICs of half-spaces: they are compared with C after the discount of "
        f"[BVSV], with the band of its estimate. {COMPONENT_NAMES}"
    )


def answer_table(results: MatrixResults, checks: Sequence[ColumnCheck]) -> Table:
    """Return how good each matrix is: estimate, reciprocity, positive work, and columns solved again."""
    rows = []
    for body in combined_first(results.scene.compared):
        shares, defect = results.errors[body], results.reciprocity.get(body)
        eigenvalue = results.eigenvalues.get(f"{body}, discounted", np.nan)
        cells: list[Cell | str] = [
            f"{100 * shares.total:.2g} ({shares.component})",
            f"{100 * defect.worst:.2g} ({defect.component})" if defect else "–",
            Cell(eigenvalue, ".2f"),
        ]
        if checks:
            cells.append(Cell(max((c.closest for c in checks if c.body == body), default=np.nan), ".2f"))
        rows.append(Row(body, cells))
    heads = [
        *numbers("estimated error", "reciprocity defect", unit="%"),
        *numbers("smallest eigenvalue", unit="1"),
        *(numbers("solid engine: difference / estimates", unit="1") if checks else []),
    ]
    return Table("body", heads, rows)


def summary(output: MatrixOutput) -> str:
    """Return how good the matrices are, what they cost, and the closest approximation, in three sentences."""
    results, grid = output.results, output.results.scene.grid
    worst_body, worst = max(results.errors.items(), key=lambda item: item[1].total)
    costs = models_of(results.matrices)
    size = f"{output.file.name} ({output.file.stat().st_size / 1e6:.1f} MB)"
    return (
        f"{size} has C between {grid.n_s} strips at {grid.n_x} lags, known to {percent(worst.total)} (worst: "
        f"{worst.component} {body_name(worst_body)}){_check_text(output.checks)}. Its models took "
        f"{seconds_of(costs):.0f} s and {max(cost.peak_memory for cost in costs.values()):.0f} MB. "
        f"{_approximations_text(results)}"
    )


def _check_text(checks: Sequence[ColumnCheck]) -> str:
    """Return how far columns of the solid engine are off, as a part of a sentence."""
    if not checks:
        return ""
    closest = max(check.closest for check in checks)
    within = "within" if closest <= 1 else "beyond"
    return f"; columns solved again in 3D differ {within} both estimates ({closest:.2f} of their sum at most)"


def _approximations_text(results: MatrixResults) -> str:
    """Return the closest approximation, and the one furthest off, in displacements by pressures."""
    body = main_body(results.scene.compared)
    nn = {
        symbol_of(variant): deviation.displacement_error[N, N]
        for variant, deviation in results.deviations[body].items()
        if variant != "C"
    }
    if not nn:
        return ""
    best, worst = min(nn, key=nn.__getitem__), max(nn, key=nn.__getitem__)
    return (
        f"Of the approximations {body_name(body)}, {best} is closest in displacements by pressures: at most "
        f"{percent(nn[best])} of the largest off ({worst}: {percent(nn[worst])})."
    )


def _cost_table(model_plans: Sequence[ModelPlan], costs: Mapping[str, Cost]) -> Table:
    """Return the table of expected / actual costs of each model."""
    rows = []
    for plan in model_plans:
        if cost := costs.get(plan.name):
            waves = cost.solver.split(", ")[-1].split()[0] if cost.solver.endswith("wavenumbers") else "–"
            cells = [
                f"{plan.expected.unknowns:,} / {cost.unknowns:,}",
                f"{plan.expected.wavenumbers or '–'} / {waves}",
                f"{plan.expected.seconds:.0f} / {sum(cost.seconds.values()):.0f}",
                f"{plan.expected.memory:.0f} / {cost.peak_memory:.0f}",
            ]
            rows.append(Row(plan.name, cells))
    return Table("model", ["unknowns", "wavenumbers", "s", "MB"], rows)


def _cost_text(results: MatrixResults, costs: Mapping[str, Cost]) -> str:
    return (
        f"Models: {seconds_of(costs):.0f} s when they were solved. This run, with models from the store: "
        f"{results.seconds:.0f} s, {results.memory:.0f} MB at its peak."
    )
