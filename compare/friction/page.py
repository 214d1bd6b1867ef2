"""The pages of motions with friction: what they have in common, and what each motion adds."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from compare.contact.dataset import ics_of, reference_of
from compare.friction import maps
from compare.friction.supports import PREFIX
from compare.report.parts import Page, Part, final_sections, write_results
from compare.report.styles import symbol_of
from compare.report.tables import Cell, Row, Table, cell, changes_table, columns_of
from femic.contact.motions import MOTIONS
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.quantities import Quantity

BELOW = (
    "Small, below each number: its estimated error (from elements twice and four times as large; in "
    "compression also from steps of load twice as large; of C also from C plus its own estimate)."
)


@dataclass(frozen=True)
class MotionPage:
    """What the page of a motion has of its own, each made from the labelled arrays."""

    summary: Callable[[xr.Dataset], str]
    parts: Callable[[xr.Dataset], Iterator[Part]]
    tables: Callable[[xr.Dataset], Sequence[Table]]
    main_figure: Callable[[xr.Dataset], Figure]

    def write(self, dataset: xr.Dataset, out: Path) -> Path:
        """Write `contact.nc`, figures and `contact.html` into a folder; return the path of the page."""
        tables = [*support_tables(dataset), *self.tables(dataset)]
        end = final_sections(tables, BELOW, cost(dataset), str(dataset.attrs["scene"]))
        page = Page(str(dataset.attrs["title"]), self.summary(dataset), chain(self.parts(dataset), end))
        return write_results(page, out, "contact", dataset)


def motion_of(dataset: xr.Dataset) -> str:
    """Return the name of the motion along whose dimension the numbers are."""
    return next(name for name, motion in MOTIONS.items() if motion.dimension in dataset.dims)


def map_parts(dataset: xr.Dataset, contact: str, work: str) -> Iterator[Part]:
    """Yield the maps of a motion; `contact` says of which contact they are, `work` what the work is."""
    yield Part("Where the contact sticks", contact, "stick", maps.stick_maps(dataset))
    yield Part("Work of friction", f"{contact} {work}", "work", maps.work_maps(dataset))


def tables_by_friction(
    dataset: xr.Dataset, rows: Callable[[xr.Dataset], Iterable[Row]] | None = None
) -> list[Table]:
    """Return a table of the motion's numbers per friction, with all rows or some."""
    columns = columns_of(MOTIONS[motion_of(dataset)].quantities.values())
    return [
        Table(f"friction {friction:g}", columns, list((rows or number_rows)(dataset.sel(friction=friction))))
        for friction in dataset.friction.values
    ]


def number_rows(dataset: xr.Dataset) -> Iterator[Row]:
    """Yield the numbers at one friction, a row for each place along the motion's dimension and each ICs."""
    motion = MOTIONS[motion_of(dataset)]
    for place in dataset[motion.dimension].values:
        for name in ics_of(dataset):
            contact = dataset.sel({"ics": name, motion.dimension: place})
            yield Row(f"{symbol_of(name)}, {motion.place(place)}", number_cells(contact, motion.quantities))


def number_cells(contact: xr.Dataset, quantities: Mapping[str, Quantity], prefix: str = "") -> list[Cell]:
    """Return the numbers of a contact with their estimates."""
    return [cell(contact[prefix + name], contact[f"estimate_{prefix}{name}"]) for name in quantities]


def support_tables(dataset: xr.Dataset) -> list[Table]:
    """Return the changes of a contact with C on other supports; empty without them."""
    if "supports" not in dataset.coords:
        return []
    motion = MOTIONS[motion_of(dataset)]
    friction, place = (float(dataset[PREFIX + dim]) for dim in ("friction", motion.dimension))
    with_c = dataset.sel({"ics": C, "friction": friction, motion.dimension: place})
    caption = f"changes with other supports, computed with C, friction {friction:g}, {motion.place(place)}"
    return [changes_table(caption, motion.quantities, with_c, dataset, PREFIX)]


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs that others are compared with."""
    return symbol_of(reference_of(dataset))


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
