"""The ICs of a contact by name: C, which is computed, approximations, and others that the caller gives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, TypeVar

import numpy as np

from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import N

C = "C"
Given = TypeVar("Given")


class NormalICs(Protocol):
    """nn ICs of both bodies that are known on one grid, such as those of a map of C."""

    @property
    def grid(self) -> Grid:
        """The grid on which they are known."""
        ...

    def at(self, on_grid: PairOnGrid) -> tuple[Array, Array]:
        """Return the ICs of bodies on this grid and their estimated errors [mm/MPa], (n_x, n_s, n_s) each."""
        ...


@dataclass(frozen=True, eq=False)
class GivenICs:
    """ICs of both bodies on a grid [mm/MPa], at lags >= 0 between strips, and their estimated errors.

    Shape (n_x, n_s, n_s, 3, 3), or (n_x, n_s, n_s) for nn alone, which contact without friction needs. In
    rolling, displacements of the wheel are those that the rail sees.
    """

    grid: Grid
    ics: Array
    estimate: Array | float = 0.0

    def at(self, _: PairOnGrid) -> tuple[Array, Array]:
        """Return the nn ICs and their estimated errors, (n_x, n_s, n_s) each."""
        estimate = np.broadcast_to(self.estimate, self.ics.shape)
        return (self.ics, estimate) if self.ics.ndim == 3 else (self.ics[..., N, N], estimate[..., N, N])

    @property
    def operator(self) -> GridOperator:
        """The ICs in all directions. Raises WrongInput for nn alone."""
        self._require_all_directions()
        return GridOperator.of(self.ics)

    @property
    def perturbed(self) -> GridOperator | None:
        """The same with their estimated errors added; None where no errors are known."""
        self._require_all_directions()
        return GridOperator.of(self.ics + self.estimate) if np.any(self.estimate) else None

    def _require_all_directions(self) -> None:
        if self.ics.ndim != 5:
            raise WrongInput(
                f"ICs of shape {self.ics.shape}: contact with friction needs (n_x, n_s, n_s, 3, 3)"
            )


NONE_GIVEN: Mapping[str, GivenICs] = MappingProxyType({})


def given_of(ics: Sequence[str], given: Mapping[str, Given]) -> dict[str, Given]:
    """Return the given ICs among those named."""
    return {name: given[name] for name in ics if name in given}


def reference_name(ics: Sequence[str], given: Sequence[str] = ()) -> str:
    """Return the ICs that others are compared with: C, or without it given ones, B-hat, or the last."""
    first = (C, *(name for name in ics if name in given), "Bhat")
    return next((name for name in first if name in ics), ics[-1])
