"""Figures of curves: panels of curves over one abscissa, C with its estimate, grids of panels."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import cycle
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from compare.report.looks import symbol_of
from compare.report.styles import (
    CHECK_STYLE,
    DASHES,
    FURTHER,
    RC,
    STYLES,
    SYMBOLS,
    Style,
    with_further,
)
from geometries.arrays import Array, Mask

INVISIBLE = 1e-9  # dimensionless IC below which a curve is shown as zero
CHECK_MARKS = 24  # about how many marks a curve of the other engine has
MOST_COLUMNS = 8  # of a legend
PANEL = 4.1, 2.9  # width and height [inch]
BAND = "C ± estimate"


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over one abscissa, arrays (n,), by their labels.

    `estimate` is the estimated error of the curve "C", drawn as a band; `check_estimate` belongs to the other
    engine's C, drawn as bars.
    """

    title: str
    across: str  # label of the abscissa
    at: Array
    up: str  # label of the ordinate
    curves: Mapping[str, Array]
    estimate: Array | None = None
    check_estimate: Array | None = None
    marks: tuple[float, ...] = ()  # abscissas of joints, dotted

    def beyond(self, at: float) -> "Panel":
        """Return the panel from an abscissa on."""
        return self.part(self.at >= at)

    def part(self, shown: Mask) -> "Panel":
        """Return the panel with a selection of its points, (n,)."""
        curves = {name: values[shown] for name, values in self.curves.items()}
        bands = (self.estimate, self.check_estimate)
        estimate, check_estimate = (None if band is None else band[shown] for band in bands)
        return replace(
            self, at=self.at[shown], curves=curves, estimate=estimate, check_estimate=check_estimate
        )


def styles_of(panels: Sequence[Panel]) -> dict[str, Style]:
    """Return a style for each label of the panels: its variant's, or one of `FURTHER` in turn."""
    labels = dict.fromkeys(label for panel in panels for label in panel.curves)
    by_symbol = {SYMBOLS.get(name, name): style for name, style in STYLES.items()}
    further = dict(zip((label for label in labels if label not in by_symbol), cycle(FURTHER), strict=False))
    return by_symbol | further


def draw(axes: Axes, panel: Panel, styles: Mapping[str, Style]) -> None:
    """Draw the curves of a panel; those first in `styles` lie on top, curves of NaN only are left out."""
    if panel.estimate is not None and "C" in panel.curves:
        c = panel.curves["C"]
        low, high = c - panel.estimate, c + panel.estimate
        axes.fill_between(panel.at, low, high, color="black", alpha=0.2, linewidth=0, label=BAND)
    order = list(styles)
    for name in sorted(panel.curves, key=order.index, reverse=True):
        values = panel.curves[name]
        if np.all(np.isnan(values)):
            continue
        if styles[name] is CHECK_STYLE:
            _draw_check(axes, panel, name, values)
        else:
            axes.plot(panel.at, values, label=name, **styles[name])


def _draw_check(axes: Axes, panel: Panel, name: str, values: Array) -> None:
    """Draw the other engine's C as marks, with bars where its estimate is given."""
    marked = slice(None, None, max(1, len(panel.at) // CHECK_MARKS))
    if panel.check_estimate is None:
        axes.plot(panel.at[marked], values[marked], label=name, **CHECK_STYLE)
        return
    bars = panel.check_estimate[marked]
    axes.errorbar(panel.at[marked], values[marked], bars, label=f"{name} ± estimate", zorder=2, **CHECK_STYLE)


def finish(axes: Axes, panel: Panel) -> None:
    """Add title, labels and joints to a panel, and show curves that vanish by symmetry as zero."""
    show_zero(axes)
    for joint in panel.marks:
        axes.axvline(joint, color="grey", linestyle=":", linewidth=1, label="_joint")
    if panel.marks:
        place = max(panel.marks), 0.02
        axes.annotate(
            " flank",
            place,
            xycoords=("data", "axes fraction"),
            fontsize=7,
            color="grey",
            ha="left",
            va="bottom",
        )
    axes.set(xlabel=panel.across, ylabel=panel.up)
    axes.set_title(panel.title, fontsize=9)


def show_zero(axes: Axes) -> None:
    """Fix the range of the ordinate where all curves vanish by symmetry, lest rounding errors fill it."""
    if max(np.max(np.abs(curve.get_ydata())) for curve in axes.get_lines()) < INVISIBLE:
        axes.set_ylim(-1e-3, 1e-3)
        axes.set_yticks([0.0])
        axes.annotate("0 by symmetry", (0.5, 0.6), xycoords="axes fraction", ha="center", color="grey")


@contextmanager
def figure_grid(
    rows: int, columns: int, each: tuple[float, float] = PANEL, **shared: Any
) -> Iterator[tuple[Figure, Any]]:
    """Yield a figure and its axes, (rows, columns), each of a size [inch]; all curves get one legend."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(each[0] * columns, each[1] * rows + 0.5), layout="constrained")
        yield figure, figure.subplots(rows, columns, squeeze=False, **shared)
        add_legend(figure)


def draw_by_ics(axes: Axes, at: xr.DataArray, values: xr.DataArray, marker_size: float = 4) -> None:
    """Draw values by ICs over an abscissa, which may differ by ICs; without markers where their size is 0."""
    names = [str(name) for name in values.ics.values]
    looks = with_further(names)
    for name in names:
        marker, look = looks[name]
        style = dict(look) | ({"marker": marker, "markersize": marker_size} if marker_size else {})
        abscissa = at.sel(ics=name) if "ics" in at.dims else at
        axes.plot(abscissa, values.sel(ics=name), label=symbol_of(name), **style)


def draw_band(axes: Axes, at: ArrayLike, low: ArrayLike, high: ArrayLike, label: str | None = None) -> None:
    """Draw the band of an estimate."""
    axes.fill_between(at, low, high, color="black", alpha=0.15, linewidth=0, label=label)


def panel_figure(panels: Sequence[Panel], columns: int, size: tuple[float, float] = PANEL) -> Figure:
    """Return a figure of panels in a number of columns, each of a size [inch], with one legend."""
    rows, styles = -(-len(panels) // columns), styles_of(panels)
    with figure_grid(rows, columns, size) as (figure, grid):
        for axes, panel in zip(grid.ravel(), panels, strict=False):
            draw(axes, panel, styles)
            finish(axes, panel)
        for axes in grid.ravel()[len(panels) :]:
            axes.remove()
    return figure


def draw_scenes(axes: Axes, panels: Mapping[Any, Panel], styles: Mapping[str, Style]) -> None:
    """Draw the panels of several scenes into the same axes; they are given by the scenes' line styles."""
    for dashes, panel in panels.items():
        draw(axes, panel, {name: {**style, "linestyle": dashes} for name, style in styles.items()})
    finish(axes, panel)


def add_scene_legends(
    figure: Figure, lengths: Mapping[str, float], styles: Mapping[str, Style], *first: Artist
) -> None:
    """Add a legend of scenes (line styles) above the panels, and one of `first` and of curves below them.

    Curves are listed from the last to the first of `styles`, as they lie on top of each other.
    `lengths` has the reference lengths [mm] by the scenes' names, in the order of `DASHES`.
    """
    curves = [Line2D([], [], label=name, **style) for name, style in reversed(list(styles.items()))]
    scenes = [
        Line2D([], [], color="dimgrey", linestyle=dashes, linewidth=1.6, label=f"{name} (L = {length:g} mm)")
        for (name, length), dashes in zip(lengths.items(), DASHES, strict=False)
    ]
    figure.legend(handles=scenes, loc="outside upper center", ncols=len(scenes), handlelength=4)
    handles = [*first, *curves]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def add_legend(figure: Figure) -> None:
    """Add one legend of all labels of a figure below it, in at most `MOST_COLUMNS` columns."""
    handles = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    columns = min(MOST_COLUMNS, len(handles))
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=columns)
