"""Sentences of the page of a campaign, computed from its numbers."""

import json
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import join_words
from femic.campaigns.report.advised import AdvisedICs
from femic.campaigns.report.axes import ShownAxis, axes_of, is_grid, swept, text_of
from femic.campaigns.report.crossings import REPORTED, extreme_crossings, known_count, lines_of, main_axis
from femic.campaigns.report.fields import COLUMN, ROW, Field, plain
from femic.campaigns.report.scales import share

FIRST = ("nn", "p_max")  # columns that are reported even if another one is worse
MOST_CATEGORIES = 4
MEANINGS = {
    "ics": "the ICs themselves (`ic`, `estimate`, with their points `x`, `s`, `on_line`)",
    "matrix": "the IC matrices (`c`, `c_estimate`)",
}


def summary(dataset: xr.Dataset, fields: Sequence[Field], advice: AdvisedICs | None) -> str:
    """Return sentences computed from the numbers: scenes, errors with their places, advice."""
    sentences = [_counted(dataset)]
    ratings = [field for field in fields if field.rates_ics]
    sentences += [sentence for field in ratings[:1] for sentence in judgement(dataset, field)]
    sentences += list(_interpolated(dataset, sentences))
    if advice is not None:
        counts = join_words(f"{name} in {count}" for name, count in advice.counts().items())
        sentences.append(f"The cheapest ICs that are good enough (scenes): {counts}.")
    also_in_file = [MEANINGS[name] for name in json.loads(dataset.attrs["keep"]) if name in MEANINGS]
    if also_in_file:
        sentences.append(f"The file of the campaign has {join_words(also_in_file)}, too.")
    return "\n".join(sentences)


def _interpolated(dataset: xr.Dataset, sentences: Sequence[str]) -> Iterator[str]:
    """Yield a sentence on interpolation, if any of the others has an interpolated place."""
    axes = swept(axes_of(dataset))
    if not (axes and is_grid(dataset) and main_axis(axes).is_number):
        return
    name = main_axis(axes).name
    if any(f"{word} {name} = " in sentence for word in ("from", "up to") for sentence in sentences):
        yield f"These values of {name} are interpolated linearly between scenes."


def judgement(dataset: xr.Dataset, field: Field) -> Iterator[str]:
    """Yield sentences on errors or deviations: their estimates, and where each row is too large."""
    if field.floor is not None and np.any(np.isfinite(field.floor)):
        largest = field.floor.max([dim for dim in field.floor.dims if dim != COLUMN])
        if field.kind == "error":
            yield f"{field.reference} is known to {share(float(largest.max()))} or better."
        else:
            by_column = {plain(name): float(largest.sel({COLUMN: name})) for name in field.columns}
            known = [f"{share(size)} ({name})" for name, size in by_column.items() if np.isfinite(size)]
            yield f"The numbers with {field.reference} are known, at the worst scene, to {join_words(known)}."
    verdicts: dict[str, list[str]] = {}
    for row in field.rows:
        if np.any(field.values.sel({ROW: row}).notnull()):
            verdicts.setdefault(_failing(dataset, field.of(rows=[row])), []).append(symbol_of(row))
    for text, rows in verdicts.items():
        yield f"{join_words(rows)} {'is' if len(rows) == 1 else 'are'} {text}"


def _counted(dataset: xr.Dataset) -> str:
    """Return the numbers of scenes, and the ranges of the axes."""
    scenes, computed, failed = (int(dataset.attrs[name]) for name in ("scenes", "computed", "failed"))
    ranges = join_words(_range(axis) for axis in axes_of(dataset))
    missing = scenes - computed - failed
    state = "all computed" if computed == scenes else f"{computed or 'none'} computed"
    state += f", {failed} failed" if failed else ""
    state += f", {missing} not computed yet" if missing else ""
    return f"{scenes} scene{'s' if scenes > 1 else ''} over {ranges}: {state}."


def _range(axis: ShownAxis) -> str:
    values = axis.values if axis.is_number else axis.categories
    if axis.is_number and len(values) > 2:
        return f"{axis.name} = {text_of(np.min(values))} ... {text_of(np.max(values))} {axis.unit}".rstrip()
    more = len(values) - MOST_CATEGORIES
    texts = [text_of(value) for value in values[:MOST_CATEGORIES]] + ([f"{more} more"] if more > 0 else [])
    return f"{axis.name} = {join_words(texts)} {axis.unit}".rstrip()


def _failing(dataset: xr.Dataset, field: Field) -> str:
    """Return the columns whose numbers in the only row exceed `REPORTED`, and the place in the worst one."""
    sizes = field.sizes.isel({ROW: 0})
    known = known_count(sizes.max(COLUMN))
    largest = {column: float(sizes.sel({COLUMN: column}).max()) for column in field.columns}
    over = [column for column, size in largest.items() if size > REPORTED]
    within = [plain(column) for column, size in largest.items() if size <= REPORTED]
    if not over:
        where = f"wherever they are known ({known})" if known else "everywhere"
        return f"within {share(REPORTED)} in {join_words(within)} {where}."
    worst = max(over, key=lambda column: largest[column])
    where = _where(dataset, sizes.sel({COLUMN: worst}))
    first = over[0] if plain(over[0]) in FIRST and worst != over[0] else None
    before = f"{plain(first)} {_where(dataset, sizes.sel({COLUMN: first}))}; in " if first else ""
    also = [plain(column) for column in over if column not in (worst, first)]
    notes = [f"also in {join_words(also)}"] if also else []
    notes += [f"in {join_words(within)} nowhere"] if within else []
    notes += [f"{known} are known"] if known else []
    remarks = f" ({'; '.join(notes)})" if notes else ""
    return (
        f"off by more than {share(REPORTED)} in {before}{plain(worst)} {where}, at most by "
        f"{share(largest[worst])}{remarks}."
    )


def _where(dataset: xr.Dataset, sizes: xr.DataArray) -> str:
    """Return where numbers exceed `REPORTED`: along an axis, at extremes of the others."""
    axes = axes_of(dataset)
    if not swept(axes):
        return "there"
    if not is_grid(dataset):
        return f"in {np.mean(sizes.values[np.isfinite(sizes.values)] > REPORTED):.0%} of the scenes"
    crossings = extreme_crossings(lines_of(sizes, axes), REPORTED)
    return ", ".join(crossing.along(main_axis(axes)) for crossing in crossings)
