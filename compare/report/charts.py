"""Charts as data: panels of curves, maps and surfaces, by the steps of a slider.

A chart is drawn twice: to be explored on a page (`compare.report.interactive`), and as a picture for paper
(`compare.report.static`), where the panels of all steps stand side by side.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from compare.report.looks import Look, label_looks, without_marker
from femic.lazy import lazy_imports
from geometries.arrays import Array

with lazy_imports():
    from compare.report import scales

Scale = Literal["sequential", "diverging", "logarithmic", "positive"]
CLASSES = ("#0072b2", "#e69f00", "#009e73", "#cc79a7")  # colours of kinds
PLAIN = Look()
MOST_MARKERS = 25  # points of a curve up to which each has its marker
MOST_LEVELS = 16  # of contours
CONTOURS = {"sequential": "viridis", "diverging": "RdBu_r"}  # maps of colours
MARKS = 24  # about how many marks a curve without a line has


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve y over x, (n,), and the half-height of its band, such as an estimated error.

    Half-heights below and above may differ, (2, n). With `bars` each point has a bar instead of a band.
    `names` are written beside the points, `notes` are read where one points at them.

    Curves with the same label are shown and hidden together; without one a curve is not in the legend.
    Markers are drawn on curves of few points only.
    """

    label: str
    x: ArrayLike
    y: ArrayLike
    look: Look = PLAIN
    band: ArrayLike | None = None
    bars: bool = False
    names: Sequence[str] = ()
    notes: Sequence[str] = ()

    @property
    def points(self) -> tuple[Array, Array]:
        """Abscissas and ordinates."""
        return np.asarray(self.x, dtype=float), np.asarray(self.y, dtype=float)

    @property
    def band_edges(self) -> tuple[Array, Array]:
        """Ordinates of the lower and the upper edge of the band, NaN where it is not known."""
        below, above = np.broadcast_to(np.asarray(self.band, dtype=float), (2, np.size(self.y)))
        return self.points[1] - below, self.points[1] + above

    @property
    def sides(self) -> list[str]:
        """Where each name stands: above or below its point, in turn."""
        return ["top" if turn % 2 else "bottom" for turn in np.cumsum([bool(name) for name in self.names])]

    @property
    def drawn_look(self) -> Look:
        """The look, without markers on a line of many points."""
        return self.look if np.size(self.x) <= MOST_MARKERS else without_marker(self.look)


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over one abscissa; labels with units. `marks` and `levels` are places of dotted lines.

    `to_scale`: both axes have the same scale. `limits_x`, `limits_y` are those of the axes at first.
    `least`: ordinates are never zoomed closer than this range at first, so that rounding looks like zero.
    Names are those of the places 0, 1, ... on an axis without numbers.
    """

    title: str
    across: str
    up: str
    curves: Sequence[Curve]
    log_x: bool = False
    log_y: bool = False
    marks: Sequence[float] = ()
    least: float = 0.0
    levels: Sequence[float] = ()
    names_x: Sequence[str] = ()
    names_y: Sequence[str] = ()
    to_scale: bool = False
    limits_x: tuple[float, float] | None = None
    limits_y: tuple[float, float] | None = None

    @property
    def vanishes(self) -> bool:
        """Whether no curve leaves the range of rounding."""
        sizes = [np.nan_to_num(np.abs(curve.points[1]), nan=0.0, posinf=0.0) for curve in self.curves]
        return self.least > 0 and all(np.max(size, initial=0.0) < self.least for size in sizes)


@dataclass(frozen=True, eq=False)
class Map:
    """Values (n_x, n_y) over x and y, NaN where there are none; further curves, such as edges, lie upon it.

    `classes` names values 0, 1, ... that are kinds instead of numbers, with colours. `limits` are those of
    the colours; a logarithmic scale has `decades` of each sign, a positive one is logarithmic between limits.
    Names are those of the places 0, 1, ... on an axis without numbers.
    """

    title: str
    across: str
    up: str
    x: Array
    y: Array
    values: Array
    unit: str
    scale: Scale = "sequential"
    limits: tuple[float, float] | None = None
    decades: float = 3.0
    classes: Sequence[str] = ()
    curves: Sequence[Curve] = ()
    to_scale: bool = False
    colours: Sequence[str] = CLASSES
    log_x: bool = False
    log_y: bool = False
    names_x: Sequence[str] = ()
    names_y: Sequence[str] = ()

    @property
    def range(self) -> tuple[float, float]:
        """The limits of the colours: those given, those of the values, symmetric where both signs count."""
        if self.limits:
            return self.limits
        low, high = (float(f(self.values)) for f in (np.nanmin, np.nanmax))
        if self.scale in ("sequential", "positive"):
            return low, high
        high = max(abs(low), abs(high), np.finfo(float).tiny)
        return -high, high


@dataclass(frozen=True, eq=False)
class Surface:
    """A body's surface in grey and values on a part of it, in 3D; points (3, n, m) [mm], values (n, m).

    `picture` is the file of the same for paper; without one it is drawn by Matplotlib.
    """

    title: str
    body: Array
    part: Array
    values: Array
    unit: str
    picture: Path | None = None


@dataclass(frozen=True, eq=False)
class Contours:
    """Filled contours of values on curved lattices, such as sections of bodies; axes have the same scale.

    `regions` are points (2, n, m) [mm] and values (n, m) there, NaN where there are none. Curves, such as
    outlines, lie upon them. `limits` are those of the colours, which go on beyond them to round levels. Where
    one points at it, a page tells the value of each `stride`-th point.
    """

    title: str
    across: str
    up: str
    regions: Sequence[tuple[Array, Array]]
    unit: str
    scale: Literal["sequential", "diverging"] = "sequential"
    limits: tuple[float, float] | None = None
    curves: Sequence[Curve] = ()
    stride: int = 1

    @property
    def levels(self) -> Array:
        """Round values in equal steps, (n + 1,), that enclose all values; a colour between each two."""
        values = np.concatenate([values.ravel() for _, values in self.regions])
        low, high = self.limits or (float(np.nanmin(values)), float(np.nanmax(values)))
        if self.scale == "diverging":
            low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))
        if not high > low:
            low, high = low - 1.0, high + 1.0
        return scales.round_levels(low, high, MOST_LEVELS)

    @property
    def colours(self) -> list[str]:
        """The colour between each two levels, as hexadecimal numbers."""
        return scales.shades(CONTOURS[self.scale], len(self.levels) - 1)


Cell = Panel | Map | Surface | Contours


@dataclass(frozen=True, eq=False)
class Chart:
    """Cells in columns, by the steps of a slider; a single step has no slider.

    `name` is that of its file, `slider` says what the steps are, and moves all sliders of the same name.
    With a `choice`, the cells of a step are alternatives, chosen by their titles: the page shows one at a
    time, paper the first.
    """

    name: str
    steps: Mapping[str, Sequence[Cell]]
    columns: int = 3
    slider: str = ""
    heights: float = 1.0  # of the cells, over the standard
    start: str = ""  # the step shown first, or the last one
    choice: str = field(default="", kw_only=True)
    alt: str = field(default="", kw_only=True)

    @property
    def first(self) -> int:
        """The number of the step shown first."""
        return list(self.steps).index(self.start) if self.start else len(self.steps) - 1

    @property
    def cells(self) -> list[Cell]:
        """The cells of all steps."""
        return [cell for cells in self.steps.values() for cell in cells]

    @property
    def legend(self) -> dict[str, Look]:
        """The look of each label, as its curves are drawn."""
        curves = [curve for cell in self.cells if not isinstance(cell, Surface) for curve in cell.curves]
        return {curve.label: curve.drawn_look for curve in curves if curve.label}


def simple_chart(
    name: str, cells: Sequence[Cell], columns: int = 3, heights: float = 1.0, alt: str = ""
) -> Chart:
    """Return a chart without a slider."""
    return Chart(name, {"": cells}, columns, heights=heights, alt=alt)


def make_curves(at: ArrayLike, values: Mapping[str, Array], estimate: ArrayLike | None = None) -> list[Curve]:
    """Return curves by their labels, such as "B̂", in the looks of these ICs; the estimate is the band of C.

    Curves that are NaN everywhere are left out.
    """
    looks = label_looks(values)
    return [
        mark_points(Curve(label, at, curve, looks[label], estimate if label == "C" else None))
        for label, curve in values.items()
        if not np.all(np.isnan(curve))
    ]


def mark_points(curve: Curve) -> Curve:
    """Return a curve, with a few of its points where these are marks without a line."""
    step = max(1, np.size(curve.x) // MARKS)
    if curve.look.dash or step == 1:
        return curve
    (x, y), band = curve.points, None if curve.band is None else np.asarray(curve.band)[..., ::step]
    return replace(curve, x=x[::step], y=y[::step], band=band)
