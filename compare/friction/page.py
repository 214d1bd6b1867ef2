"""The common ground of the pages of motions with friction: file and page, supports, sentences on cost."""

from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path

import xarray as xr

from compare.contact.figures import reference_of
from compare.friction.supports import PREFIX
from compare.report.parts import Page, Part, final_sections, write_results
from compare.report.styles import symbol_of
from compare.report.tables import Table, changes_table
from femic.contact.motions import MOTIONS
from femic.contact.pairs.given_ics import C

BELOW = (
    "Small, below each number: its estimated error (from elements twice and four times as large; in "
    "compression also from steps of load twice as large; of C also from C plus its own estimate)."
)


def write_contact_page(
    dataset: xr.Dataset, out: Path, summary: str, parts: Iterable[Part], tables: Sequence[Table]
) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page."""
    end = final_sections(
        [*support_tables(dataset), *tables], BELOW, cost(dataset), str(dataset.attrs["scene"])
    )
    page = Page(str(dataset.attrs["title"]), summary, chain(parts, end))
    return write_results(page, out, "contact", dataset)


def support_tables(dataset: xr.Dataset) -> list[Table]:
    """Return the changes of a contact with C on other supports; empty without them."""
    if "supports" not in dataset.coords:
        return []
    motion = next(one for one in MOTIONS.values() if PREFIX + one.dimension in dataset)
    friction, place = (float(dataset[PREFIX + dim]) for dim in ("friction", motion.dimension))
    with_c = dataset.sel({"ics": C, "friction": friction, motion.dimension: place})
    caption = f"changes with other supports, computed with C, friction {friction:g}, {motion.place(place)}"
    return [changes_table(caption, motion.quantities, with_c, dataset, PREFIX)]


def names(dataset: xr.Dataset) -> list[str]:
    """The names of the ICs."""
    return [str(name) for name in dataset.ics.values]


def others(dataset: xr.Dataset) -> list[str]:
    """The names of the ICs that are compared with the reference."""
    return [name for name in names(dataset) if name != reference_of(dataset)]


def band_of(dataset: xr.Dataset) -> str:
    """The label of the band of the reference's estimate."""
    return f"estimate of {symbol_of(reference_of(dataset))}"


def cost(dataset: xr.Dataset) -> str:
    """Sentences on the grid and on the seconds of contacts and of C."""
    by_ics = dataset.seconds.sum("friction")
    each = ", ".join(f"{symbol_of(name)} {float(by_ics.sel(ics=name)):.1f} s" for name in names(dataset))
    grid = (
        f"{dataset.sizes['x']} x {dataset.sizes['s']} elements of {_step(dataset, 'x'):.3g} x "
        f"{_step(dataset, 's'):.3g} mm"
    )
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


def _step(dataset: xr.Dataset, name: str) -> float:
    return float(dataset[name][1] - dataset[name][0])
