"""Loaded patches, lines of observers, and the grid of elements on which contact is solved.

All lie on the contact surface, with x along it and the arc length s across; the grid is uniform in both.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import WrongInput, require_numbers

# --- directions and components ---

DirectionName = Literal["x", "s", "n"]
DIRECTIONS: tuple[DirectionName, ...] = get_args(DirectionName)  # names of the directions 0, 1, 2
X, S, N = range(3)
COMPONENTS = tuple(i + j for i in DIRECTIONS for j in DIRECTIONS)  # displacement, then traction


def indices(component: str) -> tuple[int, int]:
    """Return the indices of the displacement and of the traction of a component such as "xn"."""
    names: list[str] = [*DIRECTIONS]
    return names.index(component[0]), names.index(component[1])


def places(components: Iterable[str]) -> tuple[Indices, ...]:
    """Return the indices of the displacements and of the tractions of components, (n,) each."""
    return tuple(np.transpose([indices(component) for component in components]))


def mirror_signs(direction: int) -> Array:
    """Return the signs that a reflection of a direction gives to the components (i, j) of ICs, (3, 3)."""
    signs = np.where(np.arange(3) == direction, -1.0, 1.0)
    return np.outer(signs, signs)


# --- patches ---


@dataclass(frozen=True)
class Patch:
    """Rectangular loaded element at x = 0: half-sides a along x, b along s, centre at arc length s [mm]."""

    a: float
    b: float
    s: float = 0.0

    def __post_init__(self) -> None:
        require_numbers(self)
        if not (0 < self.a < np.inf and 0 < self.b < np.inf):
            raise WrongInput(
                f"patch half-sides a = {self.a!r}, b = {self.b!r} must be positive and finite [mm]"
            )
        if not np.isfinite(self.s):
            raise WrongInput(f"patch centre s = {self.s!r} must be finite [mm]")

    @property
    def area(self) -> float:
        """Loaded area [mm^2]."""
        return 4 * self.a * self.b


@dataclass(frozen=True)
class Load:
    """A unit total load, uniform over a patch, in local direction 0, 1, 2 = x, s, n of each point."""

    patch: Patch
    direction: int


# --- lines ---


@dataclass(frozen=True, eq=False)
class OffsetLine:
    """Points on the surface along x (at fixed s) or along s (at fixed x); coordinates in mm."""

    name: str
    along: Literal["x", "s"]
    x: Array  # (n,)
    s: Array  # (n,)

    @property
    def running(self) -> Array:
        """The coordinate that varies [mm], shape (n,)."""
        return self.x if self.along == "x" else self.s


def line_along_x(s: float, reach: float, n_points: int) -> OffsetLine:
    """Return the line at arc length s, from x = -reach to +reach."""
    x = np.linspace(-reach, reach, n_points)
    return OffsetLine(f"s = {s:g} mm", "x", x, np.full_like(x, s))


def line_along_s(x: float, s_range: tuple[float, float], n_points: int) -> OffsetLine:
    """Return the line at longitudinal distance x over a range of arc lengths."""
    s = np.linspace(*s_range, n_points)
    return OffsetLine(f"x = {x:g} mm", "s", np.full_like(s, x), s)


# --- the grid ---


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
