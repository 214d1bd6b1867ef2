"""Maps over two axes of a campaign: colours of each scene, contour lines between them, failures crossed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import AbstractPathEffect, withStroke

from compare.pages.styles import RC
from compare.reports.sweep.axes import ShownAxis
from compare.reports.sweep.crossings import exceeded
from compare.reports.sweep.fields import COLUMN, ROW, Field, label_of
from compare.reports.sweep.scales import Scale, scale_of
from geometries.arrays import Array, Mask

COLUMNS = 5  # maps beside each other
PANEL = (2.55, 2.1)  # inches
MOST_NUMBERS = 25  # cells of a map of two axes of text that have their number written in
HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.0, foreground="white")]
BAR = 4.0  # height of a bar of colours, inches
STRONG = 0.05  # level whose line is thicker


@dataclass(frozen=True, eq=False)
class Plane:
    """The two axes of maps, and where scenes have failed, (n_across, n_up)."""

    across: ShownAxis
    up: ShownAxis
    failed: Mask


@dataclass(frozen=True, eq=False)
class Shown:
    """The numbers of a map, (n_across, n_up), its scale, and whether contour lines are drawn."""

    values: Array
    scale: Scale


def maps(
    field: Field, plane: Plane, by_row: Sequence[tuple[str, Field, Plane]] | None = None
) -> Iterator[Figure]:
    """Yield figures of maps, a row for each row of a field, or for each of `by_row`; a column per column.

    A field with many columns has several figures.
    """
    rows = list(by_row or [(label_of(name), field.of(rows=[name]), plane) for name in field.rows])
    for columns in _parted(field.columns):
        yield _figure(field.of(columns=columns), rows, columns)


def _figure(field: Field, rows: Sequence[tuple[str, Field, Plane]], columns: list[str]) -> Figure:
    """One figure; values have a scale per column, other numbers a common one."""
    common = field.kind != "value"
    scales = {
        column: scale_of(field.kind, np.array([_values(one, column, plane) for _, one, plane in rows]))
        for column in columns
    }
    with mpl.rc_context(RC | {"axes.grid": False, "hatch.linewidth": 0.5}):
        size = (PANEL[0] * len(columns) + 1.1, PANEL[1] * len(rows) + (0.6 if common else 1.1))
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(rows), len(columns), squeeze=False, sharex=True, sharey=True)
        for line, (label, one, plane) in zip(panels, rows, strict=True):
            for axes, column in zip(line, columns, strict=True):
                draw_map(axes, Shown(_values(one, column, plane), scales[column]), plane)
            line[0].set_ylabel(label)
        for column, axes in zip(columns, panels.T, strict=True):
            axes[0].set_title(column, fontsize=9)
            axes[-1].set_xlabel(rows[-1][2].across.wrapped)
            if not common:
                _bar(figure, axes, scales[column])
        if common:
            _bar(figure, panels, scales[columns[0]])
        figure.supylabel(rows[0][2].up.heading, fontsize=9)
        gaps = of_gaps([plane for *_, plane in rows], [_values(*of) for of in _each(rows, columns)])
        if gaps:
            figure.legend(handles=gaps, loc="outside lower left", ncols=2)
        return figure


def _each(rows: Sequence[tuple[str, Field, Plane]], columns: list[str]) -> Iterator[tuple[Field, str, Plane]]:
    for _, one, plane in rows:
        for column in columns:
            yield one, column, plane


def draw_map(axes: Axes, shown: Shown, plane: Plane) -> None:
    """Draw a map: a cell for each scene, lines where levels are exceeded; numbers if both axes are text."""
    scale, values = shown.scale, shown.values
    draw_cells(axes, values, plane, scale)
    across, up = plane.across, plane.up
    if across.is_number and up.is_number and min(values.shape) > 1:
        _contours(axes, shown, plane)
    elif across.is_number or up.is_number:
        _marks(axes, shown, plane)
    elif values.size <= MOST_NUMBERS:
        for (k, m), value in np.ndenumerate(values):
            if np.isfinite(value):
                place = float(across.at[k]), float(up.at[m])
                text = axes.text(*place, scale.text(value), ha="center", va="center", fontsize=7)
                text.set_path_effects(HALO)


def _marks(axes: Axes, shown: Shown, plane: Plane) -> None:
    """Draw, for each category of the one axis, where levels are exceeded along the other one."""
    along_across = plane.across.is_number
    axis, categories = (plane.across, plane.up) if along_across else (plane.up, plane.across)
    lines = shown.values.T if along_across else shown.values
    draw = axes.vlines if along_across else axes.hlines
    for place, values in zip(categories.at, lines, strict=True):
        for level in shown.scale.contours:
            ends = [end for one in exceeded(axis.at, values, level) for end in (one.start, one.end)]
            found = [end for end in ends if end is not None]
            width = 1.7 if abs(level) == STRONG else 0.8
            draw(found, place - 0.5, place + 0.5, colors="black", linewidths=width)


def draw_cells(axes: Axes, values: Array, plane: Plane, scale: Scale) -> None:
    """Draw a cell for each scene; the picture ends at the outermost values of axes of numbers."""
    across, up = plane.across, plane.up
    axes.patch.set(facecolor="white", edgecolor="0.75", hatch="/////")
    axes.pcolormesh(
        across.edges,
        up.edges,
        np.ma.masked_invalid(values).T,
        norm=scale.norm,
        cmap=scale.colours,
        rasterized=True,
    )
    for which, axis, limit in (("x", across, axes.set_xlim), ("y", up, axes.set_ylim)):
        axis.scale(axes, which)
        inside = axis.is_number and len(axis.values) > 2
        limit(*((axis.at[0], axis.at[-1]) if inside else (axis.edges[0], axis.edges[-1])))
    k, m = np.nonzero(plane.failed)
    size = 5 if plane.failed.size <= 400 else 2
    if len(k):
        axes.plot(across.at[k], up.at[m], "x", color="black", markersize=size, clip_on=False, zorder=5)


def _contours(axes: Axes, shown: Shown, plane: Plane) -> None:
    values = np.ma.masked_invalid(shown.values)
    if values.count() < 4:
        return
    margin = 0 if shown.scale.is_share else 0.03 * np.ptp(values)
    inside = [
        level for level in shown.scale.contours if values.min() + margin < level < values.max() - margin
    ]
    if not inside:
        return
    widths = [1.7 if abs(level) == STRONG else 0.8 for level in inside]
    lines = axes.contour(
        plane.across.at,
        plane.up.at,
        values.T,
        levels=inside,
        colors="black",
        linewidths=widths,
        linestyles="-",
    )
    for text in axes.clabel(lines, fmt=shown.scale.text, fontsize=7, inline_spacing=2):
        text.set_path_effects(HALO)


def _bar(figure: Figure, panels: np.ndarray, scale: Scale) -> None:
    where = "right" if scale.is_share else "bottom"
    bar = figure.colorbar(
        ScalarMappable(scale.norm, scale.colours),
        ax=panels,
        location=where,
        extend=scale.extend,
        shrink=min(0.95, BAR / (PANEL[1] * len(panels))) if scale.is_share else 0.9,
        aspect=25,
        ticks=scale.ticks,
        label=scale.label,
    )
    if scale.ticks is not None:
        bar.ax.set_yticks(scale.ticks, [scale.text(tick) for tick in scale.ticks])


def of_gaps(planes: Sequence[Plane], shown: Sequence[Array]) -> list[Artist]:
    """What crosses and hatches mean, for a legend, where there are some."""
    handles: list[Artist] = []
    if any(np.any(plane.failed) for plane in planes):
        handles.append(Line2D([], [], marker="x", color="black", linestyle="none", label="failed"))
    if any(np.any(np.isnan(values)) for values in shown):
        handles.append(Patch(facecolor="white", edgecolor="0.6", hatch="/////", label="no number"))
    return handles


def _values(field: Field, column: str, plane: Plane) -> Array:
    """The numbers of a column of a field that has one row, (n_across, n_up)."""
    values = field.values.sel({COLUMN: column}).isel({ROW: 0})
    return np.asarray(values.transpose(plane.across.name, plane.up.name).values)


def _parted(columns: list[str]) -> list[list[str]]:
    """Columns in groups of at most `COLUMNS`, about equally many."""
    count = -(-len(columns) // COLUMNS)
    size = -(-len(columns) // count)
    return [columns[start : start + size] for start in range(0, len(columns), size)]
