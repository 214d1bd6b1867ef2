"""The cells of a mesh that Gmsh has made, and the numbers of its edges."""

from collections.abc import Iterable
from types import ModuleType

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import Failure

SIMPLEX = {2: (2, "triangles"), 3: (4, "tetrahedra")}  # Gmsh's number of a type of cells, by dimension


def collected(gmsh: ModuleType, dimension: int, boundary: Iterable[int]) -> tuple[Array, Indices, Indices]:
    """Points (3, n) [mm], cells (dimension + 1, m), and faces (dimension, k) of some boundary entities.

    `boundary` holds the tags of these entities. Points that no cell uses are left out. Raises Failure where
    Gmsh left other cells than triangles or tetrahedra.
    """
    number, name = SIMPLEX[dimension]
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    types, _, nodes = gmsh.model.mesh.getElements(dimension)
    if list(types) != [number]:
        raise Failure(f"Gmsh left cells of types {list(types)} where {name} were expected")
    used, flat = np.unique(nodes[0], return_inverse=True)
    order = np.argsort(tags)
    points = xyz.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]].T
    faces = [
        np.searchsorted(used, gmsh.model.mesh.getElements(dimension - 1, entity)[2][0]) for entity in boundary
    ]
    return points, flat.reshape(-1, dimension + 1).T, np.concatenate(faces).reshape(-1, dimension).T


def edge_numbers(edges: Indices, pairs: Indices) -> Indices:
    """Numbers of the columns of `edges` (2, n_edges) that join the vertices `pairs` (2, n), shape (n,)."""
    n_vertices = int(edges.max()) + 1
    keys = np.sort(edges, axis=0).astype(np.int64).T @ [n_vertices, 1]
    order = np.argsort(keys)
    return order[np.searchsorted(keys, np.sort(pairs, axis=0).T @ [n_vertices, 1], sorter=order)]
