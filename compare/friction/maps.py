"""Maps of the contact area by ICs at one friction: pressures, where it sticks, and the work of friction."""

import numpy as np
import xarray as xr

from compare.contact.dataset import ics_of
from compare.report.charts import Map
from compare.report.looks import symbol_of

KINDS = "sticks", "slides"


def pressures(contacts: xr.Dataset) -> list[Map]:
    """Return the pressures [MPa], a map per ICs, with the same colours."""
    return _maps(contacts, contacts.p.sel(direction="n"), contacts.p.attrs["units"])


def work(contacts: xr.Dataset) -> list[Map]:
    """Return the work of friction per area, a map per ICs, with the same colours."""
    return _maps(contacts, contacts.work, contacts.work.attrs["units"])


def stick(contacts: xr.Dataset) -> list[Map]:
    """Return where the contact sticks and where it slides, a map per ICs."""
    return _maps(contacts, 1.0 - contacts.stick, "", KINDS)


def _maps(contacts: xr.Dataset, values: xr.DataArray, unit: str, classes: tuple[str, ...] = ()) -> list[Map]:
    """Return values in the contact area with each ICs, as far as any contact goes."""
    pressed = contacts.p.sel(direction="n") > 0
    area = covered(pressed)
    drawn = values.where(pressed).isel(area)
    limits = (0.0, float(drawn.max()))
    return [
        Map(
            symbol_of(name),
            "x [mm]",
            "s [mm]",
            drawn.x.values,
            drawn.s.values,
            drawn.sel(ics=name).transpose("x", "s").values,
            unit,
            limits=limits,
            classes=classes,
            to_scale=True,
        )
        for name in ics_of(contacts)
    ]


def covered(pressed: xr.DataArray) -> dict[str, slice]:
    """Return the ranges along x and s that contacts cover, with an element beside them."""
    ranges = {}
    for name, other in (("x", "s"), ("s", "x")):
        at = np.flatnonzero(pressed.any(["ics", other]))
        ranges[name] = slice(max(0, at[0] - 1), at[-1] + 2)
    return ranges
