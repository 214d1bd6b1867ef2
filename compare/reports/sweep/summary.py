"""Sentences of the page of a campaign, computed from its numbers."""

import json
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from compare.pages.parts import listed
from compare.reports.sweep.advised import Advice
from compare.reports.sweep.axes import ShownAxis, axes_of, is_grid, swept, text_of
from compare.reports.sweep.crossings import NOWHERE, grouped, told
from compare.reports.sweep.fields import COLUMN, ROW, Field, label_of, plain
from compare.reports.sweep.scales import share
from compare.reports.sweep.tables import MOST_ALONG, TOLD, along, others

FIRST = "nn"  # component of which it is told where it fails, even if another one is worse
MEANINGS = {
    "ics": "the ICs themselves (`ic`, `estimate`, with their points `x`, `s`, `on_line`)",
    "matrix": "the IC matrices (`c`, `c_estimate`)",
}


def summary(dataset: xr.Dataset, fields: Sequence[Field], advice: Advice | None) -> str:
    """Sentences computed from the numbers: what there is, what fails where, what is advised."""
    sentences = [_counted(dataset)]
    judged = [field for field in fields if field.kind != "value"]
    sentences += [sentence for field in judged[:1] for sentence in judgement(dataset, field)]
    if advice is not None:
        told_counts = listed(f"{name} in {count}" for name, count in advice.counts().items())
        sentences.append(f"The cheapest ICs that are good enough (scenes): {told_counts}.")
    kept = [MEANINGS[name] for name in json.loads(dataset.attrs["keep"]) if name in MEANINGS]
    if kept:
        sentences.append(f"The file of the campaign has {listed(kept)}, too.")
    return "\n".join(sentences)


def judgement(dataset: xr.Dataset, field: Field) -> Iterator[str]:
    """Yield sentences on errors or deviations: what is known, and where each row of them is too large."""
    if field.floor is not None and np.any(np.isfinite(field.floor)):
        yield f"C is known to {share(float(field.floor.max()))} or better."
    for row in field.rows:
        if np.any(_of_row(field, row).notnull()):
            yield _failing(dataset, field, row)


def _counted(dataset: xr.Dataset) -> str:
    """How many scenes there are, and over which axes."""
    scenes, computed, failed = (int(dataset.attrs[name]) for name in ("scenes", "computed", "failed"))
    ranges = listed(_range(axis) for axis in axes_of(dataset))
    missing = scenes - computed - failed
    state = "all computed" if computed == scenes else f"{computed or 'none'} computed"
    state += f", {failed} failed" if failed else ""
    state += f", {missing} not computed yet" if missing else ""
    return f"{scenes} scene{'s' if scenes > 1 else ''} over {ranges}: {state}."


def _range(axis: ShownAxis) -> str:
    values = axis.values if axis.is_number else np.array(axis.categories)
    if not axis.is_number or len(values) <= 2:
        return f"{axis.name} = {listed(text_of(value) for value in values[:MOST_ALONG])}" + (
            f" and {len(values) - MOST_ALONG} more" if len(values) > MOST_ALONG else ""
        )
    return f"{axis.name} = {text_of(np.min(values))} ... {text_of(np.max(values))}"


def _failing(dataset: xr.Dataset, field: Field, row: str) -> str:
    """In which columns numbers of a row exceed `TOLD`; where, for the worst of these."""
    sizes, name = abs(_of_row(field, row)), label_of(row)
    largest = {column: float(sizes.sel({COLUMN: column}).max()) for column in field.columns}
    over = [column for column, size in largest.items() if size > TOLD]
    within = [column for column, size in largest.items() if size <= TOLD]
    if not over:
        return f"{name} is within {share(TOLD)} in {listed(map(plain, within))} everywhere."
    worst = max(over, key=lambda column: largest[column])
    where = _where(dataset, sizes.sel({COLUMN: worst}))
    first = over[0] if plain(over[0]) == FIRST and worst != over[0] else None
    before = f"{plain(first)} {_where(dataset, sizes.sel({COLUMN: first}))}; in " if first else ""
    also = [plain(column) for column in over if column not in (worst, first)]
    notes = [f"also in {listed(also)}"] if also else []
    notes += [f"in {listed(map(plain, within))} nowhere"] if within else []
    noted = f" ({'; '.join(notes)})" if notes else ""
    return (
        f"{name} is off by more than {share(TOLD)} in {before}{plain(worst)} {where}, at most by "
        f"{share(largest[worst])}{noted}."
    )


def _where(dataset: xr.Dataset, sizes: xr.DataArray) -> str:
    """Where the numbers of a row and column exceed `TOLD`."""
    axes = axes_of(dataset)
    if not swept(axes):
        return "there"
    if not is_grid(dataset):
        known = sizes.values[np.isfinite(sizes.values)]
        return f"in {np.mean(known > TOLD):.0%} of the scenes"
    axis = along(axes)
    rest = [one for one in swept(axes) if one.name != axis.name]
    if len(rest) > 1:
        text = _known(*told(axis, sizes.max([one.name for one in axes if one is not axis]).values, TOLD))
        return f"{_along(axis, text)} at the worst {listed(one.name for one in rest)}"
    found = [(_known(*told(axis, sizes.isel(at).values, TOLD)), name) for name, at in others(axes, axis)]
    if len({text for text, _ in found}) == 1:
        return _along(axis, found[0][0])
    shortened = _shortened(found, rest[0].name)
    first, *more = [f"{text} at {names}" for text, names in grouped(shortened)]
    return ", ".join([_along(axis, first), *more])


def _known(text: str, note: str) -> str:
    """Where something is exceeded, and of how many scenes that is known if not of all."""
    return f"{text} (of {note})" if text == NOWHERE and note else text


def _along(axis: ShownAxis, text: str) -> str:
    """A range with the name of its axis: from flank = 32 on."""
    for word in ("from ", "up to ", "at "):
        if text.startswith(word):
            return f"{word}{axis.name} = {text.removeprefix(word)}"
    return text


def _shortened(found: Sequence[tuple[str, str]], name: str) -> list[tuple[str, str]]:
    """The same with the name of the only other axis once: at ratio = 1.05, 1.2."""
    return [
        (text, place if k == 0 else place.removeprefix(f"{name} = ")) for k, (text, place) in enumerate(found)
    ]


def _of_row(field: Field, row: str) -> xr.DataArray:
    return field.values.sel({ROW: row})
