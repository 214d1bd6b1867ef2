"""The check that an argument is positive."""

import numpy as np

from geometries.errors import WrongInput


def require_positive(name: str, value: float) -> None:
    """Raise WrongInput for what is not a positive number."""
    if not 0 < value < np.inf:
        raise WrongInput(f"{name} = {value!r}: must be positive and finite")
