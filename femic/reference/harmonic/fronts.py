"""The fronts of a section: dense matrices that amplitudes are eliminated from, part by part of its cells.

The front of a leaf has the matrices of its cells, that of a whole what the elimination of its halves leaves.
A row of the border, forces of loads or what observers see, joins a front with the amplitudes that are
eliminated there. So all places are known before the first wavenumber is solved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix

from femic.reference.harmonic.dissection import Part, dissected
from femic.reference.harmonic.section_model import SectionModel
from geometries.arrays import Array, Indices, Mask

MOST_RUNS = 12  # of consecutive places up to which blocks are added one by one

Entries = tuple[Indices, Indices, slice]  # amplitude and border of entries in a front, and which they are


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations [[K, F], [G, 0]] of a section with loads and observers.

    Amplitudes that are not `free` (n_nodes, 3) are held, those of the `last` nodes (n_nodes,) retained.
    Forces F (3 n_nodes, n) and observers G (m, 3 n_nodes) have all amplitudes.
    """

    model: SectionModel
    free: Mask
    last: Mask
    forces: csr_matrix
    observers: csr_matrix


@dataclass(frozen=True, eq=False)
class Half:
    """The places that rows and columns of what is left of a half have in the front of the whole."""

    number: int
    rows: Indices
    columns: Indices

    @cached_property
    def blocks(self) -> list[tuple[slice, slice, slice, slice]]:
        """The same as rows and columns of blocks, in the half, then in the whole; none if they are many."""
        rows, columns = _runs(self.rows), _runs(self.columns)
        if max(len(rows), len(columns)) > MOST_RUNS:
            return []
        return [(row, column, at, beside) for row, at in rows for column, beside in columns]


@dataclass(frozen=True, eq=False)
class Front:
    """Equations of a part: those of amplitudes, then, as rows, what observers see, and as columns, loads.

    The first amplitudes are those that are eliminated here: consecutive numbers from `first` on.
    """

    first: int
    eliminated: int
    amplitudes: Indices
    loads: Indices
    observers: Indices
    stiffness: Array | None  # of a leaf: parts (3, n, n) of K
    halves: tuple[Half, ...]
    forces: Entries
    seen: Entries

    @property
    def kept(self) -> Indices:
        """The amplitudes that are not eliminated here."""
        return self.amplitudes[self.eliminated :]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        n = len(self.amplitudes)
        return n + len(self.observers), n + len(self.loads)


@dataclass(frozen=True, eq=False)
class Order:
    """The parts of a section, and its free amplitudes in the order in which these eliminate them.

    `amplitudes` are their numbers 3 n + c, c the component at node n, the retained ones last. Forces F and
    observers G^T are in this order.
    """

    equations: Equations
    parts: list[Part]
    amplitudes: Indices
    number: Indices  # of each of the 3 n_nodes amplitudes in this order
    starts: Indices  # the first number of each part, and behind the last one of the retained amplitudes
    forces: csr_matrix
    seen: csr_matrix

    @classmethod
    def of(cls, equations: Equations) -> "Order":
        """The order of a section's amplitudes."""
        model, free, last = equations.model, equations.free, equations.last
        parts = dissected(model.cells, model.section.mesh.doflocs, last)
        groups = [_amplitudes(part.eliminated, free) for part in parts]
        amplitudes = np.concatenate([*groups, _amplitudes(np.flatnonzero(last), free)])
        number = np.full(free.size, -1)
        number[amplitudes] = np.arange(len(amplitudes))
        starts = np.append(0, np.cumsum([len(group) for group in groups]))
        forces, seen = (
            csr_matrix(border)[amplitudes] for border in (equations.forces, equations.observers.T)
        )
        return cls(equations, parts, amplitudes, number, starts, forces, seen)

    @property
    def retained(self) -> int:
        """Number of retained amplitudes."""
        return len(self.amplitudes) - int(self.starts[-1])

    def fronts(self) -> list[Front]:
        """The fronts of all parts, and last that of the retained amplitudes with the whole border."""
        fronts: list[Front] = []
        for number, part in enumerate(self.parts):
            kept = np.sort(self.number[_amplitudes(part.kept, self.equations.free)])
            amplitudes = np.append(np.arange(*self.starts[number : number + 2]), kept)
            halves = {half: fronts[half] for half in part.halves}
            loads = self._joined(self.forces, number, [half.loads for half in halves.values()])
            observers = self._joined(self.seen, number, [half.observers for half in halves.values()])
            fronts.append(self._front(number, amplitudes, (loads, observers), part.cells, halves))
        retained = np.arange(self.starts[-1], len(self.amplitudes))
        border = np.arange(self.forces.shape[1]), np.arange(self.seen.shape[1])
        whole = len(self.parts)
        return [*fronts, self._front(whole, retained, border, None, {whole - 1: fronts[-1]})]

    def _joined(self, border: csr_matrix, number: int, of_halves: Sequence[Indices]) -> Indices:
        """The columns of a border that a part has: those of its halves and of what it eliminates."""
        low, high = border.indptr[self.starts[number : number + 2]]
        return np.unique(np.concatenate([border.indices[low:high], *of_halves])).astype(np.int64)

    def _front(
        self,
        number: int,
        amplitudes: Indices,
        border: tuple[Indices, Indices],
        cells: Indices | None,
        halves: Mapping[int, Front],
    ) -> Front:
        """The front of a part; the number behind the last one is that of the retained amplitudes."""
        retains = number == len(self.parts)
        first = int(self.starts[number])
        end = len(self.amplitudes) if retains else int(self.starts[number + 1])
        loads, observers = border
        return Front(
            first,
            0 if retains else end - first,
            amplitudes,
            loads,
            observers,
            None if cells is None else self._stiffness(cells, amplitudes),
            tuple(
                Half(
                    half,
                    _placed(amplitudes, observers, front.kept, front.observers),
                    _placed(amplitudes, loads, front.kept, front.loads),
                )
                for half, front in halves.items()
            ),
            _entries(self.forces, (first, end), len(amplitudes), loads),
            _entries(self.seen, (first, end), len(amplitudes), observers),
        )

    def _stiffness(self, cells: Indices, amplitudes: Indices) -> Array:
        """The sums (3, n, n) of the matrices of some cells, without amplitudes that are held."""
        model, n = self.equations.model, len(amplitudes)
        of_cells = (3 * model.cells[cells][:, :, None] + np.arange(3)).reshape(len(cells), -1)
        is_free = self.equations.free.ravel()[of_cells]
        place = np.where(is_free, np.searchsorted(amplitudes, self.number[of_cells]), n)
        entry = (place[:, :, None] * (n + 1) + place[:, None, :]).ravel()
        sums = [np.bincount(entry, part[cells].ravel(), (n + 1) ** 2) for part in model.cell_matrices]
        return np.array(sums, dtype=float).reshape(3, n + 1, n + 1)[:, :n, :n]


def _amplitudes(nodes: Indices, free: Mask) -> Indices:
    """Numbers 3 n + c of the free amplitudes of nodes."""
    amplitudes = (3 * nodes[:, None] + np.arange(3)).ravel()
    return np.asarray(amplitudes[free.ravel()[amplitudes]])


def _entries(border: csr_matrix, rows: tuple[int, int], n: int, columns: Indices) -> Entries:
    """The entries of a border in the front of n amplitudes that eliminates those of some rows."""
    first, end = rows
    low, high = border.indptr[first], border.indptr[end]
    row = np.repeat(np.arange(end - first), np.diff(border.indptr[first : end + 1]))
    return row, n + np.searchsorted(columns, border.indices[low:high]), slice(low, high)


def _placed(amplitudes: Indices, border: Indices, of_half: Indices, border_of_half: Indices) -> Indices:
    """The places of the amplitudes and the border of a half among those of the whole."""
    behind = len(amplitudes) + np.searchsorted(border, border_of_half)
    return np.append(np.searchsorted(amplitudes, of_half), behind)


def _runs(places: Indices) -> list[tuple[slice, slice]]:
    """Runs of consecutive places: which of them, and where."""
    cuts = np.flatnonzero(np.diff(places) != 1) + 1
    ends = pairwise([0, *cuts.tolist(), len(places)])
    return [
        (slice(low, high), slice(int(places[low]), int(places[low]) + high - low))
        for low, high in ends
        if high > low
    ]
