"""Colours, levels and texts of errors, of deviations and of values on the page of a campaign."""

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import BoundaryNorm, Colormap, Normalize
from matplotlib.ticker import MaxNLocator

from compare.reports.sweep.fields import LEVELS, Kind
from geometries.arrays import Array

STEPS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # between colours of errors
SIGNED = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)  # likewise of deviations, above and below zero
CONTOURS = 5  # of values, about


@dataclass(frozen=True, eq=False)
class Scale:
    """The colours of numbers, the levels of contour lines, and the ticks of the bar."""

    norm: Normalize
    colours: Colormap
    contours: Sequence[float]
    ticks: Sequence[float] | None  # None: those of matplotlib
    extend: str
    label: str
    is_share: bool

    def text(self, value: float) -> str:
        """A number as it stands in a picture."""
        return share(value) if self.is_share else f"{value:.4g}"


def scale_of(kind: Kind, values: Array) -> Scale:
    """The scale of some numbers; those of errors and of deviations are the same on all pages."""
    if kind == "error":
        norm = BoundaryNorm(STEPS, len(STEPS) + 1, extend="both")
        return Scale(norm, _sampled("RdYlBu_r", len(STEPS) + 1), LEVELS, STEPS, "both", "error", True)
    if kind == "deviation":
        steps = [*(-one for one in reversed(SIGNED)), *SIGNED]
        norm = BoundaryNorm(steps, len(steps) + 1, extend="both")
        contours = [*(-one for one in reversed(LEVELS)), *LEVELS]
        return Scale(norm, _sampled("RdBu_r", len(steps) + 1), contours, steps, "both", "deviation", True)
    low, high = (float(of(values)) for of in (np.nanmin, np.nanmax))
    return Scale(
        Normalize(low, high),
        mpl.colormaps["viridis"],
        [float(level) for level in MaxNLocator(CONTOURS).tick_values(low, high)] if high > low else [],
        None,
        "neither",
        "",
        False,
    )


def share(value: float) -> str:
    """A share in percent, short."""
    return f"{100 * value:.3g} %" if abs(value) < 0.1 else f"{100 * value:.0f} %"


def _sampled(name: str, count: int) -> Colormap:
    return mpl.colormaps[name].resampled(count)
