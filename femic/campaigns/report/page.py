"""The page of a campaign: sentences, figures over the swept keys, and tables of where ICs fail."""

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.parts import Page, final_sections, write_results
from compare.report.tables import Table
from femic.cache import folders
from femic.campaigns.report.advised import advice_of
from femic.campaigns.report.axes import axes_of, is_grid, prepared, swept
from femic.campaigns.report.contents import fields_of
from femic.campaigns.report.crossings import main_axis
from femic.campaigns.report.fields import Field
from femic.campaigns.report.figures import parts
from femic.campaigns.report.summary import summary
from femic.campaigns.report.tables import (
    correlation_table,
    crossing_table,
    failure_table,
    share_table,
    slowest,
    worst_table,
    write_crossings,
)

CROSSINGS = "sweep_crossings.csv"


def write_sweep(dataset: xr.Dataset, out: Path) -> Path:
    """Write `sweep.html` of a campaign's dataset into a folder, with figures and a table of crossings.

    Returns the path of the page.
    """
    folders.make(out)
    for old in [*(out / "figures").glob("sweep_*.png"), *out.glob(CROSSINGS)]:
        old.unlink()
    dataset = prepared(dataset)
    fields, advice = fields_of(dataset), advice_of(dataset)
    if _has_crossings(dataset, fields):
        write_crossings([field for field in fields if field.rates_ics], axes_of(dataset), out / CROSSINGS)
    end = final_sections(
        list(tables(dataset, fields)),
        below(dataset, fields),
        cost(dataset),
        str(dataset.attrs["campaign"]),
        "The campaign",
    )
    title, sentences = str(dataset.attrs["title"]), summary(dataset, fields, advice)
    page = Page(title, sentences, chain(parts(dataset, fields, advice), end))
    return write_results(page, out, "sweep")


def tables(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Table]:
    """Yield all tables: where numbers exceed levels, largest numbers, failed scenes."""
    axes = axes_of(dataset)
    for field in fields:
        if swept(axes) and field.rates_ics:
            yield crossing_table(field, axes) if is_grid(dataset) else share_table(field)
        if swept(axes) and not is_grid(dataset):
            yield correlation_table(field, axes)
        yield worst_table(field, dataset)
    failures = failure_table(dataset)
    if failures is not None:
        yield failures


def below(dataset: xr.Dataset, fields: Sequence[Field]) -> str:
    """Return notes on the tables."""
    axes = swept(axes_of(dataset))
    if not fields:
        return "Nothing is computed yet."
    if not axes:
        return "One scene."
    if not is_grid(dataset):
        return "Rank correlations (Spearman) of sizes: +1 where both always grow together, 0 without order."
    if not _has_crossings(dataset, fields):
        return "Small: at which scene."
    texts = [f"Places along {main_axis(axes).name} are interpolated linearly between scenes. Small: "]
    if len(axes) > 1:
        texts += ["where a level is exceeded most, then where least; "]
    texts += [f"of largest numbers, at which scene. All places: `{CROSSINGS}`."]
    return "".join(texts)


def _has_crossings(dataset: xr.Dataset, fields: Sequence[Field]) -> bool:
    """Whether levels are exceeded along an axis of numbers."""
    axes = swept(axes_of(dataset))
    rated = any(field.rates_ics for field in fields)
    return rated and bool(axes) and is_grid(dataset) and main_axis(axes).is_number


def cost(dataset: xr.Dataset) -> str:
    """Return a sentence on the seconds of the scenes."""
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
