"""The figure of a statement: its curves, and how far each of its numbers is from its threshold."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.figures import CHECK, CHECK_MARKS, STYLE, STYLES, SYMBOLS, show_zero
from compare.validation.curves import Panel
from compare.validation.verdicts import Judged

FURTHER: tuple[Mapping[str, Any], ...] = (
    {"color": "tab:cyan", "linewidth": 1.4},
    {"color": "tab:pink", "linewidth": 1.4, "linestyle": (0, (4, 1))},
    {"color": "tab:olive", "linewidth": 1.4, "linestyle": (0, (1, 1))},
    {"color": "tab:gray", "linewidth": 1.4, "linestyle": (0, (5, 1, 1, 1))},
    {"color": "black", "linewidth": 1.4},
    {"color": "tab:red", "linewidth": 1.4, "linestyle": (0, (3, 1))},
)
BY_SYMBOL: dict[str, Mapping[str, Any]] = {SYMBOLS.get(name, name): style for name, style in STYLES.items()}
MET, UNMET = "tab:green", "tab:red"


def curves(judged: Judged) -> Figure:
    """All panels of a statement."""
    panels = judged.measured.panels
    columns = judged.measured.columns
    rows = -(-len(panels) // columns)
    styles = _styles(panels)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.1 * columns, 2.9 * rows + 0.5), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, panel in zip(grid, panels, strict=False):
            _draw(axes, panel, styles)
        for axes in grid[len(panels) :]:
            axes.remove()
        handles = {
            label: handle
            for axes in grid[: len(panels)]
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        figure.legend(
            list(handles.values()), list(handles), loc="outside lower center", ncols=min(6, len(handles))
        )
        return figure


def _styles(panels: Sequence[Panel]) -> dict[str, Mapping[str, Any]]:
    """A style for each name in a figure: that of the variant, or a further one."""
    names = dict.fromkeys(name for panel in panels for name in panel.curves)
    further = [name for name in names if name not in BY_SYMBOL and name != SYMBOLS["C_solid"]]
    return BY_SYMBOL | dict(zip(further, cycle(FURTHER), strict=False))


def _draw(axes: Axes, panel: Panel, styles: Mapping[str, Mapping[str, Any]]) -> None:
    if panel.estimate is not None:
        c = panel.curves["C"]
        low, high = c - panel.estimate, c + panel.estimate
        axes.fill_between(panel.at, low, high, color="black", alpha=0.2, linewidth=0, label="C ± estimate")
    for name, values in panel.curves.items():
        if name == SYMBOLS["C_solid"]:
            marked = slice(None, None, max(1, 2 * len(panel.at) // CHECK_MARKS))
            axes.plot(panel.at[marked], values[marked], label=name, **CHECK)
        else:
            axes.plot(panel.at, values, label=name, **styles[name])
    show_zero(axes)
    axes.set(xlabel=panel.across, ylabel=panel.up)
    axes.set_title(panel.title, fontsize=9)


def numbers(judged: Judged) -> Figure:
    """Every number beside its threshold, on a scale of its own for each criterion."""
    criteria = judged.statement.criteria
    values = judged.measured.values
    heights = [len(values[criterion.name]) + 1.6 for criterion in criteria]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 0.24 * sum(heights) + 0.4), layout="constrained")
        grid = figure.subplots(len(criteria), 1, squeeze=False, height_ratios=heights)[:, 0]
        for axes, criterion in zip(grid, criteria, strict=True):
            found = values[criterion.name]
            at = np.arange(len(found))
            colours = [MET if criterion.met(value) else UNMET for value in found.values()]
            axes.barh(at, list(found.values()), color=colours, height=0.6)
            axes.axvline(criterion.threshold, color="black", linewidth=1.2, linestyle="--")
            axes.set_yticks(at, list(found), fontsize=7)
            title = f"{criterion.says}: {criterion.relation} {criterion.threshold:.3g}"
            axes.set_title(title, fontsize=8, loc="left")
            axes.tick_params(axis="x", labelsize=7)
            axes.set_ylim(len(found) - 0.4, -0.6)
            axes.margins(x=0.08)
        return figure
