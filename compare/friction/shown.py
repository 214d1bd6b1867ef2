"""Numbers of contacts with friction as the pages show them: units, abscissas, curves by ICs, differences."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from compare.contact.compute import reference_name
from compare.contact.dataset import reference_of
from compare.friction.rolling import scaled_force
from compare.report.charts import Curve
from compare.report.looks import drawing_order, looks_of, symbol_of
from compare.report.tables import MINUS, with_estimate
from femic.contact.motions import MOTIONS
from femic.contact.pairs.quantities import ALL, OF_CURVE

KILO = 1e4  # N: from this load on, forces are shown in kN
PERCENT = "sliding_share", "zero_creepage", "equal_creepage"
FORCES = "F_x", "F_y", "load"
BY_SYMMETRY = {"F_y": "N", "M_x": "N mm", "M_z": "N mm"}  # numbers that vanish in symmetric contacts
NOISE = 1e-6  # of the load, or of the load times the half-length of the patch, below which they do


@dataclass(frozen=True)
class Shown:
    """A number as a page shows it: its symbol, its unit, and the factor from the unit of the dataset."""

    symbol: str
    unit: str
    factor: float = 1.0
    meaning: str = ""

    @property
    def title(self) -> str:
        """The symbol and the unit, in brackets."""
        return f"{self.symbol} [{self.unit}]"


def motion_of(dataset: xr.Dataset) -> str:
    """Return the name of the motion along whose dimension the numbers are."""
    return next(name for name, motion in MOTIONS.items() if motion.dimension in dataset.dims)


def load_of(dataset: xr.Dataset) -> float:
    """Return the load [N], or the largest one."""
    return float(dataset["load"].max()) if "load" in dataset.coords else float(dataset.attrs["load"])


def shown(dataset: xr.Dataset, name: str) -> Shown:
    """Return how a number is shown: creepages and shares in percent, forces of large loads in kN."""
    quantity = (dict(ALL) | dict(OF_CURVE))[name]
    symbol, meaning = quantity.symbol, quantity.meaning
    force, factor = ("kN", 1e-3) if load_of(dataset) >= KILO else ("N", 1.0)
    if name in PERCENT:
        return Shown(symbol, "%", 100.0, meaning)
    if name in FORCES:
        return Shown(symbol, force, factor, meaning)
    if name == "slope":
        return Shown(symbol, f"{force}/%", factor / 100, meaning)
    return Shown(symbol, quantity.unit, 1.0, meaning)


def abscissa(dataset: xr.Dataset) -> Shown:
    """Return how the places along the dimension of the motion are shown."""
    if motion_of(dataset) == "compression":
        load = shown(dataset, "load")
        return Shown("load", load.unit, load.factor)
    return {"rolling": Shown("creepage", "%", 100.0), "transient": Shown("rolled distance", "mm")}[
        motion_of(dataset)
    ]


def places(dataset: xr.Dataset) -> xr.DataArray:
    """Return the places along the dimension of the motion in the unit shown."""
    return dataset[MOTIONS[motion_of(dataset)].dimension] * abscissa(dataset).factor


def place_text(dataset: xr.Dataset, place: float) -> str:
    """Return a place along the dimension of the motion with its unit."""
    across = abscissa(dataset)
    return f"{place * across.factor:.4g}{'' if across.unit == '%' else ' '}{across.unit}"


def step(friction: float) -> str:
    """Return the step of a slider for a coefficient of friction."""
    return f"μ\u00a0=\u00a0{friction:g}"


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs that others are compared with."""
    return symbol_of(reference_of(dataset))


def vanishes(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a number is 0 by symmetry, to rounding."""
    if name not in BY_SYMMETRY:
        return False
    arm = float(dataset.a.max()) if BY_SYMMETRY[name] == "N mm" else 1.0
    return float(abs(dataset[name]).max()) < NOISE * load_of(dataset) * arm


def main_name(dataset: xr.Dataset) -> str:
    """Return the name of the number that ICs are judged by."""
    return "sliding_share" if motion_of(dataset) == "compression" else "F_x"


def main_number(dataset: xr.Dataset) -> xr.DataArray:
    """Return the number that ICs are judged by [%]: force over friction times load, or sliding share."""
    return _main(dataset, "")


def main_estimate(dataset: xr.Dataset) -> xr.DataArray:
    """Return the estimated error of the main number [%]."""
    return _main(dataset, "estimate_")


def _main(dataset: xr.Dataset, prefix: str) -> xr.DataArray:
    if motion_of(dataset) == "compression":
        return 100 * dataset[f"{prefix}sliding_share"].drop_attrs()
    return 100 * scaled_force(dataset, f"{prefix}F_x")


def difference(dataset: xr.Dataset) -> xr.DataArray:
    """Return the main number minus the reference's [%]."""
    number = main_number(dataset)
    return number - number.sel(ics=reference_of(dataset))


def largest_differences(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the largest difference of each ICs at any friction and place [%], and its estimate there.

    By the triangle inequality, the estimate of a difference is the sum of those of both.
    """
    known = main_estimate(dataset)
    both = known + known.sel(ics=reference_of(dataset))
    at = abs(difference(dataset)).fillna(0.0).argmax(["friction", MOTIONS[motion_of(dataset)].dimension])
    return abs(difference(dataset)).isel(at), both.isel(at)


def worst_friction(dataset: xr.Dataset) -> float:
    """Return the coefficient of friction at which ICs differ most from the reference."""
    away = abs(difference(dataset)).max(["ics", MOTIONS[motion_of(dataset)].dimension])
    return float(dataset.friction[np.argmax(away.fillna(0.0).values)])


def curves_by_ics(at: ArrayLike, values: xr.DataArray, estimate: xr.DataArray | None = None) -> list[Curve]:
    """Return curves of values by ICs over an abscissa; the reference's has its estimate as a band."""
    names = [str(name) for name in values.ics.values]
    looks, reference = looks_of(names), reference_name(names)
    return [
        Curve(
            symbol_of(name),
            at.sel(ics=name) if isinstance(at, xr.DataArray) and "ics" in at.dims else at,
            values.sel(ics=name),
            looks[name],
            estimate.sel(ics=name) if estimate is not None and name == reference else None,
        )
        for name in drawing_order(names)
    ]


def share_curves(at: ArrayLike, share: xr.DataArray, estimate: xr.DataArray) -> list[Curve]:
    """Return curves of shares [%] by ICs; the band of the reference's ends at 0 and 100."""
    below, above = (estimate.where(estimate < most, most) for most in (share, 100 - share))
    return curves_by_ics(at, share, xr.concat([below, above], "side").transpose("side", ...))


def difference_unit(dataset: xr.Dataset) -> str:
    """Return the unit of differences of the main number."""
    return "% of contact area" if motion_of(dataset) == "compression" else "% of friction load"


def percent_change(value: xr.DataArray, before: xr.DataArray) -> float:
    """Return the change of a number [%]."""
    return 100 * (float(value) / float(before) - 1) if np.isfinite(before) else np.nan


def signed(value: float | xr.DataArray, estimate: float | xr.DataArray) -> str:
    """Return a difference with its sign, and the digits that an estimate allows."""
    text = with_estimate(value, estimate).split(" ± ")[0]
    return text if text.startswith((MINUS, "–")) or text == "0" else f"+{text}"


def load_text(dataset: xr.Dataset) -> str:
    """Return the load, or the largest one, with its unit."""
    load = shown(dataset, "load")
    return f"{load_of(dataset) * load.factor:g} {load.unit}"
