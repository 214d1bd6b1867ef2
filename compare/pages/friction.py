"""The pages of motions with friction: what they have in common, and what each motion adds."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from compare.pages.contact_figures import edge
from compare.pages.contact_numbers import (
    ALONE,
    deciding_text,
    tolerance,
    tolerance_levels,
    verdict_doubts,
    verdict_sentences,
)
from compare.report.charts import Cell as ChartCell
from compare.report.charts import Chart, Curve, Map, Panel
from compare.report.looks import drawing_order, ics_looks, ics_symbol, without_marker
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import (
    Cell,
    Row,
    Table,
    changed_cell,
    number_and_estimate,
    number_text,
    with_estimate,
)
from compare.report.verdicts import verdict, verdict_cell
from femic.contact.datasets import CHANGE, FLOOR, LARGER, MISSED, estimate_of_difference
from femic.contact.motions import MOTIONS
from femic.contact.motions.rolling import OF_CURVE, scaled_force
from femic.contact.pairs.ics import C
from femic.contact.pairs.quantities import ALL
from femic.results.contact import compared_ics, ics_names, reference_ics, reference_name
from femic.results.friction import PREFIX

# --- numbers as pages show them -------------------------------------------------------------------------


KILO = 1e4  # N: from this load on, forces are shown in kN
PERCENT = "sliding_share", "zero_creepage", "equal_creepage"
FORCES = "F_x", "F_y", "load"
BY_SYMMETRY = {"F_y": "N", "M_x": "N mm", "M_z": "N mm"}  # numbers that vanish in symmetric contacts
NOISE = 1e-6  # of the load, or of the load times the half-length of the patch, below which they do


@dataclass(frozen=True)
class QuantityLabel:
    """A number as a page shows it: its symbol, its unit, and the factor from the unit of the dataset."""

    symbol: str
    unit: str
    factor: float = 1.0
    meaning: str = ""

    @property
    def title(self) -> str:
        """The symbol and the unit, in brackets."""
        return f"{self.symbol} [{self.unit}]"


def motion_name(dataset: xr.Dataset) -> str:
    """Return the name of the motion along whose dimension the numbers are."""
    return next(name for name, motion in MOTIONS.items() if motion.dimension in dataset.dims)


def largest_load(dataset: xr.Dataset) -> float:
    """Return the load [N], or the largest one."""
    return float(dataset["load"].max()) if "load" in dataset.coords else float(dataset.attrs["load"])


def quantity_label(dataset: xr.Dataset, name: str) -> QuantityLabel:
    """Return how a number is shown: creepages and shares in percent, forces of large loads in kN."""
    quantity = (dict(ALL) | dict(OF_CURVE))[name]
    symbol, meaning = quantity.symbol, quantity.meaning
    force, factor = ("kN", 1e-3) if largest_load(dataset) >= KILO else ("N", 1.0)
    if name in PERCENT:
        return QuantityLabel(symbol, "%", 100.0, meaning)
    if name in FORCES:
        return QuantityLabel(symbol, force, factor, meaning)
    if name == "slope":
        return QuantityLabel(symbol, f"{force}/%", factor / 100, meaning)
    return QuantityLabel(symbol, quantity.unit, 1.0, meaning)


def abscissa(dataset: xr.Dataset) -> QuantityLabel:
    """Return how the places along the dimension of the motion are shown."""
    load = quantity_label(dataset, "load")
    return {
        "compression": QuantityLabel("load", load.unit, load.factor),
        "rolling": QuantityLabel("creepage", "%", 100.0),
        "transient": QuantityLabel("rolled distance", "mm"),
    }[motion_name(dataset)]


def places(dataset: xr.Dataset) -> xr.DataArray:
    """Return the places along the dimension of the motion in the unit shown."""
    return dataset[MOTIONS[motion_name(dataset)].dimension] * abscissa(dataset).factor


def place_text(dataset: xr.Dataset, place: float) -> str:
    """Return a place along the dimension of the motion with its unit."""
    across = abscissa(dataset)
    return f"{number_text(place * across.factor, '.4g')} {across.unit}"


def load_text(dataset: xr.Dataset) -> str:
    """Return the load, or the largest one, with its unit."""
    load = quantity_label(dataset, "load")
    return f"{largest_load(dataset) * load.factor:g} {load.unit}"


def friction_text(dataset: xr.Dataset) -> str:
    """Return the coefficients of friction."""
    return join_words(f"{friction:g}" for friction in dataset.friction.values)


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs that others are compared with."""
    return ics_symbol(reference_ics(dataset))


def vanishes(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a number is 0 by symmetry, to rounding."""
    if name not in BY_SYMMETRY:
        return False
    arm = float(dataset.a.max()) if BY_SYMMETRY[name] == "N mm" else 1.0
    return float(abs(dataset[name]).max()) < NOISE * largest_load(dataset) * arm


# --- the number that ICs are judged by ------------------------------------------------------------------


def main_number(dataset: xr.Dataset, prefix: str = "") -> xr.DataArray:
    """Return the number that ICs are judged by [%]: force over friction times load, or sliding share.

    With the prefix `estimate_` its estimated error.
    """
    if motion_name(dataset) == "compression":
        return 100 * dataset[f"{prefix}sliding_share"].drop_attrs()
    return 100 * scaled_force(dataset, f"{prefix}F_x")


def difference(dataset: xr.Dataset) -> xr.DataArray:
    """Return the main number minus the reference's [%]."""
    number = main_number(dataset)
    return number - number.sel(ics=reference_ics(dataset))


def difference_unit(dataset: xr.Dataset) -> str:
    """Return the unit of differences of the main number."""
    return "% of the contact area" if motion_name(dataset) == "compression" else "% of friction × load"


def difference_estimate(dataset: xr.Dataset) -> xr.DataArray:
    """Return the estimated error of this difference [%].

    In steady rolling it is the difference's own. Elsewhere, by the triangle inequality, it is the sum of
    those of both.
    """
    if motion_name(dataset) == "rolling":
        forces = dataset[[f"{prefix}F_x" for prefix in ("", LARGER, CHANGE, FLOOR, MISSED)]]
        return estimate_of_difference(forces, difference)
    known = main_number(dataset, "estimate_")
    return known + known.sel(ics=reference_ics(dataset))


def judged_differences(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the differences [%] that ICs are judged by, by friction and ICs, and their estimated errors.

    They are those at all places, or the largest ones of curves.
    """
    if "largest" in dataset:
        return 100 * dataset.largest.drop_attrs(), 100 * dataset.estimate_largest.drop_attrs()
    return difference(dataset), difference_estimate(dataset)


def verdicts(dataset: xr.Dataset) -> dict[str, str]:
    """Return whether the main number is within the tolerance everywhere, by ICs."""
    off, known = judged_differences(dataset)
    limit = tolerance(dataset)
    return {
        name: verdict(abs(off.sel(ics=name)), known.sel(ics=name), limit) for name in compared_ics(dataset)
    }


def verdict_cells(dataset: xr.Dataset) -> dict[str, Cell]:
    """Return these verdicts with the sizes of the differences that they follow from, by ICs."""
    (off, known), limit, cells = judged_differences(dataset), tolerance(dataset), dict[str, Cell]()
    frictions = [f"friction {friction:g}" for friction in dataset.friction.values]
    for name in compared_ics(dataset):
        each = abs(off.sel(ics=name)), known.sel(ics=name)
        text = deciding_text(*each, limit, signed=False, places={"friction": frictions})
        cells[name] = verdict_cell(*each, limit, text)
    return cells


def verdict_text(dataset: xr.Dataset, what: str, where: tuple[str, str]) -> str:
    """Return these verdicts in sentences: `what` differs by at most the tolerance at all places, or more."""
    cells = {ics_symbol(name): cell for name, cell in verdict_cells(dataset).items()}
    return verdict_sentences(
        {symbol: cell.text for symbol, cell in cells.items()},
        {symbol: cell.below for symbol, cell in cells.items()},
        f"{what} differs from {reference_symbol(dataset)}",
        f"{tolerance(dataset):g} {difference_unit(dataset)}",
        where,
    )


def worst_friction(dataset: xr.Dataset) -> float:
    """Return the coefficient of friction at which ICs differ most from the reference."""
    away = abs(difference(dataset)).max(["ics", MOTIONS[motion_name(dataset)].dimension])
    return float(dataset.friction[np.argmax(away.fillna(0.0).values)])


def percent_change(value: xr.DataArray, before: xr.DataArray) -> float:
    """Return the change of a number [%]."""
    return 100 * (float(value) / float(before) - 1) if np.isfinite(before) else np.nan


def signed_text(value: float | xr.DataArray, estimate: float | xr.DataArray) -> str:
    """Return a difference with its sign, and the digits that an estimate allows."""
    return number_and_estimate(value, estimate, signed=True)[0]


# --- charts ---------------------------------------------------------------------------------------------


def by_friction(
    dataset: xr.Dataset,
    name: str,
    cells: Callable[[xr.Dataset], Sequence[ChartCell]],
    columns: int = 3,
    heights: float = 1.0,
    alt: str = "",
) -> Chart:
    """Return a chart of cells with a slider over friction, which begins where ICs differ most."""
    labels = {friction: f"μ\u00a0=\u00a0{friction:g}" for friction in dataset.friction.values.tolist()}
    steps = {label: cells(dataset.sel(friction=friction)) for friction, label in labels.items()}
    return Chart(name, steps, columns, "friction", heights, labels[worst_friction(dataset)], alt=alt)


def curves_by_ics(
    at: ArrayLike, values: xr.DataArray, estimate: xr.DataArray | None = None, *, share: bool = False
) -> list[Curve]:
    """Return curves of values by ICs over an abscissa; the reference's has its estimate as a band.

    The band of a share [%] ends at 0 and 100.
    """
    names = [str(name) for name in values.ics.values]
    looks, reference = ics_looks(names), reference_name(names)
    if share and estimate is not None:
        sides = [estimate.where(estimate < most, most) for most in (values, 100 - values)]
        estimate = xr.concat(sides, "side").transpose("side", ...)
    return [
        Curve(
            ics_symbol(name),
            at.sel(ics=name) if isinstance(at, xr.DataArray) and "ics" in at.dims else at,
            values.sel(ics=name),
            looks[name],
            estimate.sel(ics=name) if estimate is not None and name == reference else None,
        )
        for name in drawing_order(names)
    ]


def difference_panel(dataset: xr.Dataset, contacts: xr.Dataset, title: str) -> Panel:
    """Return the differences of the main number of contacts at one friction, with bars of their estimates."""
    estimate, symbol = difference_estimate(contacts), reference_symbol(dataset)
    known = {ics_symbol(name): estimate.sel(ics=name) for name in compared_ics(dataset)}
    curves = [
        curve if curve.label == symbol else replace(curve, band=known[curve.label], bars=True)
        for curve in curves_by_ics(places(dataset), difference(contacts))
    ]
    up, levels = f"difference [{difference_unit(dataset)}]", tolerance_levels(dataset)
    return Panel(title, abscissa(dataset).title, up, curves, levels=levels)


def numbers_chart(dataset: xr.Dataset) -> Chart:
    """Return the chart of all numbers over the dimension of the motion."""
    names = [name for name in MOTIONS[motion_name(dataset)].quantities if not vanishes(dataset, name)]
    across = abscissa(dataset)

    def panels(contacts: xr.Dataset) -> Iterator[Panel]:
        for name in names:
            number = quantity_label(dataset, name)
            values, estimate = (number.factor * contacts[key] for key in (name, f"estimate_{name}"))
            curves = curves_by_ics(places(dataset), values, estimate, share=name == "sliding_share")
            yield Panel(number.meaning, across.title, number.title, curves)

    alt = f"all numbers of the contact against {across.symbol}"
    return by_friction(dataset, "numbers", lambda contacts: list(panels(contacts)), 3, 0.85, alt)


def outlines(contacts: xr.Dataset) -> Map:
    """Return pressures with the reference, and with each of the ICs lines about the part that sticks.

    Dotted lines go about the patch.
    """
    pressure, reference = contacts.p.sel(direction="n"), reference_ics(contacts)
    ranges = covered_ranges(pressure > 0)
    near, looks = contacts.isel(ranges), ics_looks(ics_names(contacts))
    p, curves = pressure.isel(ranges).transpose("ics", "x", "s"), list[Curve]()
    sticks = near.stick.astype(bool).transpose("ics", "x", "s") & (p > 0)
    for name in drawing_order(looks):
        for part, look in ((p > 0, replace(looks[name], dash="dot", width=1.0)), (sticks, looks[name])):
            line = edge(p.x.values, p.s.values, part.sel(ics=name).values)
            curves.append(Curve(ics_symbol(name), *line, without_marker(look)))
    with_reference = p.sel(ics=reference)
    return Map(
        f"pressure with {ics_symbol(reference)}, and where the contact sticks with each of the ICs",
        "x [mm]",
        "s [mm]",
        p.x.values,
        p.s.values,
        with_reference.where(with_reference > 0).values,
        "MPa",
        curves=curves,
        to_scale=True,
    )


def work_maps(contacts: xr.Dataset) -> list[Map]:
    """Return maps of the work of friction, one per ICs, in the same colours, as far as any contact goes."""
    pressure = contacts.p.sel(direction="n")
    drawn = contacts.work.where(pressure > 0).isel(covered_ranges(pressure > 0))
    return [
        Map(
            ics_symbol(ics),
            "x [mm]",
            "s [mm]",
            drawn.x.values,
            drawn.s.values,
            drawn.sel(ics=ics).transpose("x", "s").values,
            contacts.work.attrs["units"],
            limits=(0.0, float(drawn.max())),
            to_scale=True,
        )
        for ics in ics_names(contacts)
    ]


def covered_ranges(pressed: xr.DataArray) -> dict[str, slice]:
    """Return the ranges along x and s that contacts cover, with an element beside them."""
    ranges = {}
    for name, other in (("x", "s"), ("s", "x")):
        at = np.flatnonzero(pressed.any(["ics", other]))
        ranges[name] = slice(max(0, at[0] - 1), at[-1] + 2)
    return ranges


# --- the page of a motion -------------------------------------------------------------------------------


EXACT = 1e-5  # share of a number below which its estimate is none
MOST, FEW = 20, 5  # places in the tables of the main number, and of others
OUTLINES = "Lines: around the part that sticks. Dotted lines: around the contact patch."
COLOURS = "The colours of all maps end at the largest value with any of the ICs."
PLANES = (
    "femic applies the factor to each strip of elements. Programs for planar contact apply one friction "
    "coefficient to each plane, so their forces differ where the factor changes within a patch."
)
BELOW = (
    "The tables show some of the points; the charts and contact.nc have all of them. The small number "
    "below is the estimated error, found by solving again on elements twice and four times as large, in "
    "compression also with load steps twice as large, and for C with C changed by its estimated error."
)


@dataclass(frozen=True)
class PageParts:
    """What the page of a motion has of its own.

    `doubts` say what may be wrong, beside what all motions have; `note` explains the main chart, `contact`
    says of which contact the maps are, `work` what the work of friction on them is; `remarks` are sentences
    on the limits of the numbers. `steady` is before the names of numbers of steady rolling, which then have
    rows of their own.
    """

    summary: str
    answer: Table
    note: str
    contact: str
    work: str
    doubts: Sequence[str] = ()
    further: Sequence[Folded] = ()
    remarks: Sequence[str] = ()
    steady: str = ""


@dataclass(frozen=True)
class MotionPage:
    """The main chart and the other parts of the page of a motion, made from the dataset."""

    main_chart: Callable[[xr.Dataset], Chart]
    parts: Callable[[xr.Dataset], PageParts]

    def write(self, dataset: xr.Dataset, out: Path) -> Path:
        """Write `contact.nc`, figures and `contact.html` into a folder; return the path of the page."""
        own, across = self.parts(dataset), abscissa(dataset).symbol
        sticks = by_friction(
            dataset,
            "stick",
            lambda contacts: [outlines(contacts)],
            1,
            1.3,
            alt="pressures, and where the contact sticks",
        )
        work = by_friction(dataset, "work", work_maps, alt="work of friction with each of the ICs")
        numbers = [numbers_chart(dataset), BELOW, *number_tables(dataset, own.steady)]
        sections: list[Section | Folded] = [
            Section("", [self.main_chart(dataset), *chart_notes(dataset, own.note)]),
            Section("Where the contact sticks", [f"{own.contact} {OUTLINES}", sticks]),
            *own.further,
            Folded("Maps of the work of friction", [f"{own.contact} {own.work} {COLOURS}", work]),
            Folded(f"All numbers against {across}, with each of the ICs", numbers),
            Folded(
                "Limits, other supports, grid and cost",
                [*own.remarks, *support_tables(dataset), cost(dataset)],
            ),
            Folded("The scene file", [Verbatim(str(dataset.attrs["scene"]))]),
        ]
        said = [
            *verdict_doubts(verdicts(dataset).values(), reference_ics(dataset)),
            *missing(dataset),
            *own.doubts,
        ]
        page = Page(str(dataset.attrs["title"]), own.summary, sections, own.answer, said)
        return write_results(page, out, "contact", dataset)


def chart_notes(dataset: xr.Dataset, note: str) -> list[Note]:
    """Return the notes on the main chart: its own, why these ICs, how friction depends on the angle."""
    by_angle = dataset.attrs["friction_by_angle"]
    texts = [note, dataset.attrs.get("choice", ""), f"{by_angle} {PLANES}" if by_angle else ""]
    return [Note(text) for text in texts if text]


def missing(dataset: xr.Dataset) -> Iterator[str]:
    """Yield where there is nothing to compare with, and where no contact was found."""
    if not compared_ics(dataset):
        yield ALONE.format(reference_symbol(dataset))
    for name in ics_names(dataset):
        number = main_number(dataset).sel(ics=name)
        if unsolved := int(number.isnull().sum()):
            yield f"With {ics_symbol(name)}, no contact was found at {unsolved} of {number.size} points."


def number_tables(dataset: xr.Dataset, steady: str = "") -> list[Block]:
    """Return the tables of each number, one per friction: a row for each place listed, a column per ICs.

    Below them, which numbers vanish.
    """
    motion = MOTIONS[motion_name(dataset)]
    main = "sliding_share" if motion_name(dataset) == "compression" else "F_x"
    size = dataset.sizes[motion.dimension]
    symmetric = [name for name in BY_SYMMETRY if name in dataset and vanishes(dataset, name)]

    def row(title: str, contacts: xr.Dataset, name: str, factor: float) -> Row:
        cells = []
        for value, estimate in zip(contacts[name].values, contacts[f"estimate_{name}"].values, strict=True):
            known = 0.0 if estimate <= EXACT * abs(value) else float(estimate)
            text, error = number_and_estimate(factor * float(value), factor * known)
            cells.append(Cell(text, below=error))
        return Row(title, cells)

    blocks: list[Block] = []
    for name in (name for name in motion.quantities if name not in symmetric):
        number, tables = quantity_label(dataset, name), list[Table]()
        most = MOST if name == main else FEW
        for friction in dataset.friction.values:
            contacts = dataset.sel(friction=friction)
            listed = contacts.isel({motion.dimension: np.linspace(0, size - 1, min(size, most)).astype(int)})
            rows = [
                row(place_text(dataset, place), listed.sel({motion.dimension: place}), name, number.factor)
                for place in listed[motion.dimension].values
            ]
            if steady:
                rows.append(row("steady", contacts, steady + name, number.factor))
            caption = f"friction {friction:g}: {number.title}"
            tables.append(Table(caption, [ics_symbol(ics) for ics in ics_names(dataset)], rows))
        blocks.append(Folded(f"{number.title}: {number.meaning}", tables))
    zeros = join_words(
        f"{quantity_label(dataset, name).symbol} (estimated error at most "
        f"{float(dataset[f'estimate_{name}'].max()):.2g} {BY_SYMMETRY[name]})"
        for name in symmetric
    )
    return [*blocks, f"Zero by symmetry: {zeros or 'none'}."]


def support_tables(dataset: xr.Dataset) -> list[Table]:
    """Return the changes of a contact with C on other supports; empty without them."""
    if "supports" not in dataset.coords:
        return []
    motion = MOTIONS[motion_name(dataset)]
    friction, place = (float(dataset[PREFIX + dim]) for dim in ("friction", motion.dimension))
    with_c = dataset.sel({"ics": C, "friction": friction, motion.dimension: place})
    rows = []
    for name in (name for name in motion.quantities if not vanishes(dataset, name)):
        number = quantity_label(dataset, name)
        value, estimate = (number.factor * with_c[key] for key in (name, f"estimate_{name}"))
        changed = [changed_cell(number.factor * other, value, estimate) for other in dataset[PREFIX + name]]
        texts = [cell.text for cell in changed]
        rows.append(Row(number.title, [with_estimate(value, estimate), *texts]))
    caption = f"computed with C, friction {friction:g}, {place_text(dataset, place)}"
    heads = ["these supports", *(f"change with {name}" for name in dataset.supports.values)]
    return [Table(caption, heads, rows)]


def cost(dataset: xr.Dataset) -> str:
    """Return sentences on the grid and on the seconds of contacts and of C."""
    by_ics = dataset.seconds.sum("friction")
    each = ", ".join(f"{ics_symbol(name)} {float(by_ics.sel(ics=name)):.1f} s" for name in ics_names(dataset))
    dx, ds = (float(dataset[name][1] - dataset[name][0]) for name in ("x", "s"))
    grid = f"{dataset.sizes['x']} × {dataset.sizes['s']} elements of {dx:.3g} × {ds:.3g} mm"
    about_c = ""
    if "C_seconds" in dataset.attrs:
        about_c = (
            f" C on this grid took {dataset.attrs['C_seconds']:.0f} s. Its largest estimated error is "
            f"{dataset.attrs['C_estimate']:.2%} of the largest C_nn. Contact uses the mean of C(I, J) and "
            f"C(J, I)^T; the two differ by up to {dataset.attrs['C_asymmetry']:.1%} of the largest "
            f"C_{dataset.attrs['C_asymmetry_component']}, and by less for the other components. "
            f"{dataset.attrs['discounted']}"
        )
    return f"Grid: {grid}. Contact: {each}.{about_c} The whole run took {dataset.attrs['seconds']:.0f} s."
