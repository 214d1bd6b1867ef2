"""`femic matrix`: compute the IC matrices of a scene, write the file, the figures and the report."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import h5netcdf
import numpy as np

from approx.matrix import column as approximated
from compare.pages.html import Cell, embedded, error_cell, known_cell, rendered
from compare.pages.styles import SYMBOLS, save
from compare.reports.matrix.figures import maps
from compare.results import folders, plan
from compare.results.compute import solids
from compare.results.matrix.check import Checked, check
from compare.results.matrix.compute import MatrixResults, compute_matrix
from compare.results.matrix.deviation import Deviation
from compare.results.matrix.reciprocity import described
from compare.results.provenance import results_digest
from compare.scenes.scene import Scene
from femic.means import DEFAULT, Means
from femic.models import Cost
from femic.work.store import Store
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS

COMPARED = ("A", "Bhat")  # whose difference from C is drawn


@dataclass(frozen=True)
class Asked:
    """Where results go, and the loaded strip of the figures (None: nearest to the patch)."""

    out: Path
    strip: int | None = None


def write_matrix(scene: Scene, asked: Asked, means: Means = DEFAULT) -> Path:
    """Write `matrix.nc`, figures of one loaded strip and `matrix.html` into a folder; returns its path."""
    out, watch, workers = asked.out, means.watch, means.workers
    folders.checked(out)
    chosen = _chosen(scene, asked.strip)
    path, key = out / "matrix.html", key_of_scene(scene, chosen)
    if path.is_file() and _key_of(out / "matrix.nc") == key:
        watch.on_stage("  as it is there already")
        return path
    steps = plan.matrix_steps(scene, workers)
    watch.on_stage(
        f"  about {plan.seconds(steps, workers):.0f} s, {max(step.takes.memory for step in steps):.0f} MB if "
        "nothing is kept yet"
    )
    (out / "figures").mkdir(parents=True, exist_ok=True)
    results = compute_matrix(scene, out / "matrix.nc", means)
    checks = check(results, means)
    paths = draw(results, chosen, out / "figures")
    path.write_text(render(results, steps, checks, paths, out / "matrix.nc"), encoding="utf-8")
    with h5netcdf.File(out / "matrix.nc", "a") as file:  # all of it is there
        file.attrs["key"] = key
    return path


def key_of_scene(scene: Scene, strip: int) -> str:
    """All that the file and its figures depend on: code, text, contours that it may have from files."""
    return Store().key("matrix", results_digest(), scene.text, dict(scene.bodies), strip)


def _key_of(path: Path) -> str | None:
    """What a matrix file was made of; None if it cannot be read."""
    try:
        with h5netcdf.File(path, "r") as file:
            return str(file.attrs["key"])
    except (OSError, KeyError):
        return None


def _chosen(scene: Scene, strip: int | None) -> int:
    n_s = scene.grid.n_s
    if strip is None:
        return int(np.argmin(np.abs(scene.grid.strips - scene.patch.s)))
    if not 0 <= strip < n_s:
        raise WrongInput(f"--strip {strip}: the grid has strips 0 ... {n_s - 1}")
    return strip


def draw(results: MatrixResults, strip: int, folder: Path) -> list[Path]:
    """Maps of C and of what A and B-hat lack, of the first of the bodies compared."""
    scene, body = results.scene, results.scene.compared[0]
    unit, grid = scene.reference_E * scene.reference_length, scene.grid
    c = results.column(body, strip).ic
    drawn = {"C": ("C", c)} | {
        f"C-{v}": (f"C − {SYMBOLS[v]}", c - approximated(v, solids(scene)[body], grid, strip) / grid.area)
        for v in COMPARED
    }
    where = f"{body}, load on strip {strip} (s = {grid.strips[strip]:.3g} mm)"
    return [
        save(
            maps(f"{title}: {where}", "dimensionless", grid, strip, unit * values),
            folder / f"matrix_{body}_{name}.png",
        )
        for name, (title, values) in drawn.items()
    ]


def render(
    results: MatrixResults,
    steps: Sequence[plan.Step],
    checks: Sequence[Checked],
    figures: Sequence[Path],
    file: Path,
) -> str:
    """The report as HTML."""
    scene = results.scene
    costs = {
        f"{name}, {model}": cost
        for name, found in results.found.items()
        for model, cost in found.models.items()
    }
    per_body = [sum(one.seconds for one in checks if one.body == name) for name in results.found]
    strips = len({one.strip for one in checks})
    all_strips = scene.grid.n_s * float(np.mean(per_body)) / strips / 60 if checks else 0.0
    return rendered(
        "matrix.html.j2",
        title=f"IC matrix: {scene.title}",
        summary=summary(results, file),
        known=list(_known(results)),
        demands=list(_demands(results)),
        checks=[
            {
                "body": one.body,
                "strip": one.strip,
                "apart": f"{one.apart:.2%} ({one.component})",
                "allowed": f"{one.allowed:.2%}",
                "closest": f"{one.closest:.2f}",
                "seconds": f"{one.seconds:.0f}",
            }
            for one in checks
        ],
        strips=scene.grid.n_s,
        all_strips=f"{all_strips:.0f} minutes",
        components=COMPONENTS,
        tables=[
            {"body": body, "rows": list(_rows(results, body, cells)), "measure": measure}
            for body in scene.compared
            for measure, cells in (("under_tractions", _under_tractions), ("worst", _worst))
        ],
        E=scene.reference_E,
        L=scene.reference_length,
        figures=[embedded(path) for path in figures],
        cost=plan.compared(list(steps), costs),
        took=_took(results, costs),
        text=scene.text,
    )


def summary(results: MatrixResults, file: Path) -> str:
    """One paragraph, computed."""
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
    """The best and the worst approximation of C_nn."""
    nn = {v: one.under_tractions[2, 2] for (v, of), one in results.approximations.items() if of == body}
    best, worst = min(nn, key=lambda v: nn[v]), max(nn, key=lambda v: nn[v])
    return (
        f"{SYMBOLS[best]} is best for pressures (displacements off by at most {nn[best]:.1%} of the largest)",
        f"{SYMBOLS[worst]} worst ({nn[worst]:.1%})",
    )


def _known(results: MatrixResults) -> Iterator[dict[str, str]]:
    for name, shares in results.errors.items():
        yield {
            "body": name,
            "total": f"{shares.total:.3%}",
            "where": f"{shares.component} {shares.line}",
            "mesh": f"{shares.mesh:.3%}",
            "truncation": f"{shares.truncation:.3%}",
            "waves": f"{shares.waves:.3%}",
        }


def _demands(results: MatrixResults) -> Iterator[dict[str, str]]:
    for name, eigenvalue in results.eigenvalues.items():
        body, _, kind = name.partition(", ")
        raw = kind == "raw"
        defect = described(results.reciprocity[body], results.scene.grid) if raw else "as raw"
        yield {"name": name, "defect": defect, "eigenvalue": f"{eigenvalue:.3f}"}


MakeCell = Callable[..., Cell]  # `error_cell`, or `known_cell` of C itself


def _rows(
    results: MatrixResults, body: str, cells: Callable[[Deviation, MakeCell], list[Cell]]
) -> Iterator[dict[str, object]]:
    for (variant, of), deviation in results.approximations.items():
        if of == body:
            yield {"symbol": SYMBOLS[variant], "cells": cells(deviation, error_cell)}
    yield {"symbol": "C", "cells": cells(results.known[body], known_cell)}


def _under_tractions(of: Deviation, make: MakeCell) -> list[Cell]:
    """Shares of what the component itself can cause; below them, of what pressures can."""
    values = (of.under_tractions_of_itself, of.under_tractions, of.causes_nothing)
    return [
        make(float(share), float(weight), vanishes=bool(gone))
        for share, weight, gone in zip(*(one.ravel() for one in values), strict=True)
    ]


def _worst(of: Deviation, make: MakeCell) -> list[Cell]:
    """Shares of the largest entry of the component; below them those of nearer entries, of A_nn."""
    return [
        make(float(share), float(near), vanishes=bool(gone))
        for share, near, gone in zip(*(one.ravel() for one in (of.worst, of.near, of.vanishing)), strict=True)
    ]


def _took(results: MatrixResults, costs: dict[str, Cost]) -> str:
    models = sum(sum(cost.seconds.values()) for cost in costs.values())
    return (
        f"Models: {models:.0f} s when they were solved. This run, with what was kept: "
        f"{results.seconds:.0f} s, {results.memory:.0f} MB at its peak."
    )
