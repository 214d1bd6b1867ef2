"""Numbers of contacts on pages: which ICs suffice, verdicts, and the table of all numbers of a case."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from compare.report.looks import ics_symbol
from compare.report.parts import join_words
from compare.report.tables import (
    VANISHING,
    Cell,
    Column,
    Row,
    Table,
    number_text,
    numbers,
    with_estimate,
)
from compare.report.verdicts import NO, NOT_DECIDED, YES, verdict, verdict_cell
from femic.contact.datasets import CHANGE, DISPLACED, FLOOR, LARGER, MISSED, estimate_of_difference
from femic.contact.pairs.ics import C
from femic.contact.pairs.quantities import Quantity
from femic.results.contact import case_names, map_names

KILONEWTON = 1e3
NO_BREAK = "\u00a0"
OF_PLACE = ("position", "F_y", "M_x", "s_centre")  # numbers that vanish by symmetry: no shares of them

# --- verdicts -------------------------------------------------------------------------------------------


DECIDES = (
    "“Not decided” means that the difference may be below or above the tolerance, given its estimated error. "
    "More elements (contact.elements){} can decide it."
)
ALONE = "Only {} was computed. There is nothing to compare it with: give more ICs in contact.ics."
NO_C = (
    "C was not computed. Differences are those from {}, which is itself an approximation. Add C to "
    "contact.ics to see how far each of the ICs is from C."
)


def tolerance(dataset: xr.Dataset) -> float:
    """Return the largest difference that the scene tolerates [%]."""
    return 100 * float(dataset.attrs["ics_tolerance"])


def tolerance_levels(dataset: xr.Dataset) -> list[float]:
    """Return the limits of tolerated differences [%], to be drawn; none where no scene says them."""
    return [-tolerance(dataset), tolerance(dataset)] if "ics_tolerance" in dataset.attrs else []


def verdict_sentences(
    verdicts: Mapping[str, str], deciding: Mapping[str, str], what: str, limit: str, where: tuple[str, str]
) -> str:
    """Return a sentence for each verdict that some ICs have, all of them by their symbols.

    `deciding` are the differences that verdicts follow from, with their places; `where` says of all, and of
    some of what.
    """
    by_verdict = {
        word: [ics for ics, own in verdicts.items() if own == word] for word in (YES, NO, NOT_DECIDED)
    }
    texts = {
        YES: "With {}, {} by at most {} {}.",
        NO: "With {}, {} by more than {} {} ({}).",
        NOT_DECIDED: "With {}, it is not decided whether {} by at most {} {} ({}).",
    }
    return " ".join(
        text.format(
            join_words(by_verdict[word]),
            what,
            limit,
            where[word == NO],
            join_words(
                deciding[ics] if len(by_verdict[word]) == 1 else f"{ics} {deciding[ics]}"
                for ics in by_verdict[word]
            ),
        )
        for word, text in texts.items()
        if by_verdict[word]
    )


def verdict_doubts(verdicts: Iterable[str], reference: str) -> Iterator[str]:
    """Yield what decides what is not decided, and that the reference is no finite-element one."""
    approximate = reference != C and not map_names([reference])
    if NOT_DECIDED in verdicts:
        yield DECIDES.format("" if approximate else " or a smaller error of C (engine.tolerance)")
    if approximate:
        yield NO_C.format(ics_symbol(reference))


# --- differences ----------------------------------------------------------------------------------------


def differences(dataset: xr.Dataset, key: str, reference: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Return by how much numbers differ from the reference's [%], and the estimated errors of this.

    Much of the error of two contacts on the same elements is common to both: where numbers on larger elements
    are known, differences are taken there, too. Elsewhere the errors of both are added.
    """
    errors = [LARGER, CHANGE, FLOOR, MISSED, "estimate_", DISPLACED]
    known = dataset[[prefix + key for prefix in ("", *errors) if prefix + key in dataset]].drop_attrs()

    def difference(contacts: xr.Dataset) -> xr.DataArray:
        exact = contacts[key].sel(ics=reference, drop=True)
        return 100 * (contacts[key] / exact.where(exact != 0) - 1)

    off, own = difference(known), known[f"estimate_{key}"]
    if LARGER + key not in known:
        of_reference = own.sel(ics=reference, drop=True)
        return off, 100 * (own + of_reference) / abs(known[key].sel(ics=reference, drop=True))
    moved = abs(difference(known[[DISPLACED + key]].rename({DISPLACED + key: key})) - off)
    known_to = estimate_of_difference(known, difference)
    estimate = known_to + moved.fillna(0.0)  # NaN also where nothing is linearised
    return off, estimate.where(own.notnull() & own.sel(ics=reference, drop=True).notnull())


def difference_text(value: ArrayLike, estimate: ArrayLike, *, signed: bool = True) -> str:
    """Return a difference [%] with its estimate, and with its sign unless it is a size."""
    value, estimate = float(value), float(estimate)  # type: ignore[arg-type]
    if np.isnan(value) or np.isnan(estimate):
        return "–" if np.isnan(value) else f"{number_text(value, '+.1f' if signed else '.1f')} ± ? %"
    return f"{with_estimate(value, estimate, signed=signed)} %"


def deciding_text(
    off: xr.DataArray,
    estimate: xr.DataArray,
    limit: float,
    *,
    signed: bool = True,
    places: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """Return the difference [%] that a verdict follows from: with its estimate it is furthest on its side.

    `places` are the names of the places along a dimension; where there are several, that of the difference
    is named.
    """
    beyond = verdict(abs(off), estimate, limit) == NO
    ends = abs(off) - estimate if beyond else abs(off) + estimate
    at = ends.fillna(-np.inf if beyond else np.inf).argmax(...)
    text = difference_text(off.isel(at), estimate.isel(at), signed=signed)
    named = (names[int(at[along])] for along, names in (places or {}).items() if len(names) > 1)
    return " at ".join([text, *named])


# --- which ICs suffice ----------------------------------------------------------------------------------


def case_labels(dataset: xr.Dataset) -> list[str]:
    """Return the names of the cases, loads of some kilonewtons in kN."""
    if dataset.case.attrs["units"] != "N" or float(dataset.case.max()) < KILONEWTON:
        return case_names(dataset)
    return [f"{load / KILONEWTON:.12g} kN" for load in dataset.case.values]


def largest_case(dataset: xr.Dataset, reference: str) -> int:
    """Return the number of the case with the largest load that the reference has a solution of."""
    loads = dataset["load"].sel(ics=reference) if "ics" in dataset["load"].dims else dataset["load"]
    return int(np.argmax(loads.where(dataset.p_max.sel(ics=reference).notnull(), -np.inf).values))


def judged_numbers(dataset: xr.Dataset) -> dict[str, Column]:
    """Return the numbers that one asks for first, with their heads; the prescribed one is not among them."""
    free = ("approach", "mm") if dataset.case.attrs["units"] == "N" else ("load", "N")
    return {key: Column(key, unit) for key, unit in (("p_max", "MPa"), ("a", "mm"), ("b", "mm"), free)}


def verdicts(dataset: xr.Dataset, reference: str, others: Sequence[str]) -> dict[str, str]:
    """Return whether p_max is within the tolerance in all cases, by ICs."""
    off, known = differences(dataset, "p_max", reference)
    return {name: verdict(abs(off.sel(ics=name)), known.sel(ics=name), tolerance(dataset)) for name in others}


def answer_sentence(dataset: xr.Dataset, reference: str, others: Sequence[str]) -> str:
    """Return with which ICs p_max is within the tolerance, and the reference's at the largest load."""
    number, (off, known) = largest_case(dataset, reference), differences(dataset, "p_max", reference)
    case, label, symbol = (
        dataset.isel(case=number).sel(ics=reference),
        case_labels(dataset)[number],
        ics_symbol(reference),
    )
    unit = "load" if dataset.case.attrs["units"] == "N" else "approach"
    several, limit = dataset.sizes["case"] > 1, tolerance(dataset)
    said = verdict_sentences(
        {ics_symbol(name): word for name, word in verdicts(dataset, reference, others).items()},
        {
            ics_symbol(name): deciding_text(
                off.sel(ics=name), known.sel(ics=name), limit, places={"case": case_labels(dataset)}
            )
            for name in others
        },
        f"p_max differs from {symbol}",
        f"{limit:g} %",
        (f"at every {unit}", f"at one {unit} or more") if several else (f"at {label}", f"at {label}"),
    )
    return (
        f"{said} At {label}, the largest pressure p_max is "
        f"{with_estimate(case.p_max, case.estimate_p_max)} MPa with {symbol}; ± is the estimated error. The "
        "contact patch measures 2a × 2b = "
        f"{2 * float(case.a):.3g} × {2 * float(case.b):.3g} mm, and the surface turns by "
        f"{float(case.angle):.0f}° across it."
    ).strip()


def answer_table(dataset: xr.Dataset, reference: str, others: Sequence[str]) -> Table:
    """Return with which ICs p_max is within the tolerance, by case; of a single one, also other numbers."""
    if dataset.sizes["case"] > 1:
        return verdict_table(dataset, "p_max", reference, others)
    tables = {
        head.title: verdict_table(dataset, key, reference, others)
        for key, head in judged_numbers(dataset).items()
    }
    first = next(iter(tables.values()))
    rows = [Row(title, table.rows[0].cells[1:]) for title, table in tables.items()]
    return Table(f"at {case_labels(dataset)[0]}", [f"with {ics_symbol(reference)}", *first.columns[2:]], rows)


def verdict_table(dataset: xr.Dataset, key: str, reference: str, others: Sequence[str]) -> Table:
    """Return a number with the reference, and whether others are within the tolerance of it, by case."""
    rows, (off, known) = [], differences(dataset, key, reference)
    for number, label in enumerate(case_labels(dataset)):
        exact = dataset.isel(case=number).sel(ics=reference)
        cells = [Cell(float(exact.angle), ".0f"), Cell(with_estimate(exact[key], exact[f"estimate_{key}"]))]
        for name in others:
            value, error = off.isel(case=number).sel(ics=name), known.isel(case=number).sel(ics=name)
            cells.append(verdict_cell(abs(value), error, tolerance(dataset), difference_text(value, error)))
        rows.append(Row(label.replace(" ", NO_BREAK), cells))
    asked = numbers(*(f"{ics_symbol(name)} within {tolerance(dataset):g} %?" for name in others))
    with_reference = Column(f"{key} with {ics_symbol(reference)}", judged_numbers(dataset)[key].unit)
    return Table("at", [Column("surface turns by", "°"), with_reference, *asked], rows)


# --- all numbers ----------------------------------------------------------------------------------------


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
