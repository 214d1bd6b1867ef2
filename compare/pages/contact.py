"""`femic contact` solves the contact of a scene with several ICs and writes the file, charts and report.

For two or more scenes it also writes maps of where A and B-hat differ under the pressures of their contacts.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import xarray as xr

from compare.pages import contact_figures as figures
from compare.pages.contact_answers import (
    KILONEWTON,
    answer_sentences,
    answer_table,
    case_labels,
    numbers_table,
)
from compare.report.charts import Map, chart_of
from compare.report.looks import symbol_of
from compare.report.parts import (
    Block,
    Folded,
    Note,
    Page,
    Section,
    Verbatim,
    join_words,
    write_page,
    write_results,
)
from compare.report.tables import Cell, Row, Table, changes_table, number_text, numbers
from femic.cache import folders
from femic.contact.motions.none import REFERENCE, Sensitivity, SolvedContact, sensitivities
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.results.contact import ContactResults, others_of, reference_of, to_dataset, with_supports
from femic.results.matrices import discounted
from femic.scenes.scene import Scene

# --- the page -------------------------------------------------------------------------------------------


NO_OTHERS: Mapping[str, Mapping[str, float]] = MappingProxyType({})
GRIDS = (
    "Estimate: largest estimated error of C_nn over the largest C_nn. Asymmetry: largest |C(I, J) − C(J, I)|"
    "; contact takes the mean of both. Smallest eigenvalue over the least IC of an element on itself: for "
    "given loads, of pressures without vertical load; for given approaches, of all pressures. It must be "
    "positive, or contacts are not unique."
)
SYMBOLS = "; ".join(f"{one.symbol}: {one.meaning}" for one in OF_FRICTIONLESS.values()) + "."
SIDEWAYS = 1e-3  # lateral force over load from which the summary mentions it


@dataclass(frozen=True)
class FurtherSolution:
    """A further solution of the same contacts: its name, a section, numbers by number of the case, a note."""

    name: str
    section: Folded
    numbers: Mapping[int, xr.Dataset]
    note: str


def write_contact(
    results: ContactResults,
    out: Path,
    supports: Mapping[str, Mapping[str, float]] = NO_OTHERS,
    further: FurtherSolution | None = None,
    *,
    choice: str = "",
) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page.

    `supports` has the numbers of the largest contact with other supports, by change; `choice` says why these
    ICs were chosen.
    """
    dataset = with_supports(to_dataset(results), supports).assign_attrs(choice=choice)
    return write_results(_page(results, dataset, further), out, "contact", dataset)


def _page(results: ContactResults, dataset: xr.Dataset, further: FurtherSolution | None) -> Page:
    answer = answer_table(dataset, reference_of(dataset), others_of(dataset))
    return Page(str(dataset.attrs["title"]), summary(dataset), _sections(results, dataset, further), answer)


def _sections(
    results: ContactResults, dataset: xr.Dataset, further: FurtherSolution | None
) -> Iterator[Section | Folded]:
    why = [Note(dataset.attrs["choice"])] if dataset.attrs["choice"] else []
    yield Section("", [figures.answer_chart(dataset), *why])
    lower = next(iter(results.solved.contacts.values())).on_grid.undeformed.lower
    yield Section("Pressures on the rail", [figures.on_rail(dataset, lower)])
    yield Section("Patches", [figures.patches(dataset)])
    if dataset.sizes["case"] > 1:
        yield Folded("Further numbers over the angle of the patch", [figures.further_numbers(dataset)])
    texts = _explanation(dataset, further), Note(SYMBOLS)
    yield Folded("All numbers, by load and ICs", [*texts, *_tables(dataset, further)])
    if further:
        yield further.section
    yield Folded("Rigid motions and supports of the bodies", list(_supports(results.scene, dataset)))
    yield Folded("Grids, C on them, and cost", [GRIDS, _grids_table(results), _cost(dataset, results)])
    yield Folded("The scene", [Verbatim(results.scene.text)])


def _explanation(dataset: xr.Dataset, further: FurtherSolution | None) -> str:
    sentences = [
        "Of the patch with the largest load, with estimated errors: from elements twice and four times as "
        "large; of C also from C plus its own estimate. Small, below each number: its difference to the "
        f"number with {symbol_of(reference_of(dataset))}, in its unit where it may vanish by symmetry. "
        "“p_max, displaced”: with the distance of the displaced body instead of the linearised one; a dash "
        "where that contact exceeds the grid, or has no solution: then errors are not known (± ?).",
        *_displaced_sentence(dataset),
    ]
    return " ".join([*sentences, further.note] if further else sentences)


def summary(dataset: xr.Dataset) -> str:
    """Return the answer, in at most three sentences: pressure and patch, deviations of others, what else."""
    answers = answer_sentences(dataset, reference_of(dataset), others_of(dataset))
    further = [*_lateral_force_sentence(dataset), *_displaced_sentence(dataset)]
    return " ".join([*answers, *further[:1]])


def _lateral_force_sentence(dataset: xr.Dataset) -> Iterator[str]:
    """Yield a sentence on the lateral force, where the contact is not symmetric."""
    shares, reference = dataset.F_y / dataset["load"], reference_of(dataset)
    number = int(np.argmax(abs(shares.sel(ics=reference)).values))
    shares = shares.isel(case=number)
    share = float(shares.sel(ics=reference))
    if abs(share) < SIDEWAYS:
        return
    others = join_words(
        f"{number_text(float(shares.sel(ics=name)), '+.3f')} with {symbol_of(name)}"
        for name in others_of(dataset)
    )
    yield (
        f"The lateral force on the upper body is {number_text(share, '+.3f')} of the load with "
        f"{symbol_of(reference)} at {case_labels(dataset)[number]}"
        + (f", {others}: approximations lack the bending of the sections." if others else ".")
    )


def _displaced_sentence(dataset: xr.Dataset) -> Iterator[str]:
    """Yield a sentence on the exact distance, where there are contacts with it."""
    displaced = abs(dataset.displaced_p_max / dataset.p_max - 1).sel(ics=reference_of(dataset))
    if displaced.notnull().any():
        yield (
            "The exact distance of the displaced body instead of the linearised one changes p_max by up to "
            f"{float(displaced.max()):.1%}."
        )


def _cost(dataset: xr.Dataset, results: ContactResults) -> str:
    seconds = dataset.seconds.values
    grids = json.loads(dataset.attrs["references"]).values()
    of_c = f", C on its grids {sum(float(grid['seconds']) for grid in grids):.0f} s" if grids else ""
    return (
        f"Pressures took {seconds.min():.2g} ... {seconds.max():.2g} s a case{of_c}; all of it "
        f"{results.solved.seconds:.1f} s."
    )


def _tables(dataset: xr.Dataset, further: FurtherSolution | None) -> Iterator[Table]:
    """Yield a table per case: each number with its estimate and its difference to the reference, the cost."""
    reference = reference_of(dataset)
    names, quantities = [reference, *others_of(dataset)], dict(OF_FRICTIONLESS)
    for number, label in enumerate(case_labels(dataset)):
        case = dataset.isel(case=number)
        if label.endswith("kN"):
            case = case.assign({key: case[key] / KILONEWTON for key in ("load", "estimate_load")})
            quantities["load"] = replace(OF_FRICTIONLESS["load"], unit="kN")
        with_ics = [case.sel(ics=name) for name in names]
        solutions = dict(zip(map(symbol_of, names), with_ics, strict=True))
        missing = []
        if further and number in further.numbers:
            solutions[further.name] = further.numbers[number]
            missing = [Cell("–")]
        table = numbers_table(label, quantities, solutions, with_ics[0])
        rows = {
            "p_max, displaced [MPa]": ("displaced_p_max", ".5g"),
            "iterations": ("iterations", ".0f"),
            "pressures alone [s]": ("seconds", ".2f"),
        }
        others = [
            Row(head, [*(Cell(float(one[key]), form) for one in with_ics), *missing])
            for head, (key, form) in rows.items()
        ]
        yield Table(label, table.columns, [*table.rows, *others])


def _supports(scene: Scene, dataset: xr.Dataset) -> Iterator[Block]:
    """Yield the rigid motions subtracted from C, and the effect of other supports on the largest contact."""
    if "supports" not in dataset.coords:
        yield discounted(scene)
        return
    yield f"{discounted(scene)} How other supports change the largest contact computed with C:"
    with_c = dataset.sel(ics="C").isel(case=int(dataset.attrs["supported_case"]))
    yield changes_table("supports", OF_FRICTIONLESS, with_c, dataset, "supported_")


def _grids_table(results: ContactResults) -> Table:
    """Return the table of grids, with the estimate of C on each."""
    rows = []
    for grid in dict.fromkeys(contact.on_grid.grid for contact in results.solved.contacts.values()):
        name = f"{grid.n_x} x {grid.n_s} elements of {grid.dx:.4g} x {grid.ds:.4g} mm"
        cells = ["–"] * 4
        if c := results.solved.references.get(grid):
            cells = [
                f"{c.estimate:.2%}",
                f"{c.asymmetry.share:.1e}",
                f"{c.eigenvalue:.3f}",
                f"{c.seconds:.1f}",
            ]
        rows.append(Row(name, cells))
    return Table("grid", ["estimate", "asymmetry", "smallest eigenvalue", "s for C"], rows)


# --- where A and B-hat differ under given pressures -----------------------------------------------------


MAPS = (
    "Pressures computed with B̂ in one scene (row) on the patch of another (column), at the same x / a and "
    "s / b. Colours: normal displacement with A minus B̂, over the largest with B̂. A uniform difference "
    "changes the approach only; a varying one changes the pressures."
)


def write_sensitivity(results: Mapping[str, ContactResults], out: Path) -> Path:
    """Write maps of where A and B-hat differ, of two or more scenes, and their page; returns its path."""
    cases = mutual_sensitivities(results)
    page = Page(
        f"Where A and B̂ differ: {', '.join(results)}",
        sensitivity_summary(cases),
        [Section("", [chart_of("sensitivity", *sensitivity_maps(cases)), MAPS])],
        sensitivity_table(cases),
    )
    return write_page(page, folders.make(out) / "contact.html")


def is_mapped(scene: Scene) -> bool:
    """Return whether the contact of a scene is frictionless and solved with B-hat."""
    return scene.contact.friction is None and REFERENCE in scene.contact.ics


def shape_of(results: ContactResults) -> SolvedContact:
    """Return the contact with B-hat to be mapped: at `contact.shape_load`, or at the largest load."""
    contacts = [contact for (_, ics), contact in results.solved.contacts.items() if ics == REFERENCE]
    shape_load = results.scene.contact.shape_load
    if shape_load is None:
        return max(contacts, key=lambda contact: contact.normal.load)
    return min(contacts, key=lambda contact: abs(contact.normal.load - shape_load))


def mutual_sensitivities(results: Mapping[str, ContactResults]) -> list[Sensitivity]:
    """Return the differences under the pressures of every scene (row) on the patch of every scene."""
    return list(sensitivities({name: shape_of(contacts) for name, contacts in results.items()}))


def sensitivity_summary(cases: Sequence[Sensitivity]) -> str:
    """Return how far A is off at worst, and which pressures that is under on each patch."""
    worst = max(cases, key=lambda case: case.largest)
    by_patch = {
        patch: max((case for case in cases if case.patch == patch), key=lambda case: case.largest)
        for patch in _patches(cases)
    }
    under = join_words(
        f"on the patch of {patch} under the pressures of {case.pressures}" for patch, case in by_patch.items()
    )
    return (
        f"Displacements with A are off by up to {worst.largest:.1%} of the largest with B̂, "
        f"under the pressures of {worst.pressures} on the patch of {worst.patch}. A is furthest off {under}."
    )


def _patches(cases: Sequence[Sensitivity]) -> list[str]:
    return list(dict.fromkeys(case.patch for case in cases))


def sensitivity_table(cases: Sequence[Sensitivity]) -> Table:
    """Return the range of differences, a row per pressures, a column per patch."""
    patches = _patches(cases)
    ranges = [
        Cell(" ... ".join(number_text(100 * end(case.inside), "+.1f") for end in (np.min, np.max)))
        for case in cases
    ]
    n = len(patches)
    return Table(
        "A over B̂, pressures of",
        numbers(*(f"on the patch of {patch}" for patch in patches), unit="%"),
        [Row(name, ranges[k * n : (k + 1) * n]) for k, name in enumerate(patches)],
    )


def sensitivity_maps(cases: Sequence[Sensitivity]) -> tuple[list[Map], int]:
    """Return the maps, a row per pressures, a column per patch, and the number of columns."""
    largest = 100 * max(case.largest for case in cases)
    return [_map(case, largest) for case in cases], len(_patches(cases))


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
