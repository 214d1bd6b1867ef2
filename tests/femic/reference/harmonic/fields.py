"""Fields on a section by SciPy's solver in its own order of elimination: the second route to responses."""

import numpy as np
from scipy.sparse.linalg import splu


def fields(model, held, k, forces):
    """Amplitudes (unknowns, n) under forces (unknowns, n) at k, where those in held (n_nodes, 3) are 0."""
    free = ~held.ravel()[model.amplitudes]
    numbers = model.amplitudes[free]
    u = np.zeros_like(forces)
    u[numbers] = splu(model.stiffness.at(k)[free][:, free].tocsc()).solve(forces[numbers])
    return u
