"""What the pages of rolling and of compression share: file and page, sentences on cost, curves by ICs."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes

from compare.contact.compute import C
from compare.contact.figures import reference_of
from compare.friction.quantities import Quantity
from compare.friction.supports import PREFIX, of_motion
from compare.report.parts import Page, Part, Row, Table, changed_cell
from compare.report.styles import symbol_of, with_further
from femic.cache import folders
from femic.cache.files import write_dataset

BELOW = (
    "Small, below each number: its estimated error (from elements twice and four times as large; in "
    "compression also from steps of load twice as large; of C also from C plus its own estimate)."
)


def write_contact_page(
    dataset: xr.Dataset, out: Path, summary: str, parts: Iterable[Part], tables: Sequence[Table]
) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page."""
    folders.make(out)
    write_dataset(dataset, out / "contact.nc")
    title, scene = str(dataset.attrs["title"]), str(dataset.attrs["scene"])
    page = Page(title, summary, parts, tables, BELOW, cost(dataset), scene)
    return page.write(out / "contact.html", "contact")


def of_supports(dataset: xr.Dataset) -> list[Table]:
    """What other supports change of a contact by C, a row per change; empty where it is not known."""
    if "supports" not in dataset.coords:
        return []
    given = {
        dim: float(dataset[PREFIX + dim]) for dim in ("friction", "xi", "load") if PREFIX + dim in dataset
    }
    by_c, quantities = (
        dataset.sel({"ics": C, **given}),
        of_motion("rolling" if "xi" in given else "compression"),
    )
    at = f"{100 * given['xi']:.3g} %" if "xi" in given else f"{given['load']:g} N"
    rows = [
        Row(
            str(name),
            [
                changed_cell(dataset[PREFIX + key].sel(supports=name), by_c[key], by_c[f"estimate_{key}"])
                for key in quantities
            ],
        )
        for name in dataset.supports.values
    ]
    caption = f"what other supports change: by C, friction {given['friction']:g}, {at}"
    return [Table(caption, columns(quantities), rows)]


def columns(quantities: Mapping[str, Quantity]) -> list[str]:
    """The heads of the columns of quantities."""
    return [f"{one.symbol} [{'-' if one.unit == '1' else one.unit}]" for one in quantities.values()]


def names(dataset: xr.Dataset) -> list[str]:
    """The names of the ICs."""
    return [str(name) for name in dataset.ics.values]


def band_of(dataset: xr.Dataset) -> str:
    """The label of a band: what it is the estimate of."""
    return f"estimate of {symbol_of(reference_of(dataset))}"


def cost(dataset: xr.Dataset) -> str:
    """What the numbers took."""
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


def curves(axes: Axes, at: xr.DataArray, values: xr.DataArray, *, markers: bool = True) -> None:
    """Draw values over an abscissa by all ICs; an abscissa may differ by ICs."""
    shown = names(values.to_dataset(name="values"))
    looks = with_further(shown)
    for name in shown:
        marker, look = looks[name]
        style = dict(look) | ({"marker": marker, "markersize": 3} if markers else {})
        abscissa = at.sel(ics=name) if "ics" in at.dims else at
        axes.plot(abscissa, values.sel(ics=name), label=symbol_of(name), **style)
