"""Displacements of requests, and fields on a section by SciPy's solver, the second route to responses."""

import numpy as np
from scipy.sparse.linalg import splu

from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.synthesis import displacements


def raw_ics(request, **options):
    """The displacements [mm/N] at the points of a request, before the discount."""
    return displacements(solve(request, **options), request.loads, request.points)


def fields(model, held, k, forces):
    """Amplitudes (unknowns, n) under forces (unknowns, n) at k, where those in held (n_nodes, 3) are 0.

    SciPy chooses its own order of elimination.
    """
    free = ~held.ravel()[model.amplitudes]
    numbers = model.amplitudes[free]
    u = np.zeros_like(forces)
    u[numbers] = splu(model.stiffness.at(k)[free][:, free].tocsc()).solve(forces[numbers])
    return u
