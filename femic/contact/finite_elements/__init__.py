"""Frictionless contact of two meshed bodies, without any influence coefficients.

    from femic.contact.finite_elements.result import fe_contact
    from femic.contact.finite_elements.meshed_contact import Bodies

    contact = fe_contact(Bodies(lower, upper, s_range=lower.contour.limits), load=58e3)
    contact.numbers.p_max, contact.estimate.p_max

Modules: `bodies` (mesh, stiffness, multigrid), `coupling` (mortar), `saddle` (displacements, pressures and
approach for a given contact area, and this area), `meshed_contact` (a contact on one pair of meshes, its
edges; bodies of a contact problem), `result` (meshes made for the patch, and estimates).
"""

import numpy as np

from geometries.errors import WrongInput

CELLS = 15.0  # along the shorter half-length
FEWEST = 8.0  # likewise, at least


def require_enough(cells: float) -> None:
    """Raise WrongInput for too few cells along the shorter half-length."""
    if not FEWEST <= cells < np.inf:
        raise WrongInput(f"cells = {cells!r}: at least {FEWEST:g} along the shorter half-length")
