"""File, figures and report of `femic frontier`, and the evidence table of `femic advise`."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from rich.table import Table as Printed

from compare.frontier.advice import Advice
from compare.frontier.compute import error_bounds, front, resolved_errors
from compare.frontier.figures import chart, error_text, time_text, ways_on_front, worst_errors
from compare.frontier.ways import APPROXIMATION
from compare.ics.curves import combined_first, main_body
from compare.ics.summary import body_name
from compare.report.errors import COMPONENTS, MEASURE, VANISHING, cell_of, percent
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Cell, Column, Row, Table, numbers

COST = (
    "Time: of an approximation at all points; of C the sum over all models that it and its estimate need, as "
    "measured when they were solved. Unknowns: of the largest model. Memory: peak of the process up to then, "
    "including earlier models."
)


def write_frontier(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `frontier.nc`, the figures and `frontier.html`; returns the path of the report."""
    title = f"Speed against accuracy: {dataset.attrs['title']}"
    page = Page(title, summary(dataset), _sections(dataset), answer_table(dataset))
    return write_results(page, folder, "frontier", dataset)


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    yield Section("", [chart(dataset), Note(_reading(dataset))])
    if skipped := json.loads(dataset.attrs["skipped"]):
        yield Folded("Left out", [Items([f"{name}: {reason}" for name, reason in skipped.items()])])
    bodies = combined_first(map(str, dataset.body.values))
    tables = [Section(body, [_errors_table(dataset, body)]) for body in bodies]
    yield Folded("Errors of all ways by component", [Note(_explanation(dataset)), *tables])
    yield Folded("Time, unknowns and memory of all ways", [_cost_table(dataset, bodies), Note(COST)])
    yield Folded("Scene file", [Verbatim(dataset.attrs["scene"])])


def _reading(dataset: xr.Dataset) -> str:
    return (
        f"Table: the ways on the front, {body_name(_main_body(dataset))}: no other way is as fast and "
        "closer, or as close and faster. “All”: the worst component. Numbers beside the points of C: "
        "tolerances. Bars: how far the error may be off, as the best C has one, too; below its estimate, "
        "nothing counts as closer."
    )


def _explanation(dataset: xr.Dataset) -> str:
    return (
        f"{MEASURE} Shown: the worst line. C comes from {dataset.attrs['best']}; its row has its estimated "
        f"error. *: on the front of that component. {COMPONENTS}"
    )


def _main_body(dataset: xr.Dataset) -> str:
    return main_body(map(str, dataset.body.values))


def _components(dataset: xr.Dataset) -> list[str]:
    return [str(component) for component in dataset.component.values]


def summary(dataset: xr.Dataset) -> str:
    """Return the closest approximation, the fastest C, and how good the best C is, in three sentences."""
    body = _main_body(dataset)
    errors = worst_errors(dataset, body, _components(dataset))
    is_c = (errors.kind != APPROXIMATION).values
    closest, fastest = _least(errors.isel(way=~is_c), "error"), _least(errors.isel(way=is_c), "seconds")
    best = errors.sel(way=dataset.attrs["best"])
    vanishing = ", or of 0.05 C_nn where it vanishes" if dataset.vanishes.sel(body=body).any() else ""
    return (
        f"Of the approximations {body_name(body)}, {closest.label.item()} is closest: {_off(closest)} off at "
        f"worst, in {time_text(closest.seconds.item())}. The fastest C, {fastest.way.item()}, is "
        f"{_off(fastest)} off at worst, in {time_text(fastest.seconds.item())}. Errors are shares of the "
        f"component{vanishing}, against C by {best.way.item()}, which is known to {_off(best)}."
    )


def _least(errors: xr.Dataset, name: str) -> xr.Dataset:
    return errors.isel(way=int(np.argmin(errors[name].values)))


def _off(errors: xr.Dataset) -> str:
    return f"{percent(errors.error.item())} ({errors.component.item()})"


def answer_table(dataset: xr.Dataset) -> Table:
    """Return the ways on the front of nn or of all components: time, errors in nn and in the worst one."""
    body, components = _main_body(dataset), _components(dataset)
    chosen = {"error in nn": ["nn"]} if {"nn"} < set(components) else {}
    errors = {
        head: worst_errors(dataset, body, those)
        for head, those in (chosen | {"worst error": components}).items()
    }
    fronts = {way for each in errors.values() for way in ways_on_front(each)}
    rows = []
    for way in (way for way in dataset.way.values if way in fronts):
        of_way = [each.sel(way=way) for each in errors.values()]
        worst, shares = of_way[-1], map(error_text, of_way)
        cells = [time_text(worst.seconds.item()), *shares, str(worst.component.item())]
        rows.append(Row(str(worst.label.item()), cells))
    return Table("ICs", [*numbers("time"), *numbers(*errors, unit="%"), *numbers("of")], rows)


def _errors_table(dataset: xr.Dataset, body: str) -> Table:
    """Return the errors of all ways of a body by component, with a mark where they are on its front."""
    of_body, components = dataset.sel(body=body), _components(dataset)
    errors, seconds = resolved_errors(dataset, body), of_body.seconds.values
    fronts = {c: front(seconds, errors.sel(component=c).values) for c in components}
    rows = []
    for k, way in enumerate(dataset.way.values):
        is_best, result = way == dataset.attrs["best"], of_body.isel(way=k)
        marks = {c: " *" if fronts[c][k] else "" for c in components}
        cells = [cell_of(result.sel(component=c), is_estimate=is_best, mark=marks[c]) for c in components]
        rows.append(Row(str(result.label.item()), cells))
    return Table("ICs by", numbers(*components), rows)


def _cost_table(dataset: xr.Dataset, bodies: Sequence[str]) -> Table:
    """Return the time of all ways for each body, their unknowns and memory."""
    rows = []
    for way in dataset.way.values:
        at = dataset.sel(way=way)
        sizes = (Cell(at[name].item(), form) for name, form in (("unknowns", ",d"), ("memory", ".0f")))
        times = [time_text(at.seconds.sel(body=body).item()) for body in bodies]
        rows.append(Row(str(at.label.item()), [*times, *(size if size.value else "" for size in sizes)]))
    heads = [f"time, {body}" for body in bodies]
    return Table("ICs by", [*numbers(*heads, "unknowns"), Column("memory", "MB")], rows)


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
        rows.add_row(label, time_text(float(seconds[k])), *(f"{error:.2%}" for error in way_errors))
    return rows
