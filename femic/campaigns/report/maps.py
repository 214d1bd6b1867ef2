"""Maps over two axes of a campaign: a coloured cell per scene, contour lines, crosses for failures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from textwrap import fill

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import AbstractPathEffect, withStroke

from compare.report.styles import RC
from femic.campaigns.report.axes import ShownAxis
from femic.campaigns.report.crossings import exceeded
from femic.campaigns.report.fields import COLUMN, ROW, Field
from femic.campaigns.report.scales import ColourScale, scale_of
from geometries.arrays import Array, Mask

COLUMNS = 5  # maps beside each other
PANEL = (2.55, 2.1)  # inches
LETTERS = 26  # letters along the height of a map
MOST_NUMBERS = 25  # cells of a map of two axes of text that have their number written in
HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.0, foreground="white")]
BAR = 4.0  # height of a bar of colours, inches
MOST = 0.7  # share of known scenes from which on lines are drawn
STRONG = 0.05  # level whose line is thicker
STRIP = ShownAxis("", "", np.array([""]))  # up, where there is one axis only


@dataclass(frozen=True, eq=False)
class Plane:
    """The two axes of maps, or the only axis and `STRIP`, and the failed scenes."""

    across: ShownAxis
    up: ShownAxis
    failing: xr.DataArray

    @classmethod
    def of(cls, axes: Sequence[ShownAxis], failed: xr.DataArray) -> "Plane":
        """Return the plane of the first axes; a failure is one at all places of further axes."""
        further = [axis.name for axis in axes[2:] if axis.name in failed.dims]
        return cls(axes[0], axes[1] if len(axes) > 1 else STRIP, failed.all(further))

    @property
    def failed(self) -> Mask:
        """The failed scenes, (n_across, n_up)."""
        return np.asarray(self.over(self.failing), dtype=bool)

    def over(self, values: xr.DataArray) -> Array:
        """Return numbers over the plane, (n_across, n_up)."""
        in_order = values.transpose(self.across.name, *([] if self.up is STRIP else [self.up.name]))
        return np.asarray(in_order.values.reshape(len(self.across.values), len(self.up.values)))


@dataclass(frozen=True, eq=False)
class MapRow:
    """A row of maps: its label, a field of one row, a map for each of its columns, and their plane."""

    label: str
    field: Field
    plane: Plane

    def values(self, column: str) -> Array:
        """Return the numbers of a map, (n_across, n_up)."""
        return self.plane.over(self.field.values.sel({COLUMN: column}).isel({ROW: 0}))


def maps(rows: Sequence[MapRow]) -> Iterator[Figure]:
    """Yield figures of maps, row by row; several figures where there are many columns."""
    columns = rows[0].field.columns
    for part in np.array_split(columns, -(-len(columns) // COLUMNS)):
        yield _figure(rows, part.tolist())


def _figure(rows: Sequence[MapRow], columns: list[str]) -> Figure:
    """Return one figure; values have a scale per column, other numbers a common scale."""
    first = rows[0]
    common = first.field.rates_ics
    scales = {
        column: scale_of(first.field.kind, np.array([row.values(column) for row in rows]))
        for column in columns
    }
    with mpl.rc_context(RC | {"axes.grid": False, "hatch.linewidth": 0.5}):
        size = (PANEL[0] * len(columns) + 1.1, PANEL[1] * len(rows) + (0.6 if common else 1.1))
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(rows), len(columns), squeeze=False, sharex=True, sharey=True)
        for line, row in zip(panels, rows, strict=True):
            for axes, column in zip(line, columns, strict=True):
                _draw_map(axes, row.values(column), row.plane, scales[column])
            line[0].set_ylabel(row.label)
        for column, axes in zip(columns, panels.T, strict=True):
            axes[0].set_title(column, fontsize=9)
            axes[-1].set_xlabel(first.plane.across.wrapped)
            if not common:
                _bar(figure, axes, scales[column])
        if common:
            _bar(figure, panels, scales[columns[0]], first.field.kind)
        figure.supylabel(fill(first.plane.up.heading, int(LETTERS * len(rows))), fontsize=9)
        gaps = gap_handles(
            [row.plane for row in rows], [row.values(name) for row in rows for name in columns]
        )
        if gaps:
            figure.legend(handles=gaps, loc="outside lower left", ncols=2)
        return figure


def _draw_map(axes: Axes, values: Array, plane: Plane, scale: ColourScale) -> None:
    """Draw a map: a cell for each scene, lines where levels are exceeded; numbers if both axes are text."""
    draw_cells(axes, values, plane, scale)
    across, up = plane.across, plane.up
    if across.is_number and up.is_number and min(values.shape) > 1:
        _contours(axes, values, plane, scale)
    elif across.is_number or up.is_number:
        if scale.is_share:
            _marks(axes, values, plane)
    elif values.size <= MOST_NUMBERS:
        for (k, m), value in np.ndenumerate(values):
            if np.isfinite(value):
                place = float(across.at[k]), float(up.at[m])
                text = axes.text(*place, scale.text(value), ha="center", va="center", fontsize=7)
                text.set_path_effects(HALO)


def _marks(axes: Axes, numbers: Array, plane: Plane) -> None:
    """Draw, for each category of one axis, where `STRONG` is exceeded along the other axis."""
    across, up = plane.across, plane.up
    axis, categories = (across, up) if across.is_number else (up, across)
    lines, draw = (numbers.T, axes.vlines) if across.is_number else (numbers, axes.hlines)
    for place, values in zip(categories.at, abs(lines), strict=True):
        ends = [end for part in exceeded(axis.at, values, STRONG) for end in (part.start, part.end)]
        known = [end for end in ends if end is not None]
        draw(known, place - 0.5, place + 0.5, colors="black", linewidths=1.7)


def draw_cells(axes: Axes, values: Array, plane: Plane, scale: ColourScale) -> None:
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


def _contours(axes: Axes, numbers: Array, plane: Plane, scale: ColourScale) -> None:
    """Draw contour lines where most scenes are known."""
    values = np.ma.masked_invalid(numbers)
    if values.count() < max(4, MOST * values.size):
        return
    margin = 0 if scale.is_share else 0.03 * np.ptp(values)
    inside = [level for level in scale.contours if values.min() + margin < level < values.max() - margin]
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
    for text in axes.clabel(lines, fmt=scale.text, fontsize=7, inline_spacing=2):
        text.set_path_effects(HALO)


def _bar(figure: Figure, panels: np.ndarray, scale: ColourScale, label: str = "") -> None:
    where = "right" if scale.is_share else "bottom"
    bar = figure.colorbar(
        ScalarMappable(scale.norm, scale.colours),
        ax=panels,
        location=where,
        extend="both" if scale.is_share else "neither",
        shrink=min(0.95, BAR / (PANEL[1] * len(panels))) if scale.is_share else 0.9,
        aspect=25,
        ticks=scale.ticks or None,
        label=label,
    )
    if scale.ticks:
        bar.ax.set_yticks(scale.ticks, [scale.text(tick) for tick in scale.ticks])


def gap_handles(planes: Sequence[Plane], shown: Sequence[Array]) -> list[Artist]:
    """Return legend entries of crosses and hatches, where there are any."""
    handles: list[Artist] = []
    if any(np.any(plane.failed) for plane in planes):
        handles.append(Line2D([], [], marker="x", color="black", linestyle="none", label="failed"))
    if any(np.any(np.isnan(values)) for values in shown):
        handles.append(Patch(facecolor="white", edgecolor="0.6", hatch="/////", label="not known"))
    return handles
