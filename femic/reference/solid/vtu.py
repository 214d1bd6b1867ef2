"""The only module that loads meshio: fields as binary VTK files (.vtu), which ParaView and PyVista open."""

from pathlib import Path

import numpy as np

from femic.cache.files import replacing
from femic.reference.solid.fields import NodalField, VolumeGrid
from geometries.arrays import Indices

# scikit-fem numbers the mid-side nodes as VTK does: edges 01, 12, 02, 03, 13, 23.
# In cells that are inside out, vertices 1 and 2 are swapped; this is the order of their nodes:
TURNED = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]


def write_vtu(field: NodalField, path: Path) -> Path:
    """Write quadratic tetrahedra with "displacement" [mm/N] and "von_mises" [MPa/N]; returns the path."""
    import meshio

    path.parent.mkdir(parents=True, exist_ok=True)
    values = {"displacement": field.displacement, "von_mises": field.von_mises}
    mesh = meshio.Mesh(field.grid.nodes.T, [("tetra10", right_handed(field.grid).T)], point_data=values)
    with replacing(path) as unfinished:
        mesh.write(unfinished, file_format="vtu", binary=True)
    return path


def right_handed(grid: VolumeGrid) -> Indices:
    """The cells, with vertex 3 on the side of the face 0, 1, 2 that VTK expects, shape (10, n_cells)."""
    origin, *ends = np.moveaxis(grid.nodes[:, grid.cells[:4]], 1, 0)
    edges = np.stack([end - origin for end in ends])  # (3 edges, 3 components, n_cells)
    inside_out = np.linalg.det(np.moveaxis(edges, 2, 0)) < 0
    return np.where(inside_out, grid.cells[TURNED], grid.cells)
