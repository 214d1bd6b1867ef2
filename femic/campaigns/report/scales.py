"""Colours, levels and texts of errors, deviations and values in the figures of a campaign."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, Colormap, Normalize
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator

from femic.campaigns.report.fields import LEVELS, LOWEST, Kind
from geometries.arrays import Array

STEPS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # between colours of errors
SIGNED = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)  # likewise of deviations, above and below zero
CONTOURS = 5  # of values, about
MOST_RATIO = 1e4  # of the ends of a logarithmic scale that has ticks at 1, 2, 5


@dataclass(frozen=True, eq=False)
class ColourScale:
    """The colours of numbers, levels of contour lines, and ticks of the bar; (): matplotlib's own."""

    norm: Normalize
    colours: Colormap
    contours: Sequence[float] = ()
    ticks: Sequence[float] = ()

    @property
    def is_share(self) -> bool:
        """Whether the numbers are errors or deviations."""
        return bool(self.ticks)

    def text(self, value: float) -> str:
        """Return a number as text in a figure."""
        return share(value) if self.is_share else f"{value:.4g}"


def scale_of(kind: Kind, values: Array) -> ColourScale:
    """Return the scale of some numbers; errors and deviations have the same scale on all pages."""
    if kind == "value":
        low, high = (float(of(values)) for of in (np.nanmin, np.nanmax))
        levels = MaxNLocator(CONTOURS).tick_values(low, high) if high > low else []
        return ColourScale(Normalize(low, high), mpl.colormaps["viridis"], [float(level) for level in levels])
    colours, steps = ("RdYlBu_r", STEPS) if kind == "error" else ("RdBu_r", _with_negative(SIGNED))
    norm = BoundaryNorm(steps, len(steps) + 1, extend="both")
    levels = LEVELS if kind == "error" else _with_negative(LEVELS)
    return ColourScale(norm, mpl.colormaps[colours].resampled(len(steps) + 1), levels, steps)


def draw_levels(panels: Iterable[Axes], kind: Kind, values: Array) -> None:
    """Draw dotted lines at the levels into panels of numbers, in percent; errors on logarithmic scales."""
    if kind == "value":
        return
    known = np.maximum(values[np.isfinite(values)], LOWEST)
    low = float(np.min(known, initial=LEVELS[0])) / 1.5
    high = 1.5 * float(np.max(known, initial=0.8 * LEVELS[-1]))
    for axes in panels:
        for level in LEVELS if kind == "error" else (0.0, *_with_negative(LEVELS)):
            dotted = {"linestyle": ":", "linewidth": 0.7} if level else {"linewidth": 0.8}
            axes.axhline(level, color="grey", zorder=0, **dotted)
        if kind == "error":
            axes.set(yscale="log", ylim=(low, high))
            axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < MOST_RATIO * low else (1,)))
            axes.minorticks_off()
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: share(value)))


def share(value: float) -> str:
    """Return a share in percent, short."""
    return f"{100 * value:.3g} %" if abs(value) < 0.1 else f"{100 * value:.0f} %"


def _with_negative(levels: Sequence[float]) -> list[float]:
    return [*(-level for level in reversed(levels)), *levels]
