"""Numbers of contacts on pages: the answer, verdicts, and the table of all numbers of a case."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import xarray as xr

from compare.report.looks import ics_symbol
from compare.report.tables import VANISHING, Cell, Column, Row, Table, number_text, numbers, with_estimate
from femic.contact.pairs.quantities import Quantity
from femic.results.contact import case_names

KILONEWTON = 1e3
NO_BREAK = "\u00a0"
ANSWERS = {"p_max": "MPa", "a": "mm", "b": "mm", "approach": "mm"}
OF_PLACE = ("position", "F_y", "M_x", "s_centre")  # numbers that vanish by symmetry: no shares of them
SUFFICES = 5.0  # %: deviation of the largest pressure up to which ICs suffice


def case_labels(dataset: xr.Dataset) -> list[str]:
    """Return the names of the cases, loads of some kilonewtons in kN."""
    if dataset.case.attrs["units"] != "N" or float(dataset.case.max()) < KILONEWTON:
        return case_names(dataset)
    return [f"{load / KILONEWTON:.12g} kN" for load in dataset.case.values]


def largest_case(dataset: xr.Dataset, reference: str) -> int:
    """Return the number of the case with the largest load that the reference has a solution of."""
    loads = dataset["load"].sel(ics=reference) if "ics" in dataset["load"].dims else dataset["load"]
    return int(np.argmax(loads.where(dataset.p_max.sel(ics=reference).notnull(), -np.inf).values))


def verdict(off: float | xr.DataArray, estimate: float | xr.DataArray, limit: float) -> str:
    """Return whether a difference, known to an estimate, is within a limit; all in percent."""
    off, estimate = abs(float(off)), float(estimate)
    if np.isnan(off):
        return ""
    off_text, estimate_text = (f"{float(f'{value:.2g}'):g}" for value in (off, estimate))
    if abs(off - limit) < estimate:
        return f"not decided: estimated error ± {estimate_text} %"
    return f"within {limit:g} %" if off <= limit else f"differs by {off_text} %"


def answer_sentence(dataset: xr.Dataset, reference: str) -> str:
    """Return the largest pressure and the patch at the largest load with the reference."""
    number = largest_case(dataset, reference)
    case = dataset.isel(case=number).sel(ics=reference)
    return (
        f"At {case_labels(dataset)[number]} the largest pressure is "
        f"{with_estimate(case.p_max, case.estimate_p_max)} MPa with {ics_symbol(reference)}. The patch "
        f"measures 2a × 2b = {2 * float(case.a):.3g} × {2 * float(case.b):.3g} mm; the surface turns by "
        f"{float(case.angle):.0f}° across it."
    )


def answer_table(dataset: xr.Dataset, reference: str, others: Sequence[str]) -> Table:
    """Return the numbers that one asks for first, with the reference, and how far others are from them.

    A row per case; of a single case a row for each of the ICs.
    """
    symbol, labels = ics_symbol(reference), case_labels(dataset)
    heads = [Column(key, unit) for key, unit in ANSWERS.items()]
    if len(labels) == 1:
        solutions = {name: dataset.isel(case=0).sel(ics=name) for name in (reference, *others)}
        rows = [
            Row(ics_symbol(name), [number_cell(solution, solutions[reference], key) for key in ANSWERS])
            for name, solution in solutions.items()
        ]
        return Table(f"at {labels[0]}; difference from {symbol}", heads, rows)
    rows = []
    for number, label in enumerate(labels):
        case, exact = dataset.isel(case=number), dataset.isel(case=number).sel(ics=reference)
        cells = [Cell(with_estimate(exact[key], exact[f"estimate_{key}"])) for key in ANSWERS]
        known = 100 * float(exact.estimate_p_max / exact.p_max)
        for name in others:
            off = 100 * float(case.p_max.sel(ics=name) / exact.p_max - 1)
            cells.append(Cell(off, "+.1f", verdict(off, known, SUFFICES)))
        rows.append(Row(label.replace(" ", NO_BREAK), cells))
    differences = numbers(*(f"p_max: {ics_symbol(name)} against {symbol}" for name in others), unit="%")
    return Table(f"with {symbol} at", [*heads, *differences], rows)


def numbers_table(
    caption: str,
    quantities: Mapping[str, Quantity],
    solutions: Mapping[str, xr.Dataset],
    reference: xr.Dataset,
    zeros: Collection[str] = (),
) -> Table:
    """Return all numbers of a case with their estimates, below them differences to the reference.

    A row per quantity, a column per solution, datasets of numbers; `zeros` vanish by symmetry.
    """
    rows = [
        Row(
            Column(quantity.symbol, quantity.unit).title,
            [
                Cell("0") if key in zeros else number_cell(solution, reference, key)
                for solution in solutions.values()
            ],
        )
        for key, quantity in quantities.items()
    ]
    return Table(caption, numbers(*solutions), rows)


def number_cell(solution: xr.Dataset, reference: xr.Dataset, key: str) -> Cell:
    """Return a number with its estimate, below it the difference to the reference; a dash if there is none.

    Differences are shares, or, of numbers that may vanish by symmetry or do, in their unit.
    """
    if key not in solution:
        return Cell("–")
    text = with_estimate(solution[key], solution[f"estimate_{key}"])
    if key not in reference or solution is reference or np.isnan(float(solution[key] - reference[key])):
        return Cell(text)
    difference = float(solution[key] - reference[key])
    if key not in OF_PLACE and float(reference[key]):
        share = difference / float(reference[key])
        return Cell(text, below="0%" if abs(share) < VANISHING / 2 else f"{number_text(share, '+.2%')}")
    vanishing = abs(difference) < VANISHING * float(solution[f"estimate_{key}"])
    return Cell(text, below="" if vanishing else f"{number_text(difference, '+.3g')}")
