"""The advised ICs over the axes of a campaign: categories as colours."""

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.report.looks import symbol_of
from compare.report.styles import RC, with_further
from femic.campaigns.report.axes import ShownAxis, evenly_spaced
from femic.campaigns.report.clouds import MOST_POINTS
from femic.campaigns.report.fields import body_of
from femic.campaigns.report.maps import PANEL, STRIP, Plane, draw_cells, gap_handles
from femic.campaigns.report.scales import ColourScale
from geometries.arrays import Array

NONE = "none is good enough"
MOST_BESIDE = 4  # entries of a line of the legend
PALE = 0.35  # share of white in colours


@dataclass(frozen=True, eq=False)
class AdvisedICs:
    """The advised ICs over the swept dims, as places in `names`, of which one may be `NONE`."""

    numbers: xr.DataArray
    names: tuple[str, ...]

    @property
    def labels(self) -> list[str]:
        """The names as on the page."""
        return [symbol_of(name) for name in self.names]

    @property
    def colours(self) -> Array:
        """Colours (n_names, 3): paler shades of the colours of curves."""
        styles = with_further(name for name in self.names if name != NONE)
        pure = ["0.95" if name == NONE else styles[name][1]["color"] for name in self.names]
        return PALE + (1 - PALE) * to_rgba_array(pure)[:, :3]

    @property
    def scale(self) -> ColourScale:
        """Colours of the numbers of names."""
        count = len(self.names)
        norm = BoundaryNorm(np.arange(count + 1) - 0.5, count)
        return ColourScale(norm, ListedColormap(self.colours))

    def at(self, **places: int) -> "AdvisedICs":
        """Return the advice at some places of swept dims."""
        return AdvisedICs(self.numbers.isel(places), self.names)

    def counts(self) -> dict[str, int]:
        """Return the numbers of scenes by advised ICs."""
        counts = {label: int((self.numbers == k).sum()) for k, label in enumerate(self.labels)}
        return {label: count for label, count in counts.items() if count}


def advice_of(dataset: xr.Dataset) -> AdvisedICs | None:
    """Return the advice of a campaign that kept it, with the ICs that are advised anywhere; else None."""
    if "advised" not in dataset:
        return None
    numbers = dataset.advised.sel(body=body_of(dataset), drop=True).drop_attrs().load()
    known = np.unique(numbers.values[np.isfinite(numbers.values)]).astype(int)
    if not known.size:
        return None
    used = sorted(known, key=lambda k: (k < 0, k))  # -1, none, comes last
    places = np.select([numbers == k for k in used], range(len(used)), np.nan)
    names = tuple(NONE if k < 0 else str(dataset.variant.values[k]) for k in used)
    return AdvisedICs(numbers.copy(data=places), names)


def advised_over(panels: Sequence[tuple[str, AdvisedICs, Plane]]) -> Figure:
    """Draw maps of the advised ICs over two axes beside each other, with titles; a strip over one axis."""
    _, advice, plane = panels[0]
    is_strip = plane.up is STRIP
    with mpl.rc_context(RC | {"axes.grid": False, "hatch.linewidth": 0.5}):
        width, height = 1.25 * PANEL[0], 1.25 * PANEL[1]
        size = (7.5, 1.6) if is_strip else (max(width * len(panels) + 0.6, 4.4), height + 0.9)
        figure = Figure(figsize=size, layout="constrained")
        shown = [on.over(panel_advice.numbers) for _, panel_advice, on in panels]
        drawn = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axes, values, (title, _, on) in zip(drawn, shown, panels, strict=True):
            draw_cells(axes, values, on, advice.scale)
            axes.set_title(title, fontsize=9)
            axes.set_xlabel(on.across.heading if is_strip else on.across.wrapped)
        drawn[0].set_ylabel(plane.up.wrapped)
        _legend(figure, advice, gap_handles([on for *_, on in panels], shown))
        return figure


def advised_points(advice: AdvisedICs, axes: Sequence[ShownAxis]) -> Figure:
    """Draw points of the advised ICs over the first two axes, or over the only one."""
    across, up = axes[0], axes[1] if len(axes) > 1 else STRIP
    chosen = evenly_spaced(len(across.values), MOST_POINTS)
    heights = np.zeros(len(chosen)) if up is STRIP else up.at[chosen]
    with mpl.rc_context(RC | {"grid.alpha": 0.2}):
        figure = Figure(figsize=(5.4, 1.8 if up is STRIP else 4.2), layout="constrained")
        panel: Axes = figure.subplots()
        for k, colour in enumerate(advice.colours):
            drawn = advice.numbers.values[chosen] == k
            places = across.at[chosen][drawn], heights[drawn]
            panel.scatter(*places, s=22, color=[colour], edgecolors="0.4", linewidths=0.4)
        across.scale(panel, "x")
        up.scale(panel, "y")
        panel.set(xlabel=across.heading, ylabel=up.wrapped)
        _legend(figure, advice)
        return figure


def _legend(figure: Figure, advice: AdvisedICs, gaps: Sequence[Artist] = ()) -> None:
    named = zip(advice.labels, advice.colours, strict=True)
    patches = [Patch(facecolor=colour, edgecolor="0.4", label=label) for label, colour in named]
    handles = [*patches, *gaps]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), MOST_BESIDE))
