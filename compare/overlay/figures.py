"""Figures of an overlay: one component of several scenes (matplotlib)."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from compare.figures import STYLE, STYLES, SYMBOLS, show_zero
from compare.overlay.curves import Curve, Overlay, Result, curve, is_mirrored

DRAWN = ("A", "B", "Bhat")  # the others stay in the tables
LINE_STYLES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1.3, 1.2)), (0, (5, 1.2, 1, 1.2)), (0, (9, 2)))
WIDTHS = {"C": 2.4, "A": 2.2, "B": 1.6, "Bbar": 1.3, "Bhat": 1.0}  # wide to narrow, back to front


def drawn_variants(overlay: Overlay) -> tuple[str, ...]:
    """The variants that figures show: few enough to tell apart, and whatever there is otherwise."""
    common = overlay.common.variants
    return ("C", *(tuple(variant for variant in common if variant in DRAWN) or common))


def curves(overlay: Overlay, component: str) -> Figure:
    """One component of all scenes along every line (columns) for every body (rows), dimensionless."""
    bodies, lines = overlay.common.bodies, overlay.common.lines
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.1 * len(lines), 2.7 * len(bodies) + 1.1), layout="constrained")
        grid = figure.subplots(len(bodies), len(lines), squeeze=False)
        for c, line in enumerate(lines):
            half = is_mirrored(overlay, line)
            for r, body in enumerate(bodies):
                drawn = [curve(result, line, body, component) for result in overlay.results]
                _draw_panel(grid[r, c], drawn, drawn_variants(overlay), half=half)
            grid[0, c].set_title(f"{component} on {line}")
            grid[-1, c].set_xlabel(f"{drawn[0].along} / L  [-]")
        for axes, body in zip(grid[:, 0], bodies, strict=True):
            axes.set_ylabel(f"{body}\nIC · E · L  [-]")
        _add_legends(figure, overlay)
        return figure


def _draw_panel(axes: Axes, drawn: Sequence[Curve], variants: Sequence[str], *, half: bool) -> None:
    for one, linestyle in zip(drawn, LINE_STYLES[: len(drawn)], strict=True):
        shown = one.at >= (0 if half else -np.inf)
        at, c, band = one.at[shown], one.values["C"][shown], one.estimate[shown]
        axes.fill_between(at, c - band, c + band, color="black", alpha=0.2, linewidth=0)
        for variant in variants:
            axes.plot(at, one.values[variant][shown], **_style(variant) | {"linestyle": linestyle})
    show_zero(axes)


def _style(variant: str) -> dict[str, Any]:
    """Curves that coincide stay visible: the narrow ones on top."""
    return {
        "color": STYLES[variant]["color"],
        "linewidth": WIDTHS[variant],
        "zorder": 4 - WIDTHS[variant] / 2,
    }


def _add_legends(figure: Figure, overlay: Overlay) -> None:
    """Scenes by line style above the panels, variants by colour below them."""
    styles = LINE_STYLES[: len(overlay.results)]
    scenes = [
        Line2D([], [], color="dimgrey", linestyle=linestyle, linewidth=1.6, label=_label(result))
        for result, linestyle in zip(overlay.results, styles, strict=True)
    ]
    colours = [
        Line2D([], [], label=SYMBOLS[variant], **_style(variant)) for variant in drawn_variants(overlay)
    ]
    band = Patch(color="black", alpha=0.2, linewidth=0, label="C ± estimate")
    figure.legend(handles=scenes, loc="outside upper center", ncols=len(scenes), handlelength=4)
    figure.legend(handles=[band, *colours], loc="outside lower center", ncols=1 + len(colours))


def _label(result: Result) -> str:
    return f"{result.name} (L = {result.reference_length:g} mm)"
