"""Figures of an overlay, drawn with matplotlib: one component of several scenes."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from compare.pages.panels import BAND, Panel, add_scene_legends, draw, finish
from compare.pages.styles import DASHES, RC, STYLES, SYMBOLS, Style
from compare.reports.overlay.curves import Curve, Overlay, curve, is_mirrored

OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn in figures; tables also have the others
WIDE_LINE, NARROW_LINE = 2.4, 0.9  # line widths, rear to front: curves that coincide stay visible


def drawn_variants(overlay: Overlay) -> tuple[str, ...]:
    """C and the common variants among `OVERLAID_VARIANTS`; C and all common variants if there are none."""
    common = overlay.common.variants
    return ("C", *(tuple(variant for variant in common if variant in OVERLAID_VARIANTS) or common))


def curves(overlay: Overlay, component: str) -> Figure:
    """Draw one component of all scenes, dimensionless: a column per line, a row per body."""
    bodies, lines, styles = overlay.common.bodies, overlay.common.lines, _styles(overlay)
    with mpl.rc_context(RC):
        figure = Figure(figsize=(4.1 * len(lines), 2.7 * len(bodies) + 1.1), layout="constrained")
        grid = figure.subplots(len(bodies), len(lines), squeeze=False)
        for c, line in enumerate(lines):
            half = is_mirrored(overlay, line)
            for r, body in enumerate(bodies):
                scene_curves = [curve(result, line, body, component) for result in overlay.results]
                title = f"{component} on {line}" if r == 0 else ""
                x_label = f"{scene_curves[0].along} / L  [-]" if r == len(bodies) - 1 else ""
                y_label = f"{body}\nIC · E · L  [-]" if c == 0 else ""
                panels = [
                    replace(_panel(scene_curve, styles, half=half), title=title, across=x_label, up=y_label)
                    for scene_curve in scene_curves
                ]
                _draw_panel(grid[r, c], panels, styles)
        lengths = {result.name: result.reference_length for result in overlay.results}
        colours = [Line2D([], [], label=symbol, **style) for symbol, style in reversed(styles.items())]
        band = Patch(color="black", alpha=0.2, linewidth=0, label=BAND)
        add_scene_legends(figure, lengths, [band, *colours])
        return figure


def _draw_panel(axes: Axes, panels: Sequence[Panel], styles: Mapping[str, Style]) -> None:
    """Draw the panels of all scenes into the same axes, each with its own line style."""
    for panel, dashes in zip(panels, DASHES, strict=False):
        dashed = {name: {**style, "linestyle": dashes} for name, style in styles.items()}
        draw(axes, panel, dashed, labelled=False)
    finish(axes, panel)


def _panel(scene_curve: Curve, styles: Mapping[str, Style], *, half: bool) -> Panel:
    symbols = {SYMBOLS[variant]: values for variant, values in scene_curve.values.items()}
    shown = {symbol: values for symbol, values in symbols.items() if symbol in styles}
    return Panel("", "", scene_curve.at, "", shown, scene_curve.estimate).part(
        scene_curve.at >= (0 if half else -np.inf)
    )


def _styles(overlay: Overlay) -> dict[str, dict[str, Any]]:
    """Line styles by symbol: each variant has its colour, and wide lines lie behind narrow ones."""
    variants = drawn_variants(overlay)[::-1]  # the first is drawn on top
    widths = np.linspace(NARROW_LINE, WIDE_LINE, len(variants))
    return {
        SYMBOLS[variant]: {"color": STYLES[variant]["color"], "linewidth": width, "zorder": 4 - width / 2}
        for variant, width in zip(variants, widths, strict=True)
    }
