"""Kalker's creepage coefficients of contacts of Hertz, each computed once."""

from dataclasses import replace
from functools import cache

import numpy as np

from femic.contact.exact.creepage_coefficients import CreepageCoefficients, creepage_coefficients
from femic.contact.exact.hertz import LoadedPoint

DIGITS = 9  # of the aspect of an ellipse


def coefficients_of(patch: LoadedPoint, nu: float) -> CreepageCoefficients:
    """Return the coefficients of the ellipse of a contact of Hertz; nu is the combined one.

    Raises WrongInput as `creepage_coefficients`.
    """
    of_aspect = _of_aspect(float(f"{patch.a / patch.b:.{DIGITS}g}"), nu)
    return replace(of_aspect, a=patch.a, b=patch.b)


@cache
def _of_aspect(aspect: float, nu: float) -> CreepageCoefficients:
    """Return the coefficients of an aspect a/b; they do not depend on the size."""
    return creepage_coefficients(float(np.sqrt(aspect)), float(1 / np.sqrt(aspect)), nu)
