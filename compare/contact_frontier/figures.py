"""The chart of the frontier of a contact: errors of ways over their seconds, by number and by case."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from compare.contact_frontier.errors import worst
from compare.contact_frontier.ways import APPROXIMATION
from compare.frontier.compute import front
from compare.frontier.figures import FLOOR, FRONT, LEAST_DRAWN, time_text
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import looks_of, symbol_of
from compare.report.tables import with_estimate
from geometries.arrays import Array

ALL = "all"  # the step of the slider and the panel that show the worst of all
FLOOR_LABEL = "estimate of the reference"


def label_of(way: xr.Dataset | xr.DataArray) -> str:
    """Return the name of a way in figures and tables: B̂, 20 elements; C (0.01), 40 elements."""
    symbol, tolerance, elements = symbol_of(str(way.ics.item())), way.tolerance.item(), way.elements.item()
    ics = symbol if np.isnan(tolerance) else f"{symbol} ({tolerance:g})"
    return f"{ics}, {elements} elements" if elements else ics


def chart(dataset: xr.Dataset, start: str) -> Chart:
    """Return the errors of all ways over their seconds, a step per number, with a choice of cases.

    Numbers whose errors are rounding are left out. `start` is the number shown first.
    """
    names = [name for name in known_numbers(dataset) if _spread(worst(dataset, [name]))]
    numbers = {name: [name] for name in names} | ({ALL: names} if len(names) > 1 else {})
    cases = [str(case) for case in dataset.case.values]
    shown = [None, *cases] if len(cases) > 1 else [None]
    steps = {name: [_panel(dataset, those, case) for case in shown] for name, those in numbers.items()}
    return Chart("contact_ways", steps, 1, "number", 1.4, start if start in steps else "", choice="case")


def _spread(errors: xr.Dataset) -> bool:
    """Return whether errors are known, larger than rounding, and not all the same."""
    known = errors.bound.dropna("way")
    return bool(known.size) and float(known.max()) > max(LEAST_DRAWN, 1.01 * float(known.min()))


def known_numbers(dataset: xr.Dataset) -> list[str]:
    """Return the numbers of which errors are known as shares in some case."""
    return [str(name) for name in dataset.number.values if dataset.judged.sel(number=name).any()]


def _panel(dataset: xr.Dataset, names: Sequence[str], case: str | None) -> Panel:
    """Return the errors of ways [%], with the front and the reference's estimate as lines."""
    errors = worst(dataset, names, case).dropna("way", subset=["bound"])
    title, across = case or "all cases", "time: ICs, operator, contact [s]"
    if not _spread(errors):
        return Panel(title, across, "error [%]: none, or not known as a share", [Curve("", [], [])])
    on_front, seconds = errors.sel(way=ways_on_front(errors)), errors.seconds.values
    floor = _percent(errors.floor.sel(way=dataset.attrs["best"]))
    lines = [
        Curve("front", on_front.seconds.values, _percent(on_front.error), FRONT),
        Curve(FLOOR_LABEL, [seconds.min(), seconds.max()], [floor, floor], FLOOR),
    ]
    return Panel(title, across, "error [%]", [*lines, *_points(errors)], log_x=True, log_y=True)


def _percent(errors: xr.DataArray) -> Array:
    return 100 * np.maximum(errors.values, LEAST_DRAWN)


def ways_on_front(errors: xr.Dataset) -> Array:
    """Return the names of the ways on the front of `worst`, the fastest first."""
    on_front = errors.isel(way=np.flatnonzero(front(errors.seconds.values, errors.error.values)))
    return on_front.sortby("seconds").way.values


def error_text(errors: xr.Dataset) -> str:
    """Return the error of a way of `worst` in percent: with what it may be off, or as a bound."""
    error, bound, floor = (100 * errors[name].item() for name in ("error", "bound", "floor"))
    if np.isnan(bound):
        return "–"
    return with_estimate(error, bound - error) if error > floor else f"≤ {bound:.2g}"


def _points(errors: xr.Dataset) -> Iterator[Curve]:
    """Yield the points of each ICs, one per number of elements and tolerance, with bars up to the bound."""
    looks = looks_of(dict.fromkeys(map(str, errors.ics.values)))
    for name, look in looks.items():
        ways = errors.isel(way=np.flatnonzero(errors.ics.values == name)).sortby("seconds")
        error, bound, floor = (_percent(ways[key]) for key in ("error", "bound", "floor"))
        bars = np.maximum(np.stack([np.minimum(floor, error - floor), bound - error]), 0)
        texts = [label_of(ways.sel(way=way)) for way in ways.way.values]
        notes = [_note(ways.sel(way=way)) for way in ways.way.values]
        names = [] if (ways.kind == APPROXIMATION).all() else [_after(text) for text in texts]
        yield Curve(
            symbol_of(name),
            ways.seconds.values,
            error,
            replace(look, dash=""),
            bars,
            bars=True,
            names=names,
            notes=notes,
        )


def _after(text: str) -> str:
    """Return the settings in a label: 0.1, 20."""
    return text.partition(" ")[2].replace("(", "").replace(")", "").removesuffix(" elements")


def _note(errors: xr.Dataset) -> str:
    where = f"{errors.number.item()} at {errors.case.item()}"
    time = time_text(errors.seconds.item())
    return f"{label_of(errors)}: {error_text(errors)} % ({where}) in {time}"
