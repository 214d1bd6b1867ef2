"""Answers of contacts in sentences and in a table, and the table of all numbers of a case."""

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import extreme, join_words, onset
from compare.report.tables import VANISHING, Cell, Column, Row, Table, number_text, numbers, with_estimate
from femic.contact.pairs.quantities import Quantity
from femic.results.contact import case_names

KILONEWTON = 1e3
NO_BREAK = "\u00a0"
ANSWERS = {"p_max": ("p_max", "MPa"), "a": ("a", "mm"), "b": ("b", "mm"), "approach": ("approach", "mm")}
OF_PLACE = ("position", "F_y", "M_x", "s_centre")  # numbers that vanish by symmetry: no shares of them
FAILS = 0.05  # deviation of the largest pressure from which an answer says that ICs fail


def case_labels(dataset: xr.Dataset) -> list[str]:
    """Return the names of the cases, loads of some kilonewtons in kN."""
    if dataset.case.attrs["units"] != "N" or float(dataset.case.max()) < KILONEWTON:
        return case_names(dataset)
    return [f"{load / KILONEWTON:.12g} kN" for load in dataset.case.values]


def largest_case(dataset: xr.Dataset, reference: str) -> int:
    """Return the number of the case with the largest load that the reference has a solution of."""
    loads = dataset["load"].sel(ics=reference) if "ics" in dataset["load"].dims else dataset["load"]
    return int(np.argmax(loads.where(dataset.p_max.sel(ics=reference).notnull(), -np.inf).values))


def answer_sentences(dataset: xr.Dataset, reference: str, others: Sequence[str]) -> Iterator[str]:
    """Yield pressure and patch at the largest load with the reference, and how far others are from it."""
    number, symbol = largest_case(dataset, reference), symbol_of(reference)
    case = dataset.isel(case=number).sel(ics=reference)
    pressure = with_estimate(case.p_max, case.estimate_p_max)
    patch = f"{2 * float(case.a):.3g} × {2 * float(case.b):.3g} mm over {float(case.angle):.0f}°"
    yield (
        f"At {case_labels(dataset)[number]} the largest pressure is {pressure} MPa with {symbol}"
        f"{_strain(case)}, on a patch of 2a × 2b = {patch}."
    )
    if deviations := [_deviation(dataset, name, reference) for name in others]:
        yield f"Largest difference of p_max to {symbol}: {join_words(deviations)}."


def _strain(case: xr.Dataset) -> str:
    """Return by how much strains that are not small may change p_max, where it is known."""
    change = case.get("finite_strain_p_max")
    return "" if change is None else f" (strains are taken as small: ± {float(change):.2g} MPa more)"


def _deviation(dataset: xr.Dataset, name: str, reference: str) -> str:
    """Return how far p_max with ICs is off at worst, and from which angle on it is too far."""
    deviation = dataset.p_max.sel(ics=name) / dataset.p_max.sel(ics=reference) - 1
    solved = deviation.notnull().values
    deviation, angle = deviation[solved], dataset.angle.sel(ics=reference)[solved]
    text = f"{symbol_of(name)} {number_text(extreme(deviation), '+.1%')}"
    if dataset.sizes["case"] == 1:
        return text
    failing = onset(angle.values, (abs(deviation) > FAILS).values)
    where = f"beyond {FAILS:.0%} {failing}" if failing else f"within {FAILS:.0%} everywhere"
    return f"{text} ({where})"


def answer_table(dataset: xr.Dataset, reference: str, others: Sequence[str]) -> Table:
    """Return the numbers that one asks for first, with the reference, and how far others are from them.

    A row per case; of a single case a row for each of the ICs.
    """
    symbol, labels = symbol_of(reference), case_labels(dataset)
    heads = [Column(*head) for head in ANSWERS.values()]
    if len(labels) == 1:
        solutions = {name: dataset.isel(case=0).sel(ics=name) for name in (reference, *others)}
        rows = [
            Row(symbol_of(name), [number_cell(solution, solutions[reference], key) for key in ANSWERS])
            for name, solution in solutions.items()
        ]
        return Table(f"at {labels[0]}, and over {symbol}", heads, rows)
    differences = numbers(*(f"p_max: {symbol_of(name)} over {symbol}" for name in others), unit="%")
    return Table(
        f"with {symbol} at",
        [*heads, *differences],
        [
            Row(label.replace(" ", NO_BREAK), list(_answers(dataset.isel(case=number), reference, others)))
            for number, label in enumerate(labels)
        ],
    )


def _answers(case: xr.Dataset, reference: str, others: Sequence[str]) -> Iterator[Cell]:
    solution = case.sel(ics=reference)
    for key in ANSWERS:
        yield Cell(with_estimate(solution[key], solution[f"estimate_{key}"]))
    for name in others:
        yield Cell(100 * float(case.p_max.sel(ics=name) / solution.p_max - 1), "+.1f")


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
