"""Numbers of the edges of a mesh, by their vertices."""

import numpy as np

from geometries.arrays import Indices


def edge_numbers(edges: Indices, pairs: Indices) -> Indices:
    """Numbers of the columns of `edges` (2, n_edges) that join the vertices `pairs` (2, n), shape (n,)."""
    n_vertices = int(edges.max()) + 1
    keys = np.sort(edges, axis=0).astype(np.int64).T @ [n_vertices, 1]
    order = np.argsort(keys)
    return order[np.searchsorted(keys, np.sort(pairs, axis=0).T @ [n_vertices, 1], sorter=order)]
