"""A contact with friction: ICs of two bodies on a grid, their distance, and how surfaces incline."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from femic.contact.friction.law import Strips
from femic.contact.friction.motion import Motion
from femic.contact.normal import NormalProblem
from femic.contact.operators.convolution import Convolution, Waves
from femic.contact.operators.dense import coarsened, restrict_to
from femic.contact.operators.protocols import FullOperator, Operator
from femic.contact.patch import MARGIN, Box
from femic.contact.small import SmallContact
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Grid, N, S, X

TANGENTIAL = (X, S)
MOST_PARTS = 4  # that are kept, the last ones


@dataclass(frozen=True, eq=False)
class FrictionalProblem:
    """Two bodies on a grid, with friction: their ICs in all directions, distance, and how surfaces incline.

    `distance` [mm], (n_x, n_s), as in `NormalProblem`; `inclination` [rad], (n_s,); `flat` are the ICs of
    half-spaces, whose inverse is a preconditioner; `friction` is the coefficient, zero or more, which each
    strip has times its `factor`, (n_s,), None: 1. Beside the contact `margin` elements are needed.
    """

    grid: Grid
    operator: FullOperator
    flat: Convolution
    distance: Array
    inclination: Array
    friction: float
    margin: int = MARGIN
    factor: Array | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.friction < np.inf:
            raise WrongInput(f"friction = {self.friction!r}: must be zero or positive, and finite")
        if self.factor is None:
            return
        n_s = self.grid.n_s
        if np.shape(self.factor) != (n_s,):
            raise WrongInput(
                f"factor of friction, shape {np.shape(self.factor)}: one per strip, shape ({n_s},)"
            )
        wrong = np.flatnonzero(~((np.asarray(self.factor) >= 0) & np.isfinite(self.factor)))
        if len(wrong):
            raise WrongInput(
                f"factor of friction = {self.factor[wrong[0]]!r} at strip {wrong[0]}: must be zero or "
                "positive, and finite"
            )

    @property
    def coefficients(self) -> Array | float:
        """Coefficients of friction of the strips, shape (n_s,), or of all of them."""
        return self.friction if self.factor is None else self.friction * self.factor

    def bound(self, pressures: Array) -> Array:
        """Return the largest tangential tractions [MPa] at pressures (n_x, n_s) [MPa], of this shape."""
        return np.asarray(self.coefficients * pressures)

    def scales(self, pressures: Array) -> tuple[float, float]:
        """Return what errors of pressures, and of tangential tractions, are shares of [MPa].

        The largest pressure, and the largest bound if this is less.
        """
        peak = float(np.max(pressures))
        return peak, min(float(np.max(self.bound(pressures))), peak)

    @cached_property
    def normal(self) -> NormalProblem:
        """The problem of the pressures without tangential tractions; raises as `NormalProblem`."""
        return NormalProblem(
            self.grid,
            self.operator.restricted((N,)),
            self.flat.restricted((N,)),
            self.distance,
            np.cos(self.inclination),
        )

    @property
    def small(self) -> SmallContact | None:
        """The contact for compiled loops, None if the grid is large."""
        cosine, sine = np.cos(self.inclination), np.sin(self.inclination)
        others = cosine, self.grid.area, sine, self.coefficients
        return SmallContact.make(self.operator, self.flat, self.distance, *others)

    @cached_property
    def tangential(self) -> Operator:
        """The ICs of tangential tractions and displacements."""
        return self.operator.restricted(TANGENTIAL)

    def strips(self, motion: Motion) -> Strips:
        """Return how half-spaces slip in motions of a kind: a preconditioner."""
        kind = type(motion)
        if kind not in self._strips:
            self._strips[kind] = Strips.on_half_spaces(self.flat.restricted(TANGENTIAL), motion)
        return self._strips[kind]

    @cached_property
    def _strips(self) -> dict[type[Motion], Strips]:
        return {}

    @cached_property
    def ring_inverse(self) -> Waves:
        """Approximately the pressures that cause gaps, shape (n_x, n_s, 1) each."""
        return self.flat.restricted((N,)).ring_inverse

    @property
    def has_coarser(self) -> bool:
        """Whether the grid can be made of elements twice as large."""
        return self.grid.n_x % 2 == 0 and self.grid.n_s % 2 == 0

    @cached_property
    def coarsened(self) -> "FrictionalProblem":
        """The problem on elements twice as large, the same tractions on four at a time.

        One element beside its contact is enough: the area is the same, and ends of fewer elements only make
        a reading of the edges less accurate.
        """
        normal, factor = self.normal.coarsened, self.factor
        inclination = self.inclination.reshape(-1, 2).mean(axis=1)
        return FrictionalProblem(
            normal.grid,
            coarsened(self.operator),
            self.flat.coarsened(),
            normal.distance,
            inclination,
            self.friction,
            margin=1,
            factor=None if factor is None else factor.reshape(-1, 2).mean(axis=1),
        )

    def within(self, box: Box) -> "FrictionalProblem":
        """Return the problem on the elements of a box, with the ICs in the form that is fastest there."""
        if box not in self._parts:
            if len(self._parts) == MOST_PARTS:
                del self._parts[next(iter(self._parts))]
            s = float(np.mean(self.grid.strips[box.strips]))
            self._parts[box] = FrictionalProblem(
                Grid(*box.shape, self.grid.dx, self.grid.ds, s),
                restrict_to(self.operator, box, self.distance.shape),
                self.flat.part(box.shape[0], box.strips),
                box.crop(self.distance),
                self.inclination[box.strips],
                self.friction,
                factor=None if self.factor is None else self.factor[box.strips],
            )
        return self._parts[box]

    @cached_property
    def _parts(self) -> "dict[Box, FrictionalProblem]":
        return {}
