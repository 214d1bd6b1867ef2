"""How fine the meshes of a contact by finite elements are."""

import numpy as np

from geometries.errors import WrongInput

CELLS = 15.0  # along the shorter half-length
FEWEST = 8.0  # likewise, at least


def require_enough(cells: float) -> None:
    """Raise WrongInput for too few cells along the shorter half-length."""
    if not FEWEST <= cells < np.inf:
        raise WrongInput(f"cells = {cells!r}: at least {FEWEST:g} along the shorter half-length")
