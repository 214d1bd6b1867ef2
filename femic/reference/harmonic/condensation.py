"""Responses of observers to loads at wavenumbers, for several supports at once.

Only the amplitudes G K^-1 F at the observers are needed, not all amplitudes K^-1 F under forces F. Those that
some supports hold and others leave free are retained: all others are eliminated once (`elimination`), and for
each support the free retained ones from what is left, which leaves G K^-1 F. One system per support is solved
for its amplitudes, to verify factors, what is left, and the responses.

Where observers are many and loads few, observers are not carried along: the amplitudes under all loads are
computed. A field takes as long as `ROWS_PER_FIELD` observers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from femic.reference.harmonic.elimination import Eliminated, Elimination
from femic.reference.harmonic.equations import column_weights, not_solved, require_small
from femic.reference.harmonic.fronts import Equations
from geometries.arrays import Array, Mask

ROWS_PER_FIELD = 10  # observers that take as long as one field


@dataclass(frozen=True, eq=False)
class Condensation:
    """The equations of a section with loads and observers, at any wavenumbers."""

    elimination: Elimination
    forces: csr_matrix  # F (amplitudes, n), in the order of elimination
    observers: csr_matrix  # G (m, amplitudes)
    by_fields: bool  # responses are read from the amplitudes under all loads

    @classmethod
    def of(cls, equations: Equations, supports: int) -> "Condensation":
        """Prepare the responses of a section with a number of `supports`."""
        forces, observers = equations.forces, equations.observers
        by_fields = ROWS_PER_FIELD * supports * forces.shape[1] < observers.shape[0]
        carried = observers[:0] if by_fields else observers
        elimination = Elimination.of(replace(equations, observers=carried))
        seen = csr_matrix(observers[:, elimination.amplitudes])
        return cls(elimination, elimination.forces, seen, by_fields)

    @property
    def retained(self) -> int:
        """Number of retained amplitudes."""
        return self.elimination.retained

    def at(self, k: Sequence[float]) -> "Condensed":
        """The condensed equations at wavenumbers [1/mm]; raises NotConverged where a pivot is 0."""
        try:
            return Condensed(self, self.elimination.at(k))
        except np.linalg.LinAlgError as error:
            raise not_solved(max(k), len(self.elimination.amplitudes), str(error)) from error


@dataclass(frozen=True, eq=False)
class Condensed:
    """The equations of retained amplitudes, loads and observers at some wavenumbers."""

    condensation: Condensation
    eliminated: Eliminated

    def responses(self, supports: Sequence[Mask]) -> tuple[list[Array], Array]:
        """Responses (k, m, n) [mm^2/N] with each support, and the largest residual (k,) that proves them.

        A support marks which of the retained amplitudes it leaves free. Raises NotConverged where a residual
        is too large.
        """
        prepared = self.condensation
        moved = [self._retained(free) for free in supports]
        weights = column_weights(prepared.forces)
        combined = np.eye(len(weights)) if prepared.by_fields else weights[:, None]
        fields = np.split(
            self.eliminated.fields(
                np.concatenate([of_support @ combined for of_support in moved], axis=2),
                np.tile(combined, len(moved)),
            ),
            len(moved),
            axis=2,
        )
        if prepared.by_fields:
            found = [_seen(prepared.observers, field) for field in fields]
            fields, seen = [field @ weights[:, None] for field in fields], None
        else:
            found = [self._seen_when(of_support) for of_support in moved]
            seen = [of_support @ weights[:, None] for of_support in found]
        residuals = self._residuals(supports, np.concatenate(fields, axis=2), seen, weights)
        for k, residual in zip(self.eliminated.k, residuals, strict=True):
            require_small(float(residual), float(k), len(prepared.elimination.amplitudes))
        return found, residuals

    def _retained(self, free: Mask) -> Array:
        """Retained amplitudes (k, retained, n) under the loads."""
        left, n = self.eliminated.left[:, : len(free)][:, free], len(free)
        moved = np.zeros((len(left), n, self.eliminated.left.shape[2] - n))
        try:
            moved[:, free] = np.linalg.solve(left[:, :, :n][:, :, free], left[:, :, n:])
        except np.linalg.LinAlgError as error:
            size = len(self.condensation.elimination.amplitudes)
            raise not_solved(float(np.max(self.eliminated.k)), size, str(error)) from error
        return moved

    def _seen_when(self, moved: Array) -> Array:
        """What observers see (k, m, n) where retained amplitudes are `moved` by the loads."""
        of_observers, n = self.eliminated.left[:, moved.shape[1] :], moved.shape[1]
        return np.asarray(of_observers[:, :, :n] @ moved - of_observers[:, :, n:])

    def _residuals(
        self, supports: Sequence[Mask], fields: Array, seen: Sequence[Array] | None, weights: Array
    ) -> Array:
        """The largest residual at each k of fields (k, amplitudes, support) under the weighted loads.

        That of the equations of free amplitudes, or, where observers were carried along, of the observed
        amplitudes: a share of the amplitudes at the loads, if they move more than the observers.
        """
        prepared = self.condensation
        unbalanced = self.eliminated.forces(fields) - (prepared.forces @ weights)[:, None]
        at_retained = unbalanced[:, unbalanced.shape[1] - prepared.retained :]
        at_retained[:, ~np.stack(supports, axis=1)] = 0.0
        residuals = np.max(np.linalg.norm(unbalanced, axis=1), axis=1)
        if seen is None:
            return np.asarray(residuals)
        of_fields, at_loads = (_seen(rows, fields) for rows in (prepared.observers, prepared.forces.T))
        by_condensation = np.concatenate(seen, axis=2)
        size = np.max(
            [np.linalg.norm(values, axis=1) for values in (by_condensation, of_fields, at_loads)], axis=0
        )
        apart = np.linalg.norm(by_condensation - of_fields, axis=1) / size
        return np.asarray(np.maximum(residuals, np.max(apart, axis=1)))


def _seen(rows: csr_matrix, fields: Array) -> Array:
    """Products (k, m, c) of rows (m, amplitudes) with fields (k, amplitudes, c)."""
    return np.stack([rows @ field for field in fields])
