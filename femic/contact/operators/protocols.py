"""What contact needs of ICs: operators on a grid, from anywhere."""

from typing import Protocol, Self

from geometries.arrays import Array


class Operator(Protocol):
    """ICs as an operator from tractions [MPa] to displacements [mm], shape (n_x, n_s, directions) each."""

    def __call__(self, tractions: Array) -> Array:
        """Return displacements due to tractions."""
        ...

    def coarsened(self) -> Self:
        """Return the operator on elements twice as large."""
        ...


class FullOperator(Operator, Protocol):
    """ICs of all directions."""

    def restricted(self, directions: tuple[int, ...]) -> Self:
        """Return the operator from tractions in some directions to displacements in the same."""
        ...
