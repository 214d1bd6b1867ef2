"""The scales of errors of contact numbers, from the numbers of a reference: `femic.scenes.wants`."""

from collections.abc import Callable, Mapping

import xarray as xr

from femic.scenes import wants
from femic.scenes.wants import KNOWN, Scale, Want

ESTIMATE = "estimate_"  # before the name of a number
Of = Callable[[xr.Dataset, str], xr.DataArray]


def _itself(reference: xr.Dataset, name: str) -> xr.DataArray:
    return abs(reference[name])


OF: Mapping[Scale, Of] = {
    wants.ITSELF: _itself,
    wants.ITSELF_WHERE_KNOWN: _itself,
    wants.LIMIT: lambda reference, _: reference["limit"],
    wants.LOAD: lambda reference, _: reference["load"],
    wants.HALF_WIDTH: lambda reference, _: reference["b"],
    wants.WHOLE: lambda reference, name: xr.ones_like(reference[name]),
    wants.SATURATION: lambda reference, _: abs(reference["limit"] / reference["slope"]),
}


def scale_of(want: Want, reference: xr.Dataset) -> xr.DataArray:
    """Return what errors of a number are shares of; NaN where the reference does not know it well enough."""
    scale = OF[want.scale](reference, want.number)
    if want.scale.vanishing:
        scale = scale.where(scale > KNOWN * reference[ESTIMATE + want.number])
    return scale.where(scale > 0)
