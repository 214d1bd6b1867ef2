"""Elimination of amplitudes from the equations of a section, at several wavenumbers at once.

The bordered matrix is M = [[K, F], [G, 0]], with K(k) = K0 + k K1 + k^2 K2, forces F of loads and rows G of
observers. All amplitudes but the retained ones are eliminated: what is left of M are the condensed equations
of the retained amplitudes, with the effect of the loads on them and their effect on the observers. The method
is multifrontal (I. S. Duff, J. K. Reid, ACM Trans. Math. Softw. 9, 1983, 302-325): dense matrices, the
fronts, are the same for all wavenumbers. Pivots need no exchange between fronts: where the retained
amplitudes and those of other parts are held, K is positive definite.

Nested dissection gives an order with little fill. Cells are halved again and again. A node is eliminated with
the smallest part that has all of its cells: so parts side by side do not know of each other, and what is left
of a part are the nodes on its boundary (A. George, SIAM J. Numer. Anal. 10, 1973, 345-363). Cells grow with
the distance from the load: besides lines in four directions, circles round the smallest cell separate halves
with few nodes in common.

The front of a leaf has the matrices of its cells, that of a whole what the elimination of its halves leaves.
A row of the border, forces of loads or what observers see, joins a front with the amplitudes that are
eliminated there. So all places are known before the first wavenumber is solved.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix

from femic.reference.harmonic.section import SectionModel
from geometries.arrays import Array, Indices, Mask

# --- nested dissection ---

CELLS_OF_A_LEAF = 4  # up to which parts are not halved: more cells have larger, fewer matrices


@dataclass(frozen=True, eq=False)
class Part:
    """A part of the cells: those of a leaf, or the two parts with these numbers; and its nodes.

    `eliminated` have all of their cells in it, `kept` do not.
    """

    cells: Indices | None
    halves: tuple[int, ...]
    eliminated: Indices
    kept: Indices


def dissect(cells: Indices, places: Array, last: Mask) -> list[Part]:
    """Parts of cells (n, 15), their nodes at places (2, n_nodes) [mm]; both halves come before their whole.

    The last part is the whole. Nodes that are marked in `last` (n_nodes,) are kept by all parts.
    """
    corners = places[:, cells[:, :3]]  # (2, n, 3)
    (y, z), sizes = corners.mean(axis=2), np.ptp(corners, axis=2).max(axis=0)
    smallest = int(np.argmin(sizes))
    measures = y, z, y + z, y - z, np.hypot(y - y[smallest], z - z[smallest])
    cells_of_node = np.bincount(cells.ravel(), minlength=places.shape[1])
    parts: list[Part] = []
    counts: list[Indices] = []  # of the cells that each kept node has in its part

    def add(chosen: Indices) -> int:
        halves = _halves(cells, measures, chosen)
        numbers = tuple(add(half) for half in halves)
        if halves:
            repeated = np.concatenate([parts[number].kept for number in numbers])
            nodes, places_of_repeated = np.unique(repeated, return_inverse=True)
            count = np.bincount(places_of_repeated, np.concatenate([counts[n] for n in numbers])).astype(int)
        else:
            nodes, count = np.unique(cells[chosen], return_counts=True)
        done = (count == cells_of_node[nodes]) & ~last[nodes]
        gone, at = nodes[done], places[:, nodes[done]]
        if len(gone):  # in order along their longer extent, so that neighbours have consecutive numbers
            gone = gone[np.argsort(at[np.argmax(np.ptp(at, axis=1))], kind="stable")]
        parts.append(Part(None if halves else chosen, numbers, gone, nodes[~done]))
        counts.append(count[~done])
        return len(parts) - 1

    add(np.arange(len(cells)))
    return parts


def _halves(cells: Indices, measures: Sequence[Array], chosen: Indices) -> tuple[Indices, ...]:
    """The two halves of some cells with the fewest nodes in common, none if they are not to be halved.

    Halves lie below and above the median of one of the `measures` of cells.
    """
    if len(chosen) <= CELLS_OF_A_LEAF:
        return ()
    marked = np.zeros(np.max(cells[chosen]) + 1, dtype=bool)
    best: tuple[int, tuple[Indices, ...]] = (np.iinfo(np.int64).max, ())
    for measure in measures:
        lower, upper = np.split(chosen[np.argsort(measure[chosen], kind="stable")], [len(chosen) // 2])
        marked[:] = False
        marked[cells[lower]] = True
        nodes = cells[upper].ravel()
        common = len(np.unique(nodes[marked[nodes]]))
        best = min(best, (common, (lower, upper)), key=lambda found: found[0])
    return best[1]


# --- fronts ---

MOST_RUNS = 12  # of consecutive places up to which blocks are added one by one

Entries = tuple[Indices, Indices, slice]  # amplitude and border of entries in a front, and which they are


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

    def add(self, left: Array, matrix: Array) -> None:
        """Add what is left of the half to the matrix of the whole."""
        for rows, columns, at, beside in self.blocks:
            matrix[:, at, beside] += left[:, rows, columns]
        if not self.blocks:
            matrix[:, self.rows[:, None], self.columns] += left


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


def _amplitudes(nodes: Indices, free: Mask) -> Indices:
    """Numbers 3 n + c of the free amplitudes of nodes."""
    amplitudes = (3 * nodes[:, None] + np.arange(3)).ravel()
    return np.asarray(amplitudes[free.ravel()[amplitudes]])


def _sum_cells(
    model: SectionModel, cells: Indices, free: Mask, number: Indices, amplitudes: Indices
) -> Array:
    """The sums (3, n, n) of the matrices of some cells, without amplitudes that are held."""
    n = len(amplitudes)
    cell_amplitudes = (3 * model.cells[cells][:, :, None] + np.arange(3)).reshape(len(cells), -1)
    place = np.where(free.ravel()[cell_amplitudes], np.searchsorted(amplitudes, number[cell_amplitudes]), n)
    entry = (place[:, :, None] * (n + 1) + place[:, None, :]).ravel()
    sums = [np.bincount(entry, part[cells].ravel(), (n + 1) ** 2) for part in model.cell_matrices]
    return np.array(sums, dtype=float).reshape(3, n + 1, n + 1)[:, :n, :n]


def _join(border: csr_matrix, first: int, end: int, halves: Sequence[Indices]) -> Indices:
    """The columns of a border that a part has: those of its halves and of the rows that it eliminates."""
    low, high = border.indptr[[first, end]]
    return np.unique(np.concatenate([border.indices[low:high], *halves])).astype(np.int64)


def _entries(border: csr_matrix, first: int, end: int, n: int, columns: Indices) -> Entries:
    """The entries of a border in the front of n amplitudes that eliminates those of some rows."""
    low, high = border.indptr[[first, end]]
    row = np.repeat(np.arange(end - first), np.diff(border.indptr[first : end + 1]))
    return row, n + np.searchsorted(columns, border.indices[low:high]), slice(low, high)


def _places(amplitudes: Indices, border: Indices, half: Indices, half_border: Indices) -> Indices:
    """The places of the amplitudes and the border of a half among those of the whole."""
    behind = len(amplitudes) + np.searchsorted(border, half_border)
    return np.append(np.searchsorted(amplitudes, half), behind)


def _runs(places: Indices) -> list[tuple[slice, slice]]:
    """Runs of consecutive places: which of them, and where."""
    cuts = np.flatnonzero(np.diff(places) != 1) + 1
    ends = pairwise([0, *cuts.tolist(), len(places)])
    return [
        (slice(low, high), slice(int(places[low]), int(places[low]) + high - low))
        for low, high in ends
        if high > low
    ]


# --- elimination ---

MOST_NUMBERS = 48_000_000  # of factors and fronts, up to which wavenumbers are eliminated together
LARGEST_BATCH = 8  # wavenumbers: more are not faster


@dataclass(frozen=True, eq=False)
class Elimination:
    """The elimination of the amplitudes of a section, at any wavenumbers.

    `amplitudes` are the numbers 3 n + c of the free amplitudes, the retained ones last; forces F
    (amplitudes, n) are in this order.
    """

    fronts: list[Front]
    amplitudes: Indices
    retained: int
    forces: csr_matrix
    seen: csr_matrix  # G^T (amplitudes, m)

    @classmethod
    def prepare(
        cls, model: SectionModel, free: Mask, last: Mask, forces: csr_matrix, observers: csr_matrix
    ) -> "Elimination":
        """Prepare the elimination for the equations [[K, F], [G, 0]] of a section with loads and observers.

        Amplitudes that are not `free` (n_nodes, 3) are held, those of the `last` nodes (n_nodes,) retained.
        Forces F (3 n_nodes, n) and observers G (m, 3 n_nodes) have all amplitudes.
        """
        parts = dissect(model.cells, model.section.mesh.doflocs, last)
        none = np.empty(0, dtype=np.int64)
        parts.append(Part(None, (len(parts) - 1,), np.flatnonzero(last), none))  # what is retained
        groups = [_amplitudes(part.eliminated, free) for part in parts]
        amplitudes, starts = np.concatenate(groups), np.append(0, np.cumsum([len(group) for group in groups]))
        number = np.full(free.size, -1)  # of each amplitude in this order
        number[amplitudes] = np.arange(len(amplitudes))
        forces, seen = (csr_matrix(border)[amplitudes] for border in (forces, observers.T))
        fronts: list[Front] = []
        for part, first, end in zip(parts, starts[:-1].tolist(), starts[1:].tolist(), strict=True):
            halves = {half: fronts[half] for half in part.halves}
            kept = np.sort(number[_amplitudes(part.kept, free)])
            here, n = np.append(np.arange(first, end), kept), end - first + len(kept)
            if part is parts[-1]:
                loads, observed = np.arange(forces.shape[1]), np.arange(seen.shape[1])
            else:
                loads = _join(forces, first, end, [half.loads for half in halves.values()])
                observed = _join(seen, first, end, [half.observers for half in halves.values()])
            front = Front(
                first,
                0 if part is parts[-1] else end - first,
                here,
                loads,
                observed,
                None if part.cells is None else _sum_cells(model, part.cells, free, number, here),
                tuple(
                    Half(
                        name,
                        _places(here, observed, half.kept, half.observers),
                        _places(here, loads, half.kept, half.loads),
                    )
                    for name, half in halves.items()
                ),
                _entries(forces, first, end, n, loads),
                _entries(seen, first, end, n, observed),
            )
            fronts.append(front)
        return cls(fronts, amplitudes, len(groups[-1]), forces, seen)

    @property
    def batch_size(self) -> int:
        """Number of wavenumbers that fit into memory at once, at most."""
        numbers = sum(front.eliminated * front.shape[1] for front in self.fronts)
        numbers += 2 * max(front.shape[0] * front.shape[1] for front in self.fronts)
        return int(np.clip(MOST_NUMBERS // numbers, 1, LARGEST_BATCH))

    def at(self, k: Sequence[float], forces: Array | None = None) -> "Eliminated":
        """Eliminate at wavenumbers [1/mm]; raises LinAlgError where a pivot is 0.

        `forces` (k, n) are the entries of F where it differs from wavenumber to wavenumber.
        """
        powers = np.vander(k, 3, increasing=True)
        forces = self.forces.data if forces is None else forces
        factors: list[Array] = []
        left: dict[int, Array] = {}
        for number, front in enumerate(self.fronts):
            matrix, n, m = np.zeros((len(k), *front.shape)), len(front.amplitudes), front.eliminated
            if front.stiffness is not None:
                by_cells = powers[:, None] @ front.stiffness.reshape(3, n * n)
                matrix[:, :n, :n] = by_cells.reshape(len(k), n, n)
            for half in front.halves:
                half.add(left.pop(half.number), matrix)
            row, load, entries = front.forces
            matrix[:, row, load] += forces[..., entries]
            row, observer, entries = front.seen
            matrix[:, observer, row] += self.seen.data[entries]
            factor = np.asarray(np.linalg.solve(matrix[:, :m, :m], matrix[:, :m, m:]), dtype=float)
            left[number] = matrix[:, m:, m:] - matrix[:, m:, :m] @ factor if m else matrix
            factors.append(factor)
        return Eliminated(self, np.array(k), factors, left[len(self.fronts) - 1])


def in_parts(k: Sequence[float], batch_size: int, workers: int) -> list[list[float]]:
    """Wavenumbers in parts of at most `batch_size`, about as many for each of the workers."""
    number = workers * -(-len(k) // (workers * batch_size))
    return [part.tolist() for part in np.array_split(k, number or 1) if len(part)]


@dataclass(frozen=True, eq=False)
class Eliminated:
    """What is left of M at wavenumbers k [1/mm], and the factors by which amplitudes follow from the others.

    `left` (k, retained + m, retained + n) has the rows of retained amplitudes and observers, the columns of
    retained amplitudes and loads.
    """

    elimination: Elimination
    k: Array
    factors: list[Array]
    left: Array

    def fields(self, retained: Array, loads: Array) -> Array:
        """Amplitudes (k, amplitudes, c) where the retained ones are (k, retained, c), under loads (n, c)."""
        u = np.zeros((len(self.k), len(self.elimination.amplitudes), retained.shape[-1]))
        u[:, u.shape[1] - self.elimination.retained :] = retained
        under = np.broadcast_to(-loads, (len(self.k), *loads.shape))
        for front, factor in zip(self.elimination.fronts[::-1], self.factors[::-1], strict=True):
            known = np.concatenate([u[:, front.kept], under[:, front.loads]], axis=1)
            u[:, front.first : front.first + front.eliminated] = -(factor @ known)
        return u

    def forces(self, u: Array) -> Array:
        """K u (k, amplitudes, c) of amplitudes u of this shape, from the matrices of the cells."""
        k = self.k[:, None, None]
        total = np.zeros_like(u)
        for front in self.elimination.fronts:
            if front.stiffness is not None:
                part = u[:, front.amplitudes]
                k0, k1, k2 = front.stiffness
                total[:, front.amplitudes] += k0 @ part + k * (k1 @ part + k * (k2 @ part))
        return total
