"""The pages of motions with friction: what they have in common, and what each motion adds."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr

from compare.contact.dataset import ics_of
from compare.friction import maps
from compare.friction.shown import (
    BY_SYMMETRY,
    abscissa,
    curves_by_ics,
    main_name,
    motion_of,
    place_text,
    places,
    share_curves,
    shown,
    step,
    vanishes,
    worst_friction,
)
from compare.friction.supports import PREFIX
from compare.report.charts import Cell as ChartCell
from compare.report.charts import Chart, Panel
from compare.report.looks import symbol_of
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Row, Table, changed_cell, with_estimate
from femic.contact.motions import MOTIONS
from femic.contact.pairs.given_ics import C

EXACT = 1e-5  # share of a number below which its estimate is none
MOST, FEW = 20, 5  # places in the tables of the main number, and of others
BELOW = (
    "Charts and contact.nc have all places, tables some. Small, below each number: its estimated error (from "
    "elements twice and four times as large; in compression also from steps of load twice as large; of C "
    "also from C plus its own estimate)."
)


@dataclass(frozen=True)
class MotionPage:
    """What the page of a motion has of its own, each made from the labelled arrays.

    `note` explains the main chart; `remarks` are sentences on the limits of the numbers.
    """

    summary: Callable[[xr.Dataset], str]
    answer: Callable[[xr.Dataset], Table]
    main_chart: Callable[[xr.Dataset], Chart]
    note: Callable[[xr.Dataset], str]
    contact: Callable[[xr.Dataset], str]  # of which contact the maps are
    work: str  # what the work of friction on the maps is
    sections: Callable[[xr.Dataset], Sequence[Section]] = lambda _: ()
    tables: Callable[[xr.Dataset], Sequence[Folded]] = lambda _: ()
    remarks: Callable[[xr.Dataset], Iterator[str]] = lambda _: iter(())
    steady: str = ""  # before the names of numbers of steady rolling, which then have rows of their own

    def write(self, dataset: xr.Dataset, out: Path) -> Path:
        """Write `contact.nc`, figures and `contact.html` into a folder; return the path of the page."""
        sections = chain(
            [Section("", [self.main_chart(dataset), Note(self.explained(dataset))])],
            self.sections(dataset),
            map_sections(dataset, self.contact(dataset), self.work),
            self.tables(dataset),
            [
                Folded("All numbers", [numbers_chart(dataset), BELOW, *self.number_tables(dataset)]),
                Folded("Limits, supports, grid and cost", self.details(dataset)),
                Folded("Scene file", [Verbatim(str(dataset.attrs["scene"]))]),
            ],
        )
        page = Page(str(dataset.attrs["title"]), self.summary(dataset), sections, self.answer(dataset))
        return write_results(page, out, "contact", dataset)

    def explained(self, dataset: xr.Dataset) -> str:
        """Return what the main chart shows, how friction depends on the angle, and why ICs were chosen."""
        texts = self.note(dataset), dataset.attrs["friction_by_angle"], dataset.attrs.get("choice", "")
        return " ".join(filter(None, texts))

    def number_tables(self, dataset: xr.Dataset) -> list[Block]:
        """Return the tables of each number, one per friction, and which numbers vanish."""
        symmetric = [name for name in BY_SYMMETRY if name in dataset and vanishes(dataset, name)]
        names = [name for name in MOTIONS[motion_of(dataset)].quantities if name not in symmetric]
        blocks: list[Block] = []
        for name in names:
            tables = [self._number_table(dataset, name, friction) for friction in dataset.friction.values]
            number = shown(dataset, name)
            blocks.append(Folded(f"{number.title}: {number.meaning}", tables))
        return [*blocks, _symmetry(dataset, symmetric)]

    def _number_table(self, dataset: xr.Dataset, name: str, friction: float) -> Table:
        """Return a number at one friction: a row for each place listed, a column per ICs."""
        of_friction, number = dataset.sel(friction=friction), shown(dataset, name)
        dimension = MOTIONS[motion_of(dataset)].dimension
        listed = _listed(of_friction, MOST if name == main_name(dataset) else FEW)
        rows = [
            Row(place_text(dataset, place), _cells(listed.sel({dimension: place}), name, number.factor))
            for place in listed[dimension].values
        ]
        if self.steady:
            rows.append(Row("steady", _cells(of_friction, self.steady + name, number.factor)))
        return Table(
            f"friction {friction:g}: {number.title}", [symbol_of(ics) for ics in ics_of(dataset)], rows
        )

    def details(self, dataset: xr.Dataset) -> list[Block]:
        """Return remarks, changes with other supports, and cost."""
        return [*self.remarks(dataset), *support_tables(dataset), cost(dataset)]


def _listed(dataset: xr.Dataset, most: int) -> xr.Dataset:
    """Return the numbers at some places, from the first to the last."""
    dimension = MOTIONS[motion_of(dataset)].dimension
    size = dataset.sizes[dimension]
    return dataset.isel({dimension: np.linspace(0, size - 1, min(size, most)).astype(int)})


def _symmetry(dataset: xr.Dataset, names: Sequence[str]) -> str:
    """Return a sentence on numbers that vanish by symmetry; empty without them."""
    if not names:
        return ""
    texts = [
        f"{shown(dataset, name).symbol} (estimated error at most "
        f"{float(dataset[f'estimate_{name}'].max()):.2g} {BY_SYMMETRY[name]})"
        for name in names
    ]
    return f"0 by symmetry: {join_words(texts)}."


def _cells(contacts: xr.Dataset, name: str, factor: float) -> list[Cell]:
    """Return a number with its estimate, of each ICs."""
    cells = []
    for value, estimate in zip(contacts[name].values, contacts[f"estimate_{name}"].values, strict=True):
        known = 0.0 if estimate <= EXACT * abs(value) else float(estimate)
        text, _, error = with_estimate(factor * float(value), factor * known).partition(" ± ")
        cells.append(Cell(text, below=f"± {error}" if error else ""))
    return cells


def by_friction(
    dataset: xr.Dataset,
    name: str,
    cells: Callable[[xr.Dataset], Sequence[ChartCell]],
    columns: int = 3,
) -> Chart:
    """Return a chart of cells with a slider over friction, which begins where ICs differ most."""
    steps = {step(friction): cells(dataset.sel(friction=friction)) for friction in dataset.friction.values}
    start = step(worst_friction(dataset))
    return Chart(name, steps, columns, "friction", start=start)


def numbers_chart(dataset: xr.Dataset) -> Chart:
    """Return the chart of all numbers over the dimension of the motion."""
    names = [name for name in MOTIONS[motion_of(dataset)].quantities if not vanishes(dataset, name)]

    def panels(of_friction: xr.Dataset) -> list[Panel]:
        cells = []
        for name in names:
            number = shown(dataset, name)
            values = number.factor * of_friction[name]
            estimate = number.factor * of_friction[f"estimate_{name}"]
            draw = share_curves if name == "sliding_share" else curves_by_ics
            curves = draw(places(dataset), values, estimate)
            cells.append(Panel(number.meaning, abscissa(dataset).title, number.title, curves))
        return cells

    alt = f"all numbers of the contact over the {abscissa(dataset).symbol}"
    return replace(by_friction(dataset, "numbers", panels), heights=0.85, alt=alt)


def map_sections(dataset: xr.Dataset, contact: str, work: str) -> Iterator[Section | Folded]:
    """Yield the maps of a motion; `contact` says of which contact they are, `work` what the work is."""
    yield Section("Where the contact sticks", [contact, by_friction(dataset, "stick", maps.stick)])
    largest = f"Colours end at the largest value with any ICs. {contact}"
    yield Folded("Pressures", [largest, by_friction(dataset, "pressures", maps.pressures)])
    yield Folded("Work of friction", [f"{largest} {work}", by_friction(dataset, "work", maps.work)])


def support_tables(dataset: xr.Dataset) -> list[Table]:
    """Return the changes of a contact with C on other supports; empty without them."""
    if "supports" not in dataset.coords:
        return []
    motion = MOTIONS[motion_of(dataset)]
    friction, place = (float(dataset[PREFIX + dim]) for dim in ("friction", motion.dimension))
    with_c = dataset.sel({"ics": C, "friction": friction, motion.dimension: place})
    names = [name for name in motion.quantities if not vanishes(dataset, name)]
    rows = [Row(shown(dataset, name).title, _changes(dataset, with_c, name)) for name in names]
    caption = f"computed with C, friction {friction:g}, {place_text(dataset, place)}"
    heads = ["these supports", *(f"change with {name}" for name in dataset.supports.values)]
    return [Table(caption, heads, rows)]


def _changes(dataset: xr.Dataset, with_c: xr.Dataset, name: str) -> list[Cell | str]:
    """Return a number with its estimate, and its changes with other supports."""
    factor, value, estimate = shown(dataset, name).factor, with_c[name], with_c[f"estimate_{name}"]
    changed = [
        changed_cell(factor * other, factor * value, factor * estimate) for other in dataset[PREFIX + name]
    ]
    return [with_estimate(factor * value, factor * estimate), *(replace(cell, below="") for cell in changed)]


def cost(dataset: xr.Dataset) -> str:
    """Return sentences on the grid and on the seconds of contacts and of C."""
    by_ics = dataset.seconds.sum("friction")
    each = ", ".join(f"{symbol_of(name)} {float(by_ics.sel(ics=name)):.1f} s" for name in ics_of(dataset))
    dx, ds = (float(dataset[name][1] - dataset[name][0]) for name in ("x", "s"))
    grid = f"{dataset.sizes['x']} x {dataset.sizes['s']} elements of {dx:.3g} x {ds:.3g} mm"
    of_c = ""
    if "C_seconds" in dataset.attrs:
        of_c = (
            f" C on this grid took {dataset.attrs['C_seconds']:.0f} s; its largest estimated error is "
            f"{dataset.attrs['C_estimate']:.2%} of the largest C_nn. Before the mean of C(I, J) and "
            f"C(J, I)^T is taken both differ by up to {dataset.attrs['C_asymmetry']:.1%} of the largest "
            f"C_{dataset.attrs['C_asymmetry_component']}, and less of other components. "
            f"{dataset.attrs['discounted']}"
        )
    return f"Grid: {grid}. Contact: {each}.{of_c} All in all {dataset.attrs['seconds']:.0f} s."
