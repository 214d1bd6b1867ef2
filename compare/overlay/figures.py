"""Figures of an overlay, drawn with matplotlib: one component of several scenes."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.ics.curves import line_panel
from compare.overlay.curves import is_mirrored
from compare.overlay.results import Overlay
from compare.report.panels import BAND, Panel, add_scene_legends, draw_scenes
from compare.report.styles import DASHES, RC, STYLES, SYMBOLS, Style

OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn in figures; tables also have the others
WIDE_LINE, NARROW_LINE = 2.4, 0.9  # line widths, rear to front: curves that coincide stay visible


def drawn_variants(overlay: Overlay) -> tuple[str, ...]:
    """Return C and the common variants among `OVERLAID_VARIANTS`, or all common variants if none is."""
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
                whole = [line_panel(result.ics, line, body, component) for result in overlay.results]
                title = f"{component} on {line}" if r == 0 else ""
                across = whole[0].across if r == len(bodies) - 1 else ""
                up = f"{body}\nIC · E · L  [-]" if c == 0 else ""
                panels = [
                    replace(_shown(panel, styles, half=half), title=title, across=across, up=up)
                    for panel in whole
                ]
                draw_scenes(grid[r, c], dict(zip(DASHES, panels, strict=False)), styles)
        lengths = {result.name: result.ics.reference_length for result in overlay.results}
        band = Patch(color="black", alpha=0.2, linewidth=0, label=BAND)
        add_scene_legends(figure, lengths, styles, band)
        return figure


def _shown(panel: Panel, styles: Mapping[str, Style], *, half: bool) -> Panel:
    """Return the drawn part of a panel: the curves that have a style, one half or both."""
    curves = {symbol: values for symbol, values in panel.curves.items() if symbol in styles}
    return replace(panel, curves=curves).part(panel.at >= (0 if half else -np.inf))


def _styles(overlay: Overlay) -> dict[str, dict[str, Any]]:
    """Return line styles by symbol: each variant has its colour, and wide lines lie behind narrow ones."""
    variants = drawn_variants(overlay)[::-1]  # the first is drawn on top
    widths = np.linspace(NARROW_LINE, WIDE_LINE, len(variants))
    return {
        SYMBOLS[variant]: {"color": STYLES[variant]["color"], "linewidth": width, "zorder": 4 - width / 2}
        for variant, width in zip(variants, widths, strict=True)
    }
