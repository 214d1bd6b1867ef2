"""Sentences of the page of a campaign, computed from its numbers."""

import json
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import join_words
from femic.campaigns.report.advised import AdvisedICs
from femic.campaigns.report.axes import ShownAxis, axes_of, is_grid, swept, text_of
from femic.campaigns.report.crossings import extreme_crossings, known_count, lines_of, main_axis, over_level
from femic.campaigns.report.fields import COLUMN, REPORTED, ROW, Field, plain, share

FIRST = ("nn", "p_max")  # columns that are reported even if another one is worse
MOST_CATEGORIES = 4
MEANINGS = {
    "ics": "the ICs themselves (`ic`, `estimate`, with their points `x`, `s`, `on_line`)",
    "matrix": "the IC matrices (`c`, `c_estimate`)",
}


def summary(dataset: xr.Dataset, fields: Sequence[Field], advice: AdvisedICs | None) -> str:
    """Return at most three sentences: which ICs are good enough, where they fail, what is known."""
    sentences = []
    if advice is not None:
        counts = join_words(f"{name} in {count}" for name, count in advice.counts().items())
        sentences.append(f"The cheapest ICs that are good enough (scenes): {counts}.")
    if ratings := [field for field in fields if field.rates_ics]:
        sentences += list(_ranked(dataset, ratings[0]))[: 2 - len(sentences)]
    return "\n".join([*sentences, _counted(dataset, ratings[:1])])


def _ranked(dataset: xr.Dataset, field: Field) -> Iterator[str]:
    """Yield where the closest ICs fail, and how far others are off."""
    closest = field.closest
    verdict = _failing(dataset, field.of(rows=[closest]))
    same = [row for row in _known_rows(field) if _failing(dataset, field.of(rows=[row])) == verdict]
    note = f", the closest to {field.reference}," if len(field.rows) > 1 and len(same) == 1 else ""
    yield f"{_named(same)}{note} {'is' if len(same) == 1 else 'are'} {verdict}"
    if others := [row for row in _known_rows(field) if row not in same]:
        texts = [f"{symbol_of(row)} by up to {_largest(field.of(rows=[row]))}" for row in others]
        yield f"Further off: {join_words(texts)}."


def _largest(field: Field) -> str:
    """Return the largest number of a field of one row with its column."""
    sizes = field.sizes.isel({ROW: 0})
    largest = sizes.max([dim for dim in sizes.dims if dim != COLUMN])
    return f"{share(float(largest.max()))} in {plain(field.columns[int(largest.argmax(COLUMN))])}"


def _known_rows(field: Field) -> list[str]:
    """Return the rows with any known number."""
    return [row for row in field.rows if np.any(field.values.sel({ROW: row}).notnull())]


def _named(rows: Sequence[str]) -> str:
    return join_words(map(symbol_of, rows))


def files(dataset: xr.Dataset) -> str:
    """Return what the file of a campaign has besides what the page shows; empty if nothing."""
    names = [MEANINGS[name] for name in json.loads(dataset.attrs["keep"]) if name in MEANINGS]
    return f"The file of the campaign has {join_words(names)}, too." if names else ""


def judgement(dataset: xr.Dataset, field: Field) -> str:
    """Return sentences on errors or deviations: where each row is too large, and their estimates."""
    verdicts: dict[str, list[str]] = {}
    for row in _known_rows(field):
        verdicts.setdefault(_failing(dataset, field.of(rows=[row])), []).append(row)
    sentences = [
        f"{_named(rows)} {'is' if len(rows) == 1 else 'are'} {text}" for text, rows in verdicts.items()
    ]
    known = _known(field)
    return " ".join([*sentences, *([f"{known[0].upper()}{known[1:]}."] if known else [])])


def _known(field: Field) -> str:
    """Return how well the reference is known; empty where nothing says so."""
    if field.floor is None or not np.any(np.isfinite(field.floor)):
        return ""
    largest = field.floor.max([dim for dim in field.floor.dims if dim != COLUMN])
    if field.kind == "error":
        return f"{field.reference} is known to {_rounded(float(largest.max()))} or better"
    by_column = {plain(name): float(largest.sel({COLUMN: name})) for name in field.columns}
    known = [f"{_rounded(size)} ({name})" for name, size in by_column.items() if np.isfinite(size)]
    return f"the numbers with {field.reference} are known, at the worst scene, to {join_words(known)}"


def _rounded(estimate: float) -> str:
    return share(float(f"{estimate:.2g}"))


def _counted(dataset: xr.Dataset, ratings: Sequence[Field]) -> str:
    """Return the numbers of scenes, the ranges of the axes, and how well the reference is known."""
    scenes, computed, failed = (int(dataset.attrs[name]) for name in ("scenes", "computed", "failed"))
    ranges = join_words(_range(axis) for axis in axes_of(dataset))
    missing = scenes - computed - failed
    state = "all computed" if computed == scenes else f"{computed or 'none'} computed"
    state += f", {failed} failed" if failed else ""
    state += f", {missing} not computed yet" if missing else ""
    known = "; ".join(filter(None, [state, *map(_known, ratings)]))
    return f"{scenes} scene{'s' if scenes > 1 else ''} over {ranges}: {known}."


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
    where = f"wherever known ({known})" if known else "everywhere"
    good = f"within {share(REPORTED)} in {join_words(within)} {where}" if within else ""
    if not over:
        return f"{good}."
    worst = max(over, key=lambda column: largest[column])
    first = [over[0]] if plain(over[0]) in FIRST and worst != over[0] else []
    places = [f"{plain(column)} {_where(dataset, sizes.sel({COLUMN: column}))}" for column in [*first, worst]]
    also = [plain(column) for column in over if column not in (*first, worst)]
    notes = [f"also in {join_words(also)}"] if also else []
    notes += [f"{known} are known"] if known and not within else []
    remarks = f" ({'; '.join(notes)})" if notes else ""
    start = f"{good}, but off by more" if within else f"off by more than {share(REPORTED)}"
    return f"{start} in {'; in '.join(places)}, at most by {share(largest[worst])}{remarks}."


def _where(dataset: xr.Dataset, sizes: xr.DataArray) -> str:
    """Return where numbers exceed `REPORTED`: along an axis, at extremes of the others."""
    axes = axes_of(dataset)
    if not swept(axes):
        return "there"
    if not is_grid(dataset):
        return f"in {over_level(sizes, REPORTED)} of the scenes"
    crossings = extreme_crossings(lines_of(sizes, axes), REPORTED)
    return ", ".join(crossing.along(main_axis(axes)) for crossing in crossings)
