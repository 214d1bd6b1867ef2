"""The answer of a campaign: which ICs are good enough, how far others are off, where they fail."""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import xarray as xr

from compare.campaigns.report.charts import MOST_POINTS, MOST_STEPS, Plane
from compare.campaigns.report.fields import (
    COLUMN,
    REPORTED,
    ROW,
    Field,
    Names,
    ShownAxis,
    axes_of,
    body_of,
    evenly_spaced,
    is_grid,
    plain,
    point_of,
    share,
    swept,
    swept_dims,
    text_of,
    values_text,
)
from compare.report.charts import Chart, Curve, Map, Panel, chart_of
from compare.report.errors import colour
from compare.report.looks import INK, Look, looks_of, symbol_of
from compare.report.parts import join_words
from compare.report.tables import ROUNDING, Cell, Column, Row, Table, with_estimate
from geometries.arrays import Array

# --- where numbers exceed a level -----------------------------------------------------------------------


NOWHERE, EVERYWHERE = "nowhere", "everywhere"


@dataclass(frozen=True)
class Range:
    """A range of an axis in which a level is exceeded; None: from its first, or up to its last value."""

    start: float | None = None
    end: float | None = None

    def text(self, span: float) -> str:
        """Return the range as text; ends have the digits that are significant in a `span` of values."""
        start, end = (
            None if place is None else _rounded_level(place, span) for place in (self.start, self.end)
        )
        if start is None:
            return EVERYWHERE if end is None else f"up to {end}"
        return f"from {start} on" if end is None else f"from {start} to {end}"


def ranges_above(at: Array, values: Array, level: float) -> list[Range]:
    """Return the ranges in which values (n,) over an axis exceed a level, interpolated linearly.

    Values that are NaN are left out.
    """
    known = np.isfinite(values)
    at, values = at[known], values[known]
    above = np.concatenate([[False], values > level, [False]])
    starts, ends = (np.flatnonzero(above[1:] & ~above[:-1]), np.flatnonzero(above[:-1] & ~above[1:]))

    def crossing(k: int) -> float:
        share = (level - values[k]) / (values[k + 1] - values[k])
        return float(at[k] + share * (at[k + 1] - at[k]))

    return [
        Range(
            None if start == 0 else crossing(int(start) - 1),
            None if end == len(at) else crossing(int(end) - 1),
        )
        for start, end in zip(starts, ends, strict=True)
    ]


def _rounded_level(value: float, span: float) -> str:
    """Return a value as text with three digits, and with as many as a thousandth of a span needs."""
    digits = 3
    if value and span:
        digits += max(0, int(np.floor(np.log10(abs(value) / span))))
    rounded = float(f"{value:.{digits}g}")
    if 0 < abs(value) < span / 10:
        rounded = round(rounded, 3 - int(np.floor(np.log10(span))))
    return np.format_float_positional(rounded, trim="-")


@dataclass(frozen=True)
class Crossing:
    """The range where a level is exceeded, at a place of the other axes ("": at all), and more ranges."""

    text: str
    place: str = ""
    more: str = ""

    def along(self, axis: ShownAxis) -> str:
        """Return the crossing as part of a sentence: from flank = 32 on at ratio = 1.05."""
        text = self.text
        for word in ("from ", "up to ", "at "):
            if text.startswith(word):
                text = f"{word}{axis.name} = {text.removeprefix(word)}"
        return f"{text} at {self.place}" if self.place else text


@dataclass(frozen=True, eq=False)
class Line:
    """Sizes of numbers along an axis, (n,), at a place of the other axes."""

    axis: ShownAxis
    place: Names
    sizes: Array

    def crossing(self, level: float) -> Crossing:
        """Return where the sizes exceed a level."""
        place = join_words([values_text({name: value}) for name, value in self.place.items()] or [""])
        known = np.isfinite(self.sizes)
        if not self.axis.is_number:
            over = self.axis.values[known & (self.sizes > level)]
            if len(over) in (0, np.sum(known)):
                return Crossing(EVERYWHERE if len(over) else NOWHERE, place)
            return Crossing(f"at {join_words(map(text_of, over))}", place)
        span = float(np.ptp(self.axis.values))
        texts = [part.text(span) for part in ranges_above(self.axis.values, self.sizes, level)] or [NOWHERE]
        again = [f"again {texts[1]}"] if len(texts) > 1 else []
        further = [f"and {len(texts) - 2} times more"] if len(texts) > 2 else []
        return Crossing(texts[0], place, ", ".join([*again, *further]))

    def extent(self, level: float) -> float:
        """Return the share of the known part of the axis, or of its categories, that exceeds a level."""
        known = np.isfinite(self.sizes)
        at = self.axis.at[known]
        if not self.axis.is_number or np.ptp(at) == 0:
            return float(np.mean(self.sizes[known] > level))
        covered = 0.0
        for part in ranges_above(self.axis.at, self.sizes, level):
            covered += at[-1] if part.end is None else part.end
            covered -= at[0] if part.start is None else part.start
        return covered / float(np.ptp(at))


def lines_of(sizes: xr.DataArray, axes: Sequence[ShownAxis]) -> list[Line]:
    """Return sizes over the swept dims as lines along the main axis, at all places of the others."""
    axis = main_axis(axes)
    names = [other.name for other in swept(axes) if other is not axis]
    rows = sizes.transpose(*names, axis.name).values.reshape(-1, len(axis.values))
    places = product(*(other.values for other in swept(axes) if other is not axis))
    return [
        Line(axis, dict(zip(names, place, strict=True)), row) for place, row in zip(places, rows, strict=True)
    ]


def extreme_crossings(lines: Sequence[Line], level: float) -> list[Crossing]:
    """Return where a level is exceeded: on the lines of the largest and of the least extent, if any."""
    known = [line for line in lines if np.any(np.isfinite(line.sizes))]
    if not known:
        return []
    by_extent = sorted(known, key=lambda line: (line.extent(level), np.nanmax(line.sizes)))
    most, least = by_extent[-1].crossing(level), by_extent[0].crossing(level)
    return [Crossing(most.text, more=most.more)] if most.text == least.text else [most, least]


def main_axis(axes: Iterable[ShownAxis]) -> ShownAxis:
    """Return the axis along which crossings are reported: of numbers, with the most values."""
    return max(swept(axes), key=lambda axis: (axis.is_number, len(axis.values)))


def over_level(sizes: xr.DataArray, level: float) -> str:
    """Return the share of the known scenes whose numbers exceed a level."""
    known = sizes.values[np.isfinite(sizes.values)]
    return f"{100 * np.mean(known > level):.0f} %" if known.size else "–"


def known_count(sizes: xr.DataArray) -> str:
    """Return "15 of 21 scenes" where not all are known, else ""."""
    known = int(np.sum(np.isfinite(sizes.values)))
    return "" if known == sizes.size else f"{known} of {sizes.size} scenes"


# --- the table that begins the page ---------------------------------------------------------------------


MOST_COLUMNS = 6


@dataclass(frozen=True)
class Largest:
    """The largest error or deviation of one row and column: with its estimate [%], and its scene."""

    text: str
    size: float  # a share
    scene: str


def largest_of(field: Field, dataset: xr.Dataset) -> Largest | None:
    """Return the largest number of a field of one row and column; None where nothing is known."""
    values = field.values.isel({ROW: 0, COLUMN: 0}).transpose(*swept_dims(dataset))
    if not np.any(np.isfinite(values)):
        return None
    place = np.unravel_index(np.nanargmax(abs(values.values)), values.shape)
    worst, estimate = float(values.values[place]), np.nan
    if field.floor is not None:
        estimate = float(field.floor.isel({COLUMN: 0}).transpose(*swept_dims(dataset)).values[place])
    text = with_estimate(100 * worst, 100 * estimate) if estimate > ROUNDING else f"{100 * worst:.3g}"
    sign = "+" if field.kind == "deviation" and worst > 0 else ""
    return Largest("0" if abs(worst) < ROUNDING else sign + text, abs(worst), point_of(dataset, place))


def answer_table(field: Field, dataset: xr.Dataset) -> Table:
    """Return the largest numbers of the first columns with their estimates; below, where they are large."""
    columns = field.columns[:MOST_COLUMNS]
    rows = [
        Row(
            symbol_of(row),
            [_cell(field.select(rows=[row], columns=[column]), dataset) for column in columns],
        )
        for row in field.rows
    ]
    return Table(f"largest {field.kind}", [Column(column, "%") for column in columns], rows)


def _cell(field: Field, dataset: xr.Dataset) -> Cell:
    largest = largest_of(field, dataset)
    if largest is None:
        return Cell(np.nan)
    sizes = field.sizes.isel({ROW: 0, COLUMN: 0})
    return Cell(largest.text, below=_where_large(sizes, dataset), colour=colour(largest.size))


def _where_large(sizes: xr.DataArray, dataset: xr.Dataset) -> str:
    """Return where numbers exceed `REPORTED` along the main axis; of samples, how many do."""
    axes = axes_of(dataset)
    if not swept(axes):
        return ""
    if not is_grid(dataset):
        return f"{over_level(sizes, REPORTED)} of scenes"
    return extreme_crossings(lines_of(sizes, axes), REPORTED)[0].text


def answer_note(field: Field, dataset: xr.Dataset) -> str:
    """Return what the table that begins the page shows."""
    axes = swept(axes_of(dataset))
    notes = [f"Largest of all scenes, ± the estimate of {field.reference} there."]
    if axes and is_grid(dataset):
        axis = main_axis(axes)
        others = join_words(other.name for other in axes if other is not axis)
        where = f", at the {others} where this range is largest" if others else ""
        interpolated = "; interpolated linearly between scenes" if axis.is_number else ""
        notes.append(f"Small: {axis.label} at which it exceeds {share(REPORTED)}{where}{interpolated}.")
    elif axes:
        notes.append(f"Small: share of the scenes in which it exceeds {share(REPORTED)}.")
    if left_out := field.columns[MOST_COLUMNS:]:
        notes.append(f"Further down: {join_words(map(plain, left_out))}.")
    return " ".join(notes)


# --- the advised ICs ------------------------------------------------------------------------------------


NONE, TITLE = "none", "cheapest ICs that are good enough"
GREY = "#c8ccd2"
POINT = Look(INK, "", "circle")


@dataclass(frozen=True, eq=False)
class AdvisedICs:
    """The advised ICs over the swept dims, as places in `names`, of which one may be `NONE`."""

    numbers: xr.DataArray
    names: tuple[str, ...]

    @property
    def labels(self) -> list[str]:
        """The names as on the page."""
        return [symbol_of(name) for name in self.names]

    @property
    def colours(self) -> list[str]:
        """The colours of the ICs' curves, grey for none; C, whose curves have the colour of ink, is black."""
        looks = looks_of(name for name in self.names if name != NONE)
        colours = {name: "#000000" if look.colour == INK else look.colour for name, look in looks.items()}
        return [colours.get(name, GREY) for name in self.names]

    def at(self, **places: int) -> "AdvisedICs":
        """Return the advice at some places of swept dims."""
        return AdvisedICs(self.numbers.isel(places), self.names)

    def counts(self) -> dict[str, int]:
        """Return the numbers of scenes by advised ICs."""
        counts = {label: int((self.numbers == k).sum()) for k, label in enumerate(self.labels)}
        return {label: count for label, count in counts.items() if count}


def advice_of(dataset: xr.Dataset) -> AdvisedICs | None:
    """Return the advice of a campaign that kept it, with the ICs that are advised anywhere; else None."""
    if "advised" not in dataset:
        return None
    numbers = dataset.advised.sel(body=body_of(dataset), drop=True).drop_attrs().load()
    known = np.unique(numbers.values[np.isfinite(numbers.values)]).astype(int)
    if not known.size:
        return None
    used = sorted(known, key=lambda k: (k < 0, k))  # -1, none, comes last
    places = np.select([numbers == k for k in used], range(len(used)), np.nan)
    names = tuple(NONE if k < 0 else str(dataset.variant.values[k]) for k in used)
    return AdvisedICs(numbers.copy(data=places), names)


def advised_chart(advice: AdvisedICs, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Chart:
    """Return the advised ICs over one axis, or over two by the third one, or as points of random scenes."""
    if len(axes) == 1:
        return chart_of("advice", [_over_one(advice, axes[0])], 1, 0.6)
    if "sample" in failed.dims:
        return chart_of("advice", [_points(advice, axes)], 1, 1.3)
    if len(axes) == 2:
        return chart_of("advice", [_map(advice, Plane.from_axes(axes, failed))], 1)
    third = axes[2]
    first = {axis.name: 0 for axis in axes[3:]}
    steps = {}
    for k in evenly_spaced(len(third.values), MOST_STEPS):
        place = first | {third.name: k}
        steps[values_text({third.name: third.values[k]})] = [
            _map(advice.at(**place), Plane.from_axes(axes, failed.isel(place)))
        ]
    return Chart("advice", steps, 1, third.label)


def _map(advice: AdvisedICs, plane: Plane) -> Map:
    return plane.draw_kinds(TITLE, advice.numbers, dict(zip(advice.labels, advice.colours, strict=True)))


def _over_one(advice: AdvisedICs, axis: ShownAxis) -> Panel:
    """Return points over an axis, whose ordinates are the ICs."""
    curve = Curve("", axis.at, advice.numbers.values, POINT)
    return Panel(
        TITLE,
        axis.label,
        "",
        [curve],
        log_x=axis.is_logarithmic,
        names_x=axis.categories,
        names_y=advice.labels,
    )


def _points(advice: AdvisedICs, axes: Sequence[ShownAxis]) -> Panel:
    """Return points of the advised ICs over the first two axes."""
    across, up = axes[:2]
    chosen = evenly_spaced(len(across.values), MOST_POINTS)
    numbers = advice.numbers.values[chosen]
    curves = [
        Curve(label, across.at[chosen][numbers == k], up.at[chosen][numbers == k], Look(colour, "", "circle"))
        for k, (label, colour) in enumerate(zip(advice.labels, advice.colours, strict=True))
    ]
    return Panel(
        TITLE,
        across.label,
        up.label,
        curves,
        log_x=across.is_logarithmic,
        log_y=up.is_logarithmic,
        names_x=across.categories,
        names_y=up.categories,
    )


# --- sentences ------------------------------------------------------------------------------------------


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
        sentences += list(_rank_ics(dataset, ratings[0]))[: 2 - len(sentences)]
    return "\n".join([*sentences, _count_scenes(dataset, ratings[:1])])


def _rank_ics(dataset: xr.Dataset, field: Field) -> Iterator[str]:
    """Yield where the closest ICs fail, and how far others are off."""
    closest = field.closest
    verdict = _failing(dataset, field.select(rows=[closest]))
    same = [row for row in _known_rows(field) if _failing(dataset, field.select(rows=[row])) == verdict]
    note = f", the closest to {field.reference}," if len(field.rows) > 1 and len(same) == 1 else ""
    yield f"{_join_symbols(same)}{note} {'is' if len(same) == 1 else 'are'} {verdict}"
    if others := [row for row in _known_rows(field) if row not in same]:
        texts = [f"{symbol_of(row)} by up to {_largest(field.select(rows=[row]))}" for row in others]
        yield f"Further off: {join_words(texts)}."


def _largest(field: Field) -> str:
    """Return the largest number of a field of one row with its column."""
    sizes = field.sizes.isel({ROW: 0})
    largest = sizes.max([dim for dim in sizes.dims if dim != COLUMN])
    return f"{share(float(largest.max()))} in {plain(field.columns[int(largest.argmax(COLUMN))])}"


def _known_rows(field: Field) -> list[str]:
    """Return the rows with any known number."""
    return [row for row in field.rows if np.any(field.values.sel({ROW: row}).notnull())]


def _join_symbols(rows: Sequence[str]) -> str:
    return join_words(map(symbol_of, rows))


def files(dataset: xr.Dataset) -> str:
    """Return what the file of a campaign has besides what the page shows; empty if nothing."""
    names = [MEANINGS[name] for name in json.loads(dataset.attrs["keep"]) if name in MEANINGS]
    return f"The file of the campaign has {join_words(names)}, too." if names else ""


def judgement(dataset: xr.Dataset, field: Field) -> str:
    """Return sentences on errors or deviations: where each row is too large, and their estimates."""
    verdicts: dict[str, list[str]] = {}
    for row in _known_rows(field):
        verdicts.setdefault(_failing(dataset, field.select(rows=[row])), []).append(row)
    sentences = [
        f"{_join_symbols(rows)} {'is' if len(rows) == 1 else 'are'} {text}" for text, rows in verdicts.items()
    ]
    known = _accuracy_text(field)
    return " ".join([*sentences, *([f"{known[0].upper()}{known[1:]}."] if known else [])])


def _accuracy_text(field: Field) -> str:
    """Return how well the reference is known; empty where nothing says so."""
    if field.floor is None or not np.any(np.isfinite(field.floor)):
        return ""
    largest = field.floor.max([dim for dim in field.floor.dims if dim != COLUMN])
    if field.kind == "error":
        return f"{field.reference} is known to {_share_text(float(largest.max()))} or better"
    by_column = {plain(name): float(largest.sel({COLUMN: name})) for name in field.columns}
    known = [f"{_share_text(size)} ({name})" for name, size in by_column.items() if np.isfinite(size)]
    return f"the numbers with {field.reference} are known, at the worst scene, to {join_words(known)}"


def _share_text(estimate: float) -> str:
    return share(float(f"{estimate:.2g}"))


def _count_scenes(dataset: xr.Dataset, ratings: Sequence[Field]) -> str:
    """Return the numbers of scenes, the ranges of the axes, and how well the reference is known."""
    scenes, computed, failed = (int(dataset.attrs[name]) for name in ("scenes", "computed", "failed"))
    ranges = join_words(_range(axis) for axis in axes_of(dataset))
    missing = scenes - computed - failed
    state = "all computed" if computed == scenes else f"{computed or 'none'} computed"
    state += f", {failed} failed" if failed else ""
    state += f", {missing} not computed yet" if missing else ""
    known = "; ".join(filter(None, [state, *map(_accuracy_text, ratings)]))
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
