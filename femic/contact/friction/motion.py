"""How surfaces slip over each other: by a shift, in a step of rolling, in steady rolling.

Slip follows from the rigid slip w and the displacement differences u (upper less lower body). Particles run
through a rolling contact from its leading edge at large x to its trailing edge.

    shift           s = w + u - u'                     [mm], u' before the shift
    step of rolling s = w + (u(x) - u'(x + dx)) / dx   per unit of rolled distance, u' a step before
    steady rolling  s = w + (u(x) - u(x + dx)) / dx    the same with u' = u

The last two are right to the second order half way between an element and the next one ahead, where w is
taken, too. Taken as the slip of the element, with its own w (`order` 1), this is the scheme of Kalker and of
CONTACT (Kalker 1990, Three-dimensional elastic bodies in rolling contact, section 4.3).
"""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from femic.contact.block_mean import block_mean
from femic.contact.box import Box
from femic.contact.friction.centred import Linear, centred, centred_derivative
from femic.contact.friction.leading_edge import DEPTH
from geometries.arrays import Array
from geometries.errors import WrongInput


@dataclass(frozen=True, eq=False)
class FreeSlip:
    """A slip (n_x, n_s, 2) of unknown amplitude, that which brings about a force.

    The force is the sum of `weights` (n_x, n_s, 3) [mm^2] times tractions.
    """

    slip: Array
    weights: Array
    force: float

    @property
    def coarsened(self) -> "FreeSlip":
        """The same of elements twice as large."""
        return FreeSlip(block_mean(self.slip), 4 * block_mean(self.weights), self.force)

    def within(self, box: Box) -> "FreeSlip":
        """Return the same of elements in a box."""
        return FreeSlip(box.of(self.slip), box.of(self.weights), self.force)


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion with `rigid` slip (n_x, n_s, 2), besides that of unknown amplitude."""

    rigid: Array
    free: tuple[FreeSlip, ...] = ()

    depth = 0  # elements of a leading edge that follow others
    has_coarser = True

    def slip_of(self, u: Array) -> Array:
        """Return the part of slip that is linear in displacements, shape (n_x, n_s, 2)."""
        return u

    def at_elements(self, slip: Array) -> Array:
        """Return the slip at the centres of elements; it vanishes with `slip`, which may be beside these."""
        return slip

    def derivative_at_elements(self, slip: Array) -> Linear:  # noqa: ARG002 (linear here)
        """Return the derivative of it at a slip: a linear function of changes of this."""
        return lambda change: change

    @property
    def simpler(self) -> Self | None:
        """The same in a form that is less accurate and more robust, None where there is none."""
        return None

    @property
    def given(self) -> Array:
        """The slip without displacements, shape (n_x, n_s, 2)."""
        return self.rigid

    def given_at(self, approach: float) -> Array:  # noqa: ARG002 (a shift depends on it)
        """Return the slip without displacements at a vertical approach [mm], shape (n_x, n_s, 2)."""
        return self.given

    @property
    def of_free(self) -> Array:
        """The free slips, shape (k, n_x, n_s, 2)."""
        return np.reshape([free.slip for free in self.free], (len(self.free), *self.rigid.shape))

    def coarsened(self) -> Self:
        """Return the motion on elements twice as large."""
        return replace(self, rigid=block_mean(self.rigid), free=tuple(free.coarsened for free in self.free))

    def within(self, box: Box) -> Self:
        """Return the motion of the elements in a box."""
        return replace(self, rigid=box.of(self.rigid), free=tuple(free.within(box) for free in self.free))


@dataclass(frozen=True, eq=False)
class Shift(Motion):
    """A shift by `rigid` [mm], from displacements `before` (n_x, n_s, 2) [mm]; None: from none.

    A vertical approach beyond `approach_before` [mm] also shifts surfaces along s, by `per_approach` (n_s,)
    times as much: the sine of the inclination.
    """

    before: Array | None = None
    per_approach: Array | None = None
    approach_before: float = 0.0

    @property
    def given(self) -> Array:
        """The slip without displacements [mm], shape (n_x, n_s, 2)."""
        return self.rigid if self.before is None else self.rigid - self.before

    def given_at(self, approach: float) -> Array:
        """Return the slip without displacements at a vertical approach [mm], shape (n_x, n_s, 2)."""
        if self.per_approach is None:
            return self.given
        along_s = (approach - self.approach_before) * self.per_approach
        return self.given + along_s[:, None] * [0.0, 1.0]

    def coarsened(self) -> "Shift":
        """Return the shift on elements twice as large."""
        before = None if self.before is None else block_mean(self.before)
        sines = None if self.per_approach is None else self.per_approach.reshape(-1, 2).mean(axis=1)
        return replace(super().coarsened(), before=before, per_approach=sines)

    def within(self, box: Box) -> "Shift":
        """Return the shift of the elements in a box."""
        before = None if self.before is None else box.of(self.before)
        sines = None if self.per_approach is None else self.per_approach[box.strips]
        return replace(super().within(box), before=before, per_approach=sines)


@dataclass(frozen=True, eq=False)
class SteadyRolling(Motion):
    """Steady rolling on elements of length `dx` [mm], with an error of order 1 or 2 in it.

    Of order 2, `followers` elements at the leading edge of each row follow the one behind them.
    """

    dx: float = field(kw_only=True)
    order: int = 2
    followers: int = DEPTH

    def __post_init__(self) -> None:
        if self.order not in (1, 2):
            raise WrongInput(f"order = {self.order!r}: 1 or 2")

    @property
    def depth(self) -> int:  # type: ignore[override]
        """Elements of a leading edge that follow others."""
        return self.followers if self.order > 1 else 0

    @property
    def simpler(self) -> Self | None:
        """The same with fewer elements of a leading edge that follow others, None if there are none."""
        return replace(self, followers=self.depth - 1) if self.depth else None

    def slip_of(self, u: Array) -> Array:
        """Return the part of slip that is linear in displacements, shape (n_x, n_s, 2)."""
        return (u - ahead(u)) / self.dx

    def at_elements(self, slip: Array) -> Array:
        """Return the slip at the centres of elements, from that ahead and that behind them."""
        return slip if self.order == 1 else centred(slip)

    def derivative_at_elements(self, slip: Array) -> Linear:
        """Return the derivative of it at a slip: a linear function of changes of this."""
        return super().derivative_at_elements(slip) if self.order == 1 else centred_derivative(slip)

    @property
    def given(self) -> Array:
        """The slip without displacements, shape (n_x, n_s, 2)."""
        return self._half_way(self.rigid)

    @property
    def of_free(self) -> Array:
        """The free slips, shape (k, n_x, n_s, 2)."""
        slips = [self._half_way(free.slip) for free in self.free]
        return np.reshape(slips, (len(slips), *self.rigid.shape))

    def coarsened(self) -> "SteadyRolling":
        """Return the rolling on elements twice as large."""
        return replace(super().coarsened(), dx=2 * self.dx)

    def _half_way(self, rigid: Array) -> Array:
        return rigid if self.order == 1 else (rigid + ahead(rigid)) / 2


@dataclass(frozen=True, eq=False)
class RollingStep(SteadyRolling):
    """A step of rolling by the length of an element, from displacements `before` (n_x, n_s, 2) [mm]."""

    before: Array | None = None
    has_coarser = False  # the step is as long as an element

    def slip_of(self, u: Array) -> Array:
        """Return the part of slip that is linear in displacements, shape (n_x, n_s, 2)."""
        return u / self.dx

    @property
    def given(self) -> Array:
        """The slip without displacements, shape (n_x, n_s, 2)."""
        before = 0.0 if self.before is None else ahead(self.before) / self.dx
        return super().given - before

    def within(self, box: Box) -> "RollingStep":
        """Return the step of the elements in a box."""
        before = None if self.before is None else box.of(self.before)
        return replace(super().within(box), before=before)


def ahead(values: Array) -> Array:
    """Return the values of the next elements along x; the last ones have their own."""
    return np.concatenate([values[1:], values[-1:]])
