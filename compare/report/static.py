"""Charts as pictures for paper: the cells of all steps of a chart in one figure of Matplotlib.

A notebook, which explores charts, shows a frame with a page of one chart.
"""

import re
import textwrap
from dataclasses import fields, replace
from importlib import resources
from typing import Any

import matplotlib as mpl
import numpy as np
from markupsafe import escape
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke

from compare.report import interactive
from compare.report.charts import Cell, Chart, Contours, Curve, Map, Panel, Surface
from compare.report.looks import INK, Look, without_marker
from geometries.arrays import Array

# --- pictures -------------------------------------------------------------------------------------------


RC: Any = {"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 110, "svg.fonttype": "none"}
SIZE = {Panel: (4.1, 2.8), Map: (3.6, 3.0), Surface: (7.0, 4.8), Contours: (4.1, 3.9)}  # of a cell [inch]
CHOSEN_COLUMNS = 3  # of cells that were chosen
MOST_ENTRIES, ENTRIES_PER_INCH = 8, 0.7  # of a legend in a row
MARGINS = 0.95, 0.12, 0.27, 0.5  # of a panel for title, ticks, names: left, right, top, bottom [inch]
TITLE_SIZE, LETTERS_PER_INCH = 9, 13.5  # of titles: font [pt], and letters in a line
LEGEND_PADDING, LEGEND_GAP, LINE_HEIGHT = 0.2, 0.06, 0.14  # inch
HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.6, foreground="white")]  # about lines on colours
NOT_IN_XML = "[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
NOT_IN_NAMES = r"[^A-Za-z0-9.+-]"  # of files
DASHES: dict[str, Any] = {
    "": "none",
    "solid": "-",
    "dash": (0, (4, 2)),
    "dot": (0, (1.2, 2)),
    "dashdot": (0, (4, 1.5, 1, 1.5)),
    "longdash": (0, (8, 2)),
    "longdashdot": (0, (8, 2, 1, 2)),
}
MARKERS = {
    "": "",
    "square": "s",
    "circle": "o",
    "triangle-up": "^",
    "triangle-down": "v",
    "triangle-left": "<",
    "triangle-right": ">",
    "diamond": "D",
    "diamond-tall": "d",
    "star": "*",
    "cross": "P",
    "hexagon": "h",
    "pentagon": "p",
    "octagon": "8",
    "x": "x",
}
COLOURS = {"sequential": "viridis", "diverging": "RdBu_r", "logarithmic": "RdBu_r", "positive": "YlOrRd"}


def pictures(chart: Chart) -> dict[str, Figure]:
    """Return the figures of a chart by their names: one, or one per step where a step has several rows.

    Names have the letters that names of files may have; they are numbered where they would be the same.
    """
    chart = _without_choice(chart)
    if len(chart.steps) == 1 or all(len(cells) <= chart.columns for cells in chart.steps.values()):
        return {chart.name: picture(chart)}
    names = [f"{chart.name}_{re.sub(NOT_IN_NAMES, '', step)}" for step in chart.steps]
    names = [name if names.count(name) == 1 else f"{name}_{k + 1}" for k, name in enumerate(names)]
    return {
        name: picture(replace(chart, steps={step: cells}, start=""))
        for name, (step, cells) in zip(names, chart.steps.items(), strict=True)
    }


def _without_choice(chart: Chart) -> Chart:
    """Return a chart with the first of the cells to choose from, steps side by side."""
    if not chart.choice:
        return chart
    first = {step: cells[:1] for step, cells in chart.steps.items()}
    return replace(chart, steps=first, columns=CHOSEN_COLUMNS, choice="")


def picture(chart: Chart) -> Figure:
    """Return the figure of a chart: the cells of all steps, a row or more per step, and one legend.

    Steps of a single cell stand side by side.
    """
    chart = _plain(_without_choice(chart))
    groups = [[(step, cell) for cell in cells] for step, cells in chart.steps.items()]
    if all(len(cells) == 1 for cells in groups):
        groups = [[pair for group in groups for pair in group]]
    rows = [group[k : k + chart.columns] for group in groups for k in range(0, len(group), chart.columns)]
    sizes = [SIZE[type(cell)] for cell in chart.cells]
    width, height = (max(size[k] for size in sizes) for k in (0, 1))
    columns = max(len(row) for row in rows)
    with mpl.rc_context(RC):
        figure = Figure((width * columns, height * chart.heights * len(rows) + 0.5))
        grid = figure.subplots(len(rows), columns, squeeze=False)
        for axes_row, row in zip(grid, rows, strict=True):
            for axes in axes_row[len(row) :]:
                axes.remove()
            for axes, (step, cell) in zip(axes_row, row, strict=False):
                _draw(figure, axes, cell, step)
        lines = any(isinstance(cell, Panel) for cell in chart.cells)
        handles = [
            Line2D([], [], label=label, **line_style(look if lines else without_marker(look)))
            for label, look in chart.legend.items()
        ]
        if handles:
            legend_columns = _legend_columns(figure, len(handles))
            figure.legend(handles=handles, loc="outside lower center", ncols=legend_columns)
        lay_out(figure, chart)
    return figure


def _plain(part: Any) -> Any:
    """Return a chart, or a part of it, whose texts Matplotlib shows as they are: $ begins no formula."""
    if isinstance(part, str):
        return re.sub(NOT_IN_XML, "\N{REPLACEMENT CHARACTER}", part).replace("$", r"\$")
    if isinstance(part, list | tuple):
        return [*map(_plain, part)]
    if isinstance(part, dict):
        return {_plain(key): _plain(value) for key, value in part.items()}
    if isinstance(part, Chart | Cell | Curve):
        return replace(part, **{field.name: _plain(getattr(part, field.name)) for field in fields(part)})
    return part


def lay_out(figure: Figure, chart: Chart) -> None:
    """Make room for what stands around axes.

    Around panels its size is known: each has its margins, and the legend its rows. Around other cells it is
    measured, which takes as long as drawing does; and only once: an engine of the figure would do so at each
    drawing.
    """
    if not all(isinstance(cell, Panel) and not (cell.names_x or cell.names_y) for cell in chart.cells):
        ConstrainedLayoutEngine().execute(figure)
        return
    (width, height), (left, right, top, bottom) = figure.get_size_inches(), MARGINS
    specification = figure.axes[0].get_subplotspec()
    assert specification is not None
    rows, columns = specification.get_gridspec().get_geometry()
    below = bottom
    if chart.legend:
        legend_rows = -(-len(chart.legend) // _legend_columns(figure, len(chart.legend)))
        lines = max(label.count("\n") + 1 for label in chart.legend)
        below += LEGEND_PADDING + legend_rows * (LEGEND_GAP + lines * LINE_HEIGHT)
    above = top + LINE_HEIGHT * max(axes.get_title().count("\n") for axes in figure.axes)
    panel_width = width / columns - left - right
    panel_height = (height - below + bottom) / rows - above - bottom
    figure.subplots_adjust(
        left / width,
        below / height,
        1 - right / width,
        1 - above / height,
        (left + right) / panel_width,
        (above + bottom) / panel_height,
    )


def _legend_columns(figure: Figure, entries: int) -> int:
    return min(MOST_ENTRIES, entries, round(ENTRIES_PER_INCH * figure.get_figwidth()))


def _draw(figure: Figure, axes: Axes, cell: Cell, step: str) -> None:
    title_height = 1.0 if isinstance(cell, Panel) else None  # None: measured at each drawing
    title = ", ".join(filter(None, (step, cell.title)))
    letters = int(LETTERS_PER_INCH * (SIZE[type(cell)][0] - MARGINS[0]))
    lines = (textwrap.fill(line, letters) for line in title.splitlines())
    axes.set_title("\n".join(lines), fontsize=TITLE_SIZE, y=title_height)
    axes.yaxis.get_offset_text().set_horizontalalignment("right")  # beside the title
    if isinstance(cell, Surface):
        _draw_surface(figure, axes, cell)
        return
    axes.set(xlabel=cell.across, ylabel=cell.up)
    if isinstance(cell, Map):
        _draw_map(figure, axes, cell)
    elif isinstance(cell, Contours):
        _draw_contours(figure, axes, cell)
    else:
        draw_panel(axes, cell)


def _draw_surface(figure: Figure, axes: Axes, surface: Surface) -> None:
    """Draw the picture of a surface, or else the values upon the body in 3D."""
    if surface.picture is not None:
        axes.imshow(mpl.image.imread(surface.picture))
        axes.set_axis_off()
        return
    space: Any = figure.add_subplot(axes.get_subplotspec(), projection="3d", computed_zorder=False)
    space.set_title(axes.get_title(), fontsize=TITLE_SIZE)
    axes.remove()
    norm = Normalize(np.nanmin(surface.values), np.nanmax(surface.values))
    colours = mpl.colormaps[COLOURS["sequential"]](norm(surface.values))
    part = [np.where(np.isnan(surface.values), np.nan, points) for points in surface.part]
    fine = {"rcount": 200, "ccount": 200, "rasterized": True}
    space.plot_surface(*surface.body, color="lightgrey", zorder=1, **fine)
    space.plot_surface(*part, facecolors=colours, shade=False, zorder=2, **fine)
    space.set_aspect("equal")
    space.view_init(elev=35, azim=-135)
    space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    figure.colorbar(
        ScalarMappable(norm, COLOURS["sequential"]),
        ax=space,
        label=surface.unit,
        shrink=0.6,
        use_gridspec=False,
    )


def draw_panel(axes: Axes, panel: Panel) -> None:
    """Draw the curves of a panel, without title and names of axes."""
    for curve in panel.curves:
        _draw_curve(axes, curve)
    for mark in panel.marks:
        axes.axvline(mark, color="grey", linestyle=":", linewidth=1)
    for level in panel.levels:
        axes.axhline(level, color="grey", linestyle=":", linewidth=1)
    _scale(axes, panel)
    axes.set(xlim=panel.limits_x, ylim=panel.limits_y)
    if panel.to_scale:
        axes.set_aspect("equal")
    if panel.vanishes:
        axes.set_ylim(-panel.least, panel.least)
        axes.set_yticks([0.0])
        axes.annotate("0 by symmetry", (0.5, 0.6), xycoords="axes fraction", ha="center", color="grey")


def _scale(axes: Axes, cell: Panel | Map) -> None:
    """Give axes logarithmic scales, or the names of places."""
    if cell.log_x:
        axes.set_xscale("log")
    if cell.log_y:
        axes.set_yscale("log")
    if cell.names_x:
        axes.set_xticks(range(len(cell.names_x)), cell.names_x, rotation=30, ha="right")
    if cell.names_y:
        axes.set_yticks(range(len(cell.names_y)), cell.names_y)


def _draw_curve(axes: Axes, curve: Curve) -> list[Line2D]:
    x, y = curve.points
    style = line_style(curve.drawn_look)
    if curve.band is not None and curve.bars:
        low, high = curve.band_edges
        axes.errorbar(x, y, (y - low, high - y), fmt="none", ecolor=style["color"], elinewidth=0.8, capsize=2)
    elif curve.band is not None:
        axes.fill_between(x, *curve.band_edges, color=style["color"], alpha=0.2, linewidth=0)
    for name, side, point in zip(curve.names, curve.sides, zip(x, y, strict=True), strict=False):
        beside = (3, 3 if side == "top" else -8)
        axes.annotate(name, point, beside, textcoords="offset points", fontsize=7)
    return axes.plot(x, y, label=curve.label, **style)


def line_style(look: Look) -> dict[str, Any]:
    """Return a look as the keywords of a line of Matplotlib."""
    return {
        "color": "black" if look.colour == INK else look.colour,
        "linestyle": DASHES[look.dash],
        "linewidth": 0.8 * look.width,
        "marker": MARKERS[look.marker.removesuffix("-open")],
        "markersize": 4,
        **({"markerfacecolor": "white"} if look.marker.endswith("-open") else {}),
    }


def _draw_map(figure: Figure, axes: Axes, drawn: Map) -> None:
    axes.grid(visible=False)
    low, high = drawn.range
    masked = np.ma.masked_invalid(drawn.values.T)
    ticks: dict[str, Any] = {}
    style: dict[str, Any] = {"cmap": COLOURS[drawn.scale], "norm": Normalize(low, high)}
    if drawn.classes:
        count = len(drawn.classes)
        style = {"cmap": ListedColormap(drawn.colours[:count]), "norm": Normalize(-0.5, count - 0.5)}
        ticks = {"ticks": range(count), "format": lambda value, _: drawn.classes[round(value)]}
    elif drawn.scale == "logarithmic":
        least = high / 10**drawn.decades
        powers = 10.0 ** np.arange(np.ceil(np.log10(least)), np.floor(np.log10(high)) + 1)
        style["norm"] = SymLogNorm(least, vmin=low, vmax=high)
        ticks = {"ticks": np.concatenate([-powers[::-1], [0.0], powers])}
    elif drawn.scale == "positive":
        masked = np.ma.masked_invalid(np.maximum(drawn.values.T, low))
        style["norm"], ticks = LogNorm(low, high), {"format": "%g"}
    edges = _edges(drawn.x, log=drawn.log_x), _edges(drawn.y, log=drawn.log_y)
    shades = axes.pcolormesh(*edges, masked, rasterized=True, **style)
    _scale(axes, drawn)
    bar = figure.colorbar(shades, ax=axes, label=drawn.unit, use_gridspec=False, **ticks)
    if drawn.scale == "logarithmic":
        bar.minorticks_off()
    for curve in drawn.curves:
        for line in _draw_curve(axes, curve):
            line.set_path_effects(HALO)
    if drawn.to_scale:
        axes.set_aspect("equal")


def _draw_contours(figure: Figure, axes: Axes, contours: Contours) -> None:
    levels, colours = contours.levels, ListedColormap(contours.colours)
    norm = BoundaryNorm(levels, len(levels) - 1)
    for (across, up), values in contours.regions:
        axes.contourf(
            across, up, np.ma.masked_invalid(values), levels=levels, cmap=colours, norm=norm
        ).set_rasterized(True)
    for curve in contours.curves:
        _draw_curve(axes, curve)
    shades = ScalarMappable(norm, colours)
    figure.colorbar(shades, ax=axes, label=contours.unit, ticks=levels[::2], shrink=0.8, use_gridspec=False)
    axes.set_aspect("equal")


def _edges(at: Array, *, log: bool) -> Array:
    """Return the edges of cells around their places, (n + 1,): half way between, or by ratio."""
    if log:
        return np.asarray(np.exp(_edges(np.log(at), log=False)))
    if len(at) == 1:
        return np.array([at[0] - 0.5, at[0] + 0.5])
    middles = (at[1:] + at[:-1]) / 2
    return np.array([2 * at[0] - middles[0], *middles, 2 * at[-1] - middles[-1]])


# --- notebooks ------------------------------------------------------------------------------------------


ROOM = 90  # of slider, legend and titles [px]


def in_a_frame(chart: Chart) -> str:
    """Return a chart as HTML that stands for itself, without a network."""
    templates = resources.files("compare.report") / "templates"
    style, script = ((templates / name).read_text(encoding="utf-8") for name in ("style.css", "explore.js"))
    page = (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><style>{style}</style></head><body>'
        f'<div class="chart"><script type="application/json">{interactive.as_json(chart)}</script></div>'
        f"{interactive.libraries([chart])}<script>{script}</script></body></html>"
    )
    rows = max(-(-len(cells) // chart.columns) for cells in chart.steps.values())
    height = ROOM + rows * (interactive.cell_height(chart) + 24)
    style = f"width: 100%; height: {height}px; border: 0"
    return f'<iframe title="{escape(chart.name)}" style="{style}" srcdoc="{escape(page)}"></iframe>'
