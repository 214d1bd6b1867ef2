"""The page of a campaign: sentences, figures over the swept keys, and tables of where ICs fail."""

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.parts import Folded, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Table
from femic.cache import folders
from femic.campaigns.report.advised import advice_of
from femic.campaigns.report.answer import answer_note, answer_table
from femic.campaigns.report.axes import axes_of, is_grid, prepared, swept
from femic.campaigns.report.contents import fields_of
from femic.campaigns.report.crossings import main_axis
from femic.campaigns.report.fields import Field
from femic.campaigns.report.figures import sections
from femic.campaigns.report.summary import files, summary
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
    for old in [*(out / "figures").glob("sweep_*"), *out.glob(CROSSINGS)]:
        old.unlink()
    dataset = prepared(dataset)
    fields = fields_of(dataset)
    if _has_crossings(dataset, fields):
        write_crossings([field for field in fields if field.rates_ics], axes_of(dataset), out / CROSSINGS)
    return write_results(page_of(dataset, fields), out, "sweep")


def page_of(dataset: xr.Dataset, fields: Sequence[Field]) -> Page:
    """Return the page of a prepared dataset and its fields."""
    advice = advice_of(dataset)
    ratings = [field for field in fields if field.rates_ics]
    answer = answer_table(ratings[0], dataset) if ratings else None
    note = [Section("", [Note(answer_note(ratings[0], dataset))])] if ratings else []
    charts = sections(dataset, fields, advice)
    title, text = str(dataset.attrs["title"]), summary(dataset, fields, advice)
    return Page(title, text, chain(note, charts, _folded(dataset, fields)), answer)


def _folded(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Folded | Section]:
    """Yield tables, failures, cost and the campaign, shown on request."""
    if not fields:
        yield Section("", ["Nothing is computed yet."])
    elif all_tables := list(tables(dataset, fields)):
        yield Folded("Where numbers are large, and the largest", [Note(below(dataset, fields)), *all_tables])
    if failures := failure_table(dataset):
        yield Folded(f"Failed scenes ({dataset.attrs['failed']})", [failures])
    if texts := list(filter(None, [cost(dataset), files(dataset)])):
        yield Folded("Cost, and the file", texts)
    yield Folded("The campaign", [Verbatim(str(dataset.attrs["campaign"]))])


def tables(dataset: xr.Dataset, fields: Sequence[Field]) -> Iterator[Table]:
    """Yield all tables of numbers: where they exceed levels, correlations, largest numbers."""
    axes = swept(axes_of(dataset))
    for field in fields:
        if axes and field.rates_ics:
            yield crossing_table(field, axes) if is_grid(dataset) else share_table(field)
        if axes and not is_grid(dataset):
            yield correlation_table(field, axes)
        yield worst_table(field, dataset)


def below(dataset: xr.Dataset, fields: Sequence[Field]) -> str:
    """Return a note on the tables; empty where these need none."""
    axes = swept(axes_of(dataset))
    if axes and not is_grid(dataset):
        return "Rank correlations (Spearman) of sizes: +1 where both always grow together, 0 without order."
    if not _has_crossings(dataset, fields):
        return ""
    small = " Small: where a level is exceeded most, then where least." if len(axes) > 1 else ""
    name = main_axis(axes).name
    return f"Places along {name} are interpolated linearly between scenes.{small} All places: `{CROSSINGS}`."


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
