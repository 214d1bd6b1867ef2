"""`femic contact` solves the contact of a scene with several ICs and writes the file, charts and report.

For two or more scenes it also writes maps of where A and B-hat differ under the pressures of their contacts.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages import contact_figures as figures
from compare.pages.contact_numbers import (
    ALONE,
    KILONEWTON,
    answer_sentence,
    answer_table,
    case_labels,
    judged_numbers,
    numbers_table,
    tolerance,
    verdict_doubts,
    verdict_table,
    verdicts,
)
from compare.report.charts import Map, simple_chart
from compare.report.looks import ics_symbol
from compare.report.parts import (
    Block,
    Folded,
    Note,
    Page,
    Section,
    Verbatim,
    join_words,
    range_text,
    write_page,
    write_results,
)
from compare.report.tables import Cell, Row, Table, changes_table, number_text, numbers
from femic.cache import folders
from femic.contact.motions.none import (
    REFERENCE,
    FrictionlessContacts,
    Sensitivity,
    SolvedContact,
    sensitivities,
)
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.results.contact import compared_ics, pressures, reference_ics
from femic.scenes.scene import Scene
from geometries.surfaces import Surface

# --- the page -------------------------------------------------------------------------------------------


NUMBERS = (
    "The numbers belong to the patch that carries most of the load. ± is the estimated error, found by "
    "solving again on elements twice and four times as large and, for C, with C changed by its estimated "
    "error. The small number below is the difference from the number with {}: in % or, for numbers that "
    "may be zero by symmetry, in the unit of the row. “p_max, displaced” uses the distance of the "
    "displaced body instead of the linearised distance. A dash means that this contact exceeds the grid "
    "or has no solution; its error is then unknown (± ?). Strains are assumed small: finite strains may "
    "change p_max by {:.2g} %. Approximate ICs leave out the bending of the sections, "
    "which affects lateral forces."
)
GRIDS = (
    "Estimate: the largest estimated error of C_nn, divided by the largest C_nn. Asymmetry: the largest "
    "|C(I, J) − C(J, I)|; contact uses the mean of the two. Smallest eigenvalue: divided by the smallest "
    "IC of an element on itself. With given loads it covers pressures without a vertical resultant, with "
    "given approaches all pressures. It must be positive; otherwise the contact is not unique."
)
CHART = (
    "Top: results with each of the ICs; band: estimated error of {0}. Below: differences from {0}; bars: "
    "their estimated errors; dotted lines: the tolerance, key ics_tolerance of the scene."
)
DISTANCE = (
    "The distance between the bodies is linearised in the approach. With the distance of the displaced "
    'bodies (contact.gap = "exact"), p_max would change by {} % at {}.'
)
STRAINS = "Strains are assumed small. Finite strains may change p_max by up to {} % at {}."
UNKNOWN = (
    "Estimated errors are unknown (± ?) at {}: the contact with the distance of the displaced bodies, or on "
    "larger elements, was not found."
)
SYMBOLS = "; ".join(f"{one.symbol}: {one.meaning}" for one in OF_FRICTIONLESS.values()) + "."
FURTHER_ROWS = {  # below the numbers of a case
    "p_max, displaced [MPa]": ("displaced_p_max", ".5g"),
    "iterations": ("iterations", ".0f"),
    "pressures alone [s]": ("seconds", ".2f"),
}


@dataclass(frozen=True)
class FurtherSolution:
    """A further solution of the same contacts: its name, a section, numbers by number of the case, a note."""

    name: str
    section: Folded
    numbers: Mapping[int, xr.Dataset]
    note: str


def write_contact(
    scene: Scene, dataset: xr.Dataset, out: Path, further: FurtherSolution | None = None
) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page."""
    reference, others = reference_ics(dataset), compared_ics(dataset)
    page = Page(
        str(dataset.attrs["title"]),
        answer_sentence(dataset, reference, others),
        _sections(dataset, scene.bodies["lower"].surface, further),
        answer_table(dataset, reference, others),
        list(doubts(dataset)),
    )
    return write_results(page, out, "contact", dataset)


def doubts(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what is not decided, not known, or assumed though it changes p_max by more than the tolerance."""
    reference, others = reference_ics(dataset), compared_ics(dataset)
    if others:
        yield from verdict_doubts(verdicts(dataset, reference, others).values(), reference)
    else:
        yield ALONE.format(ics_symbol(reference))
    exact, labels = dataset.sel(ics=reference), case_labels(dataset)
    for text, change in (
        (DISTANCE, exact.displaced_p_max - exact.p_max),
        (STRAINS, exact.finite_strain_p_max),
    ):
        share = 100 * (change / exact.p_max).fillna(0.0)
        at = int(abs(share).argmax("case"))
        if abs(share[at]) > tolerance(dataset):
            yield text.format(number_text(share[at], "+.2g" if text == DISTANCE else ".2g"), labels[at])
    unknown = dataset.estimate_p_max.isnull().any("ics").values
    if unknown.any():
        yield UNKNOWN.format(join_words(np.array(labels)[unknown]))


def _sections(
    dataset: xr.Dataset, lower: Surface, further: FurtherSolution | None
) -> Iterator[Section | Folded]:
    reference, others = reference_ics(dataset), compared_ics(dataset)
    symbol, exact = ics_symbol(reference), dataset.sel(ics=reference)
    strain = 100 * float((exact.finite_strain_p_max / exact.p_max).max())
    notes = [CHART.format(symbol) if others else "", dataset.attrs.get("choice", "")]
    yield Section("", [figures.answer_chart(dataset), *(Note(text) for text in notes if text)])
    yield Section("Contact patch", [figures.patches(dataset)])
    if others and dataset.sizes["case"] > 1:
        further_numbers = [key for key in judged_numbers(dataset) if key != "p_max"]
        judged = [verdict_table(dataset, key, reference, others) for key in further_numbers]
        chart = figures.numbers_chart(dataset, figures.FURTHER, reference, "numbers")
        yield Folded("Length, width and approach: which ICs suffice", [*judged, chart])
    if others:
        maps = figures.pressure_differences(dataset)
        yield Folded(f"Maps of the differences of pressures from {symbol}", [maps])
    yield Folded(f"Pressures with {symbol} on the rail in 3D", [figures.on_rail(dataset, lower)])
    notes = [NUMBERS.format(symbol, strain), *([further.note] if further else [])]
    all_numbers: list[Block] = [" ".join(notes), Note(SYMBOLS), *case_tables(dataset, further)]
    yield Folded("All numbers, by load and ICs", all_numbers)
    if further:
        yield further.section
    supports: list[Block] = [dataset.attrs["discounted"]]
    if "supports" in dataset.coords:
        with_c = dataset.sel(ics="C").isel(case=int(dataset.attrs["supported_case"]))
        changes = changes_table("supports", OF_FRICTIONLESS, with_c, dataset, "supported_")
        supports += ["Effect of other supports on the largest contact computed with C:", changes]
    yield Folded("Rigid motions and supports of the bodies", supports)
    seconds = range_text(dataset.seconds, ".2g")
    cost = f"Pressures took {seconds} s per case; the whole run took {dataset.attrs['seconds']:.1f} s."
    yield Folded("Grids, C and cost", [GRIDS, _grids_table(dataset), cost])
    yield Folded("The scene file", [Verbatim(str(dataset.attrs["scene"]))])


def case_tables(dataset: xr.Dataset, further: FurtherSolution | None = None) -> Iterator[Table]:
    """Yield a table per case: each number with its estimate and its difference to the reference, the cost."""
    names, quantities = [reference_ics(dataset), *compared_ics(dataset)], dict(OF_FRICTIONLESS)
    for number, label in enumerate(case_labels(dataset)):
        case = dataset.isel(case=number)
        if label.endswith("kN"):
            case = case.assign({key: case[key] / KILONEWTON for key in ("load", "estimate_load")})
            quantities["load"] = replace(OF_FRICTIONLESS["load"], unit="kN")
        with_ics = [case.sel(ics=name) for name in names]
        solutions, missing = dict(zip(map(ics_symbol, names), with_ics, strict=True)), []
        if further and number in further.numbers:
            solutions[further.name], missing = further.numbers[number], [Cell("–")]
        table = numbers_table(label, quantities, solutions, with_ics[0])
        others = [
            Row(head, [*(Cell(float(one[key]), form) for one in with_ics), *missing])
            for head, (key, form) in FURTHER_ROWS.items()
        ]
        yield Table(label, table.columns, [*table.rows, *others])


def _grids_table(dataset: xr.Dataset) -> Table:
    """Return the table of grids, with what is known of C on each."""
    references, rows = json.loads(dataset.attrs["references"]), {}
    for number in range(dataset.sizes["case"]):
        p = pressures(dataset, number)
        dx, ds = (float(p[name][1] - p[name][0]) if p.sizes[name] > 1 else np.nan for name in ("x", "s"))
        name = f"{p.sizes['x']} x {p.sizes['s']} x {dx:g} x {ds:g} mm"
        cells: list[Cell | str] = ["–"] * 4
        if name in references:
            forms = {"estimate": ".2%", "asymmetry": ".1e", "smallest_eigenvalue": ".3f", "seconds": ".1f"}
            cells = [Cell(float(references[name][key]), form) for key, form in forms.items()]
        rows[name] = Row(f"{p.sizes['x']} × {p.sizes['s']} elements of {dx:.3g} × {ds:.3g} mm", cells)
    return Table("grid", ["estimate", "asymmetry", "smallest eigenvalue", "s for C"], list(rows.values()))


# --- where A and B-hat differ under given pressures -----------------------------------------------------


MAPS = (
    "Each map applies the pressures of one scene (row), computed with B̂, to the patch of another scene "
    "(column), at the same x / a and s / b. Colours: the normal displacement with A minus that with B̂, "
    "divided by the largest displacement with B̂. A uniform difference only changes the approach; a "
    "varying difference changes the pressures."
)


def write_sensitivity(solved: Mapping[str, FrictionlessContacts], out: Path) -> Path:
    """Write maps of where A and B-hat differ, of two or more scenes, and their page; returns its path."""
    return write_page(sensitivity_page(solved), folders.make(out) / "contact.html")


def is_mapped(scene: Scene) -> bool:
    """Return whether the contact of a scene is frictionless and solved with B-hat."""
    return scene.contact.friction is None and REFERENCE in scene.contact.ics


def mapped_contact(solved: FrictionlessContacts) -> SolvedContact:
    """Return the contact with B-hat to be mapped: at `contact.shape_load`, or at the largest load."""
    contacts = [contact for (_, ics), contact in solved.contacts.items() if ics == REFERENCE]
    shape_load = solved.problem.specification.shape_load
    if shape_load is None:
        return max(contacts, key=lambda contact: contact.normal.load)
    return min(contacts, key=lambda contact: abs(contact.normal.load - shape_load))


def sensitivity_page(solved: Mapping[str, FrictionlessContacts]) -> Page:
    """Return the differences under the pressures of every scene (row) on the patch of every scene."""
    cases = list(sensitivities({name: mapped_contact(contacts) for name, contacts in solved.items()}))
    worst, n = max(cases, key=lambda case: case.largest), len(solved)
    ranges = [
        Cell(" ... ".join(number_text(100 * end(case.inside), "+.1f") for end in (np.min, np.max)))
        for case in cases
    ]
    table = Table(
        "A minus B̂, under the pressures of",
        numbers(*(f"on the patch of {patch}" for patch in solved), unit="%"),
        [Row(name, ranges[k * n : (k + 1) * n]) for k, name in enumerate(solved)],
    )
    maps = [_map(case, 100 * worst.largest) for case in cases]
    return Page(
        f"Where A and B̂ differ: {', '.join(solved)}",
        f"Displacements with A differ from B̂ by up to {worst.largest:.1%} of the largest displacement. "
        f"The largest difference occurs under the pressures of {worst.pressures} on the patch of "
        f"{worst.patch}.",
        [Section("", [simple_chart("sensitivity", maps, n), MAPS])],
        table,
    )


def _map(case: Sensitivity, largest: float) -> Map:
    x, s = (np.flatnonzero(case.on_patch.any(axis=axis)) for axis in (1, 0))
    shown = np.where(case.on_patch, 100 * case.difference, np.nan)
    return Map(
        f"pressures of {case.pressures} on {case.patch}",
        "x [mm]",
        "s [mm]",
        case.x[x[0] : x[-1] + 1],
        case.s[s[0] : s[-1] + 1],
        shown[x[0] : x[-1] + 1, s[0] : s[-1] + 1],
        "A − B̂, over the largest [%]",
        "diverging",
        (-largest, largest),
    )
