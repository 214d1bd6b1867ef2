"""The grid of elements on which contact is solved, uniform in x and in arc length s."""

from dataclasses import dataclass, replace

import numpy as np

from geometries.arrays import Array
from geometries.errors import WrongInput, require_numbers
from geometries.patches import Patch


@dataclass(frozen=True)
class Grid:
    """n_x by n_s elements of dx by ds [mm]: n_s strips along x, side by side about arc length s."""

    n_x: int
    n_s: int
    dx: float
    ds: float
    s: float = 0.0

    def __post_init__(self) -> None:
        require_numbers(self, whole=("n_x", "n_s"))
        if not (self.n_x >= 1 and self.n_s >= 1):
            raise WrongInput(f"n_x = {self.n_x!r}, n_s = {self.n_s!r}: at least one element each")
        for name in ("dx", "ds"):
            if not 0 < getattr(self, name) < np.inf:
                raise WrongInput(f"{name} = {getattr(self, name)!r}: must be positive and finite [mm]")
        if not np.isfinite(self.s):
            raise WrongInput(f"s = {self.s!r}: must be finite [mm]")

    @property
    def lags(self) -> Array:
        """Distances between elements along x [mm], shape (n_x,): 0, dx, 2 dx, ..."""
        return np.asarray(self.dx * np.arange(self.n_x))

    @property
    def strips(self) -> Array:
        """Arc lengths of the centres of the strips [mm], shape (n_s,)."""
        return np.asarray(self.s + self.ds * (np.arange(self.n_s) - (self.n_s - 1) / 2))

    @property
    def element(self) -> Patch:
        """An element about x = s = 0."""
        return Patch(self.dx / 2, self.ds / 2)

    def patch(self, strip: int) -> Patch:
        """Return the element of a strip at x = 0."""
        return replace(self.element, s=float(self.strips[strip]))

    @property
    def area(self) -> float:
        """Area of an element [mm^2]."""
        return self.dx * self.ds

    @property
    def extent(self) -> tuple[float, float]:
        """Range of arc lengths s that the grid covers [mm]."""
        half = self.n_s * self.ds / 2
        return self.s - half, self.s + half
