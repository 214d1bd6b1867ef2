"""`femic matrix` computes the IC matrices of a scene and writes the file, the figures and the report.

Its chart shows the response to one loaded strip by component, and differences from C.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
import xarray as xr

from approx.pair import columns as approximations
from compare.pages.ics import row_name, share_text
from compare.pages.ics_figures import combined_first, main_body
from compare.report import files
from compare.report.charts import Chart, Curve, Map, Panel
from compare.report.errors import COMPONENTS as COMPONENT_NAMES
from compare.report.errors import error_cell, percent
from compare.report.looks import INK, Look, drawing_order, ics_looks, ics_symbol
from compare.report.parts import Folded, Note, Page, Section, Verbatim, write_page
from compare.report.tables import Cell, Row, Table, numbers, texts
from compare.report.verdicts import NO, YES
from femic.cache.digests import PAGE_FOLDERS, results_digest
from femic.contact.operators.dense import Reciprocity
from femic.reference.engine import Cost
from femic.reference.job import Shares
from femic.reference.matrix.reference import MatrixReference
from femic.reference.refinement import ModelPlan, total_seconds
from femic.reference.result import total
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.ics import solids, solved_parts, solver_seconds
from femic.results.matrices import SOURCE, compute_matrix, discounted, expected_seconds, matrix_plans
from femic.results.matrix_check import ColumnCheck, check_columns
from femic.scenes import receipts
from femic.scenes.plausibility import pair_warnings
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS, DIRECTIONS, Grid

# --- the page -------------------------------------------------------------------------------------------


COMMAND = "matrix"
Value = TypeVar("Value")
ACCURACY = (
    "Largest estimated error of C over all lags and pairs of strips, and its largest parts, on the scale "
    "of refinement, to which the tolerance applies. At four or more elements from the load, this scale is "
    "the larger of max |C_ij| and 0.05 max A_nn over the lags of a pair of strips; nearer, it is 5 A_nn "
    "at the same place. Rows “C” below show the error relative to the components themselves. The file has "
    "an estimated error for each entry."
)
REQUIREMENTS = (
    "Reciprocity: the largest |C(I, J) − C(J, I)ᵀ| of the raw solution, divided by the largest value of "
    "the same component. Loads act on whole elements but displacements are read at centres, so ICs of "
    "curved bodies are not exactly reciprocal. The deviation is largest where a strip contains a joint of "
    "arc and flank. Work: the smallest eigenvalue of the symmetric part, divided by the smallest IC of an "
    "element on itself. If it is positive, tractions always do positive work."
)
TOO_LARGE = "Not computed: the matrices of this grid do not fit in memory."
CHECKS = (
    "Single loads in 3D, observed on three strips (all {} strips of a body would take about {:.0f} "
    "minutes). Shown are the largest difference from the matrix relative to the component (vanishing "
    "components excluded), the sum of both estimated errors there, and the largest ratio of a difference "
    "to this sum."
)
WORST = (
    "C is used after the rigid-body discount of [BVSV]. The number is the largest |V − C| of a component "
    "at four or more elements from the load, relative to its largest |C_ij| there. The small number below "
    "covers nearer entries, relative to A_nn at the same place. †: C_ij vanishes there, and the number is "
    "relative to 0.05 max |C_nn|."
)
APPROXIMATIONS = (
    "Approximations are ICs of half-spaces, so C is used after the rigid-body discount of [BVSV], which "
    "also removes the bending of the section. The number is the largest displacement error that tractions "
    "of at most 1 on the grid can cause, relative to the largest displacement that the component itself "
    "can cause. The small number below is the weight: the same error relative to the largest displacement "
    "under normal tractions. “Vanishes”: the component is zero, or the displacement that it causes is "
    "smaller than ten times its estimated error. An approximation is then compared with zero, and its "
    "number (†) is relative to 0.05 of the largest displacement under normal tractions. Row “C”: the "
    "estimated error of C."
)
MEASURES = {  # variables: the errors, the weights below them, and which components vanish
    "displacements": ("displacement_error", "displacement_weight", "displacement_vanishes"),
    "entries": ("entry_error", "near_entry_error", "entry_vanishes"),
}
ANSWER = (
    "Estimated error: the largest of all entries, with its component; below, whether it is within the "
    "tolerance of {}. Reciprocity defect: of the raw matrix, with its component. Smallest eigenvalue: if it "
    "is positive, tractions always do positive work. Solid engine: the largest ratio of a difference "
    "between both engines to the sum of their estimated errors; up to 1 they agree."
)
CHART = (
    "Displacements of the {} ICs per total load of 1 kN on an element of strip {} at s = {:.3g} mm; at x < "
    "0, xs, sx, xn and nx change sign. Approximations are ICs of half-spaces; they are compared with C after "
    "the rigid-body discount of [BVSV]. Band: ± the estimated error of C. "
)
MAPS = (
    "Displacements over the whole grid, for the same loaded element (cross). C: the matrix in the file, per "
    "total load of 1 kN. Colours are logarithmic."
)


def write_matrix(scene: Scene, out: Path, strip: int | None = None, options: RunOptions = DEFAULT) -> Path:
    """Write `matrix.nc`, figures of one loaded strip and `matrix.html`; returns the path of the page.

    By default the loaded strip is the one nearest to the patch. Nothing is computed if the folder has the
    same results already, unless files of figures are asked for. Raises WrongInput for a strip that the grid
    does not have.
    """
    watch, workers, n_s = options.watch, options.workers, scene.grid.n_s
    if strip is None:
        strip = int(np.argmin(np.abs(scene.grid.strips - scene.patch.s)))
    if not 0 <= strip < n_s:
        raise WrongInput(f"--strip {strip}: the grid has strips 0 ... {n_s - 1}")
    path, key = out / "matrix.html", receipts.key_of(scene, results_digest(*PAGE_FOLDERS), strip)
    if not files.figures_wanted() and receipts.holds(out, COMMAND, key):
        watch.on_stage("  already in the folder")
        return path
    plans = matrix_plans(scene, workers)
    watch.on_stage(
        f"  about {total_seconds(plans, workers):.0f} s, {max(plan.expected.memory for plan in plans):.0f} "
        f"MB for models that are not yet stored, then {expected_seconds(scene):.0f} s"
    )
    file = out / "matrix.nc"
    with receipts.renewed(out, COMMAND, key, [file.name, path.name]):
        solved = compute_matrix(scene, file, options)
        checks = check_columns(scene, solved, options)
        size = f"{file.name} ({file.stat().st_size / 1e6:.1f} MB)"
        with xr.open_dataset(file, engine="h5netcdf") as matrix:
            shown = response(scene, matrix, solved, strip)
            sections = _sections(scene, matrix, plans, checks, strip, shown)
            allowed = scene.settings.tolerance
            page = Page(
                matrix.attrs["title"],
                summary(matrix, size, allowed),
                sections,
                answer_table(matrix, checks, allowed),
                [*pair_warnings(scene), *doubts(matrix, checks, allowed)],
            )
            write_page(page, path, COMMAND)
    return path


def _by_name(matrix: xr.Dataset, attribute: str, kind: Callable[..., Value]) -> dict[str, Value]:
    """Return the records of an attribute of the file by body, or by model."""
    return {name: kind(**record) for name, record in json.loads(matrix.attrs[attribute]).items()}


def summary(matrix: xr.Dataset, file: str, tolerance: float) -> str:
    """Return what the file has, whether C is accurate enough, and what its models took."""
    sizes, costs = matrix.sizes, _by_name(matrix, "models", Cost)
    body, worst = max(_by_name(matrix, "estimated_error", Shares).items(), key=lambda item: item[1].total)
    is_converged = "converged" if worst.total <= tolerance else "not converged"
    return (
        f"{file} holds C for {sizes['loaded']} strips and {sizes['lag']} lags. C is {is_converged}: its "
        f"largest estimated error is {percent(worst.total)} ({worst.component}, {body}), the tolerance is "
        f"{share_text(tolerance)}. The models took {solver_seconds(costs):.0f} s and "
        f"{max(cost.peak_memory for cost in costs.values()):.0f} MB."
    )


def doubts(matrix: xr.Dataset, checks: Sequence[ColumnCheck], tolerance: float) -> Iterator[str]:
    """Yield where C is not accurate enough, does negative work, or differs from the solid engine's."""
    for body, shares in _by_name(matrix, "estimated_error", Shares).items():
        if shares.total > tolerance:
            yield (
                f"{body}: the estimated error of C is {percent(shares.total)} in {shares.component}, more "
                f"than the tolerance of {share_text(tolerance)}."
            )
    for name, eigenvalue in json.loads(matrix.attrs["smallest_eigenvalue"]).items():
        if eigenvalue <= 0:
            yield f"Matrix {name}: some tractions do no positive work (smallest eigenvalue {eigenvalue:.2g})."
    for check in checks:
        if check.closest > 1:
            yield (
                f"{check.body}, strip {check.strip}: the solid engine differs from C by {check.closest:.2g} "
                "times the sum of both estimated errors."
            )


def _sections(
    scene: Scene,
    matrix: xr.Dataset,
    plans: Sequence[ModelPlan],
    checks: Sequence[ColumnCheck],
    strip: int,
    shown: xr.Dataset,
) -> Iterator[Section | Folded]:
    grid, costs = scene.grid, _by_name(matrix, "models", Cost)
    reading = CHART.format(main_body(scene.compared), strip, grid.strips[strip]) + COMPONENT_NAMES
    answer = Note(ANSWER.format(share_text(scene.settings.tolerance)))
    yield Section("", [answer, chart(shown), Note(reading)])
    yield Folded("Maps of C and of its estimated error", [maps(shown), Note(MAPS)])

    columns = [*numbers("estimate"), *texts("worst at"), *numbers("mesh", "domain", "wavenumbers")]
    rows = []
    for name, shares in _by_name(matrix, "estimated_error", Shares).items():
        parts = (Cell(part, ".3%") for part in (shares.mesh, shares.truncation, shares.waves))
        rows.append(Row(name, [Cell(shares.total, ".3%"), f"{shares.component} {shares.line}", *parts]))
    yield Folded("Estimated errors of C", [f"{discounted(scene)} {ACCURACY}", Table("body", columns, rows)])

    rows, defects = [], _by_name(matrix, "reciprocity_defect", Reciprocity)
    for name, eigenvalue in json.loads(matrix.attrs["smallest_eigenvalue"]).items():
        body, _, kind = name.partition(", ")
        defect = reciprocity_text(defects[body], grid) if kind == "raw" else "as raw"
        rows.append(Row(name, [defect, Cell(eigenvalue, ".3f")]))
    table = Table("matrix", [*texts("reciprocity defect"), *numbers("smallest eigenvalue")], rows)
    missing = "" if rows else TOO_LARGE
    yield Folded("Reciprocity and positive work", [REQUIREMENTS, missing, table])

    if checks:
        minutes = grid.n_s * float(np.mean([check.seconds for check in checks])) / 60
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
        heads = ["strip", "difference", "allowed", "largest difference / allowed", "s"]
        text = CHECKS.format(grid.n_s, minutes)
        yield Folded("Check: columns computed with the solid engine", [text, Table("body", heads, rows)])

    for body in combined_first(scene.compared):
        displacements, worst = (_errors_table(matrix.sel(body=body), *names) for names in MEASURES.values())
        entries = Folded("Worst entries", [WORST, worst])
        heading = f"Errors of approximations of the {body} matrix"
        yield Folded(heading, [APPROXIMATIONS, displacements, entries])
    text = (
        f"Models: {solver_seconds(costs):.0f} s when they were solved. This run, including models from the "
        f"store: {matrix.attrs['seconds']:.0f} s, {matrix.attrs['peak_memory']:.0f} MB at its peak."
    )
    yield Folded("Cost: expected / actual", [cost_table(plans, costs), text])
    yield Folded("The scene", [Verbatim(scene.text)])


def answer_table(matrix: xr.Dataset, checks: Sequence[ColumnCheck], tolerance: float) -> Table:
    """Return how good each matrix is: estimate, reciprocity, positive work, and columns solved again."""
    rows, estimates = [], _by_name(matrix, "estimated_error", Shares)
    defects = _by_name(matrix, "reciprocity_defect", Reciprocity)
    eigenvalues = json.loads(matrix.attrs["smallest_eigenvalue"])
    for body in combined_first(matrix.body.values):
        shares, defect = estimates[body], defects.get(body)
        eigenvalue = eigenvalues.get(f"{body}, discounted", np.nan)
        cells: list[Cell | str] = [
            Cell(
                f"{100 * shares.total:.2g} ({shares.component})",
                below=f"within the tolerance: {YES if shares.total <= tolerance else NO}",
            ),
            f"{100 * defect.worst:.2g} ({defect.component})" if defect else "–",
            Cell(eigenvalue, ".2f"),
        ]
        if checks:
            cells.append(Cell(max((c.closest for c in checks if c.body == body), default=np.nan), ".2f"))
        rows.append(Row(body, cells))
    heads = [
        *numbers("estimated error", "reciprocity defect", unit="%"),
        *numbers("smallest eigenvalue", unit="1"),
        *(numbers("solid engine: difference / estimated errors", unit="1") if checks else []),
    ]
    return Table("body", heads, rows)


def _errors_table(matrix: xr.Dataset, error: str, weight: str, vanishes: str) -> Table:
    """Return a table of errors with a row per approximation that the body has, and one for C."""
    rows = []
    for variant in map(str, matrix.variant.values):
        own = matrix.sel(variant=variant)
        if own[vanishes].notnull().all():
            values = (own[name].values.ravel() for name in (error, weight, vanishes))
            cells = [
                error_cell(share, below, vanishes=bool(vanishing), is_estimate=variant == "C")
                for share, below, vanishing in zip(*map(np.ndarray.tolist, values), strict=True)
            ]
            rows.append(Row(row_name(variant), cells))
    return Table("variant", COMPONENTS, rows)


def reciprocity_text(defect: Reciprocity, grid: Grid) -> str:
    """Return text for the report: the largest defect, its place, and the largest away from joints."""
    first, second = sorted(defect.strips)
    where = f"{defect.worst:.1e} of {defect.component} (strips {first} and {second}, "
    where += f"s = {grid.strips[first]:.3g}, {grid.strips[second]:.3g} mm)"
    if not defect.at_joints:
        return where
    elsewhere = "" if defect.elsewhere is None else f"; {defect.elsewhere:.1e} without these"
    return f"{where}; joints in strips {', '.join(map(str, defect.at_joints))}{elsewhere}"


def cost_table(plans: Sequence[ModelPlan], costs: Mapping[str, Cost]) -> Table:
    """Return the table of expected / actual costs of each model."""
    rows = []
    for plan in plans:
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


# --- the chart ------------------------------------------------------------------------------------------


SMALLEST = 1e-9  # of the largest IC of all components: smaller ones are rounding
MOST_DRAWN = 50  # about as many lags, and strips, a map has at most
UNIT, PER_KILONEWTON = "µm/kN", 1e6  # of mm/N
LOADED = Look(INK, "", "cross")
ABSCISSAS = {"s": "s", "lag": "x"}


def response(
    scene: Scene, matrix: xr.Dataset, solved: Mapping[str, MatrixReference], strip: int
) -> xr.Dataset:
    """Return the response to unit loads on a strip, (..., i, j, lag, s) [µm/kN], of both bodies or the first.

    `matrix` is C of the file. Of `ic` (variant, ...), C after the discount of [BVSV] has the `estimate`.
    Rounding is 0.
    """
    grid, body = scene.grid, main_body(scene.compared)
    known = matrix.entry_vanishes.sel(body=body).notnull().all(["i", "j"])
    names = list(map(str, matrix.variant.values[known.values]))
    c = total([solved[part].column(strip, SOURCE) for part in solved_parts(body)])
    column = matrix.ic.sel(body=body).isel(loaded=strip).transpose("i", "j", "lag", "observed")
    approximated = approximations([name for name in names if name != "C"], solids(scene)[body], grid, strip)
    ics = {name: ics / grid.area for name, ics in approximated.items()} | {"C": c.ic}
    dims = ("i", "j", "lag", "s")
    arrays = {
        "matrix": (dims, column.values / grid.area),
        "ic": (("variant", *dims), np.stack(list(ics.values()))),
        "estimate": (dims, c.estimate),
    }
    coordinates = {"variant": list(ics), "i": list(DIRECTIONS), "j": list(DIRECTIONS)}
    places = {"lag": grid.lags, "s": grid.strips, "loaded": grid.strips[strip]}
    scaled = xr.Dataset(arrays, coordinates | places) * PER_KILONEWTON
    return scaled.where(abs(scaled) > SMALLEST * float(abs(scaled.matrix).max()), 0.0)


def chart(response: xr.Dataset) -> Chart:
    """Return curves of a response and their differences from C, a step per component."""
    rounding = SMALLEST * float(abs(response.matrix).max())
    steps = {
        component: list(_panels(response.sel(i=component[0], j=component[1]), component, rounding))
        for component in COMPONENTS
    }
    return Chart("response", steps, 2, "component", 0.8, "nn")


def maps(response: xr.Dataset) -> Chart:
    """Return maps of C of the file and of its estimated error, a step per component."""
    steps: dict[str, list[Map]] = {}
    for component in COMPONENTS:
        part = response.sel(i=component[0], j=component[1])
        steps[component] = [_map(part.matrix, "C"), _map(part.estimate, "estimated error of C")]
    return Chart("maps", steps, 2, "component", 0.8, "nn")


def _panels(part: xr.Dataset, component: str, rounding: float) -> Iterator[Panel]:
    """Yield curves along s and along x with their differences from C."""
    minus_c = part.assign(ic=part.ic - part.ic.sel(variant="C"))
    places = {
        "s": ({"lag": 0.0}, "along s, x = 0"),
        "lag": ({"s": part.loaded}, f"along x, s = {float(part.loaded):.3g} mm"),
    }
    for across, (at, place) in places.items():
        yield _panel(part.sel(at), across, place, f"{component} [{UNIT}]", rounding)
        yield _panel(minus_c.sel(at), across, "the same minus C", f"Δ{component} [{UNIT}]", rounding)


def _panel(part: xr.Dataset, across: str, title: str, up: str, rounding: float) -> Panel:
    looks = ics_looks(map(str, part.variant.values))
    curves = [
        Curve(
            ics_symbol(name),
            part[across].values,
            part.ic.sel(variant=name).values,
            looks[name],
            part.estimate.values if name == "C" else None,
        )
        for name in drawing_order(looks)
    ]
    return Panel(title, f"{ABSCISSAS[across]} [mm]", up, curves, least=rounding)


def _map(values: xr.DataArray, title: str) -> Map:
    """Return a map of values (lag, s), thinned; cross: the loaded element."""
    steps = {dim: -(-values.sizes[dim] // MOST_DRAWN) for dim in ("lag", "s")}
    drawn = values[:: steps["lag"], :: steps["s"]]
    x, s, largest = drawn.lag.values, drawn.s.values, float(abs(values).max()) or 1.0
    loaded = Curve("", [0.0], [float(values.loaded)], LOADED)
    limits = -largest, largest
    return Map(title, "x [mm]", "s [mm]", x, s, drawn.values, UNIT, "logarithmic", limits, curves=[loaded])
