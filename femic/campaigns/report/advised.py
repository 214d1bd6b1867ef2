"""The advised ICs over the axes of a campaign: kinds as colours, or as names of an axis."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Map, Panel, chart_of
from compare.report.looks import INK, Look, looks_of, symbol_of
from femic.campaigns.report.axes import ShownAxis, evenly_spaced, values_text
from femic.campaigns.report.curves import MOST_POINTS
from femic.campaigns.report.fields import body_of
from femic.campaigns.report.maps import MOST_STEPS, Plane

NONE, TITLE = "none", "cheapest ICs that are good enough"
GREY = "#c8ccd2"
POINT = Look(INK, "", "circle")


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
    def colours(self) -> list[str]:
        """The colours of the ICs' curves, grey for none; C, whose curves have the colour of ink, is black."""
        looks = looks_of(name for name in self.names if name != NONE)
        colours = {name: "#000000" if look.colour == INK else look.colour for name, look in looks.items()}
        return [colours.get(name, GREY) for name in self.names]

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


def advised_chart(advice: AdvisedICs, axes: Sequence[ShownAxis], failed: xr.DataArray) -> Chart:
    """Return the advised ICs over one axis, or over two by the third one, or as points of random scenes."""
    if len(axes) == 1:
        return chart_of("advice", [_over_one(advice, axes[0])], 1, 0.6)
    if "sample" in failed.dims:
        return chart_of("advice", [_points(advice, axes)], 1, 1.3)
    if len(axes) == 2:
        return chart_of("advice", [_map(advice, Plane.of(axes, failed))], 1)
    third = axes[2]
    first = {axis.name: 0 for axis in axes[3:]}
    steps = {}
    for k in evenly_spaced(len(third.values), MOST_STEPS):
        place = first | {third.name: k}
        steps[values_text({third.name: third.values[k]})] = [
            _map(advice.at(**place), Plane.of(axes, failed.isel(place)))
        ]
    return Chart("advice", steps, 1, third.label)


def _map(advice: AdvisedICs, plane: Plane) -> Map:
    return plane.kinds_of(TITLE, advice.numbers, dict(zip(advice.labels, advice.colours, strict=True)))


def _over_one(advice: AdvisedICs, axis: ShownAxis) -> Panel:
    """Return points over an axis, whose ordinates are the ICs."""
    curve = Curve("", axis.at, advice.numbers.values, POINT)
    return Panel(
        TITLE,
        axis.label,
        "",
        [curve],
        log_x=axis.is_logarithmic,
        names_x=axis.categories,
        names_y=advice.labels,
    )


def _points(advice: AdvisedICs, axes: Sequence[ShownAxis]) -> Panel:
    """Return points of the advised ICs over the first two axes."""
    across, up = axes[:2]
    chosen = evenly_spaced(len(across.values), MOST_POINTS)
    numbers = advice.numbers.values[chosen]
    curves = [
        Curve(label, across.at[chosen][numbers == k], up.at[chosen][numbers == k], Look(colour, "", "circle"))
        for k, (label, colour) in enumerate(zip(advice.labels, advice.colours, strict=True))
    ]
    return Panel(
        TITLE,
        across.label,
        up.label,
        curves,
        log_x=across.is_logarithmic,
        log_y=up.is_logarithmic,
        names_x=across.categories,
        names_y=up.categories,
    )
