"""`femic matrix` computes the IC matrices of a scene and writes the file, the figures and the report."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from approx.matrix import column as approximated
from compare.ics.compute import models_of, seconds_of, solids
from compare.matrix.check import ColumnCheck, check_columns
from compare.matrix.compute import MatrixResults, column_of, compute_matrix, discounted, matrix_plans
from compare.matrix.figures import maps
from compare.report.errors import error_cell
from compare.report.parts import Folded, Page, Picture, Section, Verbatim, write_page
from compare.report.styles import SYMBOLS
from compare.report.tables import Cell, Row, Table, numbers, texts
from femic.contact.operators.reciprocity import Reciprocity
from femic.reference.models import Cost
from femic.reference.plan import ModelPlan, total_seconds
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes import receipts
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import COMPONENTS, N

COMMAND = "matrix"
MAPPED_VARIANTS = ("A", "Bhat")  # variants whose difference from C is drawn
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


def write_matrix(scene: Scene, out: Path, strip: int | None = None, options: RunOptions = DEFAULT) -> Path:
    """Write `matrix.nc`, figures of one loaded strip and `matrix.html`; returns the path of the page.

    By default the loaded strip is the one nearest to the patch. Nothing is computed if the folder has the
    same results already. Raises WrongInput for a strip that the grid does not have.
    """
    watch, workers = options.watch, options.workers
    loaded_strip = _loaded_strip(scene, strip)
    path, key = out / "matrix.html", receipts.key_of(scene, __name__, loaded_strip)
    if receipts.holds(out, COMMAND, key):
        watch.on_stage("  as it is there already")
        return path
    model_plans = matrix_plans(scene, workers)
    watch.on_stage(
        f"  about {total_seconds(model_plans, workers):.0f} s, "
        f"{max(plan.expected.memory for plan in model_plans):.0f} MB if no model is stored yet"
    )
    with receipts.renewed(out, COMMAND, key, ["matrix.nc", path.name]):
        results = compute_matrix(scene, out / "matrix.nc", options)
        sections = _sections(results, loaded_strip, model_plans, check_columns(results, options))
        write_page(Page(f"IC matrix: {scene.title}", summary(results, out / "matrix.nc"), sections), path)
    return path


def _loaded_strip(scene: Scene, strip: int | None) -> int:
    n_s = scene.grid.n_s
    if strip is None:
        return int(np.argmin(np.abs(scene.grid.strips - scene.patch.s)))
    if not 0 <= strip < n_s:
        raise WrongInput(f"--strip {strip}: the grid has strips 0 ... {n_s - 1}")
    return strip


def pictures(results: MatrixResults, strip: int) -> Iterator[Picture]:
    """Yield maps of C and of its differences from A and B-hat, of the first of the bodies compared."""
    scene, body = results.scene, results.scene.compared[0]
    unit, grid = scene.reference_E * scene.reference_length, scene.grid
    c = column_of(scene, results.matrices, body, strip).ic
    drawn = {"C": ("C", c)} | {
        f"C-{variant}": (
            f"C − {SYMBOLS[variant]}",
            c - approximated(variant, solids(scene)[body], grid, strip) / grid.area,
        )
        for variant in MAPPED_VARIANTS
    }
    where = f"{body}, load on strip {strip} (s = {grid.strips[strip]:.3g} mm)"
    for name, (title, values) in drawn.items():
        figure = maps(f"{title}: {where}", "dimensionless", grid, strip, unit * values)
        yield Picture(f"matrix_{body}_{name}", figure)


def _sections(
    results: MatrixResults, strip: int, model_plans: Sequence[ModelPlan], checks: Sequence[ColumnCheck]
) -> Iterator[Section]:
    scene, costs = results.scene, models_of(results.matrices)
    text = f"{discounted(scene)} {ACCURACY}"
    yield Section("How accurate the matrix is", [text, _accuracy_table(results)])
    missing = "" if results.eigenvalues else TOO_LARGE
    yield Section("Reciprocity and positive work", [REQUIREMENTS, missing, _requirements_table(results)])
    if checks:
        yield Section(
            "Columns computed with the solid engine", [_checks_text(scene, checks), _checks_table(checks)]
        )
    for body in scene.compared:
        heading = f"Errors of approximations of the {body} matrix"
        folded = Folded(f"Worst entry of the {body} matrix", [WORST, _errors_table(results, body, "worst")])
        yield Section(heading, [APPROXIMATIONS, _errors_table(results, body, "displacements"), folded])
    yield Section("Responses to one strip", [_maps_text(scene), *pictures(results, strip)])
    yield Section("Cost: expected / actual", [_cost_table(model_plans, costs), _cost_text(results, costs)])
    yield Section("The scene", [Verbatim(scene.text)])


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
        rows.append(Row(SYMBOLS[variant], cells))
    return Table("variant", COMPONENTS, rows)


def _maps_text(scene: Scene) -> str:
    return (
        f"Per unit total load; × E L makes them dimensionless (E = {scene.reference_E:g} MPa, L = "
        f"{scene.reference_length:g} mm). Cross: the loaded element. Colours: logarithmic, three decades of "
        "each sign."
    )


def summary(results: MatrixResults, file: Path) -> str:
    """Return a computed paragraph: the file's content and accuracy, the best and the worst approximation."""
    scene, grid = results.scene, results.scene.grid
    body = scene.compared[0]
    largest_estimate = max(shares.total for shares in results.errors.values())
    deviations = results.deviations[body]
    nn = {variant: deviations[variant].displacement_error[N, N] for variant in deviations if variant != "C"}
    best, worst = min(nn, key=nn.__getitem__), max(nn, key=nn.__getitem__)
    return (
        f"{file.name} ({file.stat().st_size / 1e6:.1f} MB): displacements at {grid.n_s} strips and "
        f"{grid.n_x} lags under unit tractions on {grid.n_s} strips, nine components, of "
        f"{', '.join(scene.compared)}, with an estimated error of {largest_estimate:.2%}. Of the "
        f"approximations of the {body} matrix {SYMBOLS[best]} is best for pressures (displacements off by at "
        f"most {nn[best]:.1%} of the largest) and {SYMBOLS[worst]} worst ({nn[worst]:.1%})."
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
