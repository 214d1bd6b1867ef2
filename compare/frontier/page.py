"""File, figures and report of `femic frontier`, and the evidence table of `femic advise`."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.table import Table as Printed

from compare.frontier.advice import Advice
from compare.frontier.compute import error_bounds, front, resolved_errors
from compare.frontier.ways import styles
from compare.report.errors import MEASURE, VANISHING, cell_of
from compare.report.panels import figure_grid
from compare.report.parts import Folded, Items, Note, Page, Picture, Section, Verbatim, write_results
from compare.report.tables import Cell, Row, Table, numbers
from geometries.arrays import Array, Indices

LEAST_ERROR_DRAWN = 1e-6  # smaller errors vanish by symmetry and are drawn here


def write_frontier(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `frontier.nc`, the figures and `frontier.html`; returns the path of the report."""
    title = f"Speed against accuracy: {dataset.attrs['title']}"
    return write_results(Page(title, summary(dataset), _sections(dataset)), folder, "frontier", dataset)


def _sections(dataset: xr.Dataset) -> Iterator[Section]:
    bodies = [str(body) for body in dataset.body.values]
    yield Section("", [Picture(body, figure(dataset, body)) for body in bodies])
    for body in bodies:
        yield Section(body, [_table(dataset, body)])
    yield Section("", [Note(_explanation(dataset))])
    if skipped := json.loads(dataset.attrs["skipped"]):
        yield Section("Left out", [Items([f"{name}: {reason}" for name, reason in skipped.items()])])
    yield Section("", [Folded("Scene file", [Verbatim(dataset.attrs["scene"])])])


def _explanation(dataset: xr.Dataset) -> str:
    best, points = dataset.attrs["best"], dataset.attrs["points"]
    return (
        f"{MEASURE} Shown: the worst line. Errors below the estimate of C do not count as smaller. C comes "
        f"from {best}; its row has its estimated error. *: on the front of that component, no other way is "
        f"as fast and closer, or as close and faster. Time: of an approximation at all {points} points; of C "
        "the sum over all models that it and its estimate need, as measured when they were solved. "
        "Unknowns: of the largest model. Memory: peak of the process up to then, including earlier models."
    )


def summary(dataset: xr.Dataset) -> str:
    """Return a computed paragraph: the front of the first body's ways, by their worst components."""
    body = str(dataset.body.values[0])
    worst, seconds = resolved_errors(dataset, body).max("component"), dataset.seconds.sel(body=body)
    parts = [
        f"{dataset.label.values[k]} {100 * worst.values[k]:.3g} % in {_time(seconds.values[k])}"
        for k in _along_front(seconds.values, worst.values)
    ]
    return (
        f"{body} ICs at {dataset.attrs['points']} points, worst component, as a share of itself"
        f"{' (if it vanishes, of 0.05 C_nn)' if np.any(dataset.vanishes.sel(body=body)) else ''}: "
        f"{', '.join(parts)}. All other ways are slower than one of these and no better. Errors against "
        f"{dataset.attrs['best']}, which estimates its own."
    )


def _time(seconds: float) -> str:
    if np.isnan(seconds):
        return "–"
    return f"{seconds:.3g} s" if seconds >= 1 else f"{1000 * seconds:.2g} ms"


def figure(dataset: xr.Dataset, body: str) -> Figure:
    """Draw the error of each component against seconds, with the front and the best C's estimate as lines."""
    components = [str(component) for component in dataset.component.values]
    columns = min(3, len(components))
    rows = -(-len(components) // columns)
    errors = resolved_errors(dataset, body)
    with figure_grid(rows, columns, (4.4, 3.4), sharex=True) as (canvas, grid):
        for axes, component in zip(grid.ravel(), components, strict=False):
            _draw(axes, dataset.sel(body=body, component=component), errors.sel(component=component).values)
            vanishes = bool(dataset.vanishes.sel(body=body, component=component))
            axes.set_title(f"{body} {component}" + (", vanishes: share of 0.05 C_nn" if vanishes else ""))
        for axes in grid.ravel()[-columns:]:
            axes.set_xlabel(f"seconds for {dataset.attrs['points']} points  [s]")
        for axes in grid.ravel()[len(components) :]:
            axes.remove()
        canvas.supylabel("error, share of the component itself  [-]")
    return canvas


def _draw(axes: Axes, dataset: xr.Dataset, errors_of_ways: Array) -> None:
    seconds, errors = dataset.seconds.values, np.maximum(errors_of_ways, LEAST_ERROR_DRAWN)
    for kind, (colour, marker) in styles().items():
        has_kind = dataset.kind.values == kind
        if np.any(has_kind):
            axes.loglog(seconds[has_kind], errors[has_kind], marker, color=colour, mfc="none", label=kind)
    order = _along_front(seconds, errors)
    axes.loglog(seconds[order], errors[order], color="grey", linewidth=1, zorder=1, label="front")
    floor = max(float(dataset.estimate.sel(way=dataset.attrs["best"])), LEAST_ERROR_DRAWN)
    axes.axhline(floor, color="grey", linestyle=":", label="estimate of the best C")
    for k, (point, label) in enumerate(_labels(dataset, order, errors).items()):
        beside = (4, 3) if k % 2 == 0 else (4, -9)
        axes.annotate(label, point, fontsize=7, xytext=beside, textcoords="offset points")
    axes.margins(x=0.12)


def _along_front(seconds: Array, errors: Array) -> Indices:
    """Return the ways on the front, (n,), the fastest first."""
    chosen = np.flatnonzero(front(seconds, errors))
    return chosen[np.argsort(seconds[chosen])]


def _labels(dataset: xr.Dataset, ways: Indices, errors: Array) -> dict[tuple[float, float], str]:
    """Return the labels of ways by their point (seconds, error); ways at the same point share a label."""
    labels: dict[tuple[float, float], list[str]] = {}
    for k in ways:
        point = float(dataset.seconds.values[k]), float(errors[k])
        labels.setdefault(point, []).append(str(dataset.label.values[k]).removeprefix("C, harmonic "))
    return {point: ", ".join(names) for point, names in labels.items()}


def _table(dataset: xr.Dataset, body: str) -> Table:
    body_dataset, components = dataset.sel(body=body), [str(name) for name in dataset.component.values]
    errors, seconds = resolved_errors(dataset, body), body_dataset.seconds.values
    fronts = {c: front(seconds, errors.sel(component=c).values) for c in components}
    rows = []
    for k, way in enumerate(dataset.way.values):
        is_best, result = way == dataset.attrs["best"], body_dataset.isel(way=k)
        cells = [
            cell_of(result.sel(component=c), is_estimate=is_best, mark=" *" if fronts[c][k] else "")
            for c in components
        ]
        unknowns, memory = int(result.unknowns), float(result.memory)
        cost = [
            _time(seconds[k]),
            Cell(unknowns, ",d") if unknowns else "",
            Cell(memory, ".0f") if memory else "",
        ]
        rows.append(Row(str(result.label.item()), [*cells, *cost]))
    return Table("ICs by", numbers(*components, "time", "unknowns", "memory [MB]"), rows)


def evidence(dataset: xr.Dataset, advice: Advice) -> Printed:
    """Return the table behind the advice: upper bounds of each way's errors, and its seconds."""
    body, components = advice.question.body, list(advice.question.components)
    vanishing = dataset.vanishes.sel(body=body, component=components).values
    rows = Printed(
        title=f"{body}: error at most, share of the component itself (measured, and the estimate of "
        f"{dataset.attrs['best']})",
        caption="†: vanishes in C; share of 0.05 C_nn" if np.any(vanishing) else None,
    )
    headings = [
        name + (VANISHING if vanishes else "") for name, vanishes in zip(components, vanishing, strict=True)
    ]
    for heading in ("", "seconds", *headings):
        rows.add_column(heading, justify="right")
    errors, seconds = error_bounds(dataset, body), dataset.seconds.sel(body=body).values
    for k in np.argsort(seconds):
        way_errors = errors.isel(way=int(k)).sel(component=components).values
        if np.all(np.isnan(way_errors)):
            continue
        chosen = str(dataset.way.values[k]) == advice.way
        label = f"> {dataset.label.values[k]}" if chosen else str(dataset.label.values[k])
        rows.add_row(label, _time(float(seconds[k])), *(f"{error:.2%}" for error in way_errors))
    return rows
