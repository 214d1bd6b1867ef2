"""What presses two bodies on each other."""

from dataclasses import dataclass

import numpy as np

from femic.key_types import DISTINCT_DIGITS
from geometries.errors import WrongInput


@dataclass(frozen=True)
class Loading:
    """A vertical load [N] or a vertical approach [mm].

    Where a `lateral_force` [N] on the upper body is given, its lateral position follows; otherwise that is
    given. Raises WrongInput unless there is either a positive load or an approach, and both are finite.
    """

    load: float | None = None
    approach: float | None = None
    lateral_force: float | None = None

    def __post_init__(self) -> None:
        if (self.load is None) == (self.approach is None):
            raise WrongInput(f"load = {self.load!r}, approach = {self.approach!r}: give one of them")
        if self.load is not None and not 0 < self.load < np.inf:
            raise WrongInput(f"load = {self.load!r}: must be positive and finite [N]")
        if self.approach is not None and not np.isfinite(self.approach):
            raise WrongInput(f"approach = {self.approach!r}: must be finite [mm]")

    def __str__(self) -> str:
        return amount(self.load, "N") if self.load is not None else amount(self.approach or 0.0, "mm")


def amount(value: float, unit: str) -> str:
    """Return a number with six digits if these are all it has, else with as many as tell loadings apart."""
    text = f"{value:g}"
    return f"{text if float(text) == value else f'{value:.{DISTINCT_DIGITS}g}'} {unit}"
