"""Charts of a campaign: maps over two axes, curves over the only axis, points of random scenes.

A map has a cell per scene, lines where levels are exceeded, and failed scenes. Curves and points are by rows
such as ICs.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from compare.campaigns.report.fields import (
    COLUMN,
    LEVELS,
    LOWEST,
    NONE,
    REPORTED,
    ROW,
    Advice,
    Field,
    Names,
    ShownAxis,
    evenly_spaced,
    plain,
    share,
    values_text,
)
from compare.report.charts import Chart, Curve, Map, Panel, simple_chart
from compare.report.looks import INK, Look, drawing_order, ics_looks, ics_symbol, without_marker
from geometries.arrays import Array

# --- maps -----------------------------------------------------------------------------------------------


COLUMNS = 4  # maps beside each other
MOST_STEPS = 20  # values of the third axis
ERRORS = (0.1, 100.0)  # limits of the colours of errors on all pages [%]
BLUE = "#0072b2"  # of lines on the colours of errors, and on light and dark pages
LEVEL_LOOKS = tuple(
    zip(LEVELS, (Look(dash="dot"), Look(dash="dashdot"), Look(width=2.6), Look(dash="dash")), strict=True)
)
FAILED = Look("#808080", "", "x")
ALL, OTHERS = "all", "some"  # of the ICs
ADVISED = "cheapest ICs that are accurate enough"
RARE = -1  # stands for rare sets of ICs
# pale, so that lines are seen: blue for all ICs, orange for none; rare combinations have the last one between
OF_ALL, OF_NONE = "#8fc1e3", "#f0a35e"
BETWEEN = ("#d5ebdf", "#f8f0a4", "#e6cbdc", "#a8d5c0", "#cfc6e6", "#cccccc")


@dataclass(frozen=True, eq=False)
class Plane:
    """The two axes of maps, and the failed scenes."""

    across: ShownAxis
    up: ShownAxis
    failing: xr.DataArray

    @classmethod
    def from_axes(cls, axes: Sequence[ShownAxis], failed: xr.DataArray) -> "Plane":
        """Return the plane of the first axes; a failure is one at all places of further axes."""
        return cls(axes[0], axes[1], failed.all([axis.name for axis in axes[2:] if axis.name in failed.dims]))

    @property
    def has_lines(self) -> bool:
        """Whether both axes have numbers, so that there may be lines."""
        return self.across.is_number and self.up.is_number

    def over(self, values: xr.DataArray) -> Array:
        """Return numbers over the plane, (n_across, n_up)."""
        return np.asarray(values.transpose(self.across.name, self.up.name).values)

    def draw_map(
        self, title: str, values: xr.DataArray, unit: str = "", lines: Sequence[Curve] = (), **style: Any
    ) -> Map:
        """Return a map of values over the plane, with lines and marks of failed scenes."""
        across, up = self.across, self.up
        k, m = np.nonzero(self.over(self.failing))
        failed = [Curve("failed", across.at[k], up.at[m], FAILED)] if len(k) else []
        return Map(
            title,
            across.label,
            up.label,
            across.at,
            up.at,
            np.asarray(self.over(values), dtype=float),
            unit,
            curves=[*lines, *failed],
            log_x=across.is_logarithmic,
            log_y=up.is_logarithmic,
            names_x=across.categories,
            names_y=up.categories,
            **style,
        )

    def draw_kinds(
        self, title: str, places: xr.DataArray, kinds: Mapping[str, str], lines: Sequence[Curve] = ()
    ) -> Map:
        """Return a map of places among kinds, whose names have colours."""
        colours, limits = list(kinds.values()), (0.0, len(kinds) - 1.0)
        return self.draw_map(title, places, "", lines, classes=list(kinds), colours=colours, limits=limits)

    def line(self, label: str, sizes: xr.DataArray, level: float, look: Look) -> list[Curve]:
        """Return the line where sizes exceed a level, if there is one, and if both axes have numbers."""
        known = np.ma.masked_invalid(self.over(sizes))
        if not (self.has_lines and known.min() < level < known.max()):
            return []
        contour = Figure().subplots().contour(self.across.at, self.up.at, known.T, [level])
        parts = [np.concatenate([part, [[np.nan, np.nan]]]) for part in contour.allsegs[0]]
        if not parts:
            return []
        x, y = np.concatenate(parts)[:-1].T
        return [Curve(label, x, y, look)]


def columns_for(count: int) -> int:
    """Return how many of some cells are beside each other, so that rows are about as long."""
    return ceil(count / ceil(count / COLUMNS))


def field_chart(field: Field, plane: Plane, slider: str) -> Chart:
    """Return maps of all columns of a field, by its rows; the closest first."""
    steps = {ics_symbol(row): _maps(field.select(rows=[row]), plane, field) for row in field.rows}
    start = ics_symbol(field.closest if field.rates_ics else field.rows[0])
    return _chart(field.name, steps, field, slider, start)


def third_axis_chart(
    field: Field, row: str, axes: Sequence[ShownAxis], failed: xr.DataArray, name: str
) -> Chart:
    """Return maps of a row of a field over two axes, by the third; of errors the worst, too."""
    third, one_row = axes[2], field.select(rows=[row])
    steps = {}
    if field.rates_ics:
        steps["the largest error"] = _maps(
            one_row.worst_over(third.name), Plane.from_axes(axes, failed), field
        )
    for k in evenly_spaced(len(third.values), MOST_STEPS):
        at = {third.name: k}
        plane = Plane.from_axes(axes, failed.isel(at))
        steps[values_text({third.name: third.values[k]})] = _maps(one_row.at(**at), plane, field)
    return _chart(name, steps, field, third.label, next(iter(steps)))


def _chart(name: str, steps: dict[str, list[Map]], field: Field, slider: str, start: str) -> Chart:
    columns = columns_for(len(field.columns))
    return Chart(name, steps, columns, slider, 0.8, start, alt=f"maps of {field.what}")


def _maps(field: Field, plane: Plane, whole: Field) -> list[Map]:
    """Return maps of all columns of a field of one row, in the colours of a whole field.

    Lines are where shares [%] exceed the levels.
    """
    maps = []
    for column in field.columns:
        shown, lines = field.shown.sel({COLUMN: column}).isel({ROW: 0}), list[Curve]()
        for level, look in LEVEL_LOOKS if field.rates_ics else ():
            coloured = replace(look, colour=BLUE if field.kind == "error" else INK)
            lines += plane.line(share(level), abs(shown), 100 * level, coloured)
        unit = "%" if field.rates_ics else column.partition(" [")[2].removesuffix("]")
        colours = _colours(whole.select(columns=[column]))
        maps.append(plane.draw_map(column, shown, unit, lines, **colours))
    return maps


def _colours(field: Field) -> dict[str, Any]:
    """Return the scale of the colours of a field, and their limits."""
    if field.kind == "error":
        return {"scale": "positive", "limits": ERRORS}
    known = field.shown.values[np.isfinite(field.values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    if field.kind == "value":
        return {"limits": (low, high)}
    largest = max(-low, high, 100 * LEVELS[0])
    return {"scale": "diverging", "limits": (-largest, largest)}


def within_chart(field: Field, plane: Plane) -> Chart:
    """Return maps of which ICs are within a tolerance, by column; a slider changes the tolerance.

    Sets of ICs are numbered by sums of powers of two, NaN where nothing is known.
    """
    powers, known = xr.DataArray(2.0 ** np.arange(len(field.rows)), dims=ROW), field.values.notnull().any(ROW)
    sets = {level: ((field.sizes <= level) * powers).sum(ROW).where(known) for level in LEVELS}
    kinds, looks = _kinds(list(sets.values()), list(map(ics_symbol, field.rows))), ics_looks(field.rows)
    numbers = list(kinds)
    rare = float(numbers.index(RARE)) if RARE in kinds else np.nan

    def draw_map(column: str, level: float) -> Map:
        sizes, in_column = field.sizes.sel({COLUMN: column}), sets[level].sel({COLUMN: column})
        lines = [
            line
            for row in drawing_order(field.rows)
            for line in plane.line(ics_symbol(row), sizes.sel({ROW: row}), level, without_marker(looks[row]))
        ]
        places = np.select([in_column == number for number in numbers], range(len(numbers)), rare)
        shown = in_column.copy(data=places).where(in_column.notnull())
        return plane.draw_kinds(column, shown, dict(kinds.values()), lines)

    steps = {share(level): [draw_map(column, level) for column in field.columns] for level in LEVELS}
    columns = columns_for(len(field.columns))
    alt = "which ICs are within a tolerance"
    return Chart(f"within_{field.name}", steps, columns, "tolerance", 0.75, share(REPORTED), alt=alt)


def _kinds(sets: Sequence[xr.DataArray], symbols: Sequence[str]) -> dict[int, tuple[str, str]]:
    """Return names and colours of sets of ICs, from all of them to none; rare sets are `OTHERS`."""
    known = np.concatenate([numbers.values.ravel() for numbers in sets])
    counts = Counter(known[np.isfinite(known)].astype(int).tolist())
    every = 2 ** len(symbols) - 1
    frequent = [number for number, _ in counts.most_common() if number not in (0, every)]
    between = sorted(frequent[: len(BETWEEN) - 1], key=int.bit_count, reverse=True)
    kinds = {every: (ALL if len(symbols) > 2 else ", ".join(symbols), OF_ALL)}
    for number, colour in zip(between, BETWEEN, strict=False):
        names = [symbol for k, symbol in enumerate(symbols) if number >> k & 1]
        kinds[number] = ", ".join(names), colour
    if len(frequent) > len(between):
        kinds[RARE] = OTHERS, BETWEEN[-1]
    return kinds | {0: (NONE, OF_NONE)}


def advised_chart(advice: Advice, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Chart:
    """Return the advised ICs over one axis, or over two by the third one, or as points of random scenes."""
    advised, kinds = advice
    if len(axes) == 1:
        curve = Curve("", axes[0].at, advised.values, Look(INK, "", "circle"))
        return simple_chart("advice", [_axes_panel(ADVISED, axes[0], [curve], names_y=list(kinds))], 1, 0.6)
    if "sample" in failed.dims:
        across, up = axes[:2]
        chosen = evenly_spaced(len(across.values), MOST_POINTS)
        numbers, x, y = advised.values[chosen], across.at[chosen], up.at[chosen]
        points = [
            Curve(label, x[numbers == k], y[numbers == k], Look(colour, "", "circle"))
            for k, (label, colour) in enumerate(kinds.items())
        ]
        panel = _axes_panel(ADVISED, across, points, up.label, log_y=up.is_logarithmic, names_y=up.categories)
        return simple_chart("advice", [panel], 1, 1.3)

    def draw_map(place: Names) -> list[Map]:
        plane = Plane.from_axes(axes, failed.isel(place))
        return [plane.draw_kinds(ADVISED, advised.isel(place), kinds)]

    if len(axes) == 2:
        return simple_chart("advice", draw_map({}), 1)
    third, further = axes[2], {axis.name: 0 for axis in axes[3:]}
    steps = {
        values_text({third.name: third.values[k]}): draw_map(further | {third.name: k})
        for k in evenly_spaced(len(third.values), MOST_STEPS)
    }
    return Chart("advice", steps, 1, third.label)


# --- curves and points ----------------------------------------------------------------------------------


MOST_POINTS = 500  # of a panel
LEAST = 100 * LOWEST  # smallest error that is drawn [%]


def curves(field: Field, axis: ShownAxis) -> Chart:
    """Return curves of all rows over an axis, a panel per column; bands have the estimate."""
    panels = [_panel(field.select(columns=[column]), axis, column) for column in field.columns]
    return simple_chart(field.name, panels, columns_for(len(panels)))


def clouds(field: Field, axes: Sequence[ShownAxis]) -> Chart:
    """Return points of all rows over each axis, by column."""
    chosen = evenly_spaced(field.values.sizes["sample"], MOST_POINTS)
    drawn = field.at(sample=chosen)
    shown = [replace(axis, values=axis.values[chosen]) for axis in axes]
    steps = {
        plain(column): [
            _panel(drawn.select(columns=[column]), axis, f"over {axis.name}", is_cloud=True) for axis in shown
        ]
        for column in field.columns
    }
    slider = "component" if field.kind == "error" else "number"
    alt = f"{field.what} over each axis"
    return Chart(field.name, steps, columns_for(len(axes)), slider, 1.1, next(iter(steps)), alt=alt)


def _axes_panel(title: str, axis: ShownAxis, curves: Sequence[Curve], up: str = "", **style: Any) -> Panel:
    return Panel(title, axis.label, up, curves, log_x=axis.is_logarithmic, names_x=axis.categories, **style)


def _panel(field: Field, axis: ShownAxis, title: str, *, is_cloud: bool = False) -> Panel:
    """Return a panel of a field of one column over an axis."""
    looks = ics_looks(field.rows)
    if is_cloud or not axis.is_number:
        looks = {row: replace(look, dash="") for row, look in looks.items()}
    above = [100 * level for level in LEVELS]
    drawn = [
        _curve(field.select(rows=[row]), axis, looks[row], has_band=not is_cloud)
        for row in drawing_order(field.rows)
    ]
    return _axes_panel(
        title,
        axis,
        drawn,
        f"{field.kind} [%]" if field.rates_ics else field.columns[0],
        log_y=field.kind == "error",
        levels={"error": above, "deviation": [*(-level for level in above), *above], "value": []}[field.kind],
    )


def _curve(field: Field, axis: ShownAxis, look: Look, *, has_band: bool) -> Curve:
    """Return a field of one row and column over an axis where it is known, with its estimate as band."""
    values = field.shown.isel({ROW: 0, COLUMN: 0}).values
    known, is_error = np.isfinite(values), field.kind == "error"
    x, y = axis.at[known], values[known]
    if is_error:
        y = np.maximum(y, LEAST)
    band = None
    if has_band and field.floor is not None:
        estimate = 100 * field.floor.isel({COLUMN: 0}).values[known]
        band = np.array([np.minimum(estimate, y - LEAST) if is_error else estimate, estimate])
    has_estimate = band is not None and bool(np.isfinite(band).any())
    return Curve(ics_symbol(field.rows[0]), x, y, look, band if has_estimate else None)
