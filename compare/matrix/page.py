"""`femic matrix` computes the IC matrices of a scene and writes the file, the figures and the report."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from approx.matrix import column as approximated
from compare.ics.compute import models_of, seconds_of, solids
from compare.matrix.check import ColumnCheck, check
from compare.matrix.compute import MatrixResults, compute_matrix, discounted
from compare.matrix.figures import maps
from compare.matrix.reciprocity import description
from compare.plan import models
from compare.report.html import error_cell, write_page
from compare.report.styles import SYMBOLS, save
from femic.cache import folders
from femic.reference.models import Cost
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes import receipts
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS, N

COMMAND = "matrix"
MAPPED_VARIANTS = ("A", "Bhat")  # variants whose difference from C is drawn


MEASURES = {  # of `Deviation`: the errors, the weights below them, and which components vanish
    "under_tractions": ("under_tractions_of_itself", "under_tractions", "causes_nothing"),
    "worst": ("worst", "near", "vanishing"),
}


def write_matrix(scene: Scene, out: Path, strip: int | None = None, options: RunOptions = DEFAULT) -> Path:
    """Write `matrix.nc`, figures of one loaded strip and `matrix.html`; returns the path of the page.

    By default the loaded strip is the one nearest to the patch. Nothing is computed if the folder has the
    same results already. Raises WrongInput for a strip that the grid does not have.
    """
    watch, workers = options.watch, options.workers
    loaded_strip = _chosen(scene, strip)
    path, key = out / "matrix.html", receipts.key_of(scene, __name__, loaded_strip)
    if receipts.holds(out, COMMAND, key):
        watch.on_stage("  as it is there already")
        return path
    steps = models.matrix_steps(scene, workers)
    watch.on_stage(
        f"  about {models.seconds(steps, workers):.0f} s, "
        f"{max(step.expected.memory for step in steps):.0f} MB if no model is stored yet"
    )
    receipts.withdraw(out, COMMAND)
    folders.make(out / "figures")
    results = compute_matrix(scene, out / "matrix.nc", options)
    checks = check(results, options)
    paths = draw(results, loaded_strip, out / "figures")
    _write_report(results, steps, checks, paths, out / "matrix.nc")
    receipts.leave(out, COMMAND, key, ["matrix.nc", path.name])
    return path


def _chosen(scene: Scene, strip: int | None) -> int:
    n_s = scene.grid.n_s
    if strip is None:
        return int(np.argmin(np.abs(scene.grid.strips - scene.patch.s)))
    if not 0 <= strip < n_s:
        raise WrongInput(f"--strip {strip}: the grid has strips 0 ... {n_s - 1}")
    return strip


def draw(results: MatrixResults, strip: int, folder: Path) -> list[Path]:
    """Draw maps of C and of its differences from A and B-hat, of the first of the bodies compared."""
    scene, body = results.scene, results.scene.compared[0]
    unit, grid = scene.reference_E * scene.reference_length, scene.grid
    c = results.column(body, strip).ic
    drawn = {"C": ("C", c)} | {
        f"C-{variant}": (
            f"C − {SYMBOLS[variant]}",
            c - approximated(variant, solids(scene)[body], grid, strip) / grid.area,
        )
        for variant in MAPPED_VARIANTS
    }
    where = f"{body}, load on strip {strip} (s = {grid.strips[strip]:.3g} mm)"
    return [
        save(
            maps(f"{title}: {where}", "dimensionless", grid, strip, unit * values),
            folder / f"matrix_{body}_{name}.png",
        )
        for name, (title, values) in drawn.items()
    ]


def _write_report(
    results: MatrixResults,
    steps: Sequence[models.Step],
    checks: Sequence[ColumnCheck],
    figures: Sequence[Path],
    file: Path,
) -> Path:
    """Write the report beside `matrix.nc`, which is `file`; returns its path."""
    scene, costs = results.scene, models_of(results.matrices)
    per_strip = np.mean([strip_check.seconds for strip_check in checks]) if checks else 0.0
    return write_page(
        file.with_suffix(".html"),
        "matrix.html.j2",
        title=f"IC matrix: {scene.title}",
        summary=summary(results, file),
        known=results.errors,
        discounted=discounted(scene),
        demands=list(_demand_rows(results)),
        checks=checks,
        strips=scene.grid.n_s,
        all_strips=f"{scene.grid.n_s * per_strip / 60:.0f} minutes",
        components=COMPONENTS,
        tables=[
            {"body": body, "rows": list(_rows(results, body, measure)), "measure": measure}
            for body in scene.compared
            for measure in MEASURES
        ],
        E=scene.reference_E,
        L=scene.reference_length,
        figures=figures,
        cost=list(models.compared(steps, costs)),
        took=_cost_text(results, costs),
        text=scene.text,
    )


def summary(results: MatrixResults, file: Path) -> str:
    """One paragraph, computed: the file's content and accuracy, the best and the worst approximation."""
    scene, grid = results.scene, results.scene.grid
    name = scene.compared[0]
    at_worst = max(shares.total for shares in results.errors.values())
    better, worse = _extremes(results, name)
    return (
        f"{file.name} ({file.stat().st_size / 1e6:.1f} MB): displacements at {grid.n_s} strips and "
        f"{grid.n_x} lags under unit tractions on {grid.n_s} strips, nine components, of "
        f"{', '.join(scene.compared)}, known to {at_worst:.2%}. Of the approximations of the {name} matrix "
        f"{better} and {worse}."
    )


def _extremes(results: MatrixResults, body: str) -> tuple[str, str]:
    """The texts on the best and on the worst approximation of C_nn."""
    nn = {variant: found.under_tractions[N, N] for variant, found in results.deviations(body).items()}
    best, worst = min(nn, key=nn.__getitem__), max(nn, key=nn.__getitem__)
    return (
        f"{SYMBOLS[best]} is best for pressures (displacements off by at most {nn[best]:.1%} of the largest)",
        f"{SYMBOLS[worst]} worst ({nn[worst]:.1%})",
    )


def _demand_rows(results: MatrixResults) -> Iterator[dict[str, str]]:
    for name, eigenvalue in results.eigenvalues.items():
        body, _, kind = name.partition(", ")
        raw = kind == "raw"
        defect = description(results.reciprocity[body], results.scene.grid) if raw else "as raw"
        yield {"name": name, "defect": defect, "eigenvalue": f"{eigenvalue:.3f}"}


def _rows(results: MatrixResults, body: str, measure: str) -> Iterator[dict[str, object]]:
    """Yield a row of cells per approximation and one of C, by a measure of `MEASURES`."""
    for variant, deviation in (results.deviations(body) | {"C": results.known[body]}).items():
        values = (getattr(deviation, name).ravel() for name in MEASURES[measure])
        cells = [
            error_cell(float(error), float(weight), vanishes=bool(vanishes), known=variant == "C")
            for error, weight, vanishes in zip(*values, strict=True)
        ]
        yield {"symbol": SYMBOLS[variant], "cells": cells}


def _cost_text(results: MatrixResults, costs: dict[str, Cost]) -> str:
    return (
        f"Models: {seconds_of(costs):.0f} s when they were solved. This run, with what was kept: "
        f"{results.seconds:.0f} s, {results.memory:.0f} MB at its peak."
    )
