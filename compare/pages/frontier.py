"""File, chart and page of `femic frontier`, of ICs or of a contact, and the evidence of `femic advise`.

The chart has errors of ways over their seconds, by component and body, or by number and case.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from rich.table import Table as Printed

from compare.pages.ics import share_text, tolerance
from compare.report.charts import Chart, Curve, Panel
from compare.report.errors import COMPONENTS, MEASURE, VANISHING, colour, percent
from compare.report.looks import ENGINE_LOOKS, OTHER_ENGINE, Look, ics_looks, ics_symbol
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Column, Row, Table, numbers, texts, with_estimate
from compare.studies.contact_frontier import STAGES
from compare.studies.frontier import BEYOND_BUDGET, Advice, by_number, case_text, cheapest, front, worst
from femic.reference.engines import ENGINES
from geometries.arrays import Array

# --- the page -------------------------------------------------------------------------------------------


TOLERANCES = (0.1, 0.05, 0.02, 0.01)
MAIN = {  # numbers of a contact that the answer is about, as far as they were compared
    "none": ("p_max", "b", "stiffness", "approach"),
    "rolling": ("p_max", "F_x", "F_x/limit", "sliding_share"),
    "compression": ("p_max", "F_y/limit", "sliding_share"),
}
IN_A_TABLE = 9  # numbers beside each other
READING = (
    "Table: the cheapest choice whose error, plus the estimated error of the reference, is within the "
    "tolerance in all cases. If several choices take similar time (within a factor of three), the most "
    "accurate one is shown. Its error and time stand below. “None”: no choice is accurate enough; the most "
    "accurate one stands below. Chart: numbers beside points are the tolerance of C, and the elements across "
    "the smallest patch. Line: the best choices; no other choice is both as fast and more accurate. Bars: ± "
    "the estimated error of the reference. Choices whose bars overlap are equally accurate as far as one "
    "can tell: which is better is not decided."
)
SHARES = (
    "Each error is the largest over all creepages or loads and over all cases. Where a number may vanish, "
    "its relative error is only evaluated where the reference exceeds ten times its own estimated error; "
    "the last column says at how many points. Errors of forces are given twice: relative to the force, "
    "and relative to friction times load."
)
APPROACH = (
    "With C, the approach depends on the supports. A convention removes the rigid motion along z. Errors "
    "of the approach therefore contain an offset from this convention, which is the same for all "
    "approximations. Tractions do not depend on it."
)
COST = (
    "Time: for an approximation, all points; for C, the sum over all models that C and its estimated "
    "error need, measured when they were solved. Unknowns: the largest model. Memory: the peak of the "
    "process up to that point, including earlier models."
)
COST_OF_CONTACT = (
    "ICs: for C, the sum over its models, measured when they were solved. Operator: time from the ICs to "
    "the contact operator; for approximations it includes the ICs. Contact: all cases, without error "
    "estimates. Each time was measured once, while other programs may have been running."
)


def write_frontier(dataset: xr.Dataset, folder: Path) -> Path:
    """Write the file, the figures and the page of a frontier of ICs or of a contact; returns its path.

    The file is `frontier.nc`, of a contact `contact_frontier.nc`, and so are the names of the others.
    """
    name, question = (
        ("frontier", "Speed against accuracy")
        if _is_about_ics(dataset)
        else ("contact_frontier", "Which ICs does this contact need?")
    )
    title, answer = f"{question}: {dataset.attrs['title']}", answer_table(dataset)
    page = Page(title, summary(dataset), _sections(dataset), answer, list(doubts(dataset)))
    return write_results(page, folder, name, dataset)


def summary(dataset: xr.Dataset) -> str:
    """Return the cheapest choice within the tolerance of the scene, its time, and the reference's error."""
    subjects, case, allowed = main_subjects(dataset), _main_case(dataset), tolerance(dataset)
    best = dataset.label.sel(way=dataset.attrs["best"]).item()
    if not subjects:
        return (
            f"Nothing can be decided: the estimated error of the reference, {best}, is more than a tenth of "
            "every number."
        )
    subjects_by_text: dict[str, list[str]] = {}
    for subject, names in subjects.items():
        errors = worst(dataset, names, case)
        way = _cheapest(errors, allowed)
        text = (
            f"none ({_closest_text(errors)})"
            if way is None
            else f"{way.label.item()} in {time_text(way.seconds.item())}"
        )
        subjects_by_text.setdefault(text, []).append(subject)
    chosen = "; ".join(f"for {join_words(those)}, {text}" for text, those in subjects_by_text.items())
    floor = max(
        worst(dataset, names, case).floor.sel(way=dataset.attrs["best"]).item() for names in subjects.values()
    )
    return (
        f"Cheapest ICs within the tolerance of {share_text(allowed)}: {chosen}. Errors are relative to "
        f"{best}, whose estimated error is at most {percent(floor)}."
    )


def _cheapest(errors: xr.Dataset, allowed: float) -> xr.Dataset | None:
    """Return the cheapest way within a tolerance, None if there is none."""
    number = cheapest(errors.bound.values, errors.seconds.values, allowed)
    return errors.isel(way=number) if number >= 0 else None


def _closest_text(errors: xr.Dataset) -> str:
    """Return the most accurate way with its error and time."""
    known = errors.dropna("way", subset=["bound"])
    if not known.sizes["way"]:
        return "not known"
    way = known.isel(way=int(np.argmin(known.bound.values)))
    return f"most accurate: {way.label.item()}, {_error_and_time(way)}"


def _error_and_time(way: xr.Dataset) -> str:
    return f"{error_text(way)} %, {time_text(way.seconds.item())}"


def answer_table(dataset: xr.Dataset) -> Table | None:
    """Return the cheapest ways for what is asked first, a row per tolerance; their errors and time below."""
    subjects, case = main_subjects(dataset), _main_case(dataset)
    if not subjects:
        return None
    rows = []
    for allowed in sorted({*TOLERANCES, tolerance(dataset)}, reverse=True):
        cells = []
        for names in subjects.values():
            errors = worst(dataset, names, case)
            way = _cheapest(errors, allowed)
            if way is None:
                cells.append(Cell("none", below=_closest_text(errors)))
            else:
                cells.append(Cell(str(way.label.item()), below=_error_and_time(way)))
        rows.append(Row(share_text(allowed), cells))
    return Table("cheapest ICs within", texts(*subjects), rows)


def doubts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield which choices were not tried, and which have no solution."""
    skipped = json.loads(dataset.attrs["skipped"])
    expensive = [name for name, reason in skipped.items() if BEYOND_BUDGET in reason]
    unsolved = [name for name in skipped if name not in expensive]
    if expensive:
        yield f"Not tried, because the budget of time was too small: {'; '.join(expensive)}."
    if unsolved:
        yield f"No solution, for reasons under “Left out”: {'; '.join(unsolved)}."


def main_subjects(dataset: xr.Dataset) -> dict[str, list[str]]:
    """Return what is asked first, and the numbers it is about: nn and all components; or single numbers."""
    known = known_numbers(dataset)
    if _is_about_ics(dataset):
        return ({"nn": ["nn"]} if {"nn"} < set(known) else {}) | {"all components": known}
    main = [name for name in MAIN[dataset.attrs["motion"]] if name in known]
    return {name: [name] for name in main or known[: len(MAIN["none"])]}


def known_numbers(dataset: xr.Dataset) -> list[str]:
    """Return the numbers or components of which errors are known as shares in some case."""
    dataset = by_number(dataset)
    return [str(name) for name in dataset.number.values if dataset.judged.sel(number=name).any()]


def _is_about_ics(dataset: xr.Dataset) -> bool:
    return "component" in dataset.dims


def _cases(dataset: xr.Dataset) -> list[str | float]:
    """Return the bodies, both together first, or the cases of a contact."""
    if not _is_about_ics(dataset):
        return list(dataset.case.values.tolist())
    return sorted(dataset.body.values.tolist(), key=lambda body: body != "combined")


def _main_case(dataset: xr.Dataset) -> str | float | None:
    """Return the body that the answer is about; None, all cases, of a contact."""
    return _cases(dataset)[0] if _is_about_ics(dataset) else None


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    about_ics, best = _is_about_ics(dataset), dataset.label.sel(way=dataset.attrs["best"]).item()
    drawn = chart(dataset)
    yield Section(
        "", [drawn if drawn.steps else "All choices are as accurate as the reference.", Note(READING)]
    )
    if not about_ics:
        judged, points = (dataset[name].sum("case") for name in ("judged", "points"))
        rows = [
            Row(str(name), [str(dataset.scale.sel(number=name).item()), f"{known.item()} of {every.item()}"])
            for name, known, every in zip(dataset.number.values, judged, points, strict=True)
        ]
        scales = Table("number", [*texts("error is a"), *numbers("known at")], rows)
        yield Folded("What the errors are relative to", [scales, Note(SHARES)])
    cases = _cases(dataset) if about_ics else [None]
    names = known_numbers(dataset)
    marks = Note(
        f"Largest errors in percent. The row of the reference, {best}, shows its estimated error. *: among "
        f"the best choices for that number. {f'{MEASURE} {COMPONENTS}' if about_ics else ''}"
    )
    tables = [
        Section("" if case is None else str(case), [_errors_table(dataset, names[k : k + IN_A_TABLE], case)])
        for case in cases
        for k in range(0, len(names), IN_A_TABLE)
    ]
    yield Folded("Errors of all choices", [marks, *tables])
    yield Folded("Time of all choices", [_cost_table(dataset), Note(COST if about_ics else COST_OF_CONTACT)])
    if skipped := json.loads(dataset.attrs["skipped"]):
        yield Folded("Left out", [Items([f"{name}: {reason}" for name, reason in skipped.items()])])
    if not about_ics:
        yield Folded("Rigid motions and supports of the bodies", [dataset.attrs["discounted"], APPROACH])
    yield Folded("Scene file", [Verbatim(dataset.attrs["scene"])])


def _errors_table(dataset: xr.Dataset, names: Sequence[str], case: str | float | None) -> Table:
    """Return the errors of all ways by number, marked on its front; of ICs with their weight below."""
    errors = {name: worst(dataset, [name], case) for name in names}
    fronts = {name: set(ways_on_front(each.dropna("way", subset=["bound"]))) for name, each in errors.items()}
    rows = []
    for way in dataset.way.values:
        cells = []
        for name, each in errors.items():
            one = each.sel(way=way)
            weight = (
                by_number(dataset).weight.sel(way=way, number=name, case=case)
                if _is_about_ics(dataset)
                else np.nan
            )
            cells.append(
                Cell(
                    error_text(one) + (" *" if way in fronts[name] else ""),
                    below="" if np.isnan(weight) else percent(float(weight)),
                    colour="" if np.isnan(one.error) else colour(one.error.item()),
                )
            )
        rows.append(Row(str(dataset.label.sel(way=way).item()), cells))
    heads = [name + _mark(dataset, name, case) for name in names]
    return Table("ICs", numbers(*heads, unit="%"), rows)


def _mark(dataset: xr.Dataset, name: str, case: str | float | None) -> str:
    """Return the mark of a component that vanishes in C."""
    return VANISHING if _is_about_ics(dataset) and dataset.vanishes.sel(component=name, body=case) else ""


def _cost_table(dataset: xr.Dataset) -> Table:
    """Return the seconds of all ways, by body or by stage, and the sizes of their models or grids."""
    if _is_about_ics(dataset):
        seconds = {f"time, {body}": dataset.seconds.sel(body=body) for body in _cases(dataset)}
        sizes = {Column("unknowns"): ("unknowns", ",d"), Column("memory", "MB"): ("memory", ".0f")}
    else:
        heads = zip(("ICs", *STAGES[1:]), STAGES, strict=True)
        seconds = {head: dataset[f"{stage}_seconds"] for head, stage in heads} | {"all": dataset.seconds}
        sizes = {Column("strips"): ("strips", "d")}
    rows = []
    for way in dataset.way.values:
        times = [time_text(each.sel(way=way).item()) for each in seconds.values()]
        own = [Cell(dataset[name].sel(way=way).item(), form) for name, form in sizes.values()]
        rows.append(
            Row(
                str(dataset.label.sel(way=way).item()),
                [*times, *(cell if cell.value else "" for cell in own)],
            )
        )
    return Table("ICs", [*numbers(*seconds), *sizes], rows)


def evidence(dataset: xr.Dataset, advice: Advice) -> Printed:
    """Return the table behind the advice: upper bounds of each way's errors, and its seconds."""
    names, case = list(advice.question.names), advice.question.body or None
    errors = {name + _mark(dataset, name, case): worst(dataset, [name], case) for name in names}
    scales = (
        "relative to 0.05 C_nn, because it vanishes in C"
        if VANISHING in head
        else "relative to the component itself"
        if case
        else dataset.scale.sel(number=head).item()
        for head in errors
    )
    table = Printed(
        title=f"{case or 'contact'}: largest error, with the estimate of {dataset.attrs['best']}",
        caption="; ".join(f"{head}: {scale}" for head, scale in zip(errors, scales, strict=True)),
    )
    for heading in ("", "time", *errors):
        table.add_column(heading, justify="right")
    first = next(iter(errors.values())).sortby("seconds")
    for way in first.way.values:
        bounds = [each.bound.sel(way=way).item() for each in errors.values()]
        if np.all(np.isnan(bounds)):
            continue
        mark = "> " if way == advice.way else ""
        shown = ("–" if np.isnan(bound) else f"{bound:.2%}" for bound in bounds)
        own = first.sel(way=way)
        table.add_row(f"{mark}{own.label.item()}", time_text(own.seconds.item()), *shown)
    return table


# --- the chart ------------------------------------------------------------------------------------------


ALL = "all"  # the step of the slider and the panel that show the worst of all
LEAST_DRAWN = 1e-6  # error: smaller ones vanish by symmetry and are drawn here
FRONT = Look("#808080", width=1.0)
FLOOR = Look("#808080", "dot", width=1.0)
FLOOR_LABEL = "estimated error of the best C"


def chart(dataset: xr.Dataset) -> Chart:
    """Return the errors of all ways over their seconds, a step per number, with a choice of bodies or cases.

    Numbers of a contact whose errors are rounding are left out.
    """
    about_ics, cases = _is_about_ics(dataset), _cases(dataset)
    names = [name for name in known_numbers(dataset) if about_ics or _spread(worst(dataset, [name]))]
    steps = ({ALL: names} if len(names) > 1 else {}) | {name: [name] for name in names}
    shown: Sequence[str | float | None] = cases if about_ics else [None, *cases] if len(cases) > 1 else [None]
    start = next((name for name in main_subjects(dataset) if name in names), "")
    return Chart(
        "ways",
        {name: [_panel(dataset, those, case) for case in shown] for name, those in steps.items()},
        1,
        "component" if about_ics else "number",
        1.4,
        next(iter(steps)) if about_ics else start,
        choice="body" if about_ics else "case",
    )


def _spread(errors: xr.Dataset) -> bool:
    """Return whether errors are known, larger than rounding, and not all the same."""
    known = errors.bound.dropna("way")
    return bool(known.size) and float(known.max()) > max(LEAST_DRAWN, 1.01 * float(known.min()))


def _panel(dataset: xr.Dataset, names: Sequence[str], case: str | float | None) -> Panel:
    """Return the errors of ways [%], with the front and the best C's estimate as lines."""
    errors = worst(dataset, names, case).dropna("way", subset=["bound"])
    title, across = (
        "all cases" if case is None else case_text(dataset, case),
        "time: ICs, operator, contact [s]",
    )
    if _is_about_ics(dataset):
        across = f"time for {dataset.attrs['points']} points [s]"
        if len(names) == 1 and _mark(dataset, names[0], case):
            title = f"{title}: vanishes, relative to 0.05 C_nn"
    elif not _spread(errors):
        return Panel(title, across, "error [%]: none, or no relative error", [Curve("", [], [])])
    on_front, seconds = errors.sel(way=ways_on_front(errors)), errors.seconds.values
    floor = _drawn(errors.floor.sel(way=dataset.attrs["best"]))
    lines = [
        Curve("front", on_front.seconds.values, _drawn(on_front.error), FRONT),
        Curve(FLOOR_LABEL, [seconds.min(), seconds.max()], [floor, floor], FLOOR),
    ]
    return Panel(title, across, "error [%]", [*lines, *_points(errors)], log_x=True, log_y=True)


def _drawn(errors: xr.DataArray) -> Array:
    """Return errors as they are drawn on a logarithmic axis [%]."""
    return 100 * np.maximum(errors.values, LEAST_DRAWN)


def _points(errors: xr.Dataset) -> Iterator[Curve]:
    """Yield each approximation, map and engine as points, with bars that end at their bounds."""
    groups = dict.fromkeys(zip(errors.kind.values.tolist(), errors.ics.values.tolist(), strict=True))
    looks: Mapping[str, Look] = ics_looks(dict.fromkeys(ics for _, ics in groups))
    for kind, ics in groups:
        chosen = (errors.kind.values == kind) & (errors.ics.values == ics)
        ways = errors.isel(way=np.flatnonzero(chosen)).sortby("seconds")
        label, look, names = ics_symbol(ics), replace(looks[ics], dash=""), list[str]()
        if kind in ENGINES:
            look, label = ENGINE_LOOKS.get(kind, OTHER_ENGINE), f"C, {kind}"
            names = _point_names(ways, kind)
        error, bound, floor = (_drawn(ways[key]) for key in ("error", "bound", "floor"))
        bars = np.maximum(np.stack([np.minimum(floor, error - floor), bound - error]), 0)
        notes = [
            f"{way.label.item()}: {error_text(way)} % of {way.number.item()} in "
            f"{time_text(way.seconds.item())}"
            for way in (ways.isel(way=k) for k in range(ways.sizes["way"]))
        ]
        yield Curve(label, ways.seconds.values, error, look, bars, bars=True, names=names, notes=notes)


def _point_names(ways: xr.Dataset, kind: str) -> list[str]:
    """Return the tolerances of an engine's ways, with elements or options; ways at one point share a name."""
    names = [
        str(name).removeprefix(f"{kind} ").removeprefix("C ").removesuffix(" elements")
        for name in ways.way.values
    ]
    if len({name.partition(", ")[2] for name in names}) == 1:
        names = [name.partition(", ")[0] for name in names]
    points = list(zip(ways.seconds.values, ways.error.values, strict=True))
    by_point: dict[tuple[float, float], list[str]] = {}
    for point, name in zip(points, names, strict=True):
        by_point.setdefault(point, []).append(name)
    return ["; ".join(by_point.pop(point, [])) for point in points]


def ways_on_front(errors: xr.Dataset) -> Array:
    """Return the names of the ways on the front of errors over seconds, the fastest first."""
    on_front = errors.isel(way=np.flatnonzero(front(errors.seconds.values, errors.error.values)))
    return on_front.sortby("seconds").way.values


def error_text(way: xr.Dataset) -> str:
    """Return the error of a way of `worst` in percent: with what it may be off, or as a bound."""
    error, bound, floor = (100 * way[name].item() for name in ("error", "bound", "floor"))
    if np.isnan(bound):
        return "–"
    return with_estimate(error, bound - error) if error > floor else f"≤ {bound:.2g}"


def time_text(seconds: float) -> str:
    """Return seconds, or milliseconds, with their unit."""
    if np.isnan(seconds):
        return "–"
    return f"{seconds:.3g} s" if seconds >= 1 else f"{float(f'{1000 * seconds:.2g}'):g} ms"
