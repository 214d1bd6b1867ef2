"""File, figures and report of `femic frontier`, and the evidence table of `femic advise`.

The chart has errors of all ways to ICs against their seconds, by component and body.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex
from rich.table import Table as Printed

from compare.pages.ics import body_name, combined_first, main_body
from compare.report.charts import Chart, Curve, Panel
from compare.report.errors import COMPONENTS, MEASURE, VANISHING, component_cell, percent
from compare.report.looks import INK, Look, looks_of
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, write_results
from compare.report.static import MARKERS
from compare.report.tables import Cell, Column, Row, Table, numbers, with_estimate
from compare.studies.frontier import APPROXIMATION, Advice, error_bounds, front, resolved_errors, styles
from geometries.arrays import Array

# --- file and report ------------------------------------------------------------------------------------


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
        cells = [
            component_cell(result.sel(component=c), is_estimate=is_best, mark=marks[c]) for c in components
        ]
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


# --- the chart ------------------------------------------------------------------------------------------


ALL = "all"  # the step of the slider that shows the worst of all components
LEAST_DRAWN = 1e-6  # error: smaller ones vanish by symmetry and are drawn here
FRONT = Look("#808080", width=1.0)
FLOOR = Look("#808080", "dot", width=1.0)
FLOOR_LABEL = "estimate of the best C"


def chart(dataset: xr.Dataset) -> Chart:
    """Return the errors of all ways against their seconds, a step per component, with a choice of bodies."""
    components = [str(component) for component in dataset.component.values]
    chosen = ({ALL: components} if len(components) > 1 else {}) | {name: [name] for name in components}
    bodies = [str(body) for body in dataset.body.values]
    steps = {name: [_panel(dataset, body, those) for body in bodies] for name, those in chosen.items()}
    return Chart("ways", steps, 1, "component", 1.4, next(iter(steps)), choice="body")


def _panel(dataset: xr.Dataset, body: str, components: Sequence[str]) -> Panel:
    """Return the errors of a body's ways [%], with the front and the best C's estimate as lines."""
    errors = worst_errors(dataset, body, components)
    on_front, seconds = errors.sel(way=ways_on_front(errors)), errors.seconds.values
    floor = drawn_percent(errors.floor.sel(way=dataset.attrs["best"]))
    lines = [
        Curve("front", on_front.seconds.values, drawn_percent(on_front.error), FRONT),
        Curve(FLOOR_LABEL, [seconds.min(), seconds.max()], [floor, floor], FLOOR),
    ]
    vanishes = len(components) == 1 and dataset.vanishes.sel(body=body, component=components[0])
    title = f"{body}: vanishes, share of 0.05 C_nn" if vanishes else body
    across = f"time for {dataset.attrs['points']} points [s]"
    return Panel(title, across, "error [%]", [*lines, *_points(errors)], log_x=True, log_y=True)


def drawn_percent(errors: xr.DataArray) -> Array:
    """Return errors as they are drawn on a logarithmic axis [%]."""
    return 100 * np.maximum(errors.values, LEAST_DRAWN)


def worst_errors(dataset: xr.Dataset, body: str, components: Sequence[str]) -> xr.Dataset:
    """Return the errors of a body's ways in their worst components, over `way`, without ways without ICs.

    `error` [-] is at least `floor`, the best C's estimate; with this it is at most `bound`. `component` is
    the worst one, `seconds` are those of the way.
    """
    chosen = dataset.sel(body=body, component=list(components)).dropna("way", subset=["error"])
    errors, bounds = (
        of(dataset, body).sel(component=list(components), way=chosen.way)
        for of in (resolved_errors, error_bounds)
    )
    at = {"component": errors.idxmax("component")}
    floor = chosen.estimate.sel(way=dataset.attrs["best"], drop=True)
    worst = {"error": errors.sel(at), "bound": bounds.sel(at), "floor": floor.sel(at)}
    return chosen[["seconds"]].assign(worst).assign_coords(component=at["component"])


def error_text(errors: xr.Dataset) -> str:
    """Return the error of a way of `worst_errors` in percent: with its estimate, or as a bound."""
    error, bound, floor = (100 * errors[name].item() for name in ("error", "bound", "floor"))
    return with_estimate(error, floor) if error > floor else f"≤ {bound:.2g}"


def time_text(seconds: float) -> str:
    """Return seconds, or milliseconds, with their unit."""
    if np.isnan(seconds):
        return "–"
    return f"{seconds:.3g} s" if seconds >= 1 else f"{float(f'{1000 * seconds:.2g}'):g} ms"


def ways_on_front(errors: xr.Dataset) -> Array:
    """Return the names of the ways on the front of errors over seconds, the fastest first."""
    on_front = errors.isel(way=np.flatnonzero(front(errors.seconds.values, errors.error.values)))
    return on_front.sortby("seconds").way.values


def _points(errors: xr.Dataset) -> Iterator[Curve]:
    """Yield each approximation as a point, and the points of each engine with their tolerances."""
    looks = looks_of(errors.way.values[errors.kind.values == APPROXIMATION])
    for name, look in looks.items():
        yield _curve(errors.sel(way=[name]), errors.label.sel(way=name).item(), look)
    for kind, (colour, marker) in styles().items():
        ways = errors.isel(way=np.flatnonzero(errors.kind.values == kind))
        if kind != APPROXIMATION and ways.sizes["way"]:
            yield replace(_curve(ways, f"C, {kind}", _look(colour, marker)), names=_names(ways, kind))


def _curve(errors: xr.Dataset, label: str, look: Look) -> Curve:
    """Return the points of some ways, with bars that end at the best C's estimate."""
    error, bound, floor = (drawn_percent(errors[name]) for name in ("error", "bound", "floor"))
    bars = np.stack([np.minimum(floor, error - floor), bound - error])
    notes = [_note(errors.sel(way=way)) for way in errors.way.values]
    marks = replace(look, dash="")
    return Curve(label, errors.seconds.values, error, marks, np.maximum(bars, 0), bars=True, notes=notes)


def _note(errors: xr.Dataset) -> str:
    time = time_text(errors.seconds.item())
    return f"{errors.label.item()}: {error_text(errors)} % of {errors.component.item()} in {time}"


def _names(ways: xr.Dataset, kind: str) -> list[str]:
    """Return the tolerances of an engine's ways, with options that differ; ways at one point share a name."""
    names = [str(name).removeprefix(f"{kind} ") for name in ways.way.values]
    if len({options for _, _, options in (name.partition(", ") for name in names)}) == 1:
        names = [name.partition(", ")[0] for name in names]
    points = list(zip(ways.seconds.values, ways.error.values, strict=True))
    by_point: dict[tuple[float, float], list[str]] = {}
    for point, name in zip(points, names, strict=True):
        by_point.setdefault(point, []).append(name)
    return ["; ".join(by_point.pop(point, [])) for point in points]


def _look(colour: str, marker: str) -> Look:
    """Return the look of an engine's points, whose colour and marker are named as in Matplotlib."""
    names = {code: name for name, code in MARKERS.items()}
    return Look(INK if colour == "black" else to_hex(colour), "", names.get(marker, "circle"))
