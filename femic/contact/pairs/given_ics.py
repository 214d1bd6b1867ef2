"""The ICs of a contact by name: C, which is computed, approximations, and others that the caller gives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from femic.contact.pairs.pair_on_grid import PairOnGrid
from geometries.arrays import Array
from geometries.grids import Grid

C = "C"


class NormalICs(Protocol):
    """nn ICs of both bodies that are known on one grid, such as those of a map of C."""

    @property
    def grid(self) -> Grid:
        """The grid on which they are known."""
        ...

    def at(self, on_grid: PairOnGrid) -> tuple[Array, Array]:
        """The ICs of bodies on this grid and their estimated errors [mm/MPa], (n_x, n_s, n_s) each."""
        ...


@dataclass(frozen=True, eq=False)
class GivenICs:
    """nn ICs (n_x, n_s, n_s) [mm/MPa] on a grid, at lags >= 0 between strips, and their estimated errors."""

    grid: Grid
    ics: Array
    estimate: Array | float = 0.0

    def at(self, _: PairOnGrid) -> tuple[Array, Array]:
        """The ICs and their estimated errors, (n_x, n_s, n_s) each."""
        return self.ics, np.broadcast_to(self.estimate, self.ics.shape)


NONE_GIVEN: Mapping[str, NormalICs] = MappingProxyType({})


def given_of(ics: Sequence[str], given: Mapping[str, NormalICs]) -> dict[str, NormalICs]:
    """The given ICs among those named."""
    return {name: given[name] for name in ics if name in given}


def approximations_of(ics: Sequence[str], given: Mapping[str, NormalICs] = NONE_GIVEN) -> list[str]:
    """The names of approximations among those of ICs."""
    return [name for name in ics if name != C and name not in given]


def reference_name(ics: Sequence[str], given: Sequence[str] = ()) -> str:
    """The ICs that others are compared with: C, or without it given ones, B-hat, or the last."""
    first = (C, *(name for name in ics if name in given), "Bhat")
    return next((name for name in first if name in ics), ics[-1])
