"""Displacements of requests, and fields on a section by SciPy's solver, the second route to responses."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.synthesis import displacements


def raw_ics(request, **options):
    """The displacements [mm/N] at the points of a request, before the discount."""
    return displacements(solve(request, **options), request.loads, request.points)


def stiffness(model, k):
    """K(k) of all amplitudes of a section, as a sparse sum of the matrices of its cells."""
    k0, k1, k2 = model.cell_matrices
    of_cells = (3 * model.cells[:, :, None] + np.arange(3)).reshape(len(model.cells), -1)
    rows, columns = (
        np.broadcast_to(part, k0.shape).ravel() for part in (of_cells[:, :, None], of_cells[:, None])
    )
    n = 3 * model.section.mesh.doflocs.shape[1]
    return coo_array(((k0 + k * (k1 + k * k2)).ravel(), (rows, columns)), shape=(n, n)).tocsc()


def fields(model, held, k, forces):
    """Amplitudes (unknowns, n) under forces (unknowns, n) at k, where those in held (n_nodes, 3) are 0.

    SciPy chooses its own order of elimination.
    """
    free = ~held.ravel()
    u = np.zeros_like(forces)
    u[free] = splu(stiffness(model, k)[free][:, free].tocsc()).solve(forces[free])
    return u
