"""The page of a campaign: figures over the swept keys, sentences and tables of where ICs fail."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.parts import Page, Table
from compare.reports.sweep.advised import advice_of
from compare.reports.sweep.axes import axes_of, is_grid, ordered, swept
from compare.reports.sweep.fields import Field, fields_of
from compare.reports.sweep.figures import parts
from compare.reports.sweep.summary import summary
from compare.reports.sweep.tables import (
    along,
    correlation_table,
    crossing_tables,
    failure_table,
    share_table,
    slowest,
    worst_table,
)
from compare.results import folders


def write_sweep(dataset: xr.Dataset, out: Path) -> Path:
    """Write `sweep.html` and figures of a campaign's dataset into a folder; returns the path of the page."""
    folders.made(out)
    for old in (out / "figures").glob("sweep_*.png"):
        old.unlink()
    dataset = ordered(dataset)
    fields, advice = fields_of(dataset), advice_of(dataset)
    page = Page(
        str(dataset.attrs["title"]),
        summary(dataset, fields, advice),
        parts(dataset, fields, advice),
        list(tables(dataset, fields)),
        below(dataset, fields),
        cost(dataset),
        str(dataset.attrs["campaign"]),
        "The campaign",
    )
    return page.write(out / "sweep.html", "sweep")


def tables(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Table]:
    """Yield all tables: where numbers exceed levels, largest numbers, failed scenes."""
    axes = swept(axes_of(dataset))
    for field in fields:
        if axes and field.kind != "value" and is_grid(dataset):
            yield from crossing_tables(field, axes_of(dataset))
        elif axes and not is_grid(dataset):
            if field.kind != "value":
                yield share_table(field)
            yield correlation_table(field, axes)
        yield worst_table(field, dataset)
    failures = failure_table(dataset)
    if failures is not None:
        yield failures


def below(dataset: xr.Dataset, fields: Sequence[Field]) -> str:
    """What is to be known of the tables."""
    axes = swept(axes_of(dataset))
    if not fields:
        return "Nothing is computed yet."
    if not axes:
        return "One scene."
    if not is_grid(dataset):
        return "Rank correlations by Spearman: +1 where the one always grows with the other, 0 without order."
    axis = along(axes)
    if not axis.is_number:
        return "Small: at which scene."
    return (
        f"Places along {axis.name} are interpolated linearly between scenes. Small: where a level"
        " is exceeded again, how many scenes are known; of largest numbers, at which scene."
    )


def cost(dataset: xr.Dataset) -> str:
    """What the scenes took."""
    seconds = dataset["seconds"].values
    seconds = seconds[np.isfinite(seconds)]
    if not seconds.size:
        return ""
    total = f"{np.sum(seconds):.3g} s together, without models that other scenes have solved"
    if seconds.size == 1:
        return f"The scene took {total.replace(' together', '')}."
    return (
        f"Scenes took {np.min(seconds):.2g} ... {np.max(seconds):.2g} s, {total}; the slowest: "
        f"{'; '.join(slowest(dataset))}."
    )
