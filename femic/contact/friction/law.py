"""Coulomb's law on free elements as equations, and these made linear.

Tractions q with |q| <= g are the projection of q - r s onto the disc of radius g, for any r > 0, s the slip:
elements stick where |q - r s| <= g, with r s = 0, and slip elsewhere, with q = g (q - r s) / |q - r s| (Alart
and Curnier 1991, Computer Methods in Applied Mechanics and Engineering 92, 353-375).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from femic.contact.friction.centred import Linear
from femic.contact.friction.motion import Motion
from geometries.arrays import Array, Mask

TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Law:
    """The law at tractions `q` (m, 2) and bounds `g` (m, 1) of the elements in `free` (n_x, n_s).

    `slip` (n_x, n_s, 2) vanishes where elements stick; friction opposes the slip at their centres, which
    `motion` finds from it. `scale` is r. Elements in `sticking` stick whatever their bounds.
    """

    motion: Motion
    scale: float
    free: Mask
    q: Array
    g: Array
    slip: Array
    sticking: bool = False

    @cached_property
    def centred(self) -> Array:
        """Slip at the centres of elements, shape (n_x, n_s, 2)."""
        return self.motion.at_elements(self.slip)

    @cached_property
    def trial(self) -> Array:
        """Q - r s, shape (m, 2)."""
        return np.asarray(self.q - self.scale * self.centred[self.free])

    @cached_property
    def length(self) -> Array:
        """Length of it, shape (m, 1)."""
        return np.maximum(np.linalg.norm(self.trial, axis=1, keepdims=True), TINY)

    @cached_property
    def stick(self) -> Mask:
        """Which elements stick, shape (m,)."""
        return np.full(len(self.q), True) if self.sticking else np.ravel(self.length <= self.g)

    @cached_property
    def direction(self) -> Array:
        """Q - r s over its length, shape (m, 2)."""
        return self.trial / self.length

    @cached_property
    def share(self) -> Array:
        """G / |q - r s|, at most 1, shape (m, 1)."""
        return np.minimum(self.g / self.length, 1.0)

    @property
    def residual(self) -> Array:
        """What vanishes at a solution, in units of tractions, shape (m, 2)."""
        sticks = self.scale * self.slip[self.free]
        return np.where(self.stick[:, None], sticks, self.q - self.g * self.direction)

    @property
    def defect(self) -> Array:
        """Q less the projection of q - r s, continuous where elements begin to slip, shape (m, 2)."""
        return np.asarray(self.q - self.share * self.trial)

    @cached_property
    def at_elements(self) -> Linear:
        """The derivative of slip at centres by slip."""
        return self.motion.derivative_at_elements(self.slip)

    def derivative(self, q: Array, slip: Array, g: Array | float = 0.0) -> Array:
        """Return changes of the residual (m, 2) by those of q (m, 2), slip (n_x, n_s, 2) and g (m, 1)."""
        across = self.across(q - self.scale * self.at_elements(slip)[self.free])
        slides = q - self.share * across - g * self.direction
        return np.where(self.stick[:, None], self.scale * slip[self.free], slides)

    def across(self, values: Array) -> Array:
        """Return the part of values (m, 2) across the direction of tractions."""
        return np.asarray(values - self.direction * np.sum(self.direction * values, axis=1, keepdims=True))

    @property
    def coefficients(self) -> tuple[Array, Array, Array]:
        """Derivatives of both residuals of an element by its traction in the same direction, (m, 2) each.

        By the traction itself, by slip at the element, and by slip at the one behind it.
        """
        stick, across = self.stick[:, None], self.share * (1 - self.direction**2)
        own, behind = self._of_slips()
        return (
            np.where(stick, 0.0, 1 - across),
            self.scale * np.where(stick, 1.0, self.share * own),
            self.scale * np.where(stick, 0.0, self.share * behind),
        )

    def _of_slips(self) -> tuple[Array, Array]:
        """Return the parts of centred slip across tractions due to slip there and behind, (m, 2) each."""
        even = (np.arange(len(self.slip)) % 2 == 0)[:, None, None]
        own, behind = np.zeros_like(self.q), np.zeros_like(self.q)
        for i, unit in enumerate(np.eye(2)):
            of_even, of_odd = (
                self.at_elements(np.broadcast_to(mask * unit, self.slip.shape)) for mask in (even, ~even)
            )
            own[:, i] = self.across(np.where(even, of_even, of_odd)[self.free])[:, i]
            behind[:, i] = self.across(np.where(even, of_odd, of_even)[self.free])[:, i]
        return own, behind
