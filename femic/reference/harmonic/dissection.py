"""An order in which the nodes of a section are eliminated, with little fill: nested dissection of its cells.

Cells are halved again and again. A node is eliminated with the smallest part that has all of its cells: so
parts side by side do not know of each other, and what is left of a part are the nodes on its boundary
(A. George, SIAM J. Numer. Anal. 10, 1973, 345-363). Cells grow with the distance from the load: besides lines
in four directions, circles round the smallest cell separate halves with few nodes in common.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array, Indices, Mask

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


def dissected(cells: Indices, places: Array, last: Mask) -> list[Part]:
    """Parts of cells (n, 15), their nodes at places (2, n_nodes) [mm]; both halves come before their whole.

    The last part is the whole. Nodes that are marked in `last` (n_nodes,) are kept by all parts.
    """
    corners = places[:, cells[:, :3]]  # (2, n, 3)
    measures = _measures(corners.mean(axis=2), np.ptp(corners, axis=2).max(axis=0))
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
        parts.append(Part(None if halves else chosen, numbers, _in_a_row(nodes[done], places), nodes[~done]))
        counts.append(count[~done])
        return len(parts) - 1

    add(np.arange(len(cells)))
    return parts


def _measures(centres: Array, sizes: Array) -> Sequence[Array]:
    """What cells at centres (2, n) are sorted by, of which one half is below and one above the median."""
    y, z = centres
    from_smallest = np.hypot(*(centres - centres[:, [np.argmin(sizes)]]))
    return y, z, y + z, y - z, from_smallest


def _halves(cells: Indices, measures: Sequence[Array], chosen: Indices) -> tuple[Indices, ...]:
    """The two halves of some cells with the fewest nodes in common, none if they are not to be halved."""
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


def _in_a_row(nodes: Indices, places: Array) -> Indices:
    """Nodes in order along their longer extent, so that neighbours of their part have consecutive ones."""
    at = places[:, nodes]
    return nodes[np.argsort(at[np.argmax(np.ptp(at, axis=1))], kind="stable")] if len(nodes) else nodes
