"""Operators on a part of their grid, in the form whose products are fastest there."""

from dataclasses import dataclass

from femic.contact.box import Box
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.dense import GridOperator
from femic.contact.operators.protocols import FullOperator
from geometries.arrays import Array

FEW_KERNELS = 9  # convolutions with no more are fast on any grid
MOST_DENSE = 96  # strips up to which products of others are 3 to 10 times faster dense between strips


@dataclass(frozen=True, eq=False)
class Part:
    """An operator of which nothing is known, on a part of its grid of some shape."""

    operator: FullOperator
    box: Box
    shape: tuple[int, ...]

    def __call__(self, tractions: Array) -> Array:
        """Return displacements [mm] due to tractions [MPa], shape (n_x, n_s, m) each."""
        return self.box.of(self.operator(self.box.filled(tractions, self.shape)))

    def restricted(self, directions: tuple[int, ...]) -> "Part":
        """Return the operator from tractions in some directions to displacements in the same."""
        return Part(self.operator.restricted(directions), self.box, self.shape)

    def coarsened(self) -> "Part":
        """Return the operator on elements twice as large; all ends must be even numbers of elements."""
        return Part(self.operator.coarsened(), self.box.coarsened, tuple(n // 2 for n in self.shape))


def part_of(operator: FullOperator, box: Box, shape: tuple[int, ...]) -> FullOperator:
    """Return an operator of a grid of some shape on a part of it."""
    if isinstance(operator, GridOperator):
        return operator if box.shape == shape else operator.part(*box.shape[:1], box.strips)
    if not isinstance(operator, Convolution):
        return Part(operator, box, shape)
    part = operator.part(box.shape[0], box.strips)
    return GridOperator.of_convolution(part) if _faster_dense(part) else part


def coarsened(operator: FullOperator) -> FullOperator:
    """Return an operator on elements twice as large, in the form that is fastest there."""
    if isinstance(operator, Convolution) and _faster_dense(operator):
        return GridOperator.of_coarsened(operator)
    return operator.coarsened()


def _faster_dense(operator: Convolution) -> bool:
    return len(operator.kernels) > FEW_KERNELS and operator.shape[1] <= MOST_DENSE
