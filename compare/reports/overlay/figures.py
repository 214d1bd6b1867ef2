"""Figures of an overlay: one component of several scenes (matplotlib)."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from compare.pages.panels import BAND, Panel, draw, finish
from compare.pages.styles import DASHES, RC, STYLES, SYMBOLS, Style
from compare.reports.overlay.curves import Curve, Overlay, Result, curve, is_mirrored

DRAWN = ("A", "B", "Bhat")  # the others stay in the tables
WIDE, NARROW = 2.4, 0.9  # lines, back to front: what coincides stays visible


def drawn_variants(overlay: Overlay) -> tuple[str, ...]:
    """The variants that figures show: few enough to tell apart, and whatever there is otherwise."""
    common = overlay.common.variants
    return ("C", *(tuple(variant for variant in common if variant in DRAWN) or common))


def curves(overlay: Overlay, component: str) -> Figure:
    """One component of all scenes along every line (columns) for every body (rows), dimensionless."""
    bodies, lines, styles = overlay.common.bodies, overlay.common.lines, _styles(overlay)
    with mpl.rc_context(RC):
        figure = Figure(figsize=(4.1 * len(lines), 2.7 * len(bodies) + 1.1), layout="constrained")
        grid = figure.subplots(len(bodies), len(lines), squeeze=False)
        for c, line in enumerate(lines):
            half = is_mirrored(overlay, line)
            for r, body in enumerate(bodies):
                of_scenes = [curve(result, line, body, component) for result in overlay.results]
                title = f"{component} on {line}" if r == 0 else ""
                across = f"{of_scenes[0].along} / L  [-]" if r == len(bodies) - 1 else ""
                up = f"{body}\nIC · E · L  [-]" if c == 0 else ""
                panels = [_panel(one, styles, half=half).labelled(title, across, up) for one in of_scenes]
                _draw_panel(grid[r, c], panels, styles)
        _add_legends(figure, overlay)
        return figure


def _draw_panel(axes: Axes, panels: Sequence[Panel], styles: Mapping[str, Style]) -> None:
    """Panels of scenes over each other, each with its line style."""
    for panel, dashes in zip(panels, DASHES, strict=False):
        dashed = {name: {**style, "linestyle": dashes} for name, style in styles.items()}
        draw(axes, panel, dashed, labelled=False)
    finish(axes, panel)


def _panel(one: Curve, styles: Mapping[str, Style], *, half: bool) -> Panel:
    symbols = {SYMBOLS[variant]: values for variant, values in one.values.items()}
    chosen = {symbol: values for symbol, values in symbols.items() if symbol in styles}
    return Panel("", "", one.at, "", chosen, one.estimate).part(one.at >= (0 if half else -np.inf))


def _styles(overlay: Overlay) -> dict[str, dict[str, Any]]:
    """By symbol: colours of the variants, wide lines behind narrow ones."""
    variants = drawn_variants(overlay)
    widths = np.linspace(WIDE, NARROW, len(variants))
    return {
        SYMBOLS[variant]: {"color": STYLES[variant]["color"], "linewidth": width, "zorder": 4 - width / 2}
        for variant, width in zip(variants, widths, strict=True)
    }


def _add_legends(figure: Figure, overlay: Overlay) -> None:
    """Scenes by line style above the panels, variants by colour below them."""
    scenes = [
        Line2D([], [], color="dimgrey", linestyle=dashes, linewidth=1.6, label=_label(result))
        for result, dashes in zip(overlay.results, DASHES[: len(overlay.results)], strict=True)
    ]
    colours = [Line2D([], [], label=symbol, **style) for symbol, style in _styles(overlay).items()]
    band = Patch(color="black", alpha=0.2, linewidth=0, label=BAND)
    figure.legend(handles=scenes, loc="outside upper center", ncols=len(scenes), handlelength=4)
    figure.legend(handles=[band, *colours], loc="outside lower center", ncols=1 + len(colours))


def _label(result: Result) -> str:
    return f"{result.name} (L = {result.reference_length:g} mm)"
