"""The chart of `femic frontier`: errors of all ways to ICs against their seconds, by component and body."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex

from compare.frontier.compute import error_bounds, front, resolved_errors
from compare.frontier.ways import APPROXIMATION, styles
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import INK, Look, looks_of
from compare.report.static import MARKERS
from compare.report.tables import with_estimate
from geometries.arrays import Array

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
    floor = _percent(errors.floor.sel(way=dataset.attrs["best"]))
    lines = [
        Curve("front", on_front.seconds.values, _percent(on_front.error), FRONT),
        Curve(FLOOR_LABEL, [seconds.min(), seconds.max()], [floor, floor], FLOOR),
    ]
    vanishes = len(components) == 1 and dataset.vanishes.sel(body=body, component=components[0])
    title = f"{body}: vanishes, share of 0.05 C_nn" if vanishes else body
    across = f"time for {dataset.attrs['points']} points [s]"
    return Panel(title, across, "error [%]", [*lines, *_points(errors)], log_x=True, log_y=True)


def _percent(errors: xr.DataArray) -> Array:
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
    """Return the names of the ways on the front of `worst_errors`, the fastest first."""
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
    error, bound, floor = (_percent(errors[name]) for name in ("error", "bound", "floor"))
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
