"""File, chart and report of the frontier of a contact, and the evidence of advice.

The chart has errors of ways over their seconds, by number and by case.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from rich.table import Table as Printed

from compare.pages.frontier import FLOOR, FRONT, LEAST_DRAWN, drawn_percent, time_text, ways_on_front
from compare.report.charts import Chart, Curve, Panel
from compare.report.errors import colour, percent
from compare.report.looks import looks_of, symbol_of
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Row, Table, numbers, texts, with_estimate
from compare.studies.contact_advice import ContactAdvice
from compare.studies.contact_ways import APPROXIMATION, worst
from compare.studies.frontier import cheapest

# --- file and report ------------------------------------------------------------------------------------


TOLERANCES = (0.1, 0.05, 0.02, 0.01)
IN_SENTENCES = (0.05, 0.02, 0.01)
MAIN = {  # numbers of the answer, where none are named
    "none": ("p_max", "b", "stiffness", "approach"),
    "rolling": ("p_max", "F_x", "F_x/limit", "sliding_share"),
    "compression": ("p_max", "F_y/limit", "sliding_share"),
}
IN_SUMMARY = 2  # numbers of which the summary speaks
IN_A_TABLE = 6  # numbers beside each other
COST = (
    "ICs: of C the sum over its models, as measured when they were solved. Operator: from ICs to the "
    "operator of contact; of approximations with the ICs. Contact: all cases, without estimates. Measured "
    "once, beside whatever else the machine did."
)
READING = (
    "Table: the cheapest way whose error, with the estimate of the reference, is within the tolerance in all "
    "cases; among those within a factor of three in time the closest one; below it, its error and time. "
    "Points: each ICs on coarser and finer grids (elements across the smallest patch); beside C: its "
    "tolerance and elements. Bars: how far the error may be off, as the reference has one, too; below its "
    "estimate, nothing counts as closer."
)
EXPLANATION = (
    "An error is the largest over the creepages or loads of a case, and over the cases. Numbers that may "
    "vanish have errors as shares of themselves only where the reference's number exceeds ten times its own "
    "estimate: the last column says at how many of them. Forces have two names: the same difference is a "
    "larger share of the force than of friction times load, by as much as the force is smaller."
)
APPROACH = (
    "C has no approach of its own without supports: of the rigid motion that these allow, a convention takes "
    "the part along z away. So errors of approaches contain what that convention leaves, which is common to "
    "all approximations; tractions do not depend on it."
)


def write_contact_frontier(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `contact_frontier.nc`, the figures and `contact_frontier.html`; returns the path of the page."""
    title = f"Which ICs does this contact need? {dataset.attrs['title']}"
    page = Page(title, summary(dataset), _sections(dataset), answer_table(dataset))
    return write_results(page, folder, "contact_frontier", dataset)


def main_numbers(dataset: xr.Dataset) -> list[str]:
    """Return the numbers of the answer: the main ones of the motion that were compared, or the first."""
    known = known_numbers(dataset)
    main = [name for name in MAIN[dataset.attrs["motion"]] if name in known]
    return main or known[: len(MAIN["none"])]


def summary(dataset: xr.Dataset) -> str:
    """Return which ICs are enough, in at most three sentences: for one or two numbers, and against what."""
    names = main_numbers(dataset)[:IN_SUMMARY]
    if not names:
        return f"The reference, {_best(dataset)}, does not know any number well enough."
    known = join_words(
        f"{percent(worst(dataset, [name]).floor.sel(way=dataset.attrs['best']).item())} in {name}"
        for name in main_numbers(dataset)
    )
    against = f"Errors are against {_best(dataset)}, which is known to {known}."
    return " ".join([*(_sentence(dataset, name) for name in names), against])


def _best(dataset: xr.Dataset) -> str:
    return label_of(dataset.sel(way=dataset.attrs["best"]))


def _sentence(dataset: xr.Dataset, name: str) -> str:
    """Return the cheapest ways for a number, and the closest approximation."""
    errors = worst(dataset, [name])
    found: dict[str, list[str]] = {}
    for tolerance in IN_SENTENCES:
        if way := _cheapest(errors, tolerance):
            found.setdefault(way, []).append(_percent(tolerance))
    choices = [f"{label_of(errors.sel(way=way))} to {join_words(shares)}" for way, shares in found.items()]
    approximations = errors.isel(way=np.flatnonzero(errors.kind.values == APPROXIMATION)).dropna(
        "way", subset=["bound"]
    )
    text = (
        f"For {name}: {'; '.join(choices) if choices else f'no way is known to {_percent(IN_SENTENCES[0])}'}"
    )
    if not approximations.sizes["way"]:
        return f"{text}."
    closest = approximations.isel(way=int(np.argmin(approximations.bound.values)))
    return f"{text}; the closest approximation, {label_of(closest)}, is {error_text(closest)} % off at worst."


def _cheapest(errors: xr.Dataset, tolerance: float) -> str:
    """Return the name of the cheapest way that is good enough, "" where none is."""
    number = cheapest(errors.bound.values, errors.seconds.values, tolerance)
    return str(errors.way.values[number]) if number >= 0 else ""


def answer_table(dataset: xr.Dataset) -> Table:
    """Return the cheapest ways for the main numbers, a row per tolerance."""
    names = main_numbers(dataset)
    rows = []
    errors = {name: worst(dataset, [name]) for name in names}
    for tolerance in TOLERANCES:
        ways = {name: _cheapest(errors[name], tolerance) for name in names}
        cells = [
            Cell(label_of(errors[name].sel(way=way)), below=_cost(errors[name].sel(way=way)))
            if way
            else Cell("none")
            for name, way in ways.items()
        ]
        rows.append(Row(_percent(tolerance), cells))
    return Table("cheapest ICs to", texts(*names), rows)


def _percent(tolerance: float) -> str:
    return f"{100 * tolerance:g} %"


def _cost(errors: xr.Dataset) -> str:
    return f"{error_text(errors)} %, {time_text(errors.seconds.item())}"


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    drawn = chart(dataset, next(iter(main_numbers(dataset)), ""))
    yield Section("", [drawn if drawn.steps else "All ways are as good as the reference.", Note(READING)])
    yield Folded("What errors are shares of", [_scales_table(dataset), Note(EXPLANATION)])
    tables = list(_errors_tables(dataset))
    yield Folded("Errors of all ways by number", [Note(_marks(dataset)), *tables])
    yield Folded("Time of all ways", [_cost_table(dataset), Note(COST)])
    if skipped := json.loads(dataset.attrs["skipped"]):
        yield Folded("Left out", [Items([f"{name}: {reason}" for name, reason in skipped.items()])])
    yield Folded("Rigid motions and supports of the bodies", [dataset.attrs["discounted"], APPROACH])
    yield Folded("Scene file", [Verbatim(dataset.attrs["scene"])])


def _scales_table(dataset: xr.Dataset) -> Table:
    judged, points = (dataset[name].sum("case") for name in ("judged", "points"))
    rows = [
        Row(
            str(name),
            [
                str(dataset.scale.sel(number=name).item()),
                f"{judged.sel(number=name).item()} of {points.sel(number=name).item()}",
            ],
        )
        for name in dataset.number.values
    ]
    return Table("number", [*texts("error is a"), *numbers("known at")], rows)


def _marks(dataset: xr.Dataset) -> str:
    return (
        f"Worst case, in percent. The row of the reference, {_best(dataset)}, has its estimate. *: on the "
        "front of that number."
    )


def _errors_tables(dataset: xr.Dataset) -> Iterator[Table]:
    """Yield the errors of all ways, some numbers in each table."""
    names = known_numbers(dataset)
    for first in range(0, len(names), IN_A_TABLE):
        yield _errors_table(dataset, names[first : first + IN_A_TABLE])


def _errors_table(dataset: xr.Dataset, names: Sequence[str]) -> Table:
    errors = {name: worst(dataset, [name]) for name in names}
    fronts = {name: set(ways_on_front(each.dropna("way", subset=["bound"]))) for name, each in errors.items()}
    rows = []
    for way in dataset.way.values:
        cells = []
        for name, each in errors.items():
            one = each.sel(way=way)
            text = error_text(one) + (" *" if way in fronts[name] else "")
            error = one.error.item()
            cells.append(Cell(text, colour="" if np.isnan(error) else colour(error)))
        rows.append(Row(label_of(dataset.sel(way=way)), cells))
    return Table("ICs", numbers(*names, unit="%"), rows)


def _cost_table(dataset: xr.Dataset) -> Table:
    rows = []
    for way in dataset.way.values:
        at = dataset.sel(way=way)
        stages = [at[f"{stage}_seconds"].item() for stage in ("ics", "operator", "contact")]
        cells = [time_text(seconds) if seconds else "–" for seconds in (*stages, at.seconds.item())]
        rows.append(Row(label_of(at), [*cells, Cell(at.strips.item(), "d")]))
    return Table("ICs", numbers("ICs", "operator", "contact", "all", "strips"), rows)


def evidence(dataset: xr.Dataset, advice: ContactAdvice) -> Printed:
    """Return the table behind the advice: upper bounds of each way's errors, and its seconds."""
    names = list(advice.question.wants)
    table = Printed(
        title=f"error at most, worst case: measured, and the estimate of {dataset.attrs['best']}",
        caption="; ".join(f"{name}: {dataset.scale.sel(number=name).item()}" for name in names),
    )
    for heading in ("", "time", *names):
        table.add_column(heading, justify="right")
    errors = {name: worst(dataset, [name]) for name in names}
    for way in dataset.sortby("seconds").way.values:
        bounds = [each.bound.sel(way=way).item() for each in errors.values()]
        mark = "> " if way == advice.way else ""
        shown = ("–" if np.isnan(bound) else f"{bound:.2%}" for bound in bounds)
        at = dataset.sel(way=way)
        table.add_row(f"{mark}{label_of(at)}", time_text(at.seconds.item()), *shown)
    return table


# --- the chart ------------------------------------------------------------------------------------------


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
    floor = drawn_percent(errors.floor.sel(way=dataset.attrs["best"]))
    lines = [
        Curve("front", on_front.seconds.values, drawn_percent(on_front.error), FRONT),
        Curve(FLOOR_LABEL, [seconds.min(), seconds.max()], [floor, floor], FLOOR),
    ]
    return Panel(title, across, "error [%]", [*lines, *_points(errors)], log_x=True, log_y=True)


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
        error, bound, floor = (drawn_percent(ways[key]) for key in ("error", "bound", "floor"))
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
