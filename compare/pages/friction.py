"""The pages of motions with friction: what they have in common, and what each motion adds."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from compare.report.charts import Cell as ChartCell
from compare.report.charts import Chart, Curve, Map, Panel
from compare.report.looks import drawing_order, looks_of, symbol_of
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import MINUS, Cell, Row, Table, changed_cell, with_estimate
from femic.contact.motions import MOTIONS
from femic.contact.motions.rolling import OF_CURVE, scaled_force
from femic.contact.pairs.ics import C
from femic.contact.pairs.quantities import ALL
from femic.results.contact import ics_of, reference_name, reference_of
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


def motion_of(dataset: xr.Dataset) -> str:
    """Return the name of the motion along whose dimension the numbers are."""
    return next(name for name, motion in MOTIONS.items() if motion.dimension in dataset.dims)


def load_of(dataset: xr.Dataset) -> float:
    """Return the load [N], or the largest one."""
    return float(dataset["load"].max()) if "load" in dataset.coords else float(dataset.attrs["load"])


def quantity_label(dataset: xr.Dataset, name: str) -> QuantityLabel:
    """Return how a number is shown: creepages and shares in percent, forces of large loads in kN."""
    quantity = (dict(ALL) | dict(OF_CURVE))[name]
    symbol, meaning = quantity.symbol, quantity.meaning
    force, factor = ("kN", 1e-3) if load_of(dataset) >= KILO else ("N", 1.0)
    if name in PERCENT:
        return QuantityLabel(symbol, "%", 100.0, meaning)
    if name in FORCES:
        return QuantityLabel(symbol, force, factor, meaning)
    if name == "slope":
        return QuantityLabel(symbol, f"{force}/%", factor / 100, meaning)
    return QuantityLabel(symbol, quantity.unit, 1.0, meaning)


def abscissa(dataset: xr.Dataset) -> QuantityLabel:
    """Return how the places along the dimension of the motion are shown."""
    if motion_of(dataset) == "compression":
        load = quantity_label(dataset, "load")
        return QuantityLabel("load", load.unit, load.factor)
    return {
        "rolling": QuantityLabel("creepage", "%", 100.0),
        "transient": QuantityLabel("rolled distance", "mm"),
    }[motion_of(dataset)]


def places(dataset: xr.Dataset) -> xr.DataArray:
    """Return the places along the dimension of the motion in the unit shown."""
    return dataset[MOTIONS[motion_of(dataset)].dimension] * abscissa(dataset).factor


def place_text(dataset: xr.Dataset, place: float) -> str:
    """Return a place along the dimension of the motion with its unit."""
    across = abscissa(dataset)
    return f"{place * across.factor:.4g}{'' if across.unit == '%' else ' '}{across.unit}"


def step(friction: float) -> str:
    """Return the step of a slider for a coefficient of friction."""
    return f"μ\u00a0=\u00a0{friction:g}"


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs that others are compared with."""
    return symbol_of(reference_of(dataset))


def vanishes(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a number is 0 by symmetry, to rounding."""
    if name not in BY_SYMMETRY:
        return False
    arm = float(dataset.a.max()) if BY_SYMMETRY[name] == "N mm" else 1.0
    return float(abs(dataset[name]).max()) < NOISE * load_of(dataset) * arm


def main_name(dataset: xr.Dataset) -> str:
    """Return the name of the number that ICs are judged by."""
    return "sliding_share" if motion_of(dataset) == "compression" else "F_x"


def main_number(dataset: xr.Dataset) -> xr.DataArray:
    """Return the number that ICs are judged by [%]: force over friction times load, or sliding share."""
    return _main(dataset, "")


def main_estimate(dataset: xr.Dataset) -> xr.DataArray:
    """Return the estimated error of the main number [%]."""
    return _main(dataset, "estimate_")


def _main(dataset: xr.Dataset, prefix: str) -> xr.DataArray:
    if motion_of(dataset) == "compression":
        return 100 * dataset[f"{prefix}sliding_share"].drop_attrs()
    return 100 * scaled_force(dataset, f"{prefix}F_x")


def difference(dataset: xr.Dataset) -> xr.DataArray:
    """Return the main number minus the reference's [%]."""
    number = main_number(dataset)
    return number - number.sel(ics=reference_of(dataset))


def largest_differences(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the largest difference of each ICs at any friction and place [%], and its estimate there.

    By the triangle inequality, the estimate of a difference is the sum of those of both.
    """
    known = main_estimate(dataset)
    both = known + known.sel(ics=reference_of(dataset))
    at = abs(difference(dataset)).fillna(0.0).argmax(["friction", MOTIONS[motion_of(dataset)].dimension])
    return abs(difference(dataset)).isel(at), both.isel(at)


def worst_friction(dataset: xr.Dataset) -> float:
    """Return the coefficient of friction at which ICs differ most from the reference."""
    away = abs(difference(dataset)).max(["ics", MOTIONS[motion_of(dataset)].dimension])
    return float(dataset.friction[np.argmax(away.fillna(0.0).values)])


def curves_by_ics(at: ArrayLike, values: xr.DataArray, estimate: xr.DataArray | None = None) -> list[Curve]:
    """Return curves of values by ICs over an abscissa; the reference's has its estimate as a band."""
    names = [str(name) for name in values.ics.values]
    looks, reference = looks_of(names), reference_name(names)
    return [
        Curve(
            symbol_of(name),
            at.sel(ics=name) if isinstance(at, xr.DataArray) and "ics" in at.dims else at,
            values.sel(ics=name),
            looks[name],
            estimate.sel(ics=name) if estimate is not None and name == reference else None,
        )
        for name in drawing_order(names)
    ]


def share_curves(at: ArrayLike, share: xr.DataArray, estimate: xr.DataArray) -> list[Curve]:
    """Return curves of shares [%] by ICs; the band of the reference's ends at 0 and 100."""
    below, above = (estimate.where(estimate < most, most) for most in (share, 100 - share))
    return curves_by_ics(at, share, xr.concat([below, above], "side").transpose("side", ...))


def difference_unit(dataset: xr.Dataset) -> str:
    """Return the unit of differences of the main number."""
    return "% of contact area" if motion_of(dataset) == "compression" else "% of friction load"


def percent_change(value: xr.DataArray, before: xr.DataArray) -> float:
    """Return the change of a number [%]."""
    return 100 * (float(value) / float(before) - 1) if np.isfinite(before) else np.nan


def signed_text(value: float | xr.DataArray, estimate: float | xr.DataArray) -> str:
    """Return a difference with its sign, and the digits that an estimate allows."""
    text = with_estimate(value, estimate).split(" ± ")[0]
    return text if text.startswith((MINUS, "–")) or text == "0" else f"+{text}"


def load_text(dataset: xr.Dataset) -> str:
    """Return the load, or the largest one, with its unit."""
    load = quantity_label(dataset, "load")
    return f"{load_of(dataset) * load.factor:g} {load.unit}"


# --- maps of the contact area ---------------------------------------------------------------------------


KINDS = "sticks", "slides"


def pressure_maps(contacts: xr.Dataset) -> list[Map]:
    """Return the pressures [MPa], a map per ICs, with the same colours."""
    return _maps(contacts, contacts.p.sel(direction="n"), contacts.p.attrs["units"])


def work_maps(contacts: xr.Dataset) -> list[Map]:
    """Return the work of friction per area, a map per ICs, with the same colours."""
    return _maps(contacts, contacts.work, contacts.work.attrs["units"])


def stick_maps(contacts: xr.Dataset) -> list[Map]:
    """Return where the contact sticks and where it slides, a map per ICs."""
    return _maps(contacts, 1.0 - contacts.stick, "", KINDS)


def _maps(contacts: xr.Dataset, values: xr.DataArray, unit: str, classes: tuple[str, ...] = ()) -> list[Map]:
    """Return values in the contact area with each ICs, as far as any contact goes."""
    pressed = contacts.p.sel(direction="n") > 0
    area = covered_ranges(pressed)
    drawn = values.where(pressed).isel(area)
    limits = (0.0, float(drawn.max()))
    return [
        Map(
            symbol_of(name),
            "x [mm]",
            "s [mm]",
            drawn.x.values,
            drawn.s.values,
            drawn.sel(ics=name).transpose("x", "s").values,
            unit,
            limits=limits,
            classes=classes,
            to_scale=True,
        )
        for name in ics_of(contacts)
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
            number = quantity_label(dataset, name)
            blocks.append(Folded(f"{number.title}: {number.meaning}", tables))
        return [*blocks, _symmetry(dataset, symmetric)]

    def _number_table(self, dataset: xr.Dataset, name: str, friction: float) -> Table:
        """Return a number at one friction: a row for each place listed, a column per ICs."""
        of_friction, number = dataset.sel(friction=friction), quantity_label(dataset, name)
        dimension = MOTIONS[motion_of(dataset)].dimension
        listed = _list_places(of_friction, MOST if name == main_name(dataset) else FEW)
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


def _list_places(dataset: xr.Dataset, most: int) -> xr.Dataset:
    """Return the numbers at some places, from the first to the last."""
    dimension = MOTIONS[motion_of(dataset)].dimension
    size = dataset.sizes[dimension]
    return dataset.isel({dimension: np.linspace(0, size - 1, min(size, most)).astype(int)})


def _symmetry(dataset: xr.Dataset, names: Sequence[str]) -> str:
    """Return a sentence on numbers that vanish by symmetry; empty without them."""
    if not names:
        return ""
    texts = [
        f"{quantity_label(dataset, name).symbol} (estimated error at most "
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
            number = quantity_label(dataset, name)
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
    yield Section("Where the contact sticks", [contact, by_friction(dataset, "stick", stick_maps)])
    largest = f"Colours end at the largest value with any ICs. {contact}"
    yield Folded("Pressures", [largest, by_friction(dataset, "pressures", pressure_maps)])
    yield Folded("Work of friction", [f"{largest} {work}", by_friction(dataset, "work", work_maps)])


def support_tables(dataset: xr.Dataset) -> list[Table]:
    """Return the changes of a contact with C on other supports; empty without them."""
    if "supports" not in dataset.coords:
        return []
    motion = MOTIONS[motion_of(dataset)]
    friction, place = (float(dataset[PREFIX + dim]) for dim in ("friction", motion.dimension))
    with_c = dataset.sel({"ics": C, "friction": friction, motion.dimension: place})
    names = [name for name in motion.quantities if not vanishes(dataset, name)]
    rows = [Row(quantity_label(dataset, name).title, _changes(dataset, with_c, name)) for name in names]
    caption = f"computed with C, friction {friction:g}, {place_text(dataset, place)}"
    heads = ["these supports", *(f"change with {name}" for name in dataset.supports.values)]
    return [Table(caption, heads, rows)]


def _changes(dataset: xr.Dataset, with_c: xr.Dataset, name: str) -> list[Cell | str]:
    """Return a number with its estimate, and its changes with other supports."""
    factor, value, estimate = quantity_label(dataset, name).factor, with_c[name], with_c[f"estimate_{name}"]
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
